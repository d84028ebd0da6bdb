//! What the camera sees: the meshes before the environment, at two by two samples for each pixel.
//!
//! The film is drawn in bands of whole rows, one after the other on the same targets, so that memory does not
//! grow with it.

use super::gpu_data::View;
use super::light::{Light, put};
use super::mesh::{Mesh, Object};
use super::{AVERAGE, ENVIRONMENT};
use crate::error::{Error, Result};
use crate::gpu::{Film, Gpu, Passes};
use relume_formats::state::{Camera, Rgb};
use wgpu::{
    BufferUsages, CompareFunction, RenderPipeline, TextureFormat, VertexBufferLayout, VertexFormat,
    VertexStepMode,
};

/// Samples along a side of a pixel.
const SAMPLES: u32 = 2;
/// Pixels of a band; its targets take 80 bytes for each.
const BAND_PIXELS: u32 = 1 << 20;
/// Invocations of a workgroup that averages, as in the shader.
const WORKGROUP: u32 = 64;
/// Samples are linear radiance, of any size and exact.
const COLOUR: TextureFormat = TextureFormat::Rgba32Float;
const DEPTH: TextureFormat = TextureFormat::Depth32Float;

/// Everything between radiance at vertices and a picture.
pub(crate) struct Picture {
    film: Film,
    bands: Vec<Band>,
    mesh: Mesh,
    radiance: wgpu::Buffer,
    colour: wgpu::TextureView,
    depth: wgpu::TextureView,
    surface: RenderPipeline,
    /// By material.
    textures: Vec<wgpu::BindGroup>,
    background: RenderPipeline,
    /// By environment map.
    maps: Vec<wgpu::BindGroup>,
    average: wgpu::ComputePipeline,
}

/// Consecutive rows of the film.
struct Band {
    first_row: u32,
    rows: u32,
    view: wgpu::Buffer,
    surface: wgpu::BindGroup,
    background: wgpu::BindGroup,
    average: wgpu::BindGroup,
    workgroups: [u32; 2],
}

impl Picture {
    /// A picture of `size` pixels, of meshes with this `radiance` by vertex, before the maps of `light`. The
    /// shader `surface` says how a surface looks: its fragment entry point is `surface`, its vertices are
    /// those of the snippet `corner`.
    ///
    /// # Errors
    /// If the GPU cannot draw so wide a picture.
    pub(crate) fn new(
        gpu: &Gpu,
        size: [u32; 2],
        mesh: Mesh,
        radiance: &wgpu::Buffer,
        light: &Light,
        surface: &'static str,
    ) -> Result<Self> {
        let most = gpu.device.limits().max_texture_dimension_2d / SAMPLES;
        let [width, height] = size;
        if width > most {
            let reason = format!(
                "GPU {} draws at most {most} pixels a row, not {width}; give a smaller size",
                gpu.name
            );
            return Err(Error::Request(reason));
        }
        let rows = (BAND_PIXELS / width).clamp(1, height.min(most));
        let film = Film::new(
            gpu,
            size,
            (0..height).step_by(rows as usize).map(|row| (width * rows.min(height - row)) as usize),
        );
        let colour = gpu.target("samples", [SAMPLES * width, SAMPLES * rows], COLOUR);
        let depth = gpu.target("depth", [SAMPLES * width, SAMPLES * rows], DEPTH);
        let (surface, background) = (surface_pipeline(gpu, surface), background_pipeline(gpu));
        let one = |pipeline: &RenderPipeline, view| {
            gpu.bind(&pipeline.get_bind_group_layout(1), [wgpu::BindingResource::TextureView(view)])
        };
        let mut picture = Self {
            textures: mesh.textures.iter().map(|texture| one(&surface, texture)).collect(),
            maps: light.maps().iter().map(|map| one(&background, &map.texels)).collect(),
            average: gpu.compute_pipeline(AVERAGE, "average"),
            bands: Vec::new(),
            film,
            mesh,
            radiance: radiance.clone(),
            colour,
            depth,
            surface,
            background,
        };
        picture.bands = picture
            .film
            .bands
            .iter()
            .zip((0..height).step_by(rows as usize))
            .map(|(film, row)| picture.band(gpu, film, row, light))
            .collect();
        Ok(picture)
    }

    fn band(&self, gpu: &Gpu, film: &wgpu::Buffer, first_row: u32, light: &Light) -> Band {
        let pixels = (film.size() / Film::PIXEL_BYTES) as u32;
        let view =
            gpu.buffer("view", size_of::<View>() as u64, BufferUsages::UNIFORM | BufferUsages::COPY_DST);
        let surface = [view.as_entire_binding(), self.mesh.materials.as_entire_binding()];
        let average = [wgpu::BindingResource::TextureView(&self.colour), film.as_entire_binding()];
        Band {
            first_row,
            rows: pixels / self.film.size[0],
            surface: gpu.bind(&self.surface.get_bind_group_layout(0), surface),
            background: background_bindings(gpu, &self.background, light.uniform(), &view),
            average: gpu.bind(&self.average.get_bind_group_layout(0), average),
            workgroups: gpu.workgroups(pixels, WORKGROUP),
            view,
        }
    }

    /// Takes map number `index` of `light`, which is one of those that there are or the next.
    pub(crate) fn set_map(&mut self, gpu: &Gpu, index: usize, light: &Light) {
        if let Some(map) = light.maps().get(index) {
            let layout = self.background.get_bind_group_layout(1);
            put(&mut self.maps, index, gpu.bind(&layout, [wgpu::BindingResource::TextureView(&map.texels)]));
        }
    }

