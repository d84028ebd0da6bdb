//! The film as a display shows it: sRGB(curve(2^ev · L)) on a texture, in 8 bits what a PNG holds.

use super::{Film, Gpu};
use bytemuck::{Pod, Zeroable};
use relume_formats::basis::srgb_from_linear;
use relume_formats::display::{Display, Tonemap as Curve};
use wgpu::{BufferUsages, CommandEncoder, TextureFormat, TextureView};

const SHADER: &str = include_str!("tonemap.wgsl");

/// The pass that shows a film on textures of one format.
pub(crate) struct Tonemap {
    format: TextureFormat,
    pipeline: wgpu::RenderPipeline,
    /// The sRGB steps, where values are encoded; elsewhere the shader does without.
    steps: Option<wgpu::Buffer>,
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
    curve: u32,
}

impl Tonemap {
    /// Shows `film` on textures of this `format`: sRGB-encoded on 8-bit formats that do not encode
    /// themselves, else linear.
    pub(crate) fn new(gpu: &Gpu, film: &Film, format: TextureFormat) -> Self {
        let holds_bytes = matches!(format, TextureFormat::Rgba8Unorm | TextureFormat::Bgra8Unorm);
        let pipeline = pipeline(gpu, format, if holds_bytes { "encoded" } else { "linear" });
        let steps = holds_bytes.then(|| gpu.storage("sRGB steps", &srgb_steps()));
        let mut tonemap = Self { format, pipeline, steps, bands: Vec::new() };
        tonemap.set_film(gpu, film);
        tonemap
    }

    /// Shows `film` from now on.
    pub(crate) fn set_film(&mut self, gpu: &Gpu, film: &Film) {
        let layout = self.pipeline.get_bind_group_layout(0);
        let mut first_pixel = 0;
        let work = |buffer: &wgpu::Buffer| {
            let pixels = (buffer.size() / Film::PIXEL_BYTES) as u32;
            let band = Band { first_pixel, pixels, width: film.size[0], gain: 1.0, curve: 0 };
            first_pixel += pixels;
            let usage = BufferUsages::UNIFORM | BufferUsages::COPY_DST;
            let uniform = gpu.buffer("tonemap", size_of::<Band>() as u64, usage);
            let resources = [&uniform, buffer].into_iter().chain(&self.steps);
            let bindings = gpu.bind(&layout, resources.map(wgpu::Buffer::as_entire_binding));
            Work { band, uniform, bindings }
        };
        self.bands = film.bands.iter().map(work).collect();
    }

    /// The format of the textures that it shows a film on.
    pub(crate) fn format(&self) -> TextureFormat {
        self.format
    }

    /// Encodes the pass that fills `target`, of the size of the film, from the film as it will be by then.
    pub(crate) fn encode(
        &self,
        gpu: &Gpu,
        encoder: &mut CommandEncoder,
        target: &TextureView,
        display: Display,
    ) {
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("tonemap"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: target,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations {
                    load: wgpu::LoadOp::Clear(wgpu::Color::BLACK),
                    store: wgpu::StoreOp::Store,
                },
            })],
            ..Default::default()
        });
        pass.set_pipeline(&self.pipeline);
        for work in &self.bands {
            let band =
                Band { gain: display.exposure_ev.exp2(), curve: number_of(display.tonemap), ..work.band };
            gpu.queue.write_buffer(&work.uniform, 0, bytemuck::bytes_of(&band));
            pass.set_bind_group(0, &work.bindings, &[]);
            pass.draw(0..3, 0..1);
        }
    }
}

