//! What the camera sees: the meshes before the environment, at two by two samples for each pixel.
//!
//! The film is drawn in bands of whole rows, one after the other on the same targets, so that memory does not
//! grow with it.

use super::light::{Light, put};
use super::mesh::{Mesh, Object};
use super::targets::{Band, COLOUR, DEPTH, Pipelines, SAMPLES, Targets, expect_drawable};
use super::{AVERAGE, ENVIRONMENT};
use crate::error::Result;
use crate::gpu::{Film, Gpu, Passes};
use relume_formats::state::{Camera, Rgb};
use wgpu::{
    BindingResource, CompareFunction, RenderPipeline, VertexBufferLayout, VertexFormat, VertexStepMode,
};

/// Everything between radiance at vertices and a picture.
pub(crate) struct Picture {
    targets: Targets,
    pipelines: Pipelines,
    mesh: Mesh,
    radiance: wgpu::Buffer,
    /// By material.
    textures: Vec<wgpu::BindGroup>,
    /// By environment map.
    maps: Vec<wgpu::BindGroup>,
}

impl Picture {
    /// A picture of `size` pixels, which is [drawable](expect_drawable), of meshes with this `radiance` by
    /// vertex, before the maps of `light`. The shader `surface` says how a surface looks: its fragment entry
    /// point is `surface`, its vertices are those of the snippet `corner`.
    pub(crate) fn new(
        gpu: &Gpu,
        size: [u32; 2],
        mesh: Mesh,
        radiance: &wgpu::Buffer,
        light: &Light,
        surface: &'static str,
    ) -> Self {
        let pipelines = Pipelines {
            surface: surface_pipeline(gpu, surface),
            background: background_pipeline(gpu),
            average: gpu.compute_pipeline(AVERAGE, "average"),
            materials: mesh.materials.clone(),
            environment: light.uniform().clone(),
        };
        let one = |pipeline: &RenderPipeline, view| {
            gpu.bind(&pipeline.get_bind_group_layout(1), [BindingResource::TextureView(view)])
        };
        Self {
            textures: mesh.textures.iter().map(|texture| one(&pipelines.surface, texture)).collect(),
            maps: light.maps().iter().map(|map| one(&pipelines.background, &map.texels)).collect(),
            targets: Targets::new(gpu, size, &pipelines),
            pipelines,
            mesh,
            radiance: radiance.clone(),
        }
    }

    /// Draws films of `size` pixels from now on. Nothing else is made anew, and the film is black until it is
    /// drawn.
    ///
    /// # Errors
    /// If such films [cannot be drawn](expect_drawable). Then nothing has changed.
    pub(crate) fn resize(&mut self, gpu: &Gpu, size: [u32; 2]) -> Result<()> {
        expect_drawable(gpu, size)?;
        if size != self.targets.film.size {
            self.targets = Targets::new(gpu, size, &self.pipelines);
        }
        Ok(())
    }

    /// Takes map number `index` of `light`, which is one of those that there are or the next.
    pub(crate) fn set_map(&mut self, gpu: &Gpu, index: usize, light: &Light) {
        if let Some(map) = light.maps().get(index) {
            let layout = self.pipelines.background.get_bind_group_layout(1);
            put(&mut self.maps, index, gpu.bind(&layout, [BindingResource::TextureView(&map.texels)]));
        }
    }

    /// Sets where the camera stands, and the factor on all light.
    pub(crate) fn set(&self, gpu: &Gpu, camera: &Camera, gain: Rgb) {
        self.targets.set(gpu, camera, gain, self.mesh.near);
    }

    /// Encodes the passes that fill the film, with environment map number `map` behind everything.
    pub(crate) fn encode(&self, map: usize, passes: &mut Passes<'_>) {
        for band in &self.targets.bands {
            self.draw(band, map, passes);
            let mut pass = passes.compute("average");
            pass.set_pipeline(&self.pipelines.average);
            pass.set_bind_group(0, &band.average, &[]);
            pass.dispatch_workgroups(band.workgroups[0], band.workgroups[1], 1);
        }
    }

    fn draw(&self, band: &Band, map: usize, passes: &mut Passes<'_>) {
        let mut pass = passes.draw("draw", &self.targets.colour, &self.targets.depth);
        let [width, height] = [self.targets.film.size[0], band.rows].map(|pixels| (SAMPLES * pixels) as f32);
        pass.set_viewport(0.0, 0.0, width, height, 0.0, 1.0);
        pass.set_pipeline(&self.pipelines.surface);
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
            pass.set_pipeline(&self.pipelines.background);
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
        &self.targets.film
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
