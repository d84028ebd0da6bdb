//! The scene's meshes and materials on the GPU.

use super::gpu_data::Material;
use super::mips::{Sheet, levels};
use crate::gpu::Gpu;
use relume_formats::basis::{Filter, Wrap};
use relume_formats::bundle::Brdfs;
use relume_formats::kinds::textures::MaterialTexture;
use relume_formats::kinds::{StoredScene, Textures};
use relume_formats::state::Brdf;
use std::ops::Range;
use wgpu::{BufferUsages, TextureFormat};

/// Meshes and what they are drawn with.
pub(crate) struct Mesh {
    /// [vertices] three floats: metres, world space.
    pub(crate) positions: wgpu::Buffer,
    /// [vertices] two floats.
    pub(crate) uvs: wgpu::Buffer,
    /// [vertices] three floats: unit shading normals, world space.
    pub(crate) normals: wgpu::Buffer,
    /// [triangles] three u32.
    pub(crate) triangles: wgpu::Buffer,
    /// By material.
    pub(crate) materials: wgpu::Buffer,
    /// What these hold.
    of_materials: Vec<Material>,
    /// By material its [sheet](Sheet); a single white texel where there is none.
    pub(crate) textures: Vec<wgpu::TextureView>,
    /// By material: whether its texture cuts holes.
    pub(crate) cuts: Vec<bool>,
    /// The objects, in the order of their triangles.
    pub(crate) objects: Vec<Object>,
    /// Nothing closer to the eye than this is drawn, metres.
    pub(crate) near: f32,
}

/// What is drawn at once.
pub(crate) struct Object {
    /// Positions in the list of vertex indices.
    pub(crate) indices: Range<u32>,
    /// Index of its material.
    pub(crate) material: u32,
}

/// The closest that is drawn, as a share of the scene's extent.
const NEAR: f32 = 1e-5;

impl Mesh {
    /// Uploads the meshes of `scene`.
    pub(crate) fn new(gpu: &Gpu, scene: &StoredScene, textures: Option<&Textures>) -> Self {
        let texture_of =
            |index: usize| textures?.textures.iter().find(|texture| texture.material as usize == index);
        let no_uvs = || vec![[0.0; 2]; scene.positions.len()];
        let uvs = textures.map_or_else(no_uvs, |textures| textures.uvs.clone());
        let materials = scene.meta.materials.iter().enumerate();
        let materials: Vec<Material> =
            materials.map(|(index, m)| material(&m.brdf, texture_of(index))).collect();
        // What moves shapes, and what shadows are computed from.
        let placed = BufferUsages::VERTEX | BufferUsages::STORAGE | BufferUsages::COPY_SRC;
        Self {
            positions: upload(gpu, "positions", placed, &scene.positions),
            uvs: upload(gpu, "uvs", BufferUsages::VERTEX, &uvs),
            normals: upload(gpu, "normals", placed, &scene.normals),
            triangles: upload(gpu, "triangles", BufferUsages::INDEX, &scene.triangles),
            materials: gpu.storage("materials", &materials),
            textures: (0..materials.len()).map(|index| texture(gpu, texture_of(index))).collect(),
            cuts: materials.iter().map(|material| material.alpha_cutoff > 0.0).collect(),
            objects: objects(scene),
            near: NEAR * extent(&scene.positions).max(f32::MIN_POSITIVE / NEAR),
            of_materials: materials,
        }
    }

    /// Makes materials reflect as `brdfs` says, which are in the order of the scene; textures stay.
    pub(super) fn set_materials(&mut self, gpu: &Gpu, brdfs: &Brdfs) {
        for (name, brdf) in brdfs.iter() {
            let material = brdfs.index_of(name).and_then(|index| self.of_materials.get_mut(index));
            material.into_iter().for_each(|material| material.set_brdf(brdf));
        }
        gpu.queue.write_buffer(&self.materials, 0, bytemuck::cast_slice(&self.of_materials));
    }
}

fn upload<T: bytemuck::Pod>(gpu: &Gpu, label: &str, usage: BufferUsages, values: &[T]) -> wgpu::Buffer {
    let buffer = gpu.buffer(label, size_of_val(values) as u64, usage | BufferUsages::COPY_DST);
    gpu.write(&buffer, 0, bytemuck::cast_slice(values));
    buffer
}

fn material(brdf: &Brdf, texture: Option<&MaterialTexture>) -> Material {
    let wrap = |wrap: Wrap| match wrap {
        Wrap::Repeat => 0,
        Wrap::Mirror => 1,
        Wrap::Clamp => 2,
    };
    let mut material = Material {
        alpha_cutoff: texture.and_then(|texture| texture.alpha_cutoff).unwrap_or(0.0),
        wrap: texture.map_or([0; 2], |texture| texture.texture.wrap.map(wrap)),
        size: texture.map_or([1; 2], |texture| texture.texture.size),
        levels: texture.map_or(0, |texture| levels(texture.texture.size)),
        nearest: u32::from(texture.is_some_and(|texture| texture.texture.filter == Filter::Nearest)),
        ..bytemuck::Zeroable::zeroed()
    };
    material.set_brdf(brdf);
    material
}

fn texture(gpu: &Gpu, texture: Option<&MaterialTexture>) -> wgpu::TextureView {
    let Some(MaterialTexture { texture, alpha_cutoff, .. }) = texture else {
        return gpu.texture("no texture", [1, 1], TextureFormat::Rgba8Unorm, &[255; 4]);
    };
    let Sheet { size, texels } = Sheet::new(texture, alpha_cutoff.is_some_and(|cutoff| cutoff > 0.0));
    gpu.texture("texture", size, TextureFormat::Rgba8Unorm, texels.as_flattened())
}

fn objects(scene: &StoredScene) -> Vec<Object> {
    let mut end = 0;
    let object = |object: &relume_formats::kinds::scene::StoredObject| {
        let begin = end;
        end += 3 * object.triangles;
        Object { indices: begin..end, material: object.material }
    };
    scene.meta.objects.iter().map(object).collect()
}

/// The largest side of the box around all points.
fn extent(points: &[[f32; 3]]) -> f32 {
    let side = |axis: usize| {
        let along = points.iter().map(|point| point[axis]);
        along.clone().fold(f32::NEG_INFINITY, f32::max) - along.fold(f32::INFINITY, f32::min)
    };
    (0..3).map(side).fold(0.0, f32::max)
}
