//! Paths that look where light comes from: gathers with a guide, and how that is learned.
//!
//! Paths of a seed of their own, in passes of growing size, each guided by what those before it have seen;
//! what they carry in random states of the materials is what guides. So a guide depends on the shapes, lights,
//! camera and fixed materials of a scene, and on how many paths are to be traced; it is made again where it is
//! needed. Whatever it says, estimates are unbiased.

use crate::brdf;
use crate::random_state::all_in_random_state;
use crate::trace::gather::{EyeVertex, Gather, GatherPath, Onward};
use crate::trace::guide::{FilmTally, Guide, Trial, Trials};
use crate::trace::lights::Lights;
use crate::trace::world::World;
use glam::Vec3A;
use rayon::prelude::*;
use relume_formats::basis::Angles;
use relume_formats::state::Brdf;
use relume_scenes::Scene;

/// Of how many paths one is traced to learn from, and the fewest and most of these.
const LEARNING: u64 = 8;
const PATHS: [u64; 2] = [1 << 12, 1 << 19];
/// Passes, each of twice as many paths as the one before.
const PASSES: u32 = 4;
/// The seed of the first pass; those that follow have the next ones.
const SEED: u64 = 0x6775_6964_6521;
/// Random states that paths are looked at in, and the first of them; bakes are judged by others.
const STATES: usize = 12;
const FIRST_STATE: u32 = 0x7061_7468;

/// The paths of `scene` for a film of `size` pixels, each with about as many `samples`: those of
/// [`Gather::new`], but from what the eye sees they look for light where it was seen to come from.
pub fn gather<'a>(
    scene: &Scene,
    world: &'a World,
    lights: &'a Lights,
    size: [u32; 2],
    samples: u32,
    reflections: u32,
    seed: u64,
) -> Gather<'a> {
    let gather = Gather::new(scene, world, lights, size, reflections, seed);
    // Those of the scene: its paths are the same however many reflections of them count.
    if scene.reflections < 2 {
        return gather;
    }
    let paths = u64::from(size[0]) * u64::from(size[1]) * u64::from(samples) / LEARNING;
    let paths = paths.clamp(PATHS[0], PATHS[1]) as f64;
    let mut states = States::new(scene);
    let (mut seen, mut trials) = (FilmTally::new(), None);
    for pass in 0..PASSES {
        let part = f64::from(1 << pass) / f64::from((1 << PASSES) - 1);
        let film = like(size, paths * part);
        let pilot = Gather::new(scene, world, lights, film, 2, SEED + u64::from(pass));
        if pass == 0 {
            states.weigh(&pilot, film);
            learn(&pilot, film, &states, &mut seen);
        } else {
            trials = Some(learn(&pilot.guided_by(Guide::new(&seen, None)), film, &states, &mut seen));
        }
    }
    gather.guided_by(Guide::new(&seen, trials.as_ref()))
}

/// The size of a film of about so many pixels, as wide for its height as one of `size`.
fn like(size: [u32; 2], pixels: f64) -> [u32; 2] {
    let scale = (pixels / (f64::from(size[0]) * f64::from(size[1]))).sqrt();
    size.map(|side| ((f64::from(side) * scale).round() as u32).max(1))
}

/// Traces one path through every pixel, adds what it saw, and tells how well guides of some strength would
/// have served.
fn learn(pilot: &Gather<'_>, [width, height]: [u32; 2], states: &States, seen: &mut FilmTally) -> Trials {
    let of_pixel = |pixel: u32| {
        let of = |eye: &EyeVertex, onward: Onward| {
            let [all, guided] = states.squares(eye, &onward);
            let Onward { density, densities, of_light, direction } = onward;
            let trial = Trial { moment: all / density, densities, of_light };
            (pixel, eye.normal, direction, guided, trial)
        };
        onward(pilot, pixel, of)
    };
    let row = |y: u32| (y * width..(y + 1) * width).filter_map(of_pixel).collect::<Vec<_>>();
    let rows: Vec<_> = (0..height).into_par_iter().map(row).collect();
    let mut trials = Trials::new();
    for (pixel, normal, direction, square, trial) in rows.into_iter().flatten() {
        let place = [(pixel % width) as f32 / width as f32, (pixel / width) as f32 / height as f32];
        // Of bright light too large for single precision.
        if square.is_finite() && trial.moment.is_finite() {
            seen.add(place, normal, direction, square);
            trials.add(place, normal, &trial);
        }
    }
    trials
}

