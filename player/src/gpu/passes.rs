//! The passes of one frame, and the GPU's time for each where the device has timestamps.

use super::{Gpu, Readback};
use crate::error::Result;
use wgpu::{BufferUsages, CommandEncoder, ComputePass, RenderPass, TextureView};

/// Passes of a frame that can be timed: more than the largest film takes.
const MOST_PASSES: u32 = 128;
/// Bytes of one timestamp.
const TICK_BYTES: u64 = size_of::<u64>() as u64;

/// Timestamps at the begin and end of each pass.
pub struct Timer {
    queries: wgpu::QuerySet,
    resolved: wgpu::Buffer,
    readback: Readback,
    ms_per_tick: f64,
}

/// The passes of a frame as they are encoded.
pub struct Passes<'a> {
    encoder: &'a mut CommandEncoder,
    timer: Option<&'a Timer>,
    labels: Vec<&'static str>,
}

/// What the GPU took for a frame.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct PassTimes {
    /// From the begin of the first pass to the end of the last, in milliseconds.
    pub frame_ms: f64,
    /// Every pass with its label, in milliseconds.
    pub passes: Vec<(&'static str, f64)>,
}

impl<'a> Passes<'a> {
    /// No passes yet; they are timed by `timer`, if there is one.
    pub fn new(encoder: &'a mut CommandEncoder, timer: Option<&'a Timer>) -> Self {
        Self { encoder, timer, labels: Vec::new() }
    }

    /// Begins a compute pass.
    pub fn compute(&mut self, label: &'static str) -> ComputePass<'_> {
        let timestamp_writes = self.next(label).map(|(queries, [begin, end])| wgpu::ComputePassTimestampWrites {
            query_set: queries,
            beginning_of_pass_write_index: Some(begin),
            end_of_pass_write_index: Some(end),
        });
        self.encoder.begin_compute_pass(&wgpu::ComputePassDescriptor { label: Some(label), timestamp_writes })
    }

    /// Begins a pass that draws on `colour`, cleared to black, and on `depth`, cleared to 0; the depth is not kept.
    pub fn draw(&mut self, label: &'static str, colour: &TextureView, depth: &TextureView) -> RenderPass<'_> {
        let timestamp_writes = self.next(label).map(|(queries, [begin, end])| wgpu::RenderPassTimestampWrites {
            query_set: queries,
            beginning_of_pass_write_index: Some(begin),
            end_of_pass_write_index: Some(end),
        });
        self.encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some(label),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: colour,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations { load: wgpu::LoadOp::Clear(wgpu::Color::BLACK), store: wgpu::StoreOp::Store },
            })],
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: depth,
                depth_ops: Some(wgpu::Operations { load: wgpu::LoadOp::Clear(0.0), store: wgpu::StoreOp::Discard }),
                stencil_ops: None,
            }),
            timestamp_writes,
            ..Default::default()
        })
    }

    /// The timestamps of the pass that comes now.
    fn next(&mut self, label: &'static str) -> Option<(&'a wgpu::QuerySet, [u32; 2])> {
        let first = 2 * self.labels.len() as u32;
        let timer = self.timer.filter(|_| first < 2 * MOST_PASSES)?;
        self.labels.push(label);
        Some((&timer.queries, [first, first + 1]))
    }

    /// The end. Returns the labels of the passes that were timed, for [`Timer::read`].
    pub fn finish(self) -> Vec<&'static str> {
        if let Some(timer) = self.timer.filter(|_| !self.labels.is_empty()) {
            self.encoder.resolve_query_set(&timer.queries, 0..2 * self.labels.len() as u32, &timer.resolved, 0);
            timer.readback.encode(self.encoder, [&timer.resolved]);
        }
        self.labels
    }
}

impl Timer {
    /// A timer, or `None` if the device cannot tell the time.
    pub fn new(gpu: &Gpu) -> Option<Self> {
        if !gpu.device.features().contains(wgpu::Features::TIMESTAMP_QUERY) {
            return None;
        }
        let descriptor =
            wgpu::QuerySetDescriptor { label: Some("pass begins and ends"), ty: wgpu::QueryType::Timestamp, count: 2 * MOST_PASSES };
        let bytes = 2 * u64::from(MOST_PASSES) * TICK_BYTES;
        let resolved = gpu.buffer("timestamps", bytes, BufferUsages::QUERY_RESOLVE | BufferUsages::COPY_SRC);
        Some(Self {
            queries: gpu.device.create_query_set(&descriptor),
            readback: Readback::new(gpu, [&resolved]),
            resolved,
            ms_per_tick: f64::from(gpu.queue.get_timestamp_period()) * 1e-6,
        })
    }

    /// Waits for the passes called `labels`, and tells how long they took.
    pub fn read(&self, gpu: &Gpu, labels: &[&'static str]) -> Result<PassTimes> {
        if labels.is_empty() {
            gpu.wait()?;
            return Ok(PassTimes::default());
        }
        let mut ticks = Vec::new();
        self.readback.read(gpu, |bytes| ticks.extend(bytes.as_chunks().0.iter().map(|word| u64::from_le_bytes(*word))))?;
        let spans: Vec<[u64; 2]> = ticks.as_chunks().0.iter().take(labels.len()).copied().collect();
        let ms = |[begin, end]: [u64; 2]| end.saturating_sub(begin) as f64 * self.ms_per_tick;
        let begin = spans.iter().map(|span| span[0]).min().unwrap_or_default();
        let end = spans.iter().map(|span| span[1]).max().unwrap_or_default();
        Ok(PassTimes { frame_ms: ms([begin, end]), passes: labels.iter().copied().zip(spans.into_iter().map(ms)).collect() })
    }
}
