//! What vertices show the eye: all that they receive in the columns of their spaces, and what their materials
//! make of it.

use super::bands::TILE;
use super::dispatches::{Dispatches, uniform};
use super::gpu_data::{Look, Place};
use super::stage::Band;
use super::tables::Tables;
use super::{GATHER, LOOK};
use crate::gpu::{Gpu, Passes};
use relume_formats::kinds::StoredScene;
use wgpu::{BindGroup, Buffer, BufferUsages};

/// What makes what is seen of what arrives.
pub(super) struct Shown {
    gather: Dispatches,
    show: Dispatches,
    /// By band.
    looks: Vec<(Look, Buffer)>,
    /// By environment map, as soon as it has shone.
    maps: Vec<Option<BindGroup>>,
    /// By vertex of the scene, four floats each, before the light's gain: what the diffuse part shows.
    pub(super) radiance: Buffer,
    /// What the glossy part shows.
    pub(super) glossy: Buffer,
}

impl Shown {
    /// For the `bands` of the vertices of `scene`.
    pub(super) fn new(gpu: &Gpu, scene: &StoredScene, bands: &[Band], tables: &Tables) -> Self {
        let places = gpu.storage("places", &places(scene));
        let usage = BufferUsages::STORAGE | BufferUsages::VERTEX | BufferUsages::COPY_SRC;
        let bytes = (scene.positions.len() * size_of::<[f32; 4]>()) as u64;
        let [radiance, glossy] = ["radiance", "glossy"].map(|label| gpu.buffer(label, bytes, usage));
        let mut shown = Self {
            gather: Dispatches::new(gpu, GATHER, "gather"),
            show: Dispatches::new(gpu, LOOK, "show"),
            maps: Vec::new(),
            looks: Vec::new(),
            radiance,
            glossy,
        };
        for band in bands {
            let look = Look {
                eye: [0.0; 3],
                first_vertex: band.vertices.start,
                vertices: band.vertices.len() as u32,
                sin_rotation: 0.0,
                cos_rotation: 1.0,
                directions: tables.directions,
                spaces: tables.places,
            };
            let place = uniform(gpu, "look", &look);
            let workgroups = gpu.workgroups(look.vertices, TILE);
            let Band { direct, arriving, received, seen, .. } = band;
            let common = [&place, &places, &tables.buffer];
            let buffers = [&common[..], &[direct, arriving, received]].concat();
            shown.gather.push(gpu, &buffers, workgroups);
            let buffers = [&common[..], &[received, arriving, seen, &shown.radiance, &shown.glossy]].concat();
            shown.show.push(gpu, &buffers, workgroups);
            shown.looks.push((look, place));
        }
        shown
    }

    /// Sets where the eye is, metres in world space, and how far the light is turned.
    pub(super) fn set(&mut self, gpu: &Gpu, eye: [f32; 3], rotation_deg: f32) {
        for (look, place) in &mut self.looks {
            let (sin_rotation, cos_rotation) = rotation_deg.to_radians().sin_cos();
            *look = Look { eye, sin_rotation, cos_rotation, ..*look };
            gpu.queue.write_buffer(place, 0, bytemuck::bytes_of(look));
        }
    }

    /// Takes map number `index`, [filtered](super::blurs).
    pub(super) fn set_map(&mut self, gpu: &Gpu, index: usize, map: &Buffer) {
        self.maps.resize(self.maps.len().max(index + 1), None);
        if let Some(known) = self.maps.get_mut(index) {
            *known = Some(self.show.common(gpu, map));
        }
    }

    /// Encodes what does not depend on the eye.
    pub(super) fn encode_received(&self, passes: &mut Passes<'_>) {
        self.gather.encode(passes);
    }

    /// Encodes what the eye sees under map number `map`.
    pub(super) fn encode(&self, map: usize, passes: &mut Passes<'_>) {
        if let Some(Some(map)) = self.maps.get(map) {
            self.show.encode_with(passes, Some(map));
        }
    }
}

fn places(scene: &StoredScene) -> Vec<Place> {
    let materials = scene.materials_of_vertices();
    let vertices = scene.positions.iter().zip(&scene.normals).zip(&materials);
    let place = |((position, normal), material): ((&[f32; 3], &[f32; 3]), &u32)| Place {
        position: *position,
        material: *material,
        normal: *normal,
        unused: 0,
    };
    vertices.map(place).collect()
}
