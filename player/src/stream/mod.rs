//! The files of a bundle, as they arrive: whole decoded sections in playback order.
//!
//! A thread reads and decodes; the caller polls and is never kept waiting. Byte budget and rate limit live here, so that the rest of the
//! player meets a slow or short source in one form only: sections that are late, or that do not come.

mod decode;
mod playlist;
mod throttle;

pub use decode::{decode_all, decode_sections};
pub use playlist::{Item, Playlist};

use crate::error::{Error, Result};
use relume_formats::container::{Kind, Section, expect_decoded};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, SyncSender, TryRecvError, sync_channel};
use throttle::Pace;

/// Sections that may wait to be polled; a few are enough to keep the reader busy, and each may take 128 MiB.
const QUEUE: usize = 2;

/// How much may be read, and how fast.
#[derive(Debug, Clone, Copy, Default)]
pub struct Limits {
    /// Read only this many bytes of the files.
    pub bytes: Option<u64>,
    /// Read at most this many bytes a second.
    pub bytes_per_second: Option<u64>,
}

/// One section of one file.
#[derive(Debug)]
pub struct Arrival {
    /// What its file holds.
    pub kind: Kind,
    /// What the manifest calls that which its file holds, or the object that it is of; `None` for files of a method.
    pub name: Option<String>,
    /// The section, decoded and checked.
    pub section: Section,
    /// Whether it is the last one of its file.
    pub last: bool,
}

/// What a poll finds.
#[derive(Debug)]
pub enum Event {
    /// Nothing new yet.
    Waiting,
    /// The next section.
    Section(Arrival),
    /// Everything that will come has come.
    End {
        /// Whether that is the whole bundle, or the prefix that was asked for.
        complete: bool,
    },
}

/// What reader and caller share.
#[derive(Debug, Default)]
struct Shared {
    bytes: AtomicU64,
    stop: AtomicBool,
}

/// A bundle being read.
pub struct Source {
    events: Receiver<relume_formats::Result<Event>>,
    shared: Arc<Shared>,
}

impl Source {
    /// Starts to read the files of `playlist`.
    ///
    /// # Errors
    /// [`Error::Usage`] if the byte budget cannot hold one image, with the number of bytes that can.
    pub fn start(playlist: Playlist, limits: Limits) -> Result<Self> {
        if let Some(bytes) = limits.bytes {
            let needed = playlist.least_bytes()?;
            if bytes < needed {
                return Err(Error::Usage(format!(
                    "--bytes {bytes} is not enough for a first image of this bundle; give at least {needed}"
                )));
            }
        }
        let shared = Arc::new(Shared::default());
        let (sender, events) = sync_channel(QUEUE);
        let reader = Reader { limits, pace: Pace::new(limits.bytes_per_second, shared.clone()), sender };
        std::thread::Builder::new()
            .name("source".to_owned())
            .spawn(move || reader.run(&playlist))
            .map_err(|e| Error::Failed(format!("cannot start the reading thread: {e}")))?;
        Ok(Self { events, shared })
    }

    /// What has arrived since the last poll, without waiting.
    pub fn poll(&self) -> Result<Event> {
        match self.events.try_recv() {
            Ok(event) => Ok(event?),
            Err(TryRecvError::Empty) => Ok(Event::Waiting),
            Err(TryRecvError::Disconnected) => Err(Error::Failed("the reading thread ended before its time".to_owned())),
        }
    }

    /// Bytes read so far.
    pub fn bytes(&self) -> u64 {
        self.shared.bytes.load(Ordering::Relaxed)
    }
}

impl Drop for Source {
    fn drop(&mut self) {
        self.shared.stop.store(true, Ordering::Relaxed);
    }
}

/// The reading thread.
struct Reader {
    limits: Limits,
    pace: Pace,
    sender: SyncSender<relume_formats::Result<Event>>,
}

impl Reader {
    fn run(mut self, playlist: &Playlist) {
        let end = self.read(playlist);
        // A receiver that is gone wants nothing any more.
        let _ = self.sender.send(end);
    }

