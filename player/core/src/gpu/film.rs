//! What a frame is drawn on.

use super::Gpu;
use wgpu::BufferUsages;

/// Linear radiance of every pixel, W/(sr·m²), row by row over all buffers: four floats a pixel, the fourth
/// unused.
pub struct Film {
    /// Size in pixels, width and height.
    pub size: [u32; 2],
    /// The buffers, each with a band of pixels that follows the last one's.
    pub bands: Vec<wgpu::Buffer>,
}

impl Film {
    /// Bytes of one pixel.
    pub const PIXEL_BYTES: u64 = size_of::<[f32; 4]>() as u64;

    /// A film of `size` whose bands have so many pixels each.
    pub(crate) fn new(gpu: &Gpu, size: [u32; 2], pixels: impl IntoIterator<Item = usize>) -> Self {
        let usage = BufferUsages::STORAGE | BufferUsages::COPY_SRC;
        let bands = pixels
            .into_iter()
            .map(|pixels| gpu.buffer("film", pixels as u64 * Self::PIXEL_BYTES, usage))
            .collect();
        Self { size, bands }
    }
}
