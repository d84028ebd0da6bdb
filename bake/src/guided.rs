//! Paths that look where light comes from: gathers with a guide, and how that is learned.
//!
//! Paths of a seed of their own, in passes of growing size, each guided by what those before it have seen;
//! what they carry in random states of the materials is what guides. So a guide depends on the scene but for
//! the parameters of materials that vary, and on how many paths are to be traced; it is made again where it
//! is needed. Whatever it says, estimates are unbiased.

use crate::brdf;
use crate::filter::matt_where_it_varies;
use crate::interrupted::Interrupted;
use crate::job::Job;
use crate::noise_target::{self, NoiseTarget};
use crate::random_state::all_in_random_state;
use crate::trace::gather::{EyeVertex, Gather, GatherPath, Onward, Reflection};
use crate::trace::guide::{FilmTally, Guide, Trial, Trials};
use crate::trace::lights::Lights;
use crate::trace::sampler::PixelSampler;
use crate::trace::spot::Spot;
use crate::trace::world::World;
use glam::Vec3A;
use rayon::prelude::*;
use relume_formats::basis::Angles;
use relume_formats::state::Brdf;
use relume_scenes::Scene;
use std::sync::Arc;

/// Of how many paths one is traced to learn from, and the fewest and most of these.
const LEARNING: u64 = 16;
const PATHS: [u64; 2] = [1 << 15, 1 << 19];
/// Passes, each of twice as many paths as the one before.
const PASSES: u32 = 4;
/// The seed of the first pass; those that follow have the next ones.
const SEED: u64 = 0x6775_6964_6521;
/// Paths that share a sequence of samples all over the film.
const BLOCK: u32 = 1 << 10;
/// Random states that paths are looked at in, and the first of them; bakes are judged by others.
const STATES: usize = 12;
const FIRST_STATE: u32 = 0x7061_7468;
/// Memory that learning takes, bytes, where surfaces face two or three ways in most tiles: tallies, what is
/// known of them, directions, and the paths of the last pass.
pub const MEMORY: u64 = 100 << 20;

/// Which paths.
#[derive(Debug, Clone, Copy)]
pub struct Settings {
    /// Film size in pixels.
    pub size: [u32; 2],
    /// Film samples a pixel: other paths are traced for other numbers.
    pub samples: u32,
    /// Most reflections of a path that count.
    pub reflections: u32,
    /// Seed of the paths.
    pub seed: u64,
    /// How noisy the film may be; `samples` are then the most in the mean, and some tiles have more of them.
    pub target: Option<NoiseTarget>,
}

/// The paths of `scene`: those of [`Gather::new`], but from what the eye sees they look for light where it
/// was seen to come from, if any is reflected twice.
///
/// # Errors
/// If the job is interrupted.
pub fn gather<'a>(
    scene: &Scene,
    world: &'a World,
    lights: &'a Lights,
    settings: &Settings,
    job: &Job,
) -> Result<Gather<'a>, Interrupted> {
    let Settings { size, samples, reflections, seed, target } = *settings;
    let gather = Gather::new(scene, world, lights, size, reflections, seed);
    // Those of the scene: its paths are the same however many reflections of them count.
    let pilot = Gather::new(scene, world, lights, size, scene.reflections, SEED);
    let guide = guide(scene, &pilot, settings, job)?.map(Arc::new);
    let guided =
        |gather: Gather<'a>| guide.iter().fold(gather, |gather, guide| gather.guided_by(guide.clone()));
    let (gather, pilot) = (guided(gather), guided(pilot));
    let Some(target) = target else { return Ok(gather) };
    Ok(gather.counted_by(noise_target::counts(scene, &pilot, size, samples, target, job)?))
}

/// What guides the paths of `pilot`, if any light is reflected twice.
fn guide(
    scene: &Scene,
    pilot: &Gather<'_>,
    settings: &Settings,
    job: &Job,
) -> Result<Option<Guide>, Interrupted> {
    if scene.reflections < 2 {
        return Ok(None);
    }
    let Settings { size, samples, .. } = *settings;
    let wanted = u64::from(size[0]) * u64::from(size[1]) * u64::from(samples) / LEARNING;
    let blocks = wanted.clamp(PATHS[0], PATHS[1]).div_ceil(u64::from(BLOCK)) as u32;
    let progress = job.progress("guiding", u64::from(blocks));
    let mut learner = Learner { states: States::new(scene), seen: FilmTally::default(), trials: None };
    let mut guide = None;
    for pass in 0..PASSES {
        let pilot = guide.map_or_else(|| pilot.clone(), |guide| pilot.clone().guided_by(guide));
        let share = |passes: u32| (blocks * ((1 << passes) - 1)).div_ceil((1 << PASSES) - 1);
        let found = (share(pass)..share(pass + 1)).into_par_iter().map(|block| {
            progress.check()?;
            let found = learner.states.block(&pilot, block);
            progress.advance(1);
            Ok(found)
        });
        let found: Vec<_> = found.collect::<Result<Vec<_>, Interrupted>>()?.into_iter().flatten().collect();
        learner.learn(&found);
        guide = Some(Guide::new(&learner.seen, learner.trials.as_ref().filter(|_| pass + 1 == PASSES)));
    }
    Ok(guide)
}

