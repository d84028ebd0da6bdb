//! What `--stats` writes, and what the window shows of it.

use crate::error::{Error, Result};
use crate::session::{Cost, Session};
use relume_playback::NOT_MEASURED;
use serde::Serialize;
use std::collections::{BTreeMap, VecDeque};
use std::time::{Duration, Instant};

/// Times and sizes of a run. Field names are those of the JSON file.
#[derive(Debug, Serialize)]
pub struct Stats {
    adapter: String,
    backend: String,
    method: String,
    size: [u32; 2],
    frames: usize,
    cpu_ms: Option<Spread>,
    gpu_ms: Option<Spread>,
    frame_ms: Option<Spread>,
    pass_ms: BTreeMap<&'static str, Spread>,
    measured: &'static str,
    bytes_streamed: u64,
    gpu_bytes: Option<u64>,
    time_to_first_image_s: Option<f64>,
    time_to_full_quality_s: Option<f64>,
    image_bytes_per_frame: u64,
    missing_slots: Vec<usize>,
    remark: Option<&'static str>,
    pieces: &'static str,
    pieces_arrived: usize,
    pieces_expected: usize,
}

/// The middle and the tail of some measurements.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Spread {
    median: f64,
    p95: f64,
}

const MEASURED: &str = "cpu_ms: wall time of updating, encoding and submitting a frame, without read-back and file writing, with \
                        adapter cpu the method's sums too; \
                        gpu_ms: GPU timestamps from the begin of the frame's first pass to the end of its last (null if the device has \
                        none; on a software adapter, the time until the frame is done), frame_ms: both of a frame together, pass_ms: the same of each pass, where a device \
                        tells; median and 95th percentile over all frames; times to an image count from the start of the player to the \
                        finished read-back, in a window to the finished frame, and the time to full quality is null if only a prefix \
                        was played; image_bytes_per_frame: bytes of images or columns that the pass reads which sums them up; \
                        gpu_bytes: bytes of all buffers and textures on the device (null where the backend does not tell); \
                        missing_slots: numbers of the pieces that have not arrived; remark: what else there is to know of the last frame, or null";

/// Collects the costs of frames.
#[derive(Debug, Default)]
pub struct Recorder {
    cpu_ms: Vec<f64>,
    gpu_ms: Vec<f64>,
    frame_ms: Vec<f64>,
    pass_ms: BTreeMap<&'static str, Vec<f64>>,
}

/// The costs of the latest frames.
#[derive(Debug, Default)]
pub struct FrameTimes {
    /// When each ended, and its milliseconds on CPU and GPU.
    latest: VecDeque<(Instant, f64, Option<f64>)>,
}

/// How far back the medians reach.
const LATEST: Duration = Duration::from_secs(1);

impl FrameTimes {
    /// Adds a frame that ended `now`, forgetting those of more than a second ago.
    pub fn add(&mut self, now: Instant, cost: &Cost) {
        self.latest.push_back((now, cost.cpu_ms, cost.gpu_ms));
        while self.latest.front().is_some_and(|(then, ..)| now.duration_since(*then) > LATEST) {
            self.latest.pop_front();
        }
    }

    /// Median CPU and GPU milliseconds over the second before the last frame.
    pub fn medians(&self) -> (Option<f64>, Option<f64>) {
        let median = |values: Vec<f64>| Spread::of(values).map(|spread| spread.median);
        (
            median(self.latest.iter().map(|(_, cpu_ms, _)| *cpu_ms).collect()),
            median(self.latest.iter().filter_map(|(.., gpu_ms)| *gpu_ms).collect()),
        )
    }
}

/// When images appeared, in seconds since the start.
#[derive(Debug, Clone, Copy, Default)]
pub struct Appearance {
    /// The first image, however coarse.
    pub first_s: Option<f64>,
    /// The image from the whole bundle.
    pub full_s: Option<f64>,
}

