//! What vertices show the eye: all that they receive in the columns of their spaces, and what their materials
//! make of it.

use super::bands::TILE;
use super::blurs::Blurs;
use super::dispatches::{Dispatches, uniform};
use super::gpu_data::{Look, Place};
use super::stage::Band;
use super::tables::Tables;
use super::{GATHER, GLOSSY, LOOK};
use crate::gpu::{Gpu, Passes};
use crate::lit::{Bound, Surface};
use relume_formats::kinds::StoredScene;
use wgpu::{Buffer, BufferUsages};

/// Wide words of the visible parts of a vertex: of 16 cones.
pub(super) const VISIBLE_WORDS: usize = 4;

/// What makes what is seen of what arrives.
pub(super) struct Shown {
    gather: Dispatches,
    show: Dispatches,
    /// By band.
    looks: Vec<(Look, Buffer)>,
    /// By vertex of the scene, four floats each, before the light's gain: what the diffuse part shows.
    pub(super) radiance: Buffer,
    /// What the glossy part shows.
    pub(super) glossy: Buffer,
    /// [vertices, 16] visible parts of cones.
    pub(super) visible: Buffer,
}

impl Shown {
    /// For the `bands` of the vertices of `scene`, under the map in `blurs`.
    pub(super) fn new(
        gpu: &Gpu,
        scene: &StoredScene,
        bands: &[Band],
        tables: &Tables,
        blurs: &Blurs,
    ) -> Self {
        let places = gpu.storage("places", &places(scene));
        let usage = BufferUsages::STORAGE | BufferUsages::VERTEX | BufferUsages::COPY_SRC;
        let bytes = (scene.positions.len() * size_of::<[f32; 4]>()) as u64;
        let [radiance, glossy] = ["radiance", "glossy"].map(|label| gpu.buffer(label, bytes, usage));
        let mut shown = Self {
            gather: Dispatches::new(gpu, GATHER, "gather"),
            show: Dispatches::new(gpu, LOOK, "show"),
            looks: Vec::new(),
            visible: gpu.buffer("visible parts", VISIBLE_WORDS as u64 * bytes, usage),
            radiance,
            glossy,
        };
        for band in bands {
            let look = Look {
                eye: [0.0; 3],
                first_vertex: band.vertices.start,
                vertices: band.vertices.len() as u32,
                unused: [0; 3],
            };
            let place = uniform(gpu, "look", &look);
            let workgroups = gpu.workgroups(look.vertices, TILE);
            let Band { direct, arriving, received, seen, .. } = band;
            let own = |buffers: &[&Buffer]| -> Vec<(u32, Bound)> {
                let own = (0..).zip([&place, &places].into_iter().chain(buffers.iter().copied()));
                let own =
                    own.chain(tables.bound()).map(|(number, buffer)| (number, Bound::Buffer(buffer.clone())));
                own.collect()
            };
            shown.gather.push_at(gpu, own(&[direct, arriving, received]), workgroups);
            let shows = own(&[received, arriving, seen, &shown.radiance, &shown.glossy, &shown.visible]);
            shown.show.push_at(gpu, shows.into_iter().chain(blurs.bound()), workgroups);
            shown.looks.push((look, place));
        }
        shown
    }

    /// What surfaces are drawn with, whose points have highlights of the map in `blurs`.
    pub(super) fn surface(&self, tables: &Tables, blurs: &Blurs) -> Surface {
        Surface {
            shader: GLOSSY,
            vertices: vec![
                (self.radiance.clone(), 1),
                (self.glossy.clone(), 1),
                (self.visible.clone(), VISIBLE_WORDS),
            ],
            bound: blurs.bound().to_vec(),
            of_materials: tables.of_materials(),
        }
    }

    /// Sets where the eye is, metres in world space.
    pub(super) fn set_eye(&mut self, gpu: &Gpu, eye: [f32; 3]) {
        for (look, place) in &mut self.looks {
            look.eye = eye;
            gpu.queue.write_buffer(place, 0, bytemuck::bytes_of(look));
        }
    }

    /// Encodes what does not depend on the eye.
    pub(super) fn encode_received(&self, passes: &mut Passes<'_>) {
        self.gather.encode(passes);
    }

    /// Encodes what the eye sees.
    pub(super) fn encode(&self, passes: &mut Passes<'_>) {
        self.show.encode(passes);
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
