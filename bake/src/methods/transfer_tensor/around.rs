//! What vertices see of the surfaces around them.

use crate::trace::receivers::{Receiver, triangles};
use crate::trace::sampler::PixelSampler;
use crate::trace::world::{Meeting, Owner, World};
use glam::Vec3A;
use relume_scenes::Scene;
use std::f32::consts::TAU;

/// Sends rays.
pub struct Around<'a> {
    world: &'a World,
    /// By vertex.
    pub receivers: &'a [Receiver],
    triangles: Vec<[u32; 3]>,
    seed: u64,
}

/// A ray that met the front of a surface.
pub struct Ray {
    /// Unit, away from the vertex.
    pub direction: Vec3A,
    /// Where.
    pub meeting: Meeting,
    /// What the surface is of.
    pub material: u32,
}

/// How rays are spread over the hemisphere of a vertex.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Spread {
    /// Evenly over solid angle.
    Evenly,
    /// In proportion to the cosine.
    ByCosine,
}

impl<'a> Around<'a> {
    /// The vertices of `scene`, which `world` and `receivers` are of; directions are random by `seed`.
    pub fn new(scene: &Scene, (world, receivers): (&'a World, &'a [Receiver]), seed: u64) -> Self {
        Self { world, receivers, triangles: triangles(scene), seed }
    }

    /// What `vertex` meets in `count` directions, best a power of two: surfaces from their fronts.
    pub fn met(&self, vertex: usize, count: u32, spread: Spread) -> Vec<Ray> {
        let sampler = PixelSampler::new(self.seed, vertex as u32);
        let Receiver { origin, normal } = self.receivers[vertex];
        let (tangent, bitangent) = normal.any_orthonormal_pair();
        let look = |index: u32| {
            let [u, v] = sampler.sample(index).pair(0);
            let cos = if spread == Spread::Evenly { v } else { v.sqrt() };
            let (sin, (sin_phi, cos_phi)) = ((1.0 - cos * cos).max(0.0).sqrt(), (TAU * u).sin_cos());
            let direction = normal * cos + (tangent * cos_phi + bitangent * sin_phi) * sin;
            let meeting = self.world.meet(origin, direction)?;
            match meeting.owner {
                Owner::Material(material) if meeting.front => Some(Ray { direction, meeting, material }),
                _ => None,
            }
        };
        (0..count).filter_map(look).collect()
    }

    /// The vertices around a point that was met, and what each of them counts.
    pub fn corners(&self, meeting: &Meeting) -> [(usize, f32); 3] {
        let [v, w] = meeting.barycentric;
        let [a, b, c] = self.triangles[meeting.triangle as usize].map(|vertex| vertex as usize);
        [(a, 1.0 - v - w), (b, v), (c, w)]
    }
}
