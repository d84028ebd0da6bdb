//! Method `transfer-tensor`: what a vertex receives of a light, by way of materials as they are, and what it then shows
//! the eye (thesis eq. 5-5 to 5-11; cones for the mirror terms of eq. 5-13).
//!
//! Receiving depends on light and materials, [`Parts::received`], showing on the eye, too, [`Parts::shown`]. The direct
//! light of [suns](super::suns) comes on top of it.

mod material;
mod received;
mod shown;

pub use material::{Lobes, harmonic_weights};
pub use received::{Received, received};
pub use shown::{Shown, cone_points};

use super::sparse_transfer;
use crate::basis::EquirectMap;
use crate::basis::blurred::blurred;
use crate::basis::suns::split;
use crate::kinds::scene::EnvironmentLook;
use crate::kinds::transfer_tensor::FACE_SIZE;
use crate::kinds::{BrdfBasis, BrdfTensor, StoredScene, TransferTensor};
use crate::state::{Brdf, Model, Rgb};
use glam::Vec3;

/// A bundle.
#[derive(Debug, Clone, Copy)]
pub struct Parts<'a> {
    /// Meshes and materials.
    pub scene: &'a StoredScene,
    /// One space for every model that materials have.
    pub spaces: &'a [BrdfTensor],
    /// One basis for every model that varying materials have, where light is reflected more than once.
    pub bases: &'a [BrdfBasis],
    /// The tensors.
    pub transfer: &'a TransferTensor,
}

/// What shines.
#[derive(Debug, Clone)]
pub struct Lights {
    /// Haar coefficients of the map without its suns, a plane for each channel.
    pub rest: [Vec<f32>; 3],
    /// The same of the whole map.
    pub whole: [Vec<f32>; 3],
    /// The map without its suns as cones of [`widths`] see it, not turned, before the gain.
    pub blurred: Vec<EquirectMap>,
    /// Turn of the map, degrees.
    pub rotation_deg: f32,
    /// Factor on the map.
    pub gain: Rgb,
}

impl Lights {
    /// What `map` sends, for cones of `widths_deg`.
    pub fn new(map: &EquirectMap, look: &EnvironmentLook, widths_deg: &[f32]) -> Self {
        let rest = split(map).rest;
        Self {
            rest: sparse_transfer::light(&rest, look, FACE_SIZE),
            whole: sparse_transfer::light(map, look, FACE_SIZE),
            blurred: widths_deg.iter().map(|width| blurred(&rest, *width)).collect(),
            rotation_deg: look.rotation_deg,
            gain: look.gain,
        }
    }
}

/// The widths of the cones of `spaces`, degrees, each once, increasing: what maps are filtered by.
pub fn widths(spaces: &[BrdfTensor]) -> Vec<f32> {
    let mut widths: Vec<f32> =
        spaces.iter().flat_map(|space| &space.cones).map(|cone| cone.width_deg).collect();
    widths.sort_by(f32::total_cmp);
    widths.dedup();
    widths
}

impl Parts<'_> {
    /// The space of `model`.
    pub fn space(&self, model: Model) -> Option<&BrdfTensor> {
        self.spaces.iter().find(|space| space.meta.model == model)
    }

    /// What every vertex receives if materials are `brdfs`, in the order of the scene.
    pub fn received(&self, lights: &Lights, brdfs: &[Brdf]) -> Received {
        let basis = |model: Model| self.bases.iter().find(|basis| basis.functions.model() == model);
        let coefficients = |material: u32| {
            let brdf = brdfs.get(material as usize)?;
            basis(brdf.model())?.coefficients_of(brdf)
        };
        received(self.transfer, lights, coefficients)
    }

    /// What every vertex shows an eye at the point `eye`, metres, world space.
    pub fn shown(&self, received: &Received, lights: &Lights, brdfs: &[Brdf], eye: [f32; 3]) -> Vec<Shown> {
        shown::shown(self, received, lights, brdfs, eye)
    }

    /// What the highlights of a point have of the map itself, W/(sr·m²): its material is `brdf`, its unit shading normal `normal`, `outgoing` the
    /// unit vector towards the eye, in world space, and `seen` the visible part of each cone there, that of the vertices around it
    /// interpolated; nothing if there is no space of its model.
    pub fn mirrored(&self, lights: &Lights, brdf: &Brdf, normal: Vec3, outgoing: Vec3, seen: &[f32]) -> Rgb {
        let space = self.space(brdf.model());
        let lobes = space.and_then(|space| Some((space, Lobes::new(space, brdf)?)));
        let widths = widths(self.spaces);
        lobes.map_or([0.0; 3], |(space, lobes)| {
            shown::mirrored((space, &lobes), (lights, &widths), normal, outgoing, seen)
        })
    }
}
