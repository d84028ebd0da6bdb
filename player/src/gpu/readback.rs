//! Copies buffers back to the CPU.

use super::Gpu;
use crate::error::{Error, Result};
use relume_formats::state::Rgb;
use wgpu::BufferUsages;

/// Host-visible twins of some buffers.
pub struct Readback {
    twins: Vec<wgpu::Buffer>,
}

impl Readback {
    /// Twins of `sources`.
    pub fn new<'a>(gpu: &Gpu, sources: impl IntoIterator<Item = &'a wgpu::Buffer>) -> Self {
        let twin = |source: &wgpu::Buffer| {
            let usage = BufferUsages::MAP_READ | BufferUsages::COPY_DST;
            gpu.device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("read-back"),
                size: source.size(),
                usage,
                mapped_at_creation: false,
            })
        };
        Self { twins: sources.into_iter().map(twin).collect() }
    }

    /// Copies `sources`, which must be those the twins were made for and hold four floats for every colour, and waits for them: the first three floats of
    /// each, buffer by buffer.
    pub fn radiance<'a>(&self, gpu: &Gpu, sources: impl IntoIterator<Item = &'a wgpu::Buffer>) -> Result<Vec<Rgb>> {
        let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("read-back") });
        for (source, twin) in sources.into_iter().zip(&self.twins) {
            encoder.copy_buffer_to_buffer(source, 0, twin, 0, source.size());
        }
        gpu.queue.submit([encoder.finish()]);
        for twin in &self.twins {
            // The range that is asked for below tells whether this worked.
            twin.map_async(wgpu::MapMode::Read, .., |_| {});
        }
        gpu.wait()?;
        let mut radiance = Vec::new();
        for twin in &self.twins {
            let view =
                twin.get_mapped_range(..).map_err(|e| Error::Failed(format!("GPU {}: cannot read results back: {e}", gpu.info.name)))?;
            radiance.extend(view.as_chunks::<16>().0.iter().map(|pixel| {
                let [r, g, b, _] = bytemuck::cast::<[u8; 16], [f32; 4]>(*pixel);
                [r, g, b]
            }));
            drop(view);
            twin.unmap();
        }
        Ok(radiance)
    }
}