/// What one path found from the surface that the eye sees.
struct Found {
    onward: Onward,
    normal: Vec3A,
    /// By state; see [`States::found`].
    light: [[f32; 2]; STATES],
}

/// What the paths of all passes have told.
struct Learner {
    states: States,
    seen: FilmTally,
    /// Of the last pass.
    trials: Option<Trials>,
}

impl Learner {
    fn learn(&mut self, found: &[Found]) {
        self.states.weigh(found);
        let weights = self.states.weights();
        let mut trials = Trials::default();
        for Found { onward, normal, light } in found {
            let [mut all, mut guided] = [0.0; 2];
            for (light, weight) in light.iter().zip(weights) {
                all += (weight * light[0]).powi(2);
                guided += (weight * light[1]).powi(2);
            }
            let trial = Trial { moment: all / onward.density, onward };
            // Of bright light too large for single precision.
            if trial.moment.is_finite() && guided.is_finite() {
                self.seen.add(onward.place, *normal, onward.direction, guided);
                trials.add(*normal, &trial);
            }
        }
        self.trials = Some(trials);
    }
}

/// States that paths are looked at in.
struct States {
    /// All materials of each, and which of them vary.
    materials: Vec<Vec<Brdf>>,
    varies: Vec<bool>,
    /// What each showed, summed over so many paths.
    sums: [f64; STATES],
    paths: f64,
}

impl States {
    fn new(scene: &Scene) -> Self {
        let state = |number: u32| all_in_random_state(FIRST_STATE + number, scene);
        Self {
            materials: (0..STATES as u32).map(state).collect(),
            varies: (0..scene.materials.len()).map(|m| scene.vary.materials.contains(&m)).collect(),
            sums: [0.0; STATES],
            paths: 0.0,
        }
    }

    /// The paths of a block, all over the film.
    fn block(&self, pilot: &Gather<'_>, block: u32) -> Vec<Found> {
        let sampler = PixelSampler::new(SEED, block);
        let path = |number| {
            let GatherPath::Surface(eye) = pilot.anywhere(&sampler.sample(number)) else { return None };
            let onward = eye.onward?;
            let light = std::array::from_fn(|state| self.found(&eye, &onward, state));
            Some(Found { onward, normal: eye.normal, light })
        };
        (0..BLOCK).filter_map(path).collect()
    }

    /// What comes to the eye the way that the path goes on, times density, mean over channels: all of it, and
    /// that for which paths should look there. Light that choosing a point on a light finds anyway counts
    /// little: to add a density to one that is so much larger takes so much less from its variance.
    fn found(&self, eye: &EyeVertex, onward: &Onward, state: usize) -> [f32; 2] {
        let materials = &self.materials[state];
        let brdf = |spot: &Spot, angles: &Angles| {
            brdf::evaluate(&materials[spot.material as usize], spot.albedo, angles)
        };
        let grey = |light: Vec3A| light.element_sum() / 3.0;
        let [_, indirect] = eye.early_light(brdf);
        let later = eye.later_light(brdf, brdf, matt_where_it_varies(&self.varies, brdf));
        let indirect = grey(indirect + later) * onward.density;
        let of_met = |met: &Reflection| met.light * brdf(&eye.spot, &met.angles);
        let seen = eye.met().map_or(Vec3A::ZERO, of_met);
        let seen = grey(seen) * (onward.density + onward.of_light);
        let [_, lobes] = onward.densities;
        let left = (lobes / (lobes + onward.of_light).max(f32::MIN_POSITIVE)).powi(2);
        [indirect + seen, indirect + left * seen]
    }

    /// Learns how bright each state is.
    fn weigh(&mut self, found: &[Found]) {
        for Found { onward, light, .. } in found {
            for (sum, [all, _]) in self.sums.iter_mut().zip(light) {
                let light = f64::from(all / onward.density);
                *sum += if light.is_finite() { light } else { 0.0 };
            }
        }
        self.paths += found.len() as f64;
    }

    /// What each state counts, so that bright ones are no more than dark ones.
    fn weights(&self) -> [f32; STATES] {
        self.sums.map(|sum| if sum > 0.0 { (self.paths / sum) as f32 } else { 0.0 })
    }
}
