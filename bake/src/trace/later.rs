//! The rest of a gather path: what surfaces send on to the one before the eye's after three reflections and
//! more.
//!
//! Directions at materials that vary do not depend on these, so that one path serves every state. From the
//! first surface paths go on as from the eye's, for bakes keep something of its lobes; behind it, where they
//! know these materials by their albedos alone, they look where matt surfaces reflect, and every reflection
//! carries its albedo. Paths end by chance: at such a material they go on with that of the largest albedo that
//! any state may have, else with what the fixed material carries on, at most that. So nothing is cut off, and
//! the variance is finite even in a closed room.

use super::bounce::{Bounce, Chooser};
use super::gather::{FirstVertex, Gather, Reflection, Reflections};
use super::sampler::Sample;
use super::spot::Spot;
use super::world::{Owner, Surface};
use crate::brdf;
use crate::brdf::lobes::LobeMixture;
use glam::Vec3A;
use relume_formats::basis::Angles;
use relume_formats::kinds::transfer_images::MAX_ALBEDO;

/// Dimension pairs before those of later reflections, and how many each of these uses.
const FIRST_PAIR: u32 = 7;
const PAIRS_PER_REFLECTION: u32 = 4;

/// A surface that light met before it came to the one before the eye's.
#[derive(Debug, Clone, Copy)]
pub struct LaterVertex {
    /// What BRDFs know of it.
    pub spot: Spot,
    /// Between the directions and the normal of the surface that its light goes to.
    pub next_angles: Angles,
    /// Cosine / density there, over the chance that the path went on.
    pub weight: f32,
    /// Light that it reflects, not yet weighed by what is between it and the eye.
    pub reflections: Reflections,
}

impl FirstVertex {
    /// Light that it sends on after at least one more reflection, times cosine / density at the surface that
    /// the eye sees. `first` gives its BRDF at some angles; `before` those of all other surfaces.
    pub fn later_light(
        &self,
        first: impl Fn(&Spot, &Angles) -> Vec3A,
        before: impl Fn(&Spot, &Angles) -> Vec3A,
    ) -> Vec3A {
        let Some(next) = self.later.first() else { return Vec3A::ZERO };
        let mut throughput = self.weight * first(&self.spot, &next.next_angles);
        let mut sum = Vec3A::ZERO;
        for (index, vertex) in self.later.iter().enumerate() {
            throughput *= vertex.weight;
            if let Some(next) = index.checked_sub(1).and_then(|next| self.later.get(next)) {
                throughput *= before(&next.spot, &vertex.next_angles);
            }
            let reflected = |r: &Reflection| r.light * before(&vertex.spot, &r.angles);
            sum += throughput * vertex.reflections.iter().flatten().map(reflected).sum::<Vec3A>();
        }
        sum
    }
}

impl Gather<'_> {
    /// The surfaces behind `first`, of this material, until the path ends; directions are those of
    /// `mixtures`.
    pub(super) fn later_vertices(
        &self,
        mixtures: &[LobeMixture],
        first: &Surface,
        mut material: u32,
        sample: &Sample,
    ) -> Vec<LaterVertex> {
        let mut vertices: Vec<LaterVertex> = Vec::new();
        let mut surface = *first;
        for pair in (FIRST_PAIR..).step_by(PAIRS_PER_REFLECTION as usize) {
            let mixtures = if vertices.is_empty() { &self.mixtures[..] } else { mixtures };
            let chooser = Chooser::by(&mixtures[material as usize]);
            let [end, choice] = sample.pair(pair);
            let bounce = Bounce::sample(&surface, chooser, choice, sample.pair(pair + 1));
            let hit = bounce.and_then(|b| self.world.intersect(surface.offset(), b.direction));
            if let Some(vertex) = vertices.last_mut() {
                let sampled = self.light_sampled(&surface, chooser, sample, [pair + 2, pair + 3], 1);
                let seen = bounce.and_then(|b| self.light_seen(&surface, &b, hit.as_ref(), 1));
                vertex.reflections = [sampled, seen.map(|(seen, _)| seen)];
            }
            let Some((bounce, next)) = bounce.zip(hit) else { break };
            let Owner::Material(owner) = next.owner else { break };
            let chance = self.chance_of_going_on(material, surface.albedo, &bounce);
            if end >= chance {
                break;
            }
            vertices.push(LaterVertex {
                spot: next.spot(owner),
                next_angles: bounce.angles,
                weight: bounce.weight() / chance,
                reflections: [None; 2],
            });
            (surface, material) = (next, owner);
        }
        vertices
    }

    /// See the module.
    fn chance_of_going_on(&self, material: u32, albedo: Vec3A, bounce: &Bounce) -> f32 {
        self.fixed[material as usize].map_or(MAX_ALBEDO, |fixed| {
            let carried = brdf::evaluate(&fixed, albedo, &bounce.angles) * bounce.weight();
            carried.max_element().min(MAX_ALBEDO)
        })
    }
}
