//! Sections from the bytes of a bundle's files, which come in any portions.

use super::{Arrival, Event, Item, Playlist, Source};
use crate::error::Result;
use relume_formats::Error as FormatError;
use relume_formats::container::{Section, Unpacker, expect_decoded};
use relume_formats::kinds::manifest::{ContentHash, FILE_NAME};
use std::collections::VecDeque;

/// A source that is given bytes: those of all files of a playlist, in its order, one file behind another.
pub struct Incoming {
    /// The files that have not begun.
    items: VecDeque<Item>,
    current: Option<Current>,
    /// What has been pushed and from where on it has not been used.
    bytes: Vec<u8>,
    used: usize,
    /// Bytes of all files, and what those that have begun decode to.
    length: u64,
    decoded: u64,
    ended: bool,
}

/// The file that is arriving.
struct Current {
    item: Item,
    unpacker: Unpacker,
    hash: ContentHash,
}

impl Incoming {
    /// Nothing yet of the files of `playlist`.
    pub fn new(playlist: &Playlist) -> Self {
        let length = playlist.items.iter().map(|item| item.bytes).sum();
        let items = playlist.items.iter().cloned().collect();
        let mut incoming =
            Self { items, current: None, bytes: Vec::new(), used: 0, length, decoded: 0, ended: false };
        incoming.begin_next();
        incoming
    }

    /// How many bytes from the last push on must come before anything can come of them; `None` if no more are
    /// needed. It changes with every poll.
    pub fn wanted(&self) -> Option<usize> {
        let wanted = self.current.as_ref()?.unpacker.wanted()?;
        Some(wanted.saturating_sub(self.bytes.len() - self.used))
    }

    /// Adds the next bytes, however many.
    pub fn push(&mut self, bytes: &[u8]) {
        // What was used goes when it is the larger part, so that bytes are moved once on average.
        if self.used > self.bytes.len() / 2 {
            self.bytes.drain(..self.used);
            self.used = 0;
        }
        self.bytes.extend_from_slice(bytes);
    }

    /// Says that no more bytes will come: what is there is played.
    pub fn end(&mut self) {
        self.ended = true;
    }

    fn begin_next(&mut self) {
        self.current = self.items.pop_front().map(|item| {
            let unpacker = Unpacker::new(item.bytes, item.place.clone());
            Current { item, unpacker, hash: ContentHash::default() }
        });
    }
}

impl Source for Incoming {
    fn poll(&mut self) -> Result<Event> {
        while let Some(current) = &mut self.current {
            let Some(wanted) = current.unpacker.wanted() else {
                self.begin_next();
                continue;
            };
            let Some(bytes) = self.bytes.get(self.used..self.used + wanted) else {
                return Ok(if self.ended { Event::End { complete: false } } else { Event::Waiting });
            };
            self.used += wanted;
            if let Some(section) = current.take(bytes, &mut self.decoded, self.length)? {
                let last = current.unpacker.wanted().is_none();
                return Ok(Event::Section(Arrival {
                    kind: current.item.kind,
                    name: current.item.name.clone(),
                    section,
                    last,
                }));
            }
        }
        Ok(Event::End { complete: true })
    }
}

