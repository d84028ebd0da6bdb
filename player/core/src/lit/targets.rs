//! What depends on the size of a picture: the film, and what its bands are drawn on.

use super::gpu_data::View;
use super::surface::Bound;
use crate::error::{Error, Result};
use crate::gpu::{Film, Gpu};
use relume_formats::kinds::scene::{MAX_PIXELS, MAX_SIDE, is_legal_size};
use relume_formats::state::{Camera, Rgb};
use wgpu::{BindingResource, BufferUsages, RenderPipeline, TextureFormat};

/// Samples along a side of a pixel.
pub(super) const SAMPLES: u32 = 2;
/// Pixels of a band; its targets take 80 bytes for each.
const BAND_PIXELS: u32 = 1 << 20;
/// Invocations of a workgroup that averages, as in the shader.
const WORKGROUP: u32 = 64;
/// Samples are linear radiance, of any size and exact.
pub(super) const COLOUR: TextureFormat = TextureFormat::Rgba32Float;
pub(super) const DEPTH: TextureFormat = TextureFormat::Depth32Float;

/// A film, and what its bands are drawn on.
pub(super) struct Targets {
    pub(super) film: Film,
    pub(super) bands: Vec<Band>,
    pub(super) colour: wgpu::TextureView,
    pub(super) depth: wgpu::TextureView,
}

/// Consecutive rows of the film.
pub(super) struct Band {
    first_row: u32,
    pub(super) rows: u32,
    view: wgpu::Buffer,
    pub(super) surface: wgpu::BindGroup,
    pub(super) background: wgpu::BindGroup,
    pub(super) average: wgpu::BindGroup,
    pub(super) workgroups: [u32; 2],
}

/// What draws a band, whatever its size.
pub(super) struct Pipelines {
    pub(super) surface: RenderPipeline,
    pub(super) background: RenderPipeline,
    pub(super) average: wgpu::ComputePipeline,
    /// By material.
    pub(super) materials: wgpu::Buffer,
    /// What surfaces take besides, by number of the binding.
    pub(super) bound: Vec<(u32, Bound)>,
    /// The struct `Environment` of the shaders.
    pub(super) environment: wgpu::Buffer,
}

/// Fails unless films of `size` can be drawn.
///
/// # Errors
/// If it has no pixels, more than a film may have, or more in a row than the GPU can draw.
pub(crate) fn expect_drawable(gpu: &Gpu, size: [u32; 2]) -> Result<()> {
    let ([width, height], most) = (size, most_columns(gpu));
    let reason = if size.contains(&0) {
        format!("size {width}x{height} has no pixels; give at least 1x1")
    } else if !is_legal_size(size) {
        format!(
            "size {width}x{height} is too large; at most {MAX_PIXELS} pixels are drawn, and {MAX_SIDE} along a side"
        )
    } else if width > most {
        format!("GPU {} draws at most {most} pixels a row, not {width}; give a smaller size", gpu.name)
    } else {
        return Ok(());
    };
    Err(Error::Request(reason))
}

/// `size` if films of it can be drawn, shown on one texture and read back through one buffer; else the
/// largest of the same shape, to a pixel.
pub(crate) fn drawable(gpu: &Gpu, size: [u32; 2]) -> [u32; 2] {
    let limits = gpu.device.limits();
    let size = size.map(|side| f64::from(side.max(1)));
    let sides = [most_columns(gpu), limits.max_texture_dimension_2d.min(MAX_SIDE)];
    let most_pixels = MAX_PIXELS.min(limits.max_buffer_size / size_of::<[u8; 4]>() as u64) as f64;
    // Rows that are read back are padded.
    let padded = size[0] + f64::from(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT / 4);
    let shares = [
        f64::from(sides[0]) / size[0],
        f64::from(sides[1]) / size[1],
        (most_pixels / (padded * size[1])).sqrt(),
    ];
    let share = shares.into_iter().fold(1.0, f64::min);
    size.map(|side| ((side * share) as u32).max(1))
}

