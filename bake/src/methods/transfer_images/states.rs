//! States of the materials of a scene, as they are and as later reflections are baked.

use super::later::lambert;
use crate::brdf;
use glam::Vec3A;
use relume_formats::basis::Angles;
use relume_formats::kinds::BrdfBasis;
use relume_formats::kinds::transfer_images::Later;
use relume_formats::state::Brdf;
use relume_scenes::Scene;

/// A state of the materials.
pub(super) struct State {
    /// Of all of them.
    materials: Vec<Brdf>,
    /// For each: the BRDF of its effective albedo, if it varies and later reflections are baked.
    lambert: Vec<Option<Vec3A>>,
}

impl State {
    /// With these parameters of the materials that vary.
    pub(super) fn new(scene: &Scene, varying: &[Brdf], later: Option<&Later>, basis: &BrdfBasis) -> Self {
        let mut lambert_of = vec![None; scene.materials.len()];
        if let Some(later) = later {
            let on_bases: Vec<_> = varying.iter().filter_map(|m| basis.coefficients_of(m)).collect();
            let albedos = later.albedos_of(&on_bases);
            for (index, albedo) in scene.vary.materials.iter().zip(albedos) {
                lambert_of[*index] = Some(lambert(albedo.into()));
            }
        }
        Self { materials: all_materials(scene, varying), lambert: lambert_of }
    }

    /// As it is, sr⁻¹.
    pub(super) fn brdf(&self, material: u32, albedo: Vec3A, angles: &Angles) -> Vec3A {
        brdf::evaluate(&self.materials[material as usize], albedo, angles)
    }

    /// At third and later reflections as they are baked.
    pub(super) fn by_albedo(&self, material: u32, albedo: Vec3A, angles: &Angles) -> Vec3A {
        self.lambert[material as usize].unwrap_or_else(|| self.brdf(material, albedo, angles))
    }
}

/// Every material's parameters with the varying ones replaced.
pub(super) fn all_materials(scene: &Scene, varying: &[Brdf]) -> Vec<Brdf> {
    let mut all: Vec<Brdf> = scene.materials.iter().map(|m| m.brdf).collect();
    for (index, material) in scene.vary.materials.iter().zip(varying) {
        all[*index] = *material;
    }
    all
}