impl Recorder {
    /// Adds one frame.
    pub fn add(&mut self, frame: &Cost) {
        self.cpu_ms.push(frame.cpu_ms);
        self.gpu_ms.extend(frame.gpu_ms);
        self.frame_ms.extend(frame.gpu_ms.map(|gpu_ms| frame.cpu_ms + gpu_ms));
        // A frame may have several passes of one kind.
        let mut sums = BTreeMap::new();
        frame.passes_ms.iter().for_each(|(label, ms)| *sums.entry(*label).or_insert(0.0) += ms);
        sums.into_iter().for_each(|(label, ms)| self.pass_ms.entry(label).or_default().push(ms));
    }

    /// The file's content.
    pub fn finish(self, session: &Session, appearance: Appearance) -> Result<Vec<u8>> {
        let pieces = session.player().pieces();
        let stats = Stats {
            adapter: session.adapter().name.clone(),
            backend: session.adapter().backend.to_string(),
            method: session.player().method().card.name.to_owned(),
            size: session.player().film().map_or([0, 0], |film| film.size),
            frames: self.cpu_ms.len(),
            cpu_ms: Spread::of(self.cpu_ms),
            gpu_ms: Spread::of(self.gpu_ms),
            frame_ms: Spread::of(self.frame_ms),
            pass_ms: self
                .pass_ms
                .into_iter()
                .filter_map(|(label, ms)| Some((label, Spread::of(ms)?)))
                .collect(),
            measured: MEASURED,
            bytes_streamed: session.bytes_streamed(),
            gpu_bytes: session.gpu_bytes(),
            time_to_first_image_s: appearance.first_s,
            time_to_full_quality_s: appearance.full_s,
            image_bytes_per_frame: pieces.bytes_per_frame,
            pieces: pieces.what,
            pieces_arrived: pieces.arrived(),
            pieces_expected: pieces.expected,
            missing_slots: pieces.missing,
            remark: session.player().shows_map_from_outside().then_some(NOT_MEASURED),
        };
        let mut text = serde_json::to_vec_pretty(&stats)
            .map_err(|e| Error::Failed(format!("cannot encode the statistics: {e}")))?;
        text.push(b'\n');
        Ok(text)
    }
}

impl Spread {
    /// Nearest-rank percentiles; `None` without measurements.
    fn of(mut values: Vec<f64>) -> Option<Self> {
        values.sort_by(f64::total_cmp);
        let rank = |share: f64| {
            values.get(((values.len() as f64 * share).ceil() as usize).saturating_sub(1)).copied()
        };
        Some(Self { median: rank(0.5)?, p95: rank(0.95)? })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn medians_are_of_the_last_second() {
        let mut times = FrameTimes::default();
        assert_eq!(times.medians(), (None, None));
        let start = Instant::now();
        for (at_ms, cpu_ms, gpu_ms) in [
            (0, 100.0, None),
            (500, 90.0, Some(7.0)),
            (1400, 2.0, Some(5.0)),
            (1450, 1.0, None),
            (1500, 3.0, Some(9.0)),
        ] {
            times.add(start + Duration::from_millis(at_ms), &Cost { cpu_ms, gpu_ms, ..Cost::default() });
        }
        assert_eq!(times.medians(), (Some(2.0), Some(7.0)), "of the frames at 0.5 s to 1.5 s");
    }

    #[test]
    fn passes_of_one_kind_count_together() {
        let mut recorder = Recorder::default();
        for scale in [1.0, 2.0, 3.0] {
            let passes_ms = vec![("light", scale), ("draw", 2.0 * scale), ("draw", 4.0 * scale)];
            recorder.add(&Cost { cpu_ms: 1.0, gpu_ms: Some(9.0), passes_ms, ..Cost::default() });
        }
        assert_eq!(
            recorder.pass_ms,
            BTreeMap::from([("draw", vec![6.0, 12.0, 18.0]), ("light", vec![1.0, 2.0, 3.0])])
        );
    }

    #[test]
    fn percentiles_by_nearest_rank() {
        assert_eq!(Spread::of(Vec::new()), None);
        assert_eq!(Spread::of(vec![3.0]), Some(Spread { median: 3.0, p95: 3.0 }));
        let shuffled = (1..=100).map(|i| f64::from(i * 37 % 101)).collect();
        assert_eq!(Spread::of(shuffled), Some(Spread { median: 50.0, p95: 95.0 }));
    }
}
