//! The film as a display shows it: sRGB(clamp(2^ev · L)) in a texture, the same values as in a PNG.

use super::{Film, Gpu};
use bytemuck::{Pod, Zeroable};
use wgpu::BufferUsages;

const SHADER: &str = include_str!("tonemap.wgsl");
/// Invocations of a workgroup, as in the shader.
const WORKGROUP: u32 = 64;

/// A texture of 8-bit sRGB values, and the passes that fill it.
pub struct Tonemap {
    texture: wgpu::Texture,
    pipeline: wgpu::ComputePipeline,
    bands: Vec<Work>,
}

/// One dispatch: a band of the film.
struct Work {
    band: Band,
    uniform: wgpu::Buffer,
    bindings: wgpu::BindGroup,
    workgroups: [u32; 2],
}

/// The struct of `tonemap.wgsl`, as the CPU writes it.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
struct Band {
    first_pixel: u32,
    pixels: u32,
    width: u32,
    gain: f32,
}

impl Tonemap {
    /// A picture of `film`.
    pub fn new(gpu: &Gpu, film: &Film) -> Self {
        let texture = texture(gpu, film.size);
        let view = texture.create_view(&wgpu::TextureViewDescriptor::default());
        let pipeline = gpu.compute_pipeline(SHADER, "tonemap");
        let layout = pipeline.get_bind_group_layout(0);
        let mut first_pixel = 0;
        let work = |buffer: &wgpu::Buffer| {
            let band = Band { first_pixel, pixels: (buffer.size() / Film::PIXEL_BYTES) as u32, width: film.size[0], gain: 1.0 };
            first_pixel += band.pixels;
            let uniform = gpu.buffer("tonemap", size_of::<Band>() as u64, BufferUsages::UNIFORM | BufferUsages::COPY_DST);
            let resources = [uniform.as_entire_binding(), buffer.as_entire_binding(), wgpu::BindingResource::TextureView(&view)];
            let bindings = gpu.bind(&layout, resources);
            Work { band, uniform, bindings, workgroups: gpu.workgroups(band.pixels, WORKGROUP) }
        };
        let bands = film.bands.iter().map(work).collect();
        Self { texture, pipeline, bands }
    }

    /// Fills the texture from the film as it will be when everything submitted before is done.
    pub fn run(&self, gpu: &Gpu, exposure_ev: f32) {
        let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("tonemap") });
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor { label: Some("tonemap"), timestamp_writes: None });
        pass.set_pipeline(&self.pipeline);
        for work in &self.bands {
            let band = Band { gain: exposure_ev.exp2(), ..work.band };
            gpu.queue.write_buffer(&work.uniform, 0, bytemuck::bytes_of(&band));
            pass.set_bind_group(0, &work.bindings, &[]);
            pass.dispatch_workgroups(work.workgroups[0], work.workgroups[1], 1);
        }
        drop(pass);
        gpu.queue.submit([encoder.finish()]);
    }

    /// The texture: `Rgba8Unorm`, holding sRGB-encoded values.
    pub fn texture(&self) -> &wgpu::Texture {
        &self.texture
    }
}

fn texture(gpu: &Gpu, [width, height]: [u32; 2]) -> wgpu::Texture {
    gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some("picture"),
        size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::Rgba8Unorm,
        usage: wgpu::TextureUsages::STORAGE_BINDING | wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_SRC,
        view_formats: &[],
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::output::{display_value, encode_png};
    use crate::support;

    /// The texture's bytes, row by row.
    fn bytes(gpu: &Gpu, texture: &wgpu::Texture) -> Vec<[u8; 4]> {
        let (width, height) = (texture.width(), texture.height());
        let row_bytes = (width * 4).next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
        let copy = gpu.buffer("copy", u64::from(row_bytes * height), BufferUsages::COPY_DST | BufferUsages::COPY_SRC);
        let readback = super::super::Readback::new(gpu, [&copy]);
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        let layout = wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(row_bytes), rows_per_image: None };
        encoder.copy_texture_to_buffer(texture.as_image_copy(), wgpu::TexelCopyBufferInfo { buffer: &copy, layout }, texture.size());
        readback.encode(&mut encoder, [&copy]);
        gpu.queue.submit([encoder.finish()]);
        let mut pixels = Vec::new();
        let row = |row: &[u8]| row.as_chunks::<4>().0[..width as usize].to_vec();
        readback.read(gpu, |all| pixels.extend(all.chunks_exact(row_bytes as usize).flat_map(row))).unwrap();
        pixels
    }

    #[test]
    fn the_window_shows_what_a_png_holds() {
        if !support::gpu_there(|| crate::gpu::list().map(|_| ()).map_err(|e| e.to_string())) {
            return;
        }
        let gpu = Gpu::open(None).unwrap();
        let size = [37, 23];
        // Every decade of radiance, negative values, and what overflows the display.
        let radiance: Vec<[f32; 3]> =
            (0..37 * 23).map(|i| [i as f32 / 700.0, (i as f32 / 100.0 - 6.0).exp2(), i as f32 / 300.0 - 1.0]).collect();
        let film = |part: &[[f32; 3]]| gpu.storage("film", &part.iter().map(|p| [p[0], p[1], p[2], 9.0]).collect::<Vec<[f32; 4]>>());
        let (top, bottom) = radiance.split_at(300);
        let tonemap = Tonemap::new(&gpu, &Film { size, bands: vec![film(top), film(bottom)] });
        for ev in [-2.5, 0.0, 3.0] {
            tonemap.run(&gpu, ev);
            let shown = bytes(&gpu, tonemap.texture());
            let display: Vec<_> = radiance.iter().map(|r| display_value(*r, ev)).collect();
            let png = image::load_from_memory(&encode_png(size, &display).unwrap()).unwrap().to_rgb8();
            // The power function of a GPU is good to some units in the last place: at a boundary of rounding it may fall to the other side.
            let far = shown.iter().zip(png.pixels()).filter(|(s, p)| s[..3].iter().zip(&p.0).any(|(s, p)| s.abs_diff(*p) > 1)).count();
            let same = shown.iter().zip(png.pixels()).filter(|(s, p)| s[..3] == p.0 && s[3] == 255).count();
            assert_eq!(far, 0, "{ev}");
            assert!(same * 200 >= shown.len() * 199, "{ev}: {same} of {} pixels are the same", shown.len());
        }
        gpu.check().unwrap();
    }

    #[test]
    fn the_uniform_has_the_shaders_layout() {
        let module = naga::front::wgsl::parse_str(SHADER).unwrap();
        let (_, band) = module.types.iter().find(|(_, t)| t.name.as_deref() == Some("Band")).unwrap();
        let naga::TypeInner::Struct { members, span } = &band.inner else { panic!("no struct") };
        let names: Vec<_> = members.iter().map(|m| (m.name.as_deref().unwrap(), m.offset as usize)).collect();
        use std::mem::offset_of;
        let ours = [
            ("first_pixel", offset_of!(Band, first_pixel)),
            ("pixels", offset_of!(Band, pixels)),
            ("width", offset_of!(Band, width)),
            ("gain", offset_of!(Band, gain)),
        ];
        assert_eq!((names.as_slice(), *span as usize), (&ours[..], size_of::<Band>()));
    }
}
