//! States of the materials of a scene, as they are and as later reflections are baked.

use super::held_out::{OnBases, editable_coefficients};
use super::later::{beyond_albedo, lambert};
use crate::brdf;
use crate::trace::gather::GatherPath;
use crate::trace::reference::later_radiance_of;
use crate::trace::spot::Spot;
use glam::Vec3A;
use relume_formats::basis::Angles;
use relume_formats::kinds::BrdfBasis;
use relume_formats::kinds::brdf_basis::MAX_BASES;
use relume_formats::kinds::transfer_images::Later;
use relume_formats::state::{Brdf, Rgb};
use relume_scenes::Scene;

/// A state of the materials.
pub(super) struct State<'a> {
    basis: &'a BrdfBasis,
    /// Of all of them.
    materials: Vec<Brdf>,
    /// If later reflections are baked.
    baked: Option<AsBaked<'a>>,
}

/// How materials are met by later reflections.
struct AsBaked<'a> {
    later: &'a Later,
    /// For each that varies: its coefficients, and the BRDF of its effective albedo.
    coefficients: Vec<Option<Vec<Rgb>>>,
    lambert: Vec<Option<Vec3A>>,
}

impl<'a> State<'a> {
    /// With these parameters of the materials that vary.
    pub(super) fn new(
        scene: &Scene,
        varying: &[Brdf],
        later: Option<&'a Later>,
        basis: &'a BrdfBasis,
    ) -> Self {
        let materials = all_materials(scene, varying);
        let baked = later.map(|later| {
            let coefficients = editable_coefficients(scene, basis, &materials);
            let mut lambert_of = vec![None; materials.len()];
            let on_bases: Vec<_> = varying.iter().filter_map(|m| basis.coefficients_of(m)).collect();
            for (index, albedo) in scene.vary.materials.iter().zip(later.albedos_of(&on_bases)) {
                lambert_of[*index] = Some(lambert(albedo.into()));
            }
            AsBaked { later, coefficients, lambert: lambert_of }
        });
        Self { basis, materials, baked }
    }

    /// As it is, sr⁻¹.
    pub(super) fn brdf(&self, spot: &Spot, angles: &Angles) -> Vec3A {
        brdf::evaluate(&self.materials[spot.material as usize], spot.albedo, angles)
    }

    /// Light of third and later reflections as it is baked, but for nodes; all of it if none are.
    pub(super) fn later_as_baked(&self, path: &GatherPath) -> Vec3A {
        let brdf = |spot: &Spot, angles: &Angles| self.brdf(spot, angles);
        let Some(baked) = &self.baked else { return later_radiance_of(path, brdf, brdf, brdf) };
        let by_albedo = |spot: &Spot, angles: &Angles| self.by_albedo(baked, spot, angles);
        let eye = self.on_bases(baked, baked.later.eye_bases);
        later_radiance_of(path, eye, by_albedo, by_albedo) + self.lobes_as_baked(path)
    }

    /// What of that lobes add to albedos.
    pub(super) fn lobes_as_baked(&self, path: &GatherPath) -> Vec3A {
        let Some(baked) = self.baked.as_ref().filter(|baked| baked.later.lobes > 0) else {
            return Vec3A::ZERO;
        };
        let AsBaked { later, coefficients, .. } = baked;
        let beyond = |spot: &Spot, angles: &Angles| {
            let mut values = [0.0; MAX_BASES];
            self.basis.evaluate(angles, &mut values[..self.basis.bases()]);
            let coefficients = coefficients[spot.material as usize].iter().flatten().skip(1);
            coefficients.zip(beyond_albedo(later, &values)).map(|(c, value)| Vec3A::from(*c) * value).sum()
        };
        let by_albedo = |spot: &Spot, angles: &Angles| self.by_albedo(baked, spot, angles);
        later_radiance_of(path, self.on_bases(baked, later.lobe_eye_bases), beyond, by_albedo)
    }

    /// The BRDF of a material with the first `bases` of the basis.
    fn on_bases<'b>(
        &'b self,
        baked: &'b AsBaked<'_>,
        bases: u32,
    ) -> impl Fn(&Spot, &Angles) -> Vec3A + use<'a, 'b> {
        let on = OnBases { basis: self.basis, materials: &self.materials, coefficients: &baked.coefficients };
        move |spot: &Spot, angles: &Angles| on.evaluate(bases as usize, spot, angles)
    }

    /// A Lambert surface's for a material that varies.
    fn by_albedo(&self, baked: &AsBaked<'_>, spot: &Spot, angles: &Angles) -> Vec3A {
        baked.lambert[spot.material as usize].unwrap_or_else(|| self.brdf(spot, angles))
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
