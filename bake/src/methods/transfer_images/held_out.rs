//! Measures a finished bake on states it was not made for: its own paths with the analytic BRDF against the stored images, at one pixel in 16.
//!
//! As the paths are the same, noise cancels and what is left is the error of bases and storage. Pixels that show a light or the background are
//! left out: nothing there depends on bases, and one lamp in view can outshine, and so hide, the errors of a whole room.

use super::Settings;
use crate::error::Result;
use crate::job::{Interrupted, Job};
use crate::trace::gather::{Gather, GatherPath};
use crate::trace::lights::Lights;
use crate::trace::reference::radiance_of;
use crate::trace::sampler::PixelSampler;
use crate::trace::world::World;
use glam::DVec3;
use rayon::prelude::*;
use relume_formats::evaluate::transfer_images::evaluate;
use relume_formats::kinds::{BrdfBasis, TransferImages};
use relume_formats::state::{BlinnPhong, SHININESS_MAX};
use relume_scenes::Scene;

/// Number of held-out states.
pub const STATES: u32 = 16;

/// Errors over the held-out states.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HeldOutErrors {
    /// Median of the relative L2 errors.
    pub median: f64,
    /// Largest of the relative L2 errors.
    pub worst: f64,
}

/// Parameters of `materials` materials in held-out state number `state`: colours of any hue, diffuse and glossy in any proportion, exponents
/// evenly spread over octaves, which is how artists perceive them.
pub fn random_state(state: u32, materials: usize) -> Vec<BlinnPhong> {
    let sampler = PixelSampler::new(0x68_656c_646f_7574, state);
    let material = |index: usize| {
        let sample = sampler.sample(index as u32);
        let [share, exponent] = sample.pair(0);
        let [kr, kg] = sample.pair(1);
        let [kb, sr] = sample.pair(2);
        let [sg, sb] = sample.pair(3);
        BlinnPhong {
            kd: [kr, kg, kb].map(|k| k * share),
            ks: [sr, sg, sb].map(|k| k * (1.0 - share)),
            shininess: SHININESS_MAX.powf(exponent).clamp(1.0, SHININESS_MAX),
        }
    };
    (0..materials).map(material).collect()
}

/// Measures `baked` on the held-out states.
///
/// # Errors
/// If the job is interrupted.
pub fn measure(scene: &Scene, settings: &Settings, basis: &BrdfBasis, baked: &TransferImages, job: &Job) -> Result<HeldOutErrors> {
    let world = World::new(scene);
    let lights = Lights::new(scene, &world);
    let gather = Gather::new(scene, &world, &lights, settings.size, scene.reflections, settings.seed);
    let varying: Vec<Vec<BlinnPhong>> = (0..STATES).map(|s| random_state(s, scene.vary.materials.len())).collect();
    let images: Vec<_> = varying.par_iter().map(|materials| evaluate(baked, basis, materials)).collect();
    let all: Vec<Vec<BlinnPhong>> = varying.iter().map(|v| all_materials(scene, v)).collect();

    let pixels = pixels_to_measure(settings.size);
    let stage = job.stage("measuring", pixels.len() as u64);
    // For each pixel and state: squared difference and squared truth.
    let sums: Vec<Vec<[f64; 2]>> = pixels
        .par_iter()
        .map(|&pixel| {
            stage.check()?;
            let mut truth = vec![DVec3::ZERO; all.len()];
            let mut shows_light = false;
            gather.pixel(pixel, settings.samples, |path| {
                shows_light |= matches!(path, GatherPath::Light(_));
                truth.iter_mut().zip(&all).for_each(|(sum, materials)| *sum += radiance_of(path, materials).as_dvec3());
            });
            stage.advance(1);
            if shows_light {
                return Ok(vec![[0.0; 2]; all.len()]);
            }
            let squares = truth.iter().zip(&images).map(|(sum, image)| {
                let truth = *sum / f64::from(settings.samples);
                let stored = DVec3::from_array(image[pixel as usize].map(f64::from));
                [truth.distance_squared(stored), truth.length_squared()]
            });
            Ok(squares.collect())
        })
        .collect::<std::result::Result<_, Interrupted>>()?;
    let relative = |state: usize| {
        let [difference, norm] = sums.iter().fold([0.0, 0.0], |[d, n], s| [d + s[state][0], n + s[state][1]]);
        if norm > 0.0 { (difference / norm).sqrt() } else { 0.0 }
    };
    let mut errors: Vec<f64> = (0..all.len()).map(relative).collect();
    errors.sort_by(f64::total_cmp);
    let middle = errors.len() / 2;
    Ok(HeldOutErrors { median: 0.5 * (errors[middle - 1] + errors[middle]), worst: errors[errors.len() - 1] })
}

/// Every material's parameters with the varying ones replaced.
fn all_materials(scene: &Scene, varying: &[BlinnPhong]) -> Vec<BlinnPhong> {
    let mut all: Vec<BlinnPhong> = scene.materials.iter().map(|m| m.brdf).collect();
    for (index, material) in scene.vary.materials.iter().zip(varying) {
        all[*index] = *material;
    }
    all
}

/// One pixel of every block of 4 × 4, at a place that changes from block to block.
fn pixels_to_measure([width, height]: [u32; 2]) -> Vec<u32> {
    let mut pixels = Vec::new();
    for y0 in (0..height).step_by(4) {
        for x0 in (0..width).step_by(4) {
            let [dx, dy] = PixelSampler::new(1, y0 * width + x0).sample(0).pair(0).map(|u| (u * 4.0) as u32);
            pixels.push((y0 + dy).min(height - 1) * width + (x0 + dx).min(width - 1));
        }
    }
    pixels
}
