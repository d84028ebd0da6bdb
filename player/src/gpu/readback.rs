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
        let twin = |source: &wgpu::Buffer| gpu.buffer("read-back", source.size(), BufferUsages::MAP_READ | BufferUsages::COPY_DST);
        Self { twins: sources.into_iter().map(twin).collect() }
    }

    /// Copies `sources`, which must be those the twins were made for.
    pub fn encode<'a>(&self, encoder: &mut wgpu::CommandEncoder, sources: impl IntoIterator<Item = &'a wgpu::Buffer>) {
        for (source, twin) in sources.into_iter().zip(&self.twins) {
            encoder.copy_buffer_to_buffer(source, 0, twin, 0, source.size());
        }
    }

    /// Copies `sources`, which hold four floats for every colour, and waits for them: the first three floats of each, buffer by buffer.
    pub fn radiance<'a>(&self, gpu: &Gpu, sources: impl IntoIterator<Item = &'a wgpu::Buffer>) -> Result<Vec<Rgb>> {
        let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("read-back") });
        self.encode(&mut encoder, sources);
        gpu.queue.submit([encoder.finish()]);
        let mut radiance = Vec::new();
        self.read(gpu, |bytes| {
            radiance.extend(bytes.as_chunks::<16>().0.iter().map(|pixel| {
                let [r, g, b, _] = bytemuck::cast::<[u8; 16], [f32; 4]>(*pixel);
                [r, g, b]
            }));
        })?;
        Ok(radiance)
    }

    /// Waits for the copies and hands the bytes of each buffer to `take`, in order.
    pub fn read(&self, gpu: &Gpu, mut take: impl FnMut(&[u8])) -> Result<()> {
        for twin in &self.twins {
            // The range that is asked for below tells whether this worked.
            twin.map_async(wgpu::MapMode::Read, .., |_| {});
        }
        gpu.wait()?;
        for twin in &self.twins {
            let view =
                twin.get_mapped_range(..).map_err(|e| Error::Failed(format!("GPU {}: cannot read results back: {e}", gpu.info.name)))?;
            take(&view);
            drop(view);
            twin.unmap();
        }
        Ok(())
    }
}
