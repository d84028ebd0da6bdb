//! The path tracer that is our truth: any number of reflections, directions by the actual materials, lights
//! and directions combined by the balance heuristic (Veach 1997).

use super::coat::{Coat, CoatAt};
use super::lights::Lights;
use super::sampler::{PixelSampler, Sample};
use super::spot::Spot;
use super::world::{Owner, Surface, World};
use crate::brdf;
use glam::Vec3A;
use relume_formats::state::Film;
use relume_scenes::Scene;

/// Dimension pairs that one reflection uses; pair 0 is the film's.
const PAIRS_PER_REFLECTION: u32 = 4;
/// Reflections after which paths end at random, in proportion to what they still carry.
const SURE_REFLECTIONS: u32 = 4;

/// Traces paths through one scene.
pub struct PathTracer<'a> {
    world: &'a World,
    lights: &'a Lights,
    film: Film,
    width: u32,
    materials: Vec<Coat>,
    max_reflections: u32,
    seed: u64,
}

impl<'a> PathTracer<'a> {
    /// Prepares paths of at most `max_reflections` reflections for a film of `size` pixels.
    pub fn new(
        scene: &Scene,
        world: &'a World,
        lights: &'a Lights,
        size: [u32; 2],
        max_reflections: u32,
        seed: u64,
    ) -> Self {
        Self {
            world,
            lights,
            film: scene.camera.film(size[0], size[1]),
            width: size[0],
            materials: Coat::all_of(scene),
            max_reflections,
            seed,
        }
    }

    /// Radiance estimates of the first `samples` paths of pixel number `pixel`, in order.
    pub fn pixel(&self, pixel: u32, samples: u32, mut each: impl FnMut(Vec3A)) {
        let sampler = PixelSampler::new(self.seed, pixel);
        let (x, y) = ((pixel % self.width) as f32, (pixel / self.width) as f32);
        for index in 0..samples {
            let sample = sampler.sample(index);
            let [dx, dy] = sample.pair(0);
            each(self.radiance(self.film.eye_in_world, self.film.direction(x + dx, y + dy), &sample));
        }
    }

    /// An estimate of the radiance that arrives at `origin` from `direction`, W/(sr·m²).
    pub fn radiance(&self, origin: Vec3A, direction: Vec3A, sample: &Sample) -> Vec3A {
        let (mut origin, mut direction) = (origin, direction);
        let mut radiance = Vec3A::ZERO;
        let mut throughput = Vec3A::ONE;
        let mut before: Option<(Surface, f32)> = None;
        let mut painted = None;
        for reflection in 0.. {
            let hit = self.world.intersect(origin, direction);
            radiance += throughput * self.emitted(before.as_ref(), direction, hit.as_ref());
            let Some((surface, spot)) = hit.and_then(|s| spot_of(&s).map(|spot| (s, spot))) else { break };
            let Some(coat) = self.materials.get(spot.material as usize) else { break };
            let material = coat.at(&spot, &mut painted);
            if reflection == self.max_reflections {
                break;
            }
            let first_pair = 1 + reflection * PAIRS_PER_REFLECTION;
            radiance += throughput * self.direct(&surface, &material, sample, first_pair);
            let Some((next, chance, factor)) = self.reflect(&surface, &material, sample, first_pair) else {
                break;
            };
            throughput *= factor;
            if reflection >= SURE_REFLECTIONS {
                let survival = throughput.max_element().min(0.95);
                if sample.pair(first_pair + 3)[0] >= survival {
                    break;
                }
                throughput /= survival;
            }
            (origin, direction) = (surface.offset(), next);
            before = Some((surface, chance));
        }
        radiance
    }

    /// Light met by a ray, weighted against the chance that [`PathTracer::direct`] had found it; `before` is
    /// where the ray came from and its density, `None` for rays from the eye.
    fn emitted(&self, before: Option<&(Surface, f32)>, direction: Vec3A, hit: Option<&Surface>) -> Vec3A {
        let light = self.lights.met(direction, hit);
        match before {
            Some((from, density)) if light != Vec3A::ZERO => {
                light * (density / (density + self.lights.density_of(from, direction, hit)))
            }
            _ => light,
        }
    }

    /// Light that arrives straight from a light and is reflected.
    fn direct(&self, surface: &Surface, material: &CoatAt<'_>, sample: &Sample, first_pair: u32) -> Vec3A {
        let choice = sample.pair(first_pair)[0];
        let Some(light) =
            self.lights.sample_visible(self.world, surface, choice, sample.pair(first_pair + 1))
        else {
            return Vec3A::ZERO;
        };
        let normal = surface.shading_normal;
        let brdf = material.evaluate(&brdf::angles(light.direction, surface.outgoing, normal));
        let share = light
            .density
            .map_or(1.0, |d| d / (d + material.lobes.density(normal, surface.outgoing, light.direction)));
        brdf * light.weight * (light.direction.dot(normal) * share)
    }

    /// Where the path goes on: direction, its density, and BRDF · cosine / density.
    fn reflect(
        &self,
        surface: &Surface,
        material: &CoatAt<'_>,
        sample: &Sample,
        first_pair: u32,
    ) -> Option<(Vec3A, f32, Vec3A)> {
        let normal = surface.shading_normal;
        let choice = sample.pair(first_pair)[1];
        let (direction, density) =
            material.lobes.sample(normal, surface.outgoing, choice, sample.pair(first_pair + 2));
        let cosine = direction.dot(normal);
        if cosine <= 0.0 || direction.dot(surface.geometric_normal) <= 0.0 {
            return None;
        }
        let brdf = material.evaluate(&brdf::angles(direction, surface.outgoing, normal));
        let factor = brdf * (cosine / density);
        (factor != Vec3A::ZERO).then_some((direction, density, factor))
    }
}

fn spot_of(surface: &Surface) -> Option<Spot> {
    match surface.owner {
        Owner::Material(index) => Some(surface.spot(index)),
        Owner::Light(_) => None,
    }
}
