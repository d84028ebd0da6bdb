//! The GPU's time for the passes of each frame, where the device has timestamps: told a few frames later,
//! when it is known, so that nothing waits for it.

use super::Gpu;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use wgpu::{BufferUsages, CommandEncoder};

/// Passes of a frame that can be timed: more than the largest film takes.
const MOST_PASSES: u32 = 128;
/// Bytes of one timestamp.
const TICK_BYTES: u64 = size_of::<u64>() as u64;
/// Frames whose times may be under way at once; further ones are not timed.
const SLOTS: usize = 4;

/// What the GPU took for a frame.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct PassTimes {
    /// Number of the frame, as drawing it told.
    pub frame: u64,
    /// From the begin of the first pass to the end of the last, in milliseconds.
    pub frame_ms: f64,
    /// Every pass with its label, in milliseconds.
    pub passes: Vec<(&'static str, f64)>,
}

/// Timestamps at the begin and end of each pass.
pub(crate) struct Timer {
    slots: Vec<Slot>,
    ms_per_tick: f64,
}

/// Timestamps of one frame, from its encoding until they are read.
pub(super) struct Slot {
    pub(super) queries: wgpu::QuerySet,
    resolved: wgpu::Buffer,
    /// What the CPU reads.
    host: wgpu::Buffer,
    /// Whether it may. The device holds a second reference until it has copied the timestamps, or the frame
    /// was dropped without being submitted.
    is_mapped: Arc<AtomicBool>,
    frame: u64,
    labels: Vec<&'static str>,
}

impl Timer {
    /// A timer, or `None` if the device cannot tell the time.
    pub(crate) fn new(gpu: &Gpu) -> Option<Self> {
        let can_tell = gpu.device.features().contains(wgpu::Features::TIMESTAMP_QUERY);
        can_tell.then(|| Self {
            slots: (0..SLOTS).map(|_| Slot::new(gpu)).collect(),
            ms_per_tick: f64::from(gpu.queue.get_timestamp_period()) * 1e-6,
        })
    }

    /// A place for the timestamps of frame number `frame`; `None` if all are under way.
    pub(super) fn begin(&mut self, frame: u64) -> Option<&mut Slot> {
        let slot = self.slots.iter_mut().find(|slot| slot.is_free())?;
        (slot.frame, slot.labels) = (frame, Vec::new());
        Some(slot)
    }

    /// The times that have become known since the last call, in the order of the frames.
    pub(crate) fn times(&mut self) -> Vec<PassTimes> {
        let ms_per_tick = self.ms_per_tick;
        let mut times: Vec<PassTimes> =
            self.slots.iter_mut().filter_map(|slot| slot.take(ms_per_tick)).collect();
        times.sort_by_key(|times| times.frame);
        times
    }
}

impl Slot {
    fn new(gpu: &Gpu) -> Self {
        let count = 2 * MOST_PASSES;
        let bytes = u64::from(count) * TICK_BYTES;
        let descriptor = wgpu::QuerySetDescriptor {
            label: Some("pass begins and ends"),
            ty: wgpu::QueryType::Timestamp,
            count,
        };
        Self {
            queries: gpu.device.create_query_set(&descriptor),
            resolved: gpu.buffer("timestamps", bytes, BufferUsages::QUERY_RESOLVE | BufferUsages::COPY_SRC),
            host: gpu.buffer("timestamps to read", bytes, BufferUsages::MAP_READ | BufferUsages::COPY_DST),
            is_mapped: Arc::default(),
            frame: 0,
            labels: Vec::new(),
        }
    }

    fn is_under_way(&self) -> bool {
        Arc::strong_count(&self.is_mapped) > 1
    }

    fn is_free(&self) -> bool {
        !self.is_under_way() && !self.is_mapped.load(Ordering::Acquire)
    }

    /// The numbers of the timestamps at both ends of the pass that comes now; `None` if there are too many
    /// passes.
    pub(super) fn next(&mut self, label: &'static str) -> Option<[u32; 2]> {
        let first = 2 * self.labels.len() as u32;
        if first == 2 * MOST_PASSES {
            return None;
        }
        self.labels.push(label);
        Some([first, first + 1])
    }

