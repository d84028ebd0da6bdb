//! The film as a display shows it: sRGB(clamp(2^ev · L)) on a texture, in 8 bits the same values as in a PNG.

use super::{Film, Gpu};
use bytemuck::{Pod, Zeroable};
use relume_formats::basis::srgb_from_linear;
use wgpu::{BufferUsages, CommandEncoder, TextureFormat, TextureView};

const SHADER: &str = include_str!("tonemap.wgsl");

/// The pass that shows a film on textures of one format.
pub(crate) struct Tonemap {
    format: TextureFormat,
    pipeline: wgpu::RenderPipeline,
    bands: Vec<Work>,
}

/// A band of the film.
struct Work {
    band: Band,
    uniform: wgpu::Buffer,
    bindings: wgpu::BindGroup,
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
    /// Shows `film` on textures of this `format`: sRGB-encoded on 8-bit formats that do not encode themselves, else linear.
    pub(crate) fn new(gpu: &Gpu, film: &Film, format: TextureFormat) -> Self {
        let holds_bytes = matches!(format, TextureFormat::Rgba8Unorm | TextureFormat::Bgra8Unorm);
        let pipeline = pipeline(gpu, format, if holds_bytes { "encoded" } else { "linear" });
        // Where nothing is encoded, the shader does without the steps.
        let steps = holds_bytes.then(|| gpu.storage("sRGB steps", &srgb_steps()));
        let layout = pipeline.get_bind_group_layout(0);
        let mut first_pixel = 0;
        let work = |buffer: &wgpu::Buffer| {
            let band = Band { first_pixel, pixels: (buffer.size() / Film::PIXEL_BYTES) as u32, width: film.size[0], gain: 1.0 };
            first_pixel += band.pixels;
            let uniform = gpu.buffer("tonemap", size_of::<Band>() as u64, BufferUsages::UNIFORM | BufferUsages::COPY_DST);
            let resources = [&uniform, buffer].into_iter().chain(&steps).map(wgpu::Buffer::as_entire_binding);
            let bindings = gpu.bind(&layout, resources);
            Work { band, uniform, bindings }
        };
        let bands = film.bands.iter().map(work).collect();
        Self { format, pipeline, bands }
    }

    /// The format of the textures that it shows a film on.
    pub(crate) fn format(&self) -> TextureFormat {
        self.format
    }

    /// Encodes the pass that fills `target`, of the size of the film, from the film as it will be by then.
    pub(crate) fn encode(&self, gpu: &Gpu, encoder: &mut CommandEncoder, target: &TextureView, exposure_ev: f32) {
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("tonemap"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: target,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations { load: wgpu::LoadOp::Clear(wgpu::Color::BLACK), store: wgpu::StoreOp::Store },
            })],
            ..Default::default()
        });
        pass.set_pipeline(&self.pipeline);
        for work in &self.bands {
            let band = Band { gain: exposure_ev.exp2(), ..work.band };
            gpu.queue.write_buffer(&work.uniform, 0, bytemuck::bytes_of(&band));
            pass.set_bind_group(0, &work.bindings, &[]);
            pass.draw(0..3, 0..1);
        }
    }
}

fn pipeline(gpu: &Gpu, format: TextureFormat, fragment: &'static str) -> wgpu::RenderPipeline {
    let module = gpu.shader("tonemap", SHADER);
    gpu.device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some("tonemap"),
        layout: None,
        vertex: wgpu::VertexState {
            module: &module,
            entry_point: Some("everywhere"),
            compilation_options: Default::default(),
            buffers: &[],
        },
        primitive: wgpu::PrimitiveState::default(),
        depth_stencil: None,
        multisample: wgpu::MultisampleState::default(),
        fragment: Some(wgpu::FragmentState {
            module: &module,
            entry_point: Some(fragment),
            compilation_options: Default::default(),
            targets: &[Some(format.into())],
        }),
        multiview_mask: None,
        cache: None,
    })
}

/// The least linear value of 0..=1 that is encoded as each 8-bit step.
fn srgb_steps() -> Vec<f32> {
    let one = 1.0_f32.to_bits();
    let least = |step: u8| {
        // Positive floats are in the order of their bits.
        let (mut below, mut reached) = (0, one);
        while below < reached {
            let middle = below + (reached - below) / 2;
            if srgb_from_linear(f32::from_bits(middle)) >= step { reached = middle } else { below = middle + 1 }
        }
        f32::from_bits(reached)
    };
    (0..=u8::MAX).map(least).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{gpu, read_bytes, target};

    #[test]
    fn a_texture_shows_what_a_png_holds() {
        let Some(gpu) = gpu() else { return };
        let size = [37, 23];
        // Every decade of radiance, negative values, what overflows the display, and what is no number.
        let mut radiance: Vec<[f32; 3]> =
            (0..37 * 23).map(|i| [i as f32 / 700.0, (i as f32 / 100.0 - 6.0).exp2(), i as f32 / 300.0 - 1.0]).collect();
        radiance[5] = [f32::INFINITY, f32::NEG_INFINITY, -0.0];
        let film = |part: &[[f32; 3]]| gpu.storage("film", &part.iter().map(|p| [p[0], p[1], p[2], 9.0]).collect::<Vec<[f32; 4]>>());
        // Bands need not end with rows.
        let (top, bottom) = radiance.split_at(300);
        let film = Film { size, bands: vec![film(top), film(bottom)] };
        for format in [TextureFormat::Rgba8Unorm, TextureFormat::Bgra8Unorm, TextureFormat::Rgba8UnormSrgb] {
            let tonemap = Tonemap::new(&gpu, &film, format);
            for ev in [-2.5_f32, 0.0, 3.0] {
                let texture = target(&gpu, size, format);
                let mut encoder = gpu.device.create_command_encoder(&Default::default());
                tonemap.encode(&gpu, &mut encoder, &texture.create_view(&Default::default()), ev);
                gpu.queue.submit([encoder.finish()]);
                for ((shown, radiance), index) in read_bytes(&gpu, &texture).into_iter().zip(&radiance).zip(0..) {
                    let [r, g, b] = radiance.map(|v| srgb_from_linear((v * ev.exp2()).clamp(0.0, 1.0)));
                    let expected = if format == TextureFormat::Bgra8Unorm { [b, g, r, 255] } else { [r, g, b, 255] };
                    // What encodes itself may round its own way.
                    let slack = u8::from(format.is_srgb());
                    assert!(
                        shown.iter().zip(expected).all(|(s, e)| s.abs_diff(e) <= slack),
                        "{format:?} {ev} {index}: {shown:?} {expected:?}"
                    );
                }
            }
        }
    }

    #[test]
    fn steps_are_where_the_encoding_changes() {
        let steps = srgb_steps();
        assert_eq!((steps.len(), steps[0]), (256, 0.0));
        for (step, least) in steps.iter().enumerate().skip(1) {
            assert_eq!(usize::from(srgb_from_linear(*least)), step);
            assert_eq!(usize::from(srgb_from_linear(least.next_down())), step - 1);
        }
    }

    #[test]
    fn the_uniform_has_the_shaders_layout() {
        use crate::gpu::layout::{expect, layout_of};
        expect(SHADER, "Band", &layout_of!(Band { first_pixel, pixels, width, gain }));
    }
}
