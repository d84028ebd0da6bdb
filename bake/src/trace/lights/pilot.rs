//! Some paths that learn which lights are seen from where.

use super::places::{Found, Powers, Visit};
use super::{LightSample, Lights, faces};
use crate::brdf::lobes::LobeMixture;
use crate::trace::environment::PatchChances;
use crate::trace::sampler::{PixelSampler, Sample};
use crate::trace::world::{Owner, Surface, World};
use rayon::prelude::*;
use relume_formats::state::{Camera, Film};

/// Size of the film that paths start from, one from each pixel; wide, for films may be.
const FILM: [u32; 2] = [216, 96];
/// The seed of the paths, which is nobody else's.
const SEED: u64 = 0x6c69_6768_7473;
/// Surfaces of a path.
const VERTICES: u32 = 3;
/// Most lights looked at from a surface.
const LIGHTS: u32 = 8;
/// Looks at the environment from a surface.
const LOOKS: u32 = 2;
/// Dimension pairs of a surface.
const PAIRS: u32 = 1 + LIGHTS + LOOKS;

/// What arrives at surfaces that the camera sees, and at what these see.
pub fn visits(lights: &Lights, powers: &Powers, world: &World, camera: &Camera) -> Vec<Visit> {
    let [width, height] = FILM;
    let whole = lights
        .environment
        .as_ref()
        .map(|environment| PatchChances::new(&environment.brightness_of_patches(), environment.patches()[0]));
    let pilot = Pilot { lights, powers, world, film: camera.film(width, height), whole };
    let row = |y: u32| (0..width).flat_map(|x| pilot.path(x, y)).collect::<Vec<_>>();
    (0..height).into_par_iter().map(row).collect::<Vec<_>>().into_iter().flatten().collect()
}

struct Pilot<'a> {
    lights: &'a Lights,
    powers: &'a Powers,
    world: &'a World,
    film: Film,
    /// All of the environment, by brightness.
    whole: Option<PatchChances>,
}

impl Pilot<'_> {
    fn path(&self, x: u32, y: u32) -> Vec<Visit> {
        let sample = PixelSampler::new(SEED, y * FILM[0] + x).sample(0);
        let [dx, dy] = sample.pair(0);
        let (mut origin, mut direction) =
            (self.film.eye_in_world, self.film.direction(x as f32 + dx, y as f32 + dy));
        let mut visits = Vec::new();
        for first_pair in (0..VERTICES).map(|vertex| 1 + vertex * PAIRS) {
            let Some(surface) = self.world.intersect(origin, direction) else { break };
            if !matches!(surface.owner, Owner::Material(_)) {
                break;
            }
            visits.push(self.visit(&surface, &sample, first_pair + 1));
            let normal = surface.shading_normal;
            (direction, _) =
                LobeMixture::cosine().sample(normal, surface.outgoing, 0.0, sample.pair(first_pair));
            origin = surface.offset();
            if direction.dot(surface.geometric_normal) <= 0.0 {
                break;
            }
        }
        visits
    }

    fn visit(&self, surface: &Surface, sample: &Sample, first_pair: u32) -> Visit {
        let mut found = Vec::new();
        let lights = self.powers.lights() as u32;
        let looked_at = lights.min(LIGHTS);
        for look in 0..looked_at {
            let point = sample.pair(first_pair + look);
            // One of each part of the lights, which is a single one where there are few.
            let within = sample.pair(first_pair + (look + 1) % looked_at)[0];
            let light = ((look as f32 + within) * lights as f32 / looked_at as f32) as u32;
            let light = light.min(lights - 1);
            let arriving = self.lights.lights[light as usize].sample(surface.offset(), point);
            let times = f64::from(lights) / f64::from(looked_at);
            found.extend(self.square(surface, arriving).map(|s| Found { choice: light, square: s * times }));
        }
        if let (Some(environment), Some(whole)) = (&self.lights.environment, &self.whole) {
            for look in 0..LOOKS {
                let point = sample.pair(first_pair + LIGHTS + look);
                let arriving = LightSample::of_environment(environment, whole, point);
                let patch = environment.patch_of(arriving.direction);
                let times = self.powers.patch(patch) / f64::from(LOOKS);
                let choice = lights + patch as u32;
                found.extend(
                    self.square(surface, Some(arriving)).map(|s| Found { choice, square: s * times }),
                );
            }
        }
        Visit { position: surface.position, normal: surface.geometric_normal, found }
    }

    /// The square of what `arriving` brings, if it does.
    fn square(&self, surface: &Surface, arriving: Option<LightSample>) -> Option<f64> {
        let light = arriving.filter(|light| faces(surface, light))?;
        let brings = light.weight.max_element() * light.direction.dot(surface.shading_normal);
        // Of bright light too large for single precision.
        let square = f64::from(brings).powi(2);
        let arrives = || !self.world.occluded(surface.offset(), light.direction, light.distance);
        (square.is_finite() && square > 0.0 && arrives()).then_some(square)
    }
}
