//! Materials as paths meet them: one all over, or what textures say at each point.

use super::spot::Spot;
use crate::brdf;
use crate::brdf::lobes::LobeMixture;
use glam::Vec3A;
use relume_formats::basis::Angles;
use relume_formats::state::{Brdf, Paint};
use relume_scenes::Scene;
use std::borrow::Cow;
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
#[derive(Debug, Clone)]
pub struct CoatAt<'a> {
    of_channels: OfChannels,
    albedo: Vec3A,
    /// Its lobes, to choose directions by.
    pub lobes: Cow<'a, LobeMixture>,
}

/// The BRDF of each channel.
#[derive(Debug, Clone, Copy)]
enum OfChannels {
    Alike(Brdf),
    Apart([Brdf; 3]),
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
        match &self.paint {
            None => brdf::evaluate(&self.brdf, spot.albedo, angles),
            Some(paint) => OfChannels::of(paint, spot).evaluate(albedo_beside(paint, spot), angles),
        }
    }

    /// The material at a spot that wears it.
    pub fn at(&self, spot: &Spot) -> CoatAt<'_> {
        let Some(paint) = &self.paint else {
            return CoatAt {
                of_channels: OfChannels::Alike(self.brdf),
                albedo: spot.albedo,
                lobes: Cow::Borrowed(&self.lobes),
            };
        };
        let of_channels = OfChannels::of(paint, spot);
        let lobes = match &of_channels {
            OfChannels::Alike(brdf) => LobeMixture::for_material(brdf),
            OfChannels::Apart(brdfs) => LobeMixture::for_materials(brdfs),
        };
        CoatAt { of_channels, albedo: albedo_beside(paint, spot), lobes: Cow::Owned(lobes) }
    }
}

impl CoatAt<'_> {
    /// The BRDF, sr⁻¹.
    pub fn evaluate(&self, angles: &Angles) -> Vec3A {
        self.of_channels.evaluate(self.albedo, angles)
    }
}

/// What the scene's texture multiplies the diffuse colour with where it is painted.
fn albedo_beside(paint: &Paint, spot: &Spot) -> Vec3A {
    if paint.replaces_texture { Vec3A::ONE } else { spot.albedo }
}

impl OfChannels {
    fn of(paint: &Paint, spot: &Spot) -> Self {
        let brdfs @ [first, others @ ..] = paint.brdf.channels(&paint.at(spot.uv));
        if others == [first; 2] { Self::Alike(first) } else { Self::Apart(brdfs) }
    }

    fn evaluate(&self, albedo: Vec3A, angles: &Angles) -> Vec3A {
        match self {
            Self::Alike(brdf) => brdf::evaluate(brdf, albedo, angles),
            Self::Apart(brdfs) => {
                let [r, g, b] = brdfs.each_ref().map(|brdf| brdf::evaluate(brdf, albedo, angles));
                Vec3A::new(r.x, g.y, b.z)
            }
        }
    }
}
