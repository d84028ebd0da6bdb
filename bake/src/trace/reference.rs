//! Reference images: radiance and its variance at every pixel, for any state.

use super::coat::Coat;
use super::gather::GatherPath;
use super::lights::Lights;
use super::path::PathTracer;
use super::spot::Spot;
use super::world::World;
use crate::guided;
use crate::interrupted::Interrupted;
use crate::job::Job;
use crate::noise_target::NoiseTarget;
use glam::{DVec3, Vec3A};
use rayon::prelude::*;
use relume_formats::basis::Angles;
use relume_scenes::Scene;
use relume_scenes::painting::Painting;

/// Which paths a reference traces.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Paths {
    /// The ones with the least noise for the materials at hand.
    Best,
    /// The very ones that a bake with the same size, seed and samples traces, up to two reflections; later
    /// ones are traced for the highlights that they may have, which bakes know nothing of.
    Gather,
}

/// What to trace.
#[derive(Debug, Clone, Copy)]
pub struct Settings {
    /// Film size in pixels.
    pub size: [u32; 2],
    /// Film samples a pixel.
    pub samples: u32,
    /// Seed of the paths.
    pub seed: u64,
    /// Most reflections of a path; 1 is direct light only.
    pub reflections: u32,
    /// Which paths.
    pub paths: Paths,
    /// How noisy pictures may be, with [`Paths::Gather`]; `samples` are then the most in the mean.
    pub target: Option<NoiseTarget>,
}

impl Settings {
    /// Of the paths of a gather.
    pub fn guided(&self) -> guided::Settings {
        let Self { size, samples, seed, reflections, target, .. } = *self;
        guided::Settings { size, samples, reflections, seed, target }
    }
}

/// An image with its uncertainty, row by row.
#[derive(Debug, Clone, PartialEq)]
pub struct Estimate {
    /// Linear radiance, W/(sr·m²).
    pub radiance: Vec<[f32; 3]>,
    /// Variance of each radiance: the samples' variance over their number, an upper bound as samples are
    /// stratified.
    pub variance: Vec<[f32; 3]>,
}

/// Sums of one pixel in one state.
#[derive(Debug, Clone, Copy, Default)]
struct PixelSums {
    samples: u32,
    sum: DVec3,
    squares: DVec3,
}

impl PixelSums {
    fn add(&mut self, radiance: Vec3A) {
        let radiance = radiance.as_dvec3();
        self.samples += 1;
        self.sum += radiance;
        self.squares += radiance * radiance;
    }

    fn mean_and_variance(&self) -> ([f32; 3], [f32; 3]) {
        let n = f64::from(self.samples);
        let mean = self.sum / n;
        let spread = (self.squares / n - mean * mean).max(DVec3::ZERO);
        // One sample says nothing of its spread.
        let variance = if self.samples > 1 { spread / (n - 1.0) } else { DVec3::INFINITY };
        (mean.as_vec3().to_array(), variance.as_vec3().to_array())
    }
}

/// Renders `scenes`, which must differ in their materials only. With [`Paths::Gather`] they share one set of
/// paths, whose directions follow the materials of `base`. `paintings` say where textures lie on materials that any
/// of them paints.
///
/// # Errors
/// If the job is interrupted.
pub fn render(
    base: &Scene,
    scenes: &[Scene],
    paintings: &[Painting],
    settings: &Settings,
    job: &Job,
) -> Result<Vec<Estimate>, Interrupted> {
    let world = World::painted(base, paintings);
    let lights = Lights::new(base, &world);
    match settings.paths {
        Paths::Best => {
            scenes.iter().map(|scene| render_best(scene, &world, &lights, settings, job)).collect()
        }
        Paths::Gather => {
            let gather =
                guided::gather(base, &world, &lights, &settings.guided(), job)?.with_later_highlights();
            let states: Vec<Vec<Coat>> = scenes.iter().map(Coat::all_of).collect();
            let pixel = |pixel| {
                let mut sums = vec![PixelSums::default(); states.len()];
                gather.pixel(pixel, gather.samples(pixel, settings.samples), |path| {
                    for (sums, materials) in sums.iter_mut().zip(&states) {
                        sums.add(radiance_of(path, |spot, angles| {
                            materials[spot.material as usize].evaluate(spot, angles)
                        }));
                    }
                });
                sums
            };
            film(settings, scenes.len(), job, pixel)
        }
    }
}

/// Radiance that `path` carries if `brdf` gives the BRDF at a point of a surface, at some angles.
pub fn radiance_of(path: &GatherPath, brdf: impl Fn(&Spot, &Angles) -> Vec3A) -> Vec3A {
    early_radiance_of(path, &brdf) + later_radiance_of(path, &brdf, &brdf, &brdf)
}

/// The part of it that was reflected at most twice.
pub fn early_radiance_of(path: &GatherPath, brdf: impl Fn(&Spot, &Angles) -> Vec3A) -> Vec3A {
    match path {
        GatherPath::Light(radiance) => *radiance,
        GatherPath::Surface(eye) => {
            let [direct, indirect] = eye.early_light(brdf);
            eye.emitted + direct + indirect
        }
    }
}

/// The part that was reflected more often: `brdf` at the surface that the eye sees, `first` at the one before,
/// and `before` at all others.
pub fn later_radiance_of(
    path: &GatherPath,
    brdf: impl Fn(&Spot, &Angles) -> Vec3A,
    first: impl Fn(&Spot, &Angles) -> Vec3A,
    before: impl Fn(&Spot, &Angles) -> Vec3A,
) -> Vec3A {
    match path {
        GatherPath::Light(_) => Vec3A::ZERO,
        GatherPath::Surface(eye) => eye.later_light(brdf, first, before),
    }
}

fn render_best(
    scene: &Scene,
    world: &World,
    lights: &Lights,
    settings: &Settings,
    job: &Job,
) -> Result<Estimate, Interrupted> {
    let tracer = PathTracer::new(scene, world, lights, settings.size, settings.reflections, settings.seed);
    let pixel = |pixel| {
        let mut sums = PixelSums::default();
        tracer.pixel(pixel, settings.samples, |radiance| sums.add(radiance));
        vec![sums]
    };
    Ok(film(settings, 1, job, pixel)?.swap_remove(0))
}

/// Computes every pixel, a row at a time on all threads.
fn film(
    settings: &Settings,
    images: usize,
    job: &Job,
    pixel: impl Fn(u32) -> Vec<PixelSums> + Sync,
) -> Result<Vec<Estimate>, Interrupted> {
    let [width, height] = settings.size;
    let progress = job.progress("tracing", u64::from(height));
    let rows: Vec<Vec<Vec<PixelSums>>> = (0..height)
        .into_par_iter()
        .map(|y| {
            progress.check()?;
            let row = (0..width).map(|x| pixel(y * width + x)).collect();
            progress.advance(1);
            Ok(row)
        })
        .collect::<Result<_, Interrupted>>()?;
    let estimate = |image: usize| {
        let pixels = rows.iter().flatten().map(|sums| sums[image].mean_and_variance());
        let (radiance, variance) = pixels.unzip();
        Estimate { radiance, variance }
    };
    Ok((0..images).map(estimate).collect())
}
