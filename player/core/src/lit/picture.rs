//! What the camera sees: the meshes before the environment, at two by two samples for each pixel.
//!
//! The film is drawn in bands of whole rows, one after the other on the same targets, so that memory does not
//! grow with it.

use super::light::{Light, halves_of, put};
use super::mesh::{Mesh, Object};
use super::suns::Suns;
use super::surface::Surface;
use super::targets::{Band, COLOUR, Pipelines, SAMPLES, Targets, expect_drawable};
use super::{AVERAGE, ENVIRONMENT, pipeline};
use crate::error::Result;
use crate::gpu::{Film, Gpu, Passes};
use relume_formats::bundle::Brdfs;
use relume_formats::state::{Camera, Rgb};
use wgpu::{BindingResource, CompareFunction, RenderPipeline, VertexFormat};

/// Everything between radiance at vertices and a picture.
pub(crate) struct Picture {
    targets: Targets,
    pipelines: Pipelines,
    mesh: Mesh,
    suns: Suns,
    /// What the surfaces' shader takes of vertices beside those of the mesh.
    vertices: Vec<wgpu::Buffer>,
    /// By material.
    textures: Vec<wgpu::BindGroup>,
    /// By environment map.
    maps: Vec<wgpu::BindGroup>,
}

impl Picture {
    /// A picture of `size` pixels, which is [drawable](expect_drawable), of meshes that look like
    /// `surface`, before the maps of `light`.
    pub(crate) fn new(gpu: &Gpu, size: [u32; 2], mesh: Mesh, surface: Surface, light: &Light) -> Self {
        let pipelines = Pipelines {
            surface: surface_pipeline(gpu, &surface),
            background: background_pipeline(gpu),
            average: gpu.compute_pipeline(AVERAGE, "average"),
            materials: mesh.materials.clone(),
            bound: surface.bound.clone(),
            environment: light.uniform().clone(),
        };
        let background = pipelines.background.get_bind_group_layout(1);
        let textures = pipelines.surface.get_bind_group_layout(1);
        let texture = |(index, view): (usize, &wgpu::TextureView)| {
            let of_material = surface.of_materials.get(index).map_or(&[][..], Vec::as_slice);
            let bound = of_material.iter().map(|(binding, bound)| (*binding, bound.resource()));
            gpu.bind_at(&textures, [(0, BindingResource::TextureView(view))].into_iter().chain(bound))
        };
        Self {
            textures: mesh.textures.iter().enumerate().map(texture).collect(),
            maps: light.maps().iter().map(|map| halves_of(gpu, &background, map)).collect(),
            targets: Targets::new(gpu, size, &pipelines),
            suns: Suns::new(gpu, &mesh, &pipelines.surface),
            pipelines,
            mesh,
            vertices: surface.vertices.into_iter().map(|(buffer, _)| buffer).collect(),
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
            put(&mut self.maps, index, halves_of(gpu, &layout, map));
        }
    }

    /// Sets where the camera stands, and the factor on all light.
    pub(crate) fn set(&self, gpu: &Gpu, camera: &Camera, gain: Rgb) {
        self.targets.set(gpu, camera, gain, self.mesh.near);
    }

    /// Sets how materials reflect; textures stay.
    pub(crate) fn set_materials(&mut self, gpu: &Gpu, brdfs: &Brdfs) {
        self.mesh.set_materials(gpu, brdfs);
    }

    /// Takes the suns of `light` as it stands now.
    pub(crate) fn set_suns(&mut self, gpu: &Gpu, light: &Light) {
        self.suns.set_light(gpu, light);
    }

    /// Vertices move in the next frame.
    pub(crate) fn vertices_move(&mut self) {
        self.suns.vertices_move();
    }

    /// Encodes the passes that fill the film, with environment map number `map` behind everything.
    pub(crate) fn encode(&mut self, map: usize, passes: &mut Passes<'_>) {
        self.suns.encode(&self.mesh, passes);
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
        pass.set_bind_group(2, &self.suns.bindings, &[]);
        let Mesh { positions, uvs, normals, .. } = &self.mesh;
        for (slot, buffer) in (0..).zip([positions, uvs, normals].into_iter().chain(&self.vertices)) {
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

    /// [vertices] three floats: unit shading normals, world space.
    pub(crate) fn normals(&self) -> &wgpu::Buffer {
        &self.mesh.normals
    }

    /// The film.
    pub(crate) fn film(&self) -> &Film {
        &self.targets.film
    }
}

/// Both sides are drawn: a surface hides what is behind it, wherever it is seen from.
fn surface_pipeline(gpu: &Gpu, surface: &Surface) -> RenderPipeline {
    let of_mesh =
        [VertexFormat::Float32x3, VertexFormat::Float32x2, VertexFormat::Float32x3].map(|f| vec![f]);
    let known = surface.vertices.iter().map(|(_, count)| vec![VertexFormat::Float32x4; *count]);
    let mut location = 0;
    let attributes = of_mesh.into_iter().chain(known).map(|formats| {
        let attributes = pipeline::vertices(location, &formats);
        location += formats.len() as u32;
        attributes
    });
    let attributes: Vec<_> = attributes.collect();
    let buffers: Vec<_> = attributes.iter().map(|attributes| pipeline::buffer(attributes)).collect();
    let targets = [Some(COLOUR.into())];
    pipeline::new(
        gpu,
        surface.shader,
        ("corner", Some("surface")),
        &buffers,
        &targets,
        CompareFunction::Greater,
    )
}

/// Drawn last, where nothing is.
fn background_pipeline(gpu: &Gpu) -> RenderPipeline {
    let (points, targets) = (("everywhere", Some("background")), [Some(COLOUR.into())]);
    pipeline::new(gpu, ENVIRONMENT, points, &[], &targets, CompareFunction::GreaterEqual)
}
