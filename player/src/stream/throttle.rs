//! A reader that counts bytes and keeps to a rate.

use super::Shared;
use std::io::{self, Read};
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

/// Longest single sleep, so that a source that nobody wants any more ends soon.
const NAP: Duration = Duration::from_millis(50);

/// The pace of reading, over all files of a bundle.
pub(super) struct Pace {
    bytes_per_second: Option<u64>,
    started: Instant,
    shared: Arc<Shared>,
}

impl Pace {
    /// A pace that starts now.
    pub(super) fn new(bytes_per_second: Option<u64>, shared: Arc<Shared>) -> Self {
        Self { bytes_per_second, started: Instant::now(), shared }
    }

    /// Most bytes to ask for at once: a nap's worth, at least one.
    fn portion(&self) -> usize {
        let nap = |rate: u64| (rate as f64 * NAP.as_secs_f64()).max(1.0) as usize;
        self.bytes_per_second.map_or(usize::MAX, nap)
    }

    /// Waits until `bytes` more are due. Fails if the caller has gone.
    fn spend(&self, bytes: usize) -> io::Result<()> {
        let total = self.shared.bytes.fetch_add(bytes as u64, Ordering::Relaxed) + bytes as u64;
        let Some(rate) = self.bytes_per_second else { return Ok(()) };
        // A rate may be so low that the end lies beyond any clock.
        let due = Duration::try_from_secs_f64(total as f64 / rate as f64).unwrap_or(Duration::MAX);
        while let Some(left) = due.checked_sub(self.started.elapsed()).filter(|left| !left.is_zero()) {
            if self.shared.stop.load(Ordering::Relaxed) {
                return Err(io::Error::other("nobody waits for the rest"));
            }
            std::thread::sleep(left.min(NAP));
        }
        Ok(())
    }
}

/// A reader that keeps to a pace.
pub(super) struct Throttle<'a, R> {
    input: R,
    pace: &'a mut Pace,
}

impl<'a, R> Throttle<'a, R> {
    /// Reads `input` at the `pace`.
    pub(super) fn new(input: R, pace: &'a mut Pace) -> Self {
        Self { input, pace }
    }
}

impl<R: Read> Read for Throttle<'_, R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let portion = buffer.len().min(self.pace.portion());
        let read = self.input.read(buffer.get_mut(..portion).unwrap_or_default())?;
        self.pace.spend(read)?;
        Ok(read)
    }
}