    /// The end of the frame: when it is done, its timestamps can be read.
    pub(super) fn finish(&mut self, encoder: &mut CommandEncoder) {
        if self.labels.is_empty() {
            return;
        }
        encoder.resolve_query_set(&self.queries, 0..2 * self.labels.len() as u32, &self.resolved, 0);
        encoder.copy_buffer_to_buffer(&self.resolved, 0, &self.host, 0, self.host.size());
        let is_mapped = self.is_mapped.clone();
        encoder.map_buffer_on_submit(&self.host, wgpu::MapMode::Read, .., move |result| {
            is_mapped.store(result.is_ok(), Ordering::Release);
        });
    }

    /// The times, once they are there.
    fn take(&mut self, ms_per_tick: f64) -> Option<PassTimes> {
        if self.is_under_way() || !self.is_mapped.swap(false, Ordering::AcqRel) {
            return None;
        }
        let ticks: Vec<u64> = match self.host.get_mapped_range(..) {
            Ok(bytes) => bytes.as_chunks().0.iter().map(|word| u64::from_le_bytes(*word)).collect(),
            Err(_) => Vec::new(),
        };
        self.host.unmap();
        let spans: Vec<[u64; 2]> = ticks.as_chunks().0.iter().take(self.labels.len()).copied().collect();
        let ms = |[begin, end]: [u64; 2]| end.saturating_sub(begin) as f64 * ms_per_tick;
        let begin = spans.iter().map(|span| span[0]).min()?;
        let end = spans.iter().map(|span| span[1]).max()?;
        let passes = self.labels.iter().copied().zip(spans.into_iter().map(ms)).collect();
        Some(PassTimes { frame: self.frame, frame_ms: ms([begin, end]), passes })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gpu::Passes;
    use crate::testing::{gpu, wait};

    fn encoder(gpu: &Gpu) -> CommandEncoder {
        gpu.device.create_command_encoder(&Default::default())
    }

    /// Encodes a frame of `passes` passes that do nothing.
    fn frame(timer: &mut Timer, encoder: &mut CommandEncoder, frame: u64, passes: usize) {
        let mut timed = Passes::new(encoder, Some(timer), frame);
        (0..passes).for_each(|_| drop(timed.compute("nothing")));
        timed.finish();
    }

    #[test]
    fn times_come_late_in_order_and_none_is_waited_for() {
        let Some(gpu) = gpu() else { return };
        let Some(mut timer) = Timer::new(&gpu) else { return };
        // More frames than can be under way: the first are timed.
        for number in 0..SLOTS as u64 + 3 {
            let mut encoder = encoder(&gpu);
            frame(&mut timer, &mut encoder, number, 1 + number as usize);
            gpu.queue.submit([encoder.finish()]);
        }
        wait(&gpu);
        let mut times = timer.times();
        assert!(
            times.len() >= SLOTS && times.windows(2).all(|pair| pair[0].frame < pair[1].frame),
            "{times:?}"
        );
        let first = times.remove(0);
        assert_eq!((first.frame, first.passes.len()), (0, 1));
        assert!(times.iter().all(|t| t.passes.len() as u64 == 1 + t.frame && t.frame_ms >= 0.0));
        assert!(timer.times().is_empty());
    }

    #[test]
    fn a_frame_that_is_never_submitted_costs_no_slot() {
        let Some(gpu) = gpu() else { return };
        let Some(mut timer) = Timer::new(&gpu) else { return };
        for number in 0..3 * SLOTS as u64 {
            frame(&mut timer, &mut encoder(&gpu), number, 2);
        }
        let mut last = encoder(&gpu);
        frame(&mut timer, &mut last, 99, MOST_PASSES as usize + 5);
        gpu.queue.submit([last.finish()]);
        wait(&gpu);
        let times = timer.times();
        assert_eq!(
            times.iter().map(|t| (t.frame, t.passes.len())).collect::<Vec<_>>(),
            [(99, MOST_PASSES as usize)]
        );
    }
}
