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

    /// Copies `sources`, which must be those the twins were made for and hold four floats for every colour,
    /// and waits for them: the first three floats of each, buffer by buffer.
    pub fn radiance<'a>(
        &self,
        gpu: &Gpu,
        sources: impl IntoIterator<Item = &'a wgpu::Buffer>,
    ) -> Result<Vec<Rgb>> {
        let mut encoder =
            gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("read-back") });
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
            let view = twin.get_mapped_range(..).map_err(|e| {
                Error::Failed(format!("GPU {}: cannot read results back: {e}", gpu.info.name))
            })?;
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

/// A host-visible twin of a picture.
#[derive(Debug, Clone)]
pub struct PictureReadback {
    size: [u32; 2],
    /// Bytes of a row in the twin, which are aligned as copies must be.
    row_bytes: u32,
    twin: wgpu::Buffer,
}

impl PictureReadback {
    /// Of pictures of this size, see [`Gpu::picture`].
    pub fn new(gpu: &Gpu, size: [u32; 2]) -> Self {
        let row_bytes = (4 * size[0]).next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
        let twin = gpu.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("picture read-back"),
            size: u64::from(row_bytes) * u64::from(size[1]),
            usage: BufferUsages::MAP_READ | BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        Self { size, row_bytes, twin }
    }

    /// Encodes the copy.
    pub fn encode(&self, encoder: &mut wgpu::CommandEncoder, picture: &wgpu::Texture) {
        let layout = wgpu::TexelCopyBufferLayout {
            offset: 0,
            bytes_per_row: Some(self.row_bytes),
            rows_per_image: None,
        };
        let [width, height] = self.size;
        let extent = wgpu::Extent3d { width, height, depth_or_array_layers: 1 };
        encoder.copy_texture_to_buffer(
            picture.as_image_copy(),
            wgpu::TexelCopyBufferInfo { buffer: &self.twin, layout },
            extent,
        );
    }

    /// Waits for the last copy: four bytes for every pixel, row by row.
    pub fn read(&self, gpu: &Gpu) -> Result<Vec<u8>> {
        // The range that is asked for below tells whether this worked.
        self.twin.map_async(wgpu::MapMode::Read, .., |_| {});
        gpu.wait()?;
        let view = self.twin.get_mapped_range(..).map_err(|e| {
            Error::Failed(format!("GPU {}: cannot read the picture back: {e}", gpu.info.name))
        })?;
        let row = 4 * self.size[0] as usize;
        let pixels =
            view.chunks_exact(self.row_bytes as usize).flat_map(|padded| &padded[..row]).copied().collect();
        drop(view);
        self.twin.unmap();
        Ok(pixels)
    }
}