impl Current {
    /// Takes the next bytes; with the last of them the file must turn out to be the one that the manifest
    /// lists.
    fn take(
        &mut self,
        bytes: &[u8],
        decoded: &mut u64,
        length: u64,
    ) -> relume_formats::Result<Option<Section>> {
        let was_known = self.unpacker.header().is_some();
        self.hash.update(bytes);
        let section = self.unpacker.take(bytes.to_vec())?;
        let place = &self.item.place;
        if let Some(header) = self.unpacker.header().filter(|_| !was_known) {
            header.expect_kind(self.item.kind, self.item.kind.current_version(), place)?;
            if header.sections.is_empty() {
                return Err(FormatError::invalid(place, "holds no sections; bake it again"));
            }
            *decoded += header.decoded_bytes();
            expect_decoded(*decoded, length, place)?;
        }
        if self.unpacker.wanted().is_none() && self.hash.text() != self.item.hash {
            let reason =
                format!("its hash is not the one in {FILE_NAME}; the file was changed, bake it again");
            return Err(FormatError::invalid(place, reason));
        }
        Ok(section)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Error;
    use crate::support::Bundle;
    use crate::testing::{bytes, playlist};

    /// Name and bytes of a section, and whether it is the last of its file.
    type Came = (String, Vec<u8>, bool);

    /// Everything that comes of `bytes` in portions, and whether it was the whole.
    fn play(playlist: &Playlist, bytes: &[u8], portion: usize) -> Result<(Vec<Came>, bool)> {
        let mut source = Incoming::new(playlist);
        let (mut portions, mut found) = (bytes.chunks(portion), Vec::new());
        loop {
            match source.poll()? {
                Event::Section(arrival) => {
                    found.push((arrival.section.info.name, arrival.section.bytes, arrival.last))
                }
                Event::End { complete } => return Ok((found, complete)),
                Event::Waiting => match portions.next() {
                    Some(portion) => source.push(portion),
                    None => source.end(),
                },
            }
        }
    }

    #[test]
    fn portions_of_any_size_make_the_same_sections() {
        let bundle = Bundle::write(true);
        let playlist = playlist(bundle.folder(), Some("glow"));
        let bytes = bytes(&playlist);
        let (whole, complete) = play(&playlist, &bytes, usize::MAX).unwrap();
        let at = |name: &str| whole.iter().position(|(n, ..)| n == name).unwrap();
        assert!(
            at("positions") < at("animation")
                && at("animation") < at("lobes")
                && at("lobes") < at("fragments/pixel")
        );
        assert!(complete && at("scales") + 1 == at(&format!("image/{:04}", bundle.images.images[0].slot)));
        assert_eq!(whole.iter().filter(|(.., last)| *last).count(), playlist.items.len());
        for portion in [1, 7, 64, 4096] {
            assert!(play(&playlist, &bytes, portion).unwrap() == (whole.clone(), true), "{portion}");
        }
        // All but the last byte hold all but the last section.
        let (short, complete) = play(&playlist, &bytes[..bytes.len() - 1], 50).unwrap();
        assert!(!complete && short == whole[..whole.len() - 1]);
    }

    #[test]
    fn no_more_is_wanted_than_the_next_section_needs() {
        let bundle = Bundle::write(true);
        let playlist = playlist(bundle.folder(), None);
        let bytes = bytes(&playlist);
        let (mut source, mut at) = (Incoming::new(&playlist), 0);
        loop {
            match source.poll().unwrap() {
                Event::Section(_) => {}
                Event::End { complete } => break assert!(complete),
                Event::Waiting => {
                    let wanted = source.wanted().unwrap();
                    assert!(wanted > 0);
                    source.push(&bytes[at..at + wanted]);
                    at += wanted;
                }
            }
        }
        assert_eq!((at, source.wanted()), (bytes.len(), None));
    }

    #[test]
    fn what_is_not_the_listed_file_is_refused() {
        let bundle = Bundle::write(true);
        let playlist = playlist(bundle.folder(), None);
        let bytes = bytes(&playlist);
        let refusal = |playlist: &Playlist, bytes: &[u8]| match play(playlist, bytes, 999).unwrap_err() {
            Error::Format(error) => error.to_string(),
            other => panic!("{other}"),
        };
        let mut damaged = bytes.clone();
        *damaged.last_mut().unwrap() ^= 1;
        assert!(refusal(&playlist, &damaged).contains("checksum"));
        let mut other = playlist.clone();
        other.items[0].hash = "0".repeat(32);
        assert!(refusal(&other, &bytes).contains("its hash is not the one in manifest.json"));
        let mut other = playlist.clone();
        other.items[0].bytes += 1;
        assert!(refusal(&other, &bytes).contains("cut short"));
        let mut other = playlist;
        other.items.swap(0, 1);
        assert!(!refusal(&other, &bytes).is_empty());
    }
}
