//! How paths go on at a surface: in directions of its lobes, and in those that light was seen to come from.

use super::guide::Directions;
use super::world::Surface;
use crate::brdf::angles;
use crate::brdf::lobes::LobeMixture;
use glam::Vec3A;
use relume_formats::basis::Angles;

/// What chooses the directions at a surface. It knows no material that varies.
#[derive(Clone, Copy)]
pub(super) struct Chooser<'a> {
    lobes: &'a LobeMixture,
    /// Where light was seen to come from, and the part of the paths that follows it.
    guide: Option<(&'a Directions, f32)>,
}

impl<'a> Chooser<'a> {
    /// By lobes alone.
    pub fn by(lobes: &'a LobeMixture) -> Self {
        Self { lobes, guide: None }
    }

    /// By lobes and a guide, if there is one, which so large a part of the paths follows.
    pub fn guided(lobes: &'a LobeMixture, guide: Option<(&'a Directions, f32)>) -> Self {
        Self { lobes, guide }
    }

    /// A direction, with the densities per steradian of the guide and of the lobes. It may point below the
    /// surface, where it carries nothing.
    fn sample(&self, surface: &Surface, choice: f32, point: [f32; 2]) -> (Vec3A, [f32; 2]) {
        let (normal, outgoing) = (surface.shading_normal, surface.outgoing);
        let (guide, part) = self.guide.unzip();
        let part = part.unwrap_or_default();
        match guide {
            Some(guide) if choice < part => {
                let (direction, density) = guide.sample(choice / part, point);
                (direction, [density, self.lobes.density(normal, outgoing, direction)])
            }
            _ => {
                let choice = (choice - part) / (1.0 - part);
                let (direction, density) = self.lobes.sample(normal, outgoing, choice, point);
                (direction, [guide.map_or(0.0, |guide| guide.density(direction)), density])
            }
        }
    }

    /// Density per steradian with which a direction is chosen.
    pub fn density(&self, surface: &Surface, direction: Vec3A) -> f32 {
        let lobes = self.lobes.density(surface.shading_normal, surface.outgoing, direction);
        self.mix([self.guide.map_or(0.0, |(guide, _)| guide.density(direction)), lobes])
    }

    /// Of guide and lobes.
    fn mix(&self, [guide, lobes]: [f32; 2]) -> f32 {
        self.guide.map_or(lobes, |(_, part)| part * guide + (1.0 - part) * lobes)
    }
}

/// A direction chosen at a surface, above it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Bounce {
    pub direction: Vec3A,
    /// Per steradian.
    pub density: f32,
    /// Those of the guide and of the lobes, which it is mixed of.
    pub densities: [f32; 2],
    /// With the shading normal.
    pub cosine: f32,
    pub angles: Angles,
}

impl Bounce {
    pub fn sample(surface: &Surface, chooser: Chooser<'_>, choice: f32, point: [f32; 2]) -> Option<Self> {
        let normal = surface.shading_normal;
        let (direction, densities) = chooser.sample(surface, choice, point);
        let cosine = direction.dot(normal);
        let above = cosine > 0.0 && direction.dot(surface.geometric_normal) > 0.0;
        above.then(|| Self {
            direction,
            density: chooser.mix(densities),
            densities,
            cosine,
            angles: angles(direction, surface.outgoing, normal),
        })
    }

    pub fn weight(&self) -> f32 {
        self.cosine / self.density
    }
}
