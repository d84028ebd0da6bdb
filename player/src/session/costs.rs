//! What frames take, put together when each is done: nobody waits for that.

use relume_playback::PassTimes;
use std::collections::VecDeque;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::time::Instant;
use wgpu::CommandEncoder;

/// What a frame took.
#[derive(Debug, Clone, Default)]
pub struct Cost {
    /// Number of the frame.
    pub frame: u64,
    /// Updating, encoding and submitting, in milliseconds.
    pub cpu_ms: f64,
    /// All its passes on the GPU, in milliseconds, where the device tells.
    pub gpu_ms: Option<f64>,
    /// Each of its passes, in milliseconds, where the device tells.
    pub passes_ms: Vec<(&'static str, f64)>,
}

/// The costs of frames under way.
pub(super) struct Costs {
    is_timed: bool,
    is_software: bool,
    /// Number of the frame that is done, and when that was noticed.
    done: Receiver<(u64, Instant)>,
    sender: Sender<(u64, Instant)>,
    submitted: VecDeque<Submitted>,
}

/// A frame under way.
struct Submitted {
    frame: u64,
    at: Instant,
    cpu_ms: f64,
}

impl Costs {
    /// No frames yet on a device that has timestamps or not, and is a program on the CPU or not.
    pub(super) fn new(is_timed: bool, is_software: bool) -> Self {
        let (sender, done) = channel();
        Self { is_timed, is_software, done, sender, submitted: VecDeque::new() }
    }

    /// Learns when `frame`, which `encoder` encodes, is done.
    pub(super) fn watch(&self, frame: u64, encoder: &CommandEncoder) {
        let sender = self.sender.clone();
        encoder.on_submitted_work_done(move || {
            // Who no longer listens does not play any more.
            let _ = sender.send((frame, Instant::now()));
        });
    }

    /// Frame number `frame`, on which the CPU worked since `started`, has been submitted just now.
    pub(super) fn submitted(&mut self, frame: u64, started: Instant) {
        let at = Instant::now();
        self.submitted.push_back(Submitted {
            frame,
            at,
            cpu_ms: at.duration_since(started).as_secs_f64() * 1e3,
        });
    }

    /// The costs of frames that are done, in their order, given what the GPU told of frames since the last
    /// call.
    pub(super) fn take(&mut self, times: Vec<PassTimes>) -> Vec<Cost> {
        let mut times = times.into_iter().peekable();
        let mut costs = Vec::new();
        while let Ok((frame, at)) = self.done.try_recv() {
            let Some(submitted) = self.submitted.pop_front().filter(|submitted| submitted.frame == frame)
            else {
                continue;
            };
            while times.peek().is_some_and(|times| times.frame < frame) {
                times.next();
            }
            let told = times.next_if(|times| times.frame == frame);
            costs.push(self.cost(&submitted, at, told));
        }
        costs
    }

    fn cost(&self, submitted: &Submitted, done: Instant, told: Option<PassTimes>) -> Cost {
        let cost = Cost { frame: submitted.frame, cpu_ms: submitted.cpu_ms, ..Cost::default() };
        if self.is_timed && self.is_software {
            // Once llvmpipe has drawn anything, it writes both timestamps of a pass at the same moment.
            let gpu_ms = Some(done.saturating_duration_since(submitted.at).as_secs_f64() * 1e3);
            return Cost { gpu_ms, ..cost };
        }
        match told {
            Some(times) => Cost { gpu_ms: Some(times.frame_ms), passes_ms: times.passes, ..cost },
            None => cost,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn times(frame: u64) -> PassTimes {
        PassTimes { frame, frame_ms: 10.0 + frame as f64, passes: vec![("draw", frame as f64)] }
    }

    #[test]
    fn times_find_their_frames_whenever_they_come() {
        let mut costs = Costs::new(true, false);
        let now = Instant::now();
        (0..4).for_each(|frame| costs.submitted(frame, now));
        let is_done = |costs: &Costs, frame| costs.sender.send((frame, now)).unwrap();
        assert!(costs.take(Vec::new()).is_empty() && costs.submitted.len() == 4);
        is_done(&costs, 0);
        let found = costs.take(vec![times(0)]);
        assert_eq!((found.len(), found[0].gpu_ms, costs.submitted.len()), (1, Some(10.0), 3));
        // Frame 2 was not timed.
        [1, 2, 3].into_iter().for_each(|frame| is_done(&costs, frame));
        let found: Vec<_> =
            costs.take(vec![times(1), times(3)]).into_iter().map(|cost| (cost.frame, cost.gpu_ms)).collect();
        assert_eq!((found, costs.submitted.len()), (vec![(1, Some(11.0)), (2, None), (3, Some(13.0))], 0));
    }

    #[test]
    fn a_software_adapter_is_timed_by_the_clock_and_one_without_timestamps_not_at_all() {
        let start = Instant::now();
        for (is_timed, expected) in [(true, true), (false, false)] {
            let mut costs = Costs::new(is_timed, true);
            costs.submitted(0, start);
            costs.sender.send((0, Instant::now())).unwrap();
            let found = costs.take(Vec::new());
            assert_eq!((found[0].gpu_ms.is_some(), found[0].passes_ms.len()), (expected, 0));
        }
    }
}