    /// Sets where the camera stands, and the factor on all light.
    pub(crate) fn set(&self, gpu: &Gpu, camera: &Camera, gain: Rgb) {
        let [width, height] = self.film.size;
        let film = camera.film(width, height);
        let [forward, right, up] = film.axes().map(|axis| axis.to_array());
        for band in &self.bands {
            let v = |row: u32| 1.0 - 2.0 * row as f32 / height as f32;
            let (top, bottom) = (v(band.first_row), v(band.first_row + band.rows));
            let view = View {
                eye_in_world: film.eye_in_world.to_array(),
                near: self.mesh.near,
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

    /// Encodes the passes that fill the film, with environment map number `map` behind everything.
    pub(crate) fn encode(&self, map: usize, passes: &mut Passes<'_>) {
        for band in &self.bands {
            self.draw(band, map, passes);
            let mut pass = passes.compute("average");
            pass.set_pipeline(&self.average);
            pass.set_bind_group(0, &band.average, &[]);
            pass.dispatch_workgroups(band.workgroups[0], band.workgroups[1], 1);
        }
    }

    fn draw(&self, band: &Band, map: usize, passes: &mut Passes<'_>) {
        let mut pass = passes.draw("draw", &self.colour, &self.depth);
        let [width, height] = [self.film.size[0], band.rows].map(|pixels| (SAMPLES * pixels) as f32);
        pass.set_viewport(0.0, 0.0, width, height, 0.0, 1.0);
        pass.set_pipeline(&self.surface);
        pass.set_bind_group(0, &band.surface, &[]);
        for (slot, buffer) in (0..).zip([&self.mesh.positions, &self.radiance, &self.mesh.uvs]) {
            pass.set_vertex_buffer(slot, buffer.slice(..));
        }
        pass.set_index_buffer(self.mesh.triangles.slice(..), wgpu::IndexFormat::Uint32);
        for Object { indices, material } in &self.mesh.objects {
            if let Some(texture) = self.textures.get(*material as usize) {
                pass.set_bind_group(1, texture, &[]);
                // The number of the instance tells the shader the material.
                pass.draw_indexed(indices.clone(), 0, *material..*material + 1);
            }
        }
        if let Some(map) = self.maps.get(map) {
            pass.set_pipeline(&self.background);
            pass.set_bind_group(0, &band.background, &[]);
            pass.set_bind_group(1, map, &[]);
            pass.draw(0..3, 0..1);
        }
    }

    /// [vertices] three floats: where vertices are drawn, metres, world space.
    pub(crate) fn positions(&self) -> &wgpu::Buffer {
        &self.mesh.positions
    }

    /// The film.
    pub(crate) fn film(&self) -> &Film {
        &self.film
    }
}

/// Both sides are drawn: a surface hides what is behind it, wherever it is seen from.
fn surface_pipeline(gpu: &Gpu, shader: &str) -> RenderPipeline {
    let attribute = |format, shader_location| [wgpu::VertexAttribute { format, offset: 0, shader_location }];
    let [position, radiance, uv] = [
        attribute(VertexFormat::Float32x3, 0),
        attribute(VertexFormat::Float32x4, 1),
        attribute(VertexFormat::Float32x2, 2),
    ];
    let buffers = [&position, &radiance, &uv].map(|attributes| {
        let array_stride = attributes.iter().map(|attribute| attribute.format.size()).sum();
        Some(VertexBufferLayout { array_stride, step_mode: VertexStepMode::Vertex, attributes })
    });
    pipeline(gpu, shader, ["corner", "surface"], &buffers, CompareFunction::Greater)
}

/// Drawn last, where nothing is.
fn background_pipeline(gpu: &Gpu) -> RenderPipeline {
    pipeline(gpu, ENVIRONMENT, ["everywhere", "background"], &[], CompareFunction::GreaterEqual)
}

fn pipeline(
    gpu: &Gpu,
    shader: &str,
    [vertex, fragment]: [&'static str; 2],
    buffers: &[Option<VertexBufferLayout<'_>>],
    compare: CompareFunction,
) -> RenderPipeline {
    let module = gpu.shader(fragment, shader);
    gpu.device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some(fragment),
        layout: None,
        vertex: wgpu::VertexState {
            module: &module,
            entry_point: Some(vertex),
            compilation_options: Default::default(),
            buffers,
        },
        primitive: wgpu::PrimitiveState::default(),
        depth_stencil: Some(wgpu::DepthStencilState {
            format: DEPTH,
            depth_write_enabled: Some(true),
            depth_compare: Some(compare),
            stencil: wgpu::StencilState::default(),
            bias: wgpu::DepthBiasState::default(),
        }),
        multisample: wgpu::MultisampleState::default(),
        fragment: Some(wgpu::FragmentState {
            module: &module,
            entry_point: Some(fragment),
            compilation_options: Default::default(),
            targets: &[Some(COLOUR.into())],
        }),
        multiview_mask: None,
        cache: None,
    })
}

/// The bindings of the background, which are not consecutive: binding 1 is of the resampling.
fn background_bindings(
    gpu: &Gpu,
    pipeline: &RenderPipeline,
    environment: &wgpu::Buffer,
    view: &wgpu::Buffer,
) -> wgpu::BindGroup {
    let entries = [(0, environment), (2, view)]
        .map(|(binding, buffer)| wgpu::BindGroupEntry { binding, resource: buffer.as_entire_binding() });
    gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: Some("background"),
        layout: &pipeline.get_bind_group_layout(0),
        entries: &entries,
    })
}
