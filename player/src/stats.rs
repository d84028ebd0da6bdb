//! What `--stats` writes, and what the window shows of it.

use crate::error::{Error, Result};
use crate::session::{Cost, Session};
use serde::Serialize;
use std::collections::VecDeque;
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
    measured: &'static str,
    bytes_streamed: u64,
    time_to_first_image_s: Option<f64>,
    time_to_full_quality_s: Option<f64>,
    image_bytes_per_frame: u64,
    missing_slots: Vec<usize>,
}

/// The middle and the tail of some measurements.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Spread {
    median: f64,
    p95: f64,
}

const MEASURED: &str = "cpu_ms: wall time of updating the coefficients, encoding and submitting a frame, without read-back and file writing; \
                        gpu_ms: GPU timestamps around the frame's compute pass (null if the device has none; in a window on a software \
                        adapter, the time until the pass is done); median and 95th percentile over all frames; times to an image count \
                        from the start of the player to the finished read-back, in a window to the finished pass, and the time to full \
                        quality is null if only a prefix was played";

/// Collects the costs of frames.
#[derive(Debug, Default)]
pub struct Recorder {
    cpu_ms: Vec<f64>,
    gpu_ms: Vec<f64>,
}

/// The costs of the latest frames.
#[derive(Debug, Default)]
pub struct FrameTimes {
    latest: VecDeque<(Instant, Cost)>,
}

/// How far back the medians reach.
const LATEST: Duration = Duration::from_secs(1);

impl FrameTimes {
    /// Adds a frame that ended `now`, forgetting those of more than a second ago.
    pub fn add(&mut self, now: Instant, cost: Cost) {
        self.latest.push_back((now, cost));
        while self.latest.front().is_some_and(|(then, _)| now.duration_since(*then) > LATEST) {
            self.latest.pop_front();
        }
    }

    /// Median CPU and GPU milliseconds over the second before the last frame.
    pub fn medians(&self) -> (Option<f64>, Option<f64>) {
        let median = |values: Vec<f64>| Spread::of(values).map(|spread| spread.median);
        (
            median(self.latest.iter().map(|(_, cost)| cost.cpu_ms).collect()),
            median(self.latest.iter().filter_map(|(_, cost)| cost.gpu_ms).collect()),
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
    pub fn add(&mut self, frame: Cost) {
        self.cpu_ms.push(frame.cpu_ms);
        self.gpu_ms.extend(frame.gpu_ms);
    }

    /// The file's content.
    pub fn finish(self, session: &Session, appearance: Appearance) -> Result<Vec<u8>> {
        let images = session.images()?;
        let stats = Stats {
            adapter: session.adapter().name.clone(),
            backend: session.adapter().backend.to_string(),
            method: session.method_name().to_owned(),
            size: images.size(),
            frames: self.cpu_ms.len(),
            cpu_ms: Spread::of(self.cpu_ms),
            gpu_ms: Spread::of(self.gpu_ms),
            measured: MEASURED,
            bytes_streamed: session.bytes_streamed(),
            time_to_first_image_s: appearance.first_s,
            time_to_full_quality_s: appearance.full_s,
            image_bytes_per_frame: images.bytes_per_frame(),
            missing_slots: images.missing(),
        };
        let mut text = serde_json::to_vec_pretty(&stats).map_err(|e| Error::Failed(format!("cannot encode the statistics: {e}")))?;
        text.push(b'\n');
        Ok(text)
    }
}

impl Spread {
    /// Nearest-rank percentiles; `None` without measurements.
    fn of(mut values: Vec<f64>) -> Option<Self> {
        values.sort_by(f64::total_cmp);
        let rank = |share: f64| values.get(((values.len() as f64 * share).ceil() as usize).saturating_sub(1)).copied();
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
        for (at_ms, cpu_ms, gpu_ms) in
            [(0, 100.0, None), (500, 90.0, Some(7.0)), (1400, 2.0, Some(5.0)), (1450, 1.0, None), (1500, 3.0, Some(9.0))]
        {
            times.add(start + Duration::from_millis(at_ms), Cost { cpu_ms, gpu_ms });
        }
        assert_eq!(times.medians(), (Some(2.0), Some(7.0)), "of the frames at 0.5 s to 1.5 s");
    }

    #[test]
    fn percentiles_by_nearest_rank() {
        assert_eq!(Spread::of(Vec::new()), None);
        assert_eq!(Spread::of(vec![3.0]), Some(Spread { median: 3.0, p95: 3.0 }));
        let shuffled = (1..=100).map(|i| f64::from(i * 37 % 101)).collect();
        assert_eq!(Spread::of(shuffled), Some(Spread { median: 50.0, p95: 95.0 }));
    }
}
