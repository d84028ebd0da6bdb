//! Materials as paths meet them: one all over, or what textures say at each point.

use super::spot::Spot;
use crate::brdf;
use crate::brdf::lobes::LobeMixture;
use glam::Vec3A;
use relume_formats::basis::Angles;
use relume_formats::state::{Brdf, Paint};
use relume_scenes::Scene;
use std::sync::Arc;

/// A material in one state.
#[derive(Debug, Clone)]
pub struct Coat {
    brdf: Brdf,
    paint: Option<Arc<Paint>>,
    /// Its lobes, where nothing is painted.
    lobes: LobeMixture,
}

/// A material at one point.
#[derive(Debug, Clone, Copy)]
pub struct CoatAt<'a> {
    brdf: &'a Brdf,
    /// The BRDF of each channel, where they are not alike.
    apart: Option<&'a [Brdf; 3]>,
    albedo: Vec3A,
    /// Its lobes, to choose directions by.
    pub lobes: &'a LobeMixture,
}

/// What textures say at one point.
#[derive(Debug, Clone)]
pub struct Painted {
    brdfs: [Brdf; 3],
    lobes: LobeMixture,
}

impl Coat {
    /// Those of all materials of a scene.
    pub fn all_of(scene: &Scene) -> Vec<Self> {
        let coat = |material: &relume_scenes::Material| Self {
            brdf: material.brdf,
            paint: material.paint.clone(),
            lobes: LobeMixture::for_material(&material.brdf),
        };
        scene.materials.iter().map(coat).collect()
    }

    /// The BRDF at a spot that wears the material, sr⁻¹.
    pub fn evaluate(&self, spot: &Spot, angles: &Angles) -> Vec3A {
        let Some(paint) = &self.paint else { return brdf::evaluate(&self.brdf, spot.albedo, angles) };
        let (brdfs, albedo) = (paint.brdf.channels(&paint.at(spot.uv)), albedo_beside(paint, spot));
        match are_alike(&brdfs) {
            true => brdf::evaluate(&brdfs[0], albedo, angles),
            false => evaluate_apart(&brdfs, albedo, angles),
        }
    }

    /// The material at a spot that wears it. What is painted there is put into `painted`.
    pub fn at<'a>(&'a self, spot: &Spot, painted: &'a mut Option<Painted>) -> CoatAt<'a> {
        let Some(paint) = &self.paint else {
            return CoatAt { brdf: &self.brdf, apart: None, albedo: spot.albedo, lobes: &self.lobes };
        };
        let Painted { brdfs, lobes } = painted.insert(Painted::new(paint, spot));
        let apart = (!are_alike(brdfs)).then_some(&*brdfs);
        CoatAt { brdf: &brdfs[0], apart, albedo: albedo_beside(paint, spot), lobes }
    }
}

impl Painted {
    fn new(paint: &Paint, spot: &Spot) -> Self {
        let brdfs = paint.brdf.channels(&paint.at(spot.uv));
        let lobes = match are_alike(&brdfs) {
            true => LobeMixture::for_material(&brdfs[0]),
            false => LobeMixture::for_materials(&brdfs),
        };
        Self { brdfs, lobes }
    }
}

impl CoatAt<'_> {
    /// The BRDF, sr⁻¹.
    pub fn evaluate(&self, angles: &Angles) -> Vec3A {
        match self.apart {
            None => brdf::evaluate(self.brdf, self.albedo, angles),
            Some(brdfs) => evaluate_apart(brdfs, self.albedo, angles),
        }
    }
}

/// What the scene's texture multiplies the diffuse colour with where it is painted.
fn albedo_beside(paint: &Paint, spot: &Spot) -> Vec3A {
    if paint.replaces_texture { Vec3A::ONE } else { spot.albedo }
}

fn are_alike([first, others @ ..]: &[Brdf; 3]) -> bool {
    others.iter().all(|other| other == first)
}

/// Red by the first, green by the second, and blue by the third.
fn evaluate_apart(brdfs: &[Brdf; 3], albedo: Vec3A, angles: &Angles) -> Vec3A {
    let [r, g, b] = brdfs.each_ref().map(|brdf| brdf::evaluate(brdf, albedo, angles));
    Vec3A::new(r.x, g.y, b.z)
}