    fn read(&mut self, playlist: &Playlist) -> relume_formats::Result<Event> {
        let (mut start, mut decoded) = (0, 0);
        let length = playlist.items.iter().map(|item| item.bytes).sum();
        for item in &playlist.items {
            let mut sections = item.open(&mut self.pace)?;
            decoded += sections.header().decoded_bytes();
            expect_decoded(decoded, length, sections.place())?;
            let table = sections.header().sections.clone();
            for (index, info) in table.iter().enumerate() {
                if self.limits.bytes.is_some_and(|budget| start + info.offset + info.stored_bytes > budget) {
                    return Ok(Event::End { complete: false });
                }
                let Some(section) = sections.next_section()? else { break };
                let last = index + 1 == table.len();
                if last {
                    item.expect_hash(&sections)?;
                }
                let arrival = Arrival { kind: item.kind, name: item.name.clone(), section, last };
                if self.sender.send(Ok(Event::Section(arrival))).is_err() {
                    return Ok(Event::End { complete: false });
                }
            }
            start += item.bytes;
        }
        Ok(Event::End { complete: true })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::support::Bundle;
    use std::time::{Duration, Instant};

    fn names_until_end(source: &Source) -> Result<(Vec<String>, bool)> {
        let mut names = Vec::new();
        loop {
            match source.poll()? {
                Event::Waiting => std::thread::sleep(Duration::from_millis(1)),
                Event::Section(arrival) => names.push(arrival.section.info.name),
                Event::End { complete } => return Ok((names, complete)),
            }
        }
    }

    fn play(bundle: &Bundle, limits: Limits) -> Result<(Vec<String>, bool, u64)> {
        let source = Source::start(Playlist::of(bundle.folder(), None, Some("glow"))?, limits)?;
        let (names, complete) = names_until_end(&source)?;
        Ok((names, complete, source.bytes()))
    }

    #[test]
    fn everything_arrives_in_playback_order() {
        let bundle = Bundle::write(true);
        let (names, complete, bytes) = play(&bundle, Limits::default()).unwrap();
        let at = |name: &str| names.iter().position(|n| n == name).unwrap();
        assert!(at("positions") < at("animation") && at("animation") < at("lobes") && at("lobes") < at("fragments/pixel"));
        assert!(complete && at("scales") + 1 == at(&format!("image/{:04}", bundle.images.images[0].slot)));
        assert_eq!(bytes, bundle.playlist_bytes());
    }

    #[test]
    fn a_budget_ends_between_sections_and_is_kept() {
        let bundle = Bundle::write(true);
        let all = bundle.playlist_bytes();
        let (every, ..) = play(&bundle, Limits { bytes: Some(all), ..Limits::default() }).unwrap();
        let (names, complete, bytes) = play(&bundle, Limits { bytes: Some(all - 1), ..Limits::default() }).unwrap();
        assert!(!complete && bytes < all && names == every[..every.len() - 1]);
    }

    #[test]
    fn too_small_a_budget_names_the_least_that_will_do() {
        let bundle = Bundle::write(true);
        let message = play(&bundle, Limits { bytes: Some(10), ..Limits::default() }).unwrap_err().to_string();
        let needed: u64 = message.rsplit(' ').next().unwrap().parse().unwrap();
        assert!(play(&bundle, Limits { bytes: Some(needed - 1), ..Limits::default() }).is_err());
        let (names, complete, bytes) = play(&bundle, Limits { bytes: Some(needed), ..Limits::default() }).unwrap();
        assert_eq!((names.iter().filter(|n| n.starts_with("image/")).count(), complete, bytes), (1, false, needed));
    }

    #[test]
    fn the_rate_is_not_exceeded() {
        let bundle = Bundle::write(true);
        let bytes = bundle.playlist_bytes();
        let start = Instant::now();
        play(&bundle, Limits { bytes_per_second: Some(bytes * 4), ..Limits::default() }).unwrap();
        // A quarter of a second at that rate; sleeping never ends early.
        assert!(start.elapsed() >= Duration::from_millis(245), "{:?}", start.elapsed());
    }
}