/// The number of a curve in `tonemap.wgsl`.
fn number_of(curve: Curve) -> u32 {
    match curve {
        Curve::Clamp => 0,
        Curve::Neutral => 1,
        Curve::Agx => 2,
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
            if srgb_from_linear(f32::from_bits(middle)) >= step {
                reached = middle
            } else {
                below = middle + 1
            }
        }
        f32::from_bits(reached)
    };
    (0..=u8::MAX).map(least).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{gpu, read_bytes, read_texels, target};

    /// What `display` shows of `radiance` on a texture of `format`, from two bands that do not end with rows.
    fn shown(gpu: &Gpu, radiance: &[[f32; 3]], display: Display, format: TextureFormat) -> wgpu::Texture {
        let film = |part: &[[f32; 3]]| {
            gpu.storage("film", &part.iter().map(|p| [p[0], p[1], p[2], 9.0]).collect::<Vec<[f32; 4]>>())
        };
        let (top, bottom) = radiance.split_at(300);
        let film = Film { size: SIZE, bands: vec![film(top), film(bottom)] };
        let texture = target(gpu, SIZE, format);
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        Tonemap::new(gpu, &film, format).encode(
            gpu,
            &mut encoder,
            &texture.create_view(&Default::default()),
            display,
        );
        gpu.queue.submit([encoder.finish()]);
        texture
    }

    const SIZE: [u32; 2] = [37, 23];

    #[test]
    fn a_texture_shows_what_a_png_holds() {
        let Some(gpu) = gpu() else { return };
        // Every decade of radiance, negative values, what overflows the display, and what has no end.
        let mut radiance: Vec<[f32; 3]> = (0..37 * 23)
            .map(|i| [i as f32 / 700.0, (i as f32 / 100.0 - 6.0).exp2(), i as f32 / 300.0 - 1.0])
            .collect();
        radiance[5] = [f32::INFINITY, f32::NEG_INFINITY, -0.0];
        for format in [TextureFormat::Rgba8Unorm, TextureFormat::Bgra8Unorm, TextureFormat::Rgba8UnormSrgb] {
            for (tonemap, exposure_ev) in
                Curve::ALL.into_iter().flat_map(|curve| [-2.5_f32, 0.0, 3.0].map(|ev| (curve, ev)))
            {
                let display = Display { exposure_ev, tonemap };
                let texture = shown(&gpu, &radiance, display, format);
                for ((shown, radiance), index) in
                    read_bytes(&gpu, &texture).into_iter().zip(&radiance).zip(0..)
                {
                    let [r, g, b] = display.shown(*radiance).map(srgb_from_linear);
                    let expected =
                        if format == TextureFormat::Bgra8Unorm { [b, g, r, 255] } else { [r, g, b, 255] };
                    // What encodes itself may round its own way, and curves divide and take powers as the
                    // device does.
                    let slack = u8::from(format.is_srgb() || tonemap != Curve::Clamp);
                    assert!(
                        shown.iter().zip(expected).all(|(s, e)| s.abs_diff(e) <= slack),
                        "{format:?} {display:?} {index}: {shown:?} {expected:?}"
                    );
                }
            }
        }
    }

    /// All combinations of some values in three channels, on a texture that does not round.
    #[test]
    fn curves_are_those_of_the_cpu() {
        let Some(gpu) = gpu() else { return };
        let values =
            [-1.0, 0.0, 1e-6, 0.003, 0.04, 0.08, 0.3, 0.8, 2.5, 40.0, 1e6, f32::MAX, f32::INFINITY, f32::NAN];
        let pick = |i: usize| values[i % values.len()];
        let all: Vec<[f32; 3]> = (0..values.len().pow(3))
            .map(|i| [pick(i), pick(i / values.len()), pick(i / values.len().pow(2))])
            .collect();
        let pixels = (SIZE[0] * SIZE[1]) as usize;
        for (tonemap, part) in
            Curve::ALL.into_iter().flat_map(|curve| all.chunks(pixels).map(move |part| (curve, part)))
        {
            let display = Display { exposure_ev: 0.5, tonemap };
            let mut radiance = part.to_vec();
            radiance.resize(pixels, [0.5; 3]);
            let texture = shown(&gpu, &radiance, display, TextureFormat::Rgba32Float);
            for (radiance, shown) in radiance.iter().zip(read_texels::<[f32; 4]>(&gpu, &texture)) {
                let expected = display.shown(*radiance);
                // Devices may take powers of 2 as exp2 and log2 do, to some 10⁻⁶.
                assert!(
                    (0..3).all(|c| (shown[c] - expected[c]).abs() <= 2e-5),
                    "{tonemap:?} of {radiance:?}: {shown:?} {expected:?}"
                );
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
        expect(SHADER, "Band", &layout_of!(Band { first_pixel, pixels, width, gain, curve }));
    }
}
