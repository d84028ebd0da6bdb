//! Light that arrives by way of other surfaces, which reflect it evenly in their colours (ours; the source
//! has direct light only).

use super::settings::BOUNCED_FACE_SIZE;
use super::texels::{FACE_SIZE, summed};
use crate::trace::receivers::{Receiver, triangles};
use crate::trace::spans::{Eye, TexelRays};
use crate::trace::world::{Owner, World};
use glam::Vec3A;
use relume_formats::basis::cubemap::{self, FACES};
use relume_scenes::Scene;
use std::collections::BTreeMap;

/// Texels along a side of the cube of directions in which other surfaces are looked for.
const DIRECTIONS: usize = 32;
/// Texels of the light.
pub const TEXELS: usize = FACES * BOUNCED_FACE_SIZE * BOUNCED_FACE_SIZE;

/// Sums a row of direct light over squares of texels: the transfer from the texels of the coarser light.
pub fn coarse(row: &[f32]) -> Vec<f32> {
    summed(row, FACE_SIZE, BOUNCED_FACE_SIZE)
}

/// Adds `share` of `source`, of `channels` values a texel, to `row`, texels × RGB. Direct light has one
/// channel, for it meets no colour on its way.
pub fn add(row: &mut [f32], share: Vec3A, source: &[f32], channels: usize) {
    for (sum, value) in row.as_chunks_mut::<3>().0.iter_mut().zip(source.chunks_exact(channels)) {
        match *value {
            [grey] => (0..3).for_each(|c| sum[c] += share[c] * grey),
            [red, green, blue] => (0..3).for_each(|c| sum[c] += share[c] * [red, green, blue][c]),
            _ => {}
        }
    }
}

/// A row as one plane of texels for each channel: `direct` light, which has no colour, and behind it what all
/// bounces bring, texels × RGB.
pub fn planes(direct: &[f32], bounced: &[f32]) -> Vec<Vec<f32>> {
    let plane = |c: usize| direct.iter().chain(bounced.iter().skip(c).step_by(3)).copied().collect();
    (0..3).map(plane).collect()
}

/// Finds what a vertex receives from other vertices.
pub struct Bouncer<'a> {
    world: &'a World,
    /// Vertices of every triangle of the objects.
    triangles: Vec<[u32; 3]>,
    /// Diffuse albedo of every material, textures left out.
    albedos: Vec<Vec3A>,
    /// Where other surfaces are looked for.
    directions: TexelRays,
    /// Solid angles of the directions over π.
    weights: Vec<f32>,
}

impl<'a> Bouncer<'a> {
    /// For the objects of `scene`, which `world` was made of.
    pub fn new(scene: &Scene, world: &'a World) -> Self {
        let n = DIRECTIONS;
        let solid_angles = cubemap::solid_angles(n);
        let weight = |i: usize| (solid_angles[i % (n * n)] / std::f64::consts::PI) as f32;
        Self {
            world,
            triangles: triangles(scene),
            albedos: scene.materials.iter().map(|m| Vec3A::from(m.brdf.diffuse_albedo())).collect(),
            directions: TexelRays::centres(n),
            weights: (0..FACES * n * n).map(weight).collect(),
        }
    }

    /// The row of light, texels × RGB, that reaches `receiver` after one reflection more than `arriving`:
    /// rows of texels × `channels` at every vertex. Surfaces seen from behind reflect nothing.
    pub fn row(&self, receiver: &Receiver, arriving: &[f32], channels: usize) -> Vec<f32> {
        let (mut row, length) = (vec![0.0; 3 * TEXELS], channels * TEXELS);
        for (vertex, share) in self.shares(receiver) {
            add(&mut row, share, &arriving[vertex as usize * length..][..length], channels);
        }
        row
    }

    /// The vertices around the points that `receiver` sees, each with the share of its radiance that counts,
    /// its colour included.
    pub fn shares(&self, receiver: &Receiver) -> BTreeMap<u32, Vec3A> {
        let mut shares = BTreeMap::new();
        let Receiver { origin, normal } = *receiver;
        let eye = Eye { origin, horizon: Some(normal), rays: &self.directions, within: None };
        for (texel, hit) in self.world.meet_all(eye, &self.directions.above(normal)) {
            let (Owner::Material(material), true) = (hit.owner, hit.front) else { continue };
            let cosine = normal.dot(self.directions.directions()[texel]);
            let reflected = self.albedos[material as usize] * hit.albedo * (cosine * self.weights[texel]);
            let [v, w] = hit.barycentric;
            for (vertex, share) in self.triangles[hit.triangle as usize].into_iter().zip([1.0 - v - w, v, w])
            {
                *shares.entry(vertex).or_insert(Vec3A::ZERO) += reflected * share;
            }
        }
        shares
    }
}