/// Traces the first path of a pixel; what `of` makes of it if it goes on from a surface.
fn onward<T>(pilot: &Gather<'_>, pixel: u32, of: impl Fn(&EyeVertex, Onward) -> T) -> Option<T> {
    let mut found = None;
    pilot.pixel(pixel, 1, |path| {
        if let GatherPath::Surface(eye) = path {
            found = eye.onward.map(|onward| of(eye, onward));
        }
    });
    found
}

/// States that paths are looked at in.
struct States {
    /// All materials of each.
    materials: Vec<Vec<Brdf>>,
    /// What each counts: bright ones are no more than dark ones.
    weights: [f32; STATES],
}

impl States {
    fn new(scene: &Scene) -> Self {
        let state = |number: u32| all_in_random_state(FIRST_STATE + number, scene);
        Self { materials: (0..STATES as u32).map(state).collect(), weights: [1.0; STATES] }
    }

    /// Weighs all states by how bright the paths of `pilot` find them.
    fn weigh(&mut self, pilot: &Gather<'_>, [width, height]: [u32; 2]) {
        let of_pixel = |pixel| {
            onward(pilot, pixel, |eye, onward| {
                let found = |state: usize| f64::from(self.found(eye, &onward, state)[0] / onward.density);
                std::array::from_fn::<f64, STATES, _>(found)
            })
        };
        let found: Vec<_> = (0..width * height).into_par_iter().filter_map(of_pixel).collect();
        let sum = |state: usize| found.iter().map(|of| of[state]).filter(|of| of.is_finite()).sum::<f64>();
        self.weights = std::array::from_fn(|state| {
            let mean = sum(state) / found.len().max(1) as f64;
            if mean > 0.0 { mean.recip() as f32 } else { 0.0 }
        });
    }

    /// Sums over states of the squares of [`States::found`].
    fn squares(&self, eye: &EyeVertex, onward: &Onward) -> [f32; 2] {
        let mut squares = [0.0; 2];
        for (state, weight) in self.weights.iter().enumerate() {
            let found = self.found(eye, onward, state).map(|found| (weight * found).powi(2));
            squares.iter_mut().zip(found).for_each(|(sum, square)| *sum += square);
        }
        squares
    }

    /// What comes to the eye the way that the path goes on, times density, mean over channels: all of it, and
    /// that for which paths should look there. Light that choosing a point on a light finds anyway counts
    /// little: to add a density to one that is so much larger takes so much less from its variance.
    fn found(&self, eye: &EyeVertex, onward: &Onward, state: usize) -> [f32; 2] {
        let materials = &self.materials[state];
        let brdf =
            |m: u32, albedo: Vec3A, angles: &Angles| brdf::evaluate(&materials[m as usize], albedo, angles);
        let grey = |light: Vec3A| light.element_sum() / 3.0;
        let [_, indirect] = eye.early_light(brdf);
        let indirect = grey(indirect) * onward.density;
        let [_, seen] = eye.direct;
        let seen = seen.map_or(Vec3A::ZERO, |seen| seen.light * brdf(eye.material, eye.albedo, &seen.angles));
        let seen = grey(seen) * (onward.density + onward.of_light);
        let [_, lobes] = onward.densities;
        let left = (lobes / (lobes + onward.of_light).max(f32::MIN_POSITIVE)).powi(2);
        [indirect + seen, indirect + left * seen]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn films_of_pilots_are_shaped_like_the_film() {
        assert_eq!(like([512, 256], 2048.0), [64, 32]);
        assert_eq!(like([10_000, 1], 100.0), [1000, 1]);
        assert_eq!(like([64, 64], 4096.0), [64, 64]);
    }
}
