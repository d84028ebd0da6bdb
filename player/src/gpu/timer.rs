//! GPU time of one pass, where the device has timestamps.

use super::{Gpu, Readback};
use crate::error::Result;
use wgpu::BufferUsages;

/// Two timestamps around a pass.
pub struct Timer {
    queries: wgpu::QuerySet,
    resolved: wgpu::Buffer,
    readback: Readback,
    ms_per_tick: f64,
}

impl Timer {
    /// A timer, or `None` if the device cannot tell the time.
    pub fn new(gpu: &Gpu) -> Option<Self> {
        if !gpu.device.features().contains(wgpu::Features::TIMESTAMP_QUERY) {
            return None;
        }
        let descriptor = wgpu::QuerySetDescriptor { label: Some("pass begin and end"), ty: wgpu::QueryType::Timestamp, count: 2 };
        let resolved = gpu.buffer("timestamps", 16, BufferUsages::QUERY_RESOLVE | BufferUsages::COPY_SRC);
        Some(Self {
            queries: gpu.device.create_query_set(&descriptor),
            readback: Readback::new(gpu, [&resolved]),
            resolved,
            ms_per_tick: f64::from(gpu.queue.get_timestamp_period()) * 1e-6,
        })
    }

    /// What to give the pass.
    pub fn writes(&self) -> wgpu::ComputePassTimestampWrites<'_> {
        wgpu::ComputePassTimestampWrites {
            query_set: &self.queries,
            beginning_of_pass_write_index: Some(0),
            end_of_pass_write_index: Some(1),
        }
    }

    /// To be encoded after the pass.
    pub fn encode(&self, encoder: &mut wgpu::CommandEncoder) {
        encoder.resolve_query_set(&self.queries, 0..2, &self.resolved, 0);
        self.readback.encode(encoder, [&self.resolved]);
    }

    /// Waits for the pass and tells how long it took, in milliseconds.
    pub fn read_ms(&self, gpu: &Gpu) -> Result<f64> {
        let mut ticks = [0_u64; 2];
        self.readback.read(gpu, |bytes| {
            for (tick, word) in ticks.iter_mut().zip(bytes.as_chunks().0) {
                *tick = u64::from_le_bytes(*word);
            }
        })?;
        Ok(ticks[1].saturating_sub(ticks[0]) as f64 * self.ms_per_tick)
    }
}