/// Most pixels of a row of a film.
fn most_columns(gpu: &Gpu) -> u32 {
    (gpu.device.limits().max_texture_dimension_2d / SAMPLES).min(MAX_SIDE)
}

impl Targets {
    /// For a film of `size` pixels, which is one that can be drawn.
    pub(super) fn new(gpu: &Gpu, size: [u32; 2], pipelines: &Pipelines) -> Self {
        let [width, height] = size;
        let rows = (BAND_PIXELS / width).clamp(1, height.min(most_columns(gpu)));
        let starts = || (0..height).step_by(rows as usize);
        let film = Film::new(gpu, size, starts().map(|row| (width * rows.min(height - row)) as usize));
        let colour = gpu.target("samples", [SAMPLES * width, SAMPLES * rows], COLOUR);
        let depth = gpu.target("depth", [SAMPLES * width, SAMPLES * rows], DEPTH);
        let bands = film.bands.iter().zip(starts());
        let bands = bands
            .map(|(buffer, first_row)| Band::new(gpu, buffer, width, first_row, pipelines, &colour))
            .collect();
        Self { film, bands, colour, depth }
    }

    /// Sets where the camera stands, the factor on all light, and the closest that is drawn, metres.
    pub(super) fn set(&self, gpu: &Gpu, camera: &Camera, gain: Rgb, near: f32) {
        let [width, height] = self.film.size;
        let film = camera.film(width, height);
        let [forward, right, up] = film.axes().map(|axis| axis.to_array());
        for band in &self.bands {
            let v = |row: u32| 1.0 - 2.0 * row as f32 / height as f32;
            let (top, bottom) = (v(band.first_row), v(band.first_row + band.rows));
            let view = View {
                eye_in_world: film.eye_in_world.to_array(),
                near,
                forward,
                band_middle: 0.5 * (top + bottom),
                right,
                band_reach: 0.5 * (top - bottom),
                up,
                first_row: band.first_row as f32,
                gain,
                width: width as f32,
                height: height as f32,
                unused: [0.0; 3],
            };
            gpu.queue.write_buffer(&band.view, 0, bytemuck::bytes_of(&view));
        }
    }
}

impl Band {
    fn new(
        gpu: &Gpu,
        film: &wgpu::Buffer,
        width: u32,
        first_row: u32,
        pipelines: &Pipelines,
        colour: &wgpu::TextureView,
    ) -> Self {
        let pixels = (film.size() / Film::PIXEL_BYTES) as u32;
        let view =
            gpu.buffer("view", size_of::<View>() as u64, BufferUsages::UNIFORM | BufferUsages::COPY_DST);
        let surface = (0..).zip([&view, &pipelines.materials].map(wgpu::Buffer::as_entire_binding));
        let bound = pipelines.bound.iter().map(|(binding, bound)| (*binding, bound.resource()));
        let average = [BindingResource::TextureView(colour), film.as_entire_binding()];
        Self {
            first_row,
            rows: pixels / width,
            surface: gpu.bind_at(&pipelines.surface.get_bind_group_layout(0), surface.chain(bound)),
            background: background_bindings(gpu, pipelines, &view),
            average: gpu.bind(&pipelines.average.get_bind_group_layout(0), average),
            workgroups: gpu.workgroups(pixels, WORKGROUP),
            view,
        }
    }
}

/// The bindings of the background, which are not consecutive: binding 1 is of the resampling.
fn background_bindings(gpu: &Gpu, pipelines: &Pipelines, view: &wgpu::Buffer) -> wgpu::BindGroup {
    let bound = [(0, &pipelines.environment), (2, view)];
    let bound = bound.map(|(binding, buffer)| (binding, buffer.as_entire_binding()));
    gpu.bind_at(&pipelines.background.get_bind_group_layout(0), bound)
}
