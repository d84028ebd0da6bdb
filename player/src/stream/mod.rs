//! The files of a bundle, read by a thread that also decodes them; byte budget and rate limit live here.

mod edition;
mod files;
mod throttle;

pub use edition::Edition;

use crate::error::{Error, Result};
use files::{least_bytes, open_item};
use relume_formats::{Error as FormatError, Place};
use relume_playback::{Event, Incoming, Item, Playlist, Source};
use std::io::Read as _;
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

/// What reader and caller share.
#[derive(Debug, Default)]
struct Shared {
    bytes: AtomicU64,
    stop: AtomicBool,
}

/// A bundle being read from files.
pub struct Files {
    events: Receiver<relume_playback::Result<Event>>,
    shared: Arc<Shared>,
    /// The manifest.
    place: Place,
}

impl Files {
    /// Starts to read the files of `playlist`, which are those of `edition`.
    ///
    /// # Errors
    /// [`Error::Usage`] if the byte budget cannot hold one image, with the number of bytes that can.
    pub fn start(playlist: Playlist, edition: Edition, limits: Limits) -> Result<Self> {
        if let Some(bytes) = limits.bytes {
            let needed = least_bytes(&playlist)?;
            if bytes < needed {
                return Err(Error::Usage(format!(
                    "--bytes {bytes} is not enough for a first image of this bundle; give at least {needed}"
                )));
            }
        }
        let (shared, place) = (Arc::new(Shared::default()), playlist.place.clone());
        let (sender, events) = sync_channel(QUEUE);
        let reader =
            Reader { edition, limits, pace: Pace::new(limits.bytes_per_second, shared.clone()), sender };
        std::thread::Builder::new()
            .name("source".to_owned())
            .spawn(move || reader.run(&playlist))
            .map_err(|e| Error::Failed(format!("cannot start the reading thread: {e}")))?;
        Ok(Self { events, shared, place })
    }

    /// Bytes read so far.
    pub fn bytes(&self) -> u64 {
        self.shared.bytes.load(Ordering::Relaxed)
    }
}

impl Source for Files {
    fn poll(&mut self) -> relume_playback::Result<Event> {
        match self.events.try_recv() {
            Ok(event) => event,
            Err(TryRecvError::Empty) => Ok(Event::Waiting),
            Err(TryRecvError::Disconnected) => {
                let reason = std::io::Error::other("the reading thread ended before its time");
                Err(FormatError::output(&self.place, reason).into())
            }
        }
    }
}

impl Drop for Files {
    fn drop(&mut self) {
        self.shared.stop.store(true, Ordering::Relaxed);
    }
}

/// The reading thread.
struct Reader {
    edition: Edition,
    limits: Limits,
    pace: Pace,
    sender: SyncSender<relume_playback::Result<Event>>,
}

impl Reader {
    fn run(mut self, playlist: &Playlist) {
        let mut incoming = Incoming::new(playlist);
        let end = self.read(playlist, &mut incoming);
        // A receiver that is gone wants nothing any more.
        let _ = self.sender.send(end);
    }

    /// Reads until the end, a section at a time: no byte that does not belong to a whole one within the
    /// budget.
    fn read(&mut self, playlist: &Playlist, incoming: &mut Incoming) -> relume_playback::Result<Event> {
        let mut read = 0;
        for item in &playlist.items {
            let mut file = open_item(item, &mut self.pace)?;
            self.edition.expect_there()?;
            let end = read + item.bytes;
            loop {
                match incoming.poll()? {
                    Event::Waiting if read == end => break,
                    Event::Waiting => {}
                    Event::End { complete } => return Ok(Event::End { complete }),
                    section => {
                        if self.sender.send(Ok(section)).is_err() {
                            return Ok(Event::End { complete: false });
                        }
                        continue;
                    }
                }
                let wanted = incoming.wanted().unwrap_or_default();
                read += wanted as u64;
                if self.limits.bytes.is_some_and(|budget| read > budget) {
                    return Ok(Event::End { complete: false });
                }
                let mut bytes = vec![0; wanted];
                file.read_exact(&mut bytes).map_err(|e| unreadable(item, e))?;
                incoming.push(&bytes);
            }
        }
        incoming.poll()
    }
}

/// The error that a file, which was as long as it should be, could not be read to its end.
fn unreadable(item: &Item, error: std::io::Error) -> FormatError {
    match error.kind() {
        std::io::ErrorKind::UnexpectedEof => {
            FormatError::invalid(&item.place, "the file ends early; it is cut short, bake it again")
        }
        _ => FormatError::io(&item.place, error),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::support::Bundle;
    use std::time::{Duration, Instant};

    fn names_until_end(source: &mut Files) -> Result<(Vec<String>, bool)> {
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
        let edition = Edition::read(bundle.folder())?;
        let playlist = Playlist::of(edition.manifest(), &edition.place(), None, Some("glow"))?;
        let mut source = Files::start(playlist, edition, limits)?;
        let (names, complete) = names_until_end(&mut source)?;
        Ok((names, complete, source.bytes()))
    }

    #[test]
    fn everything_arrives_in_playback_order() {
        let bundle = Bundle::write(true);
        let (names, complete, bytes) = play(&bundle, Limits::default()).unwrap();
        let at = |name: &str| names.iter().position(|n| n == name).unwrap();
        assert!(
            at("positions") < at("animation")
                && at("animation") < at("lobes")
                && at("lobes") < at("fragments/pixel")
        );
        assert!(complete && at("scales") + 1 == at(&format!("image/{:04}", bundle.images.images[0].slot)));
        assert_eq!(bytes, bundle.playlist_bytes());
    }

    #[test]
    fn a_bake_that_takes_the_place_of_another_is_not_mixed_with_it() {
        let bundle = Bundle::write(true);
        let edition = Edition::read(bundle.folder()).unwrap();
        let playlist = Playlist::of(edition.manifest(), &edition.place(), None, None).unwrap();
        // Files of the same length and hash, so that nothing but the manifest tells.
        let mut other = bundle.manifest.clone();
        other.scene_hash = "1".repeat(32);
        other.write(bundle.folder()).unwrap();
        let mut source = Files::start(playlist, edition, Limits::default()).unwrap();
        let error = names_until_end(&mut source).unwrap_err();
        assert!(error.to_string().contains("baked again while it was read"), "{error}");
        assert_eq!(error.exit_code(), 2);
    }

    #[test]
    fn a_budget_ends_between_sections_and_is_kept() {
        let bundle = Bundle::write(true);
        let all = bundle.playlist_bytes();
        let (every, ..) = play(&bundle, Limits { bytes: Some(all), ..Limits::default() }).unwrap();
        let (names, complete, bytes) =
            play(&bundle, Limits { bytes: Some(all - 1), ..Limits::default() }).unwrap();
        assert!(!complete && bytes < all && names == every[..every.len() - 1]);
    }

    #[test]
    fn too_small_a_budget_names_the_least_that_will_do() {
        let bundle = Bundle::write(true);
        let message = play(&bundle, Limits { bytes: Some(10), ..Limits::default() }).unwrap_err().to_string();
        let needed: u64 = message.rsplit(' ').next().unwrap().parse().unwrap();
        assert!(play(&bundle, Limits { bytes: Some(needed - 1), ..Limits::default() }).is_err());
        let (names, complete, bytes) =
            play(&bundle, Limits { bytes: Some(needed), ..Limits::default() }).unwrap();
        assert_eq!(
            (names.iter().filter(|n| n.starts_with("image/")).count(), complete, bytes),
            (1, false, needed)
        );
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
