//! A look at a scene before hours of work: a picture of some 64 × 64 pixels, and what is wrong in it, in
//! words.
//!
//! The picture is of first hits, and of the light that arrives there if everything is grey, so that it says
//! nothing of materials and all of light and camera. What it costs is one hierarchy and some 300,000 rays.

mod warnings;

use crate::darkness::in_grey;
use crate::error::Result;
use crate::job::{Job, ProgressMode};
use crate::trace::lights::Lights;
use crate::trace::path::PathTracer;
use crate::trace::world::{Meeting, Owner, World};
use glam::Vec3A;
use rayon::prelude::*;
use relume_formats::state::Film;
use relume_scenes::Scene;

/// Larger side of the picture, pixels.
const SIDE: f64 = 64.0;
/// Paths of each pixel.
const SAMPLES: u32 = 16;
/// What half of the lit surfaces are to be shown below, everything being grey and white being 1.
const MIDDLE: f32 = 0.4;
/// What the dimmer nine tenths are to be shown below.
const BRIGHT: f32 = 0.8;

/// What a look at a scene has shown.
pub struct Probe<'a> {
    scene: &'a Scene,
    world: World,
    film: Film,
    /// What each pixel's middle shows, row by row.
    meetings: Vec<Option<Meeting>>,
    /// Radiance of each pixel with everything grey.
    grey: Vec<[f32; 3]>,
}

impl<'a> Probe<'a> {
    /// Looks at `scene` as a film of `size` pixels would show it.
    ///
    /// # Errors
    /// If the user asks to stop.
    pub fn new(scene: &'a Scene, size: [u32; 2]) -> Result<Self> {
        let size = small(size);
        let [width, height] = size;
        let (grey, film) = (in_grey(scene), scene.camera.film(width, height));
        let world = World::new(&grey);
        let lights = Lights::new(&grey, &world);
        let tracer = PathTracer::new(&grey, &world, &lights, size, scene.reflections, 0);
        let progress = Job::new(ProgressMode::None).progress("looking", u64::from(height));
        let pixel = |pixel: u32| {
            let direction = film.direction((pixel % width) as f32 + 0.5, (pixel / width) as f32 + 0.5);
            let mut sum = Vec3A::ZERO;
            tracer.pixel(pixel, SAMPLES, |radiance| sum += radiance);
            (world.meet(film.eye_in_world, direction), (sum / SAMPLES as f32).to_array())
        };
        let row = |y: u32| {
            progress.check()?;
            Ok((0..width).map(|x| pixel(y * width + x)).collect())
        };
        let rows: Vec<Vec<_>> = (0..height).into_par_iter().map(row).collect::<Result<_>>()?;
        let (meetings, grey) = rows.into_iter().flatten().unzip();
        Ok(Self { scene, world, film, meetings, grey })
    }

    /// What is wrong with the scene, a sentence each; bakes go on.
    pub fn warnings(&self) -> Vec<String> {
        warnings::of(self)
    }

    /// By how much the display should brighten the picture, so that grey surfaces look grey, in steps of a
    /// half; 0 if all is black.
    pub fn exposure_ev(&self) -> f32 {
        let ev = (2.0 * self.wanted_ev().unwrap_or(0.0)).round() / 2.0;
        // Not −0, which would be written so.
        ev.clamp(-32.0, 32.0) + 0.0
    }

    /// The exposure at which the middle of the picture is in the middle of the range and little of it at the
    /// end; `None` if all is black.
    fn wanted_ev(&self) -> Option<f32> {
        let [middle, bright] = [self.brightness(0.5)?, self.brightness(0.9)?];
        Some((MIDDLE / middle).min(BRIGHT / bright).log2())
    }

    /// Materials that are seen, each with the number of pixels that show it, the one with the most first.
    pub fn seen(&self) -> Vec<(String, u32)> {
        let mut counts = vec![0; self.scene.materials.len()];
        for meeting in self.meetings.iter().flatten() {
            if let Owner::Material(material) = meeting.owner
                && let Some(count) = counts.get_mut(material as usize)
            {
                *count += 1;
            }
        }
        let names = self.scene.materials.iter().map(|material| material.name.clone());
        let mut seen: Vec<(String, u32)> = names.zip(counts).filter(|(_, count)| *count > 0).collect();
        seen.sort_by_key(|(_, count)| std::cmp::Reverse(*count));
        seen
    }

    /// The radiance, as the mean of its channels, that the given part of the lit surfaces stays below, before
    /// exposure; `None` if there are none.
    fn brightness(&self, part: f64) -> Option<f32> {
        let is_surface =
            |met: &Option<Meeting>| met.is_some_and(|met| matches!(met.owner, Owner::Material(_)));
        let mean = |[r, g, b]: &[f32; 3]| (r + g + b) / 3.0;
        let surfaces = self.grey.iter().zip(&self.meetings).filter(|(_, met)| is_surface(met));
        let mut lit: Vec<f32> =
            surfaces.map(|(radiance, _)| mean(radiance)).filter(|radiance| *radiance > 0.0).collect();
        lit.sort_by(f32::total_cmp);
        lit.get((part * lit.len() as f64) as usize).copied()
    }
}

/// A film of the same proportions, at most [`SIDE`] pixels wide and high.
fn small(size: [u32; 2]) -> [u32; 2] {
    let larger = f64::from(size[0].max(size[1]));
    size.map(|side| ((f64::from(side) * (SIDE / larger).min(1.0)).round() as u32).max(1))
}
