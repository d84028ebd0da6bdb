//! Pictures of states, from the paths of a bake and with its filter.

use super::choice::Filter;
use super::film::Film;
use super::row::Row;
use super::seen::{LAYERS, Seen, Watcher, half_of};
use crate::brdf;
use crate::guided;
use crate::interrupted::Interrupted;
use crate::job::Job;
use crate::trace::gather::{Gather, GatherPath};
use crate::trace::lights::Lights;
use crate::trace::reference::{Estimate, Settings};
use crate::trace::spot::Spot;
use crate::trace::world::World;
use glam::{DVec3, Vec3A};
use rayon::prelude::*;
use relume_formats::basis::Angles;
use relume_formats::state::Brdf;
use relume_scenes::Scene;

/// What one fragment shows in one state: sums over its samples, and of their squares, by layer.
#[derive(Clone, Copy, Default)]
struct Shown {
    sums: [Vec3A; LAYERS],
    squares: [Vec3A; LAYERS],
}

impl Shown {
    fn add(&mut self, light: [Vec3A; LAYERS]) {
        for (layer, light) in light.into_iter().enumerate() {
            self.sums[layer] += light;
            self.squares[layer] += light * light;
        }
    }

    /// Mean of a layer, and the variance of that mean.
    fn mean_and_variance(&self, layer: usize, samples: f32) -> (DVec3, DVec3) {
        let samples = f64::from(samples);
        let mean = self.sums[layer].as_dvec3() / samples;
        let spread = (self.squares[layer].as_dvec3() / samples - mean * mean).max(DVec3::ZERO);
        // One sample says nothing of its spread, which is about as large as it.
        (mean, if samples > 1.0 { spread / (samples - 1.0) } else { mean * mean })
    }
}

/// One class of surfaces in a pixel.
struct Record {
    pixel: u32,
    class: u16,
    seen: Seen,
    /// By state.
    shown: Vec<Shown>,
}

/// Renders `scenes`, which must differ from `base` in their materials only, on one set of paths, the very
/// ones that a bake of `base` traces up to two reflections, filtered as it filters them. With
/// later reflections, which find highlights here, states count a little otherwise against each other, and a
/// choice may fall otherwise.
///
/// # Errors
/// If the job is interrupted.
pub fn render(
    base: &Scene,
    scenes: &[Scene],
    settings: &Settings,
    job: &Job,
) -> Result<Vec<Estimate>, Interrupted> {
    let [width, height] = settings.size;
    let world = World::new(base);
    let lights = Lights::new(base, &world);
    let gather = guided::gather(base, &world, &lights, &settings.guided(), job)?.with_later_highlights();
    let records = trace(base, &gather, scenes, settings, job)?;
    let samples = |pixel: u32| gather.samples(pixel, settings.samples);
    let film = Film::new(width, samples, records.iter().map(|r| (r.pixel, r.class, r.seen)));
    let filter = Filter::new(film, job)?;
    // By number of the fragment.
    let mut shown = vec![&[][..]; filter.fragments().len()];
    for record in &records {
        if let Some(number) = filter.number(record.pixel, record.class) {
            shown[number as usize] = &record.shown;
        }
    }
    let mut images = vec![vec![(DVec3::ZERO, DVec3::ZERO); (width * height) as usize]; scenes.len()];
    for record in &records {
        let emitted = Vec3A::from(record.seen.emitted).as_dvec3() / f64::from(samples(record.pixel));
        images.iter_mut().for_each(|image| image[record.pixel as usize].0 += emitted);
    }
    let tiles = filter.tiles();
    let progress = job.progress("filtering images", tiles.len() as u64);
    let filtered = tiles.par_iter().map(|tile| {
        progress.check()?;
        let of_state = |rows: &[Row; LAYERS], state| filtered(&filter, rows, &shown, state);
        let states =
            |(number, rows)| (number, (0..scenes.len()).map(|s| of_state(&rows, s)).collect::<Vec<_>>());
        let fragments: Vec<_> = filter.rows(*tile).into_iter().map(states).collect();
        progress.advance(1);
        Ok(fragments)
    });
    for (number, states) in filtered.collect::<Result<Vec<_>, Interrupted>>()?.into_iter().flatten() {
        let fragment = &filter.fragments()[number as usize];
        let coverage = f64::from(fragment.coverage);
        for (image, (mean, variance)) in images.iter_mut().zip(states) {
            let pixel = &mut image[fragment.pixel as usize];
            pixel.0 += mean * coverage;
            pixel.1 += variance * coverage * coverage;
        }
    }
    let rgb = |value: &DVec3| value.as_vec3().to_array();
    let estimate = |image: &Vec<(DVec3, DVec3)>| Estimate {
        radiance: image.iter().map(|(mean, _)| rgb(mean)).collect(),
        variance: image.iter().map(|(_, variance)| rgb(variance)).collect(),
    };
    Ok(images.iter().map(estimate).collect())
}

fn trace(
    base: &Scene,
    gather: &Gather<'_>,
    scenes: &[Scene],
    settings: &Settings,
    job: &Job,
) -> Result<Vec<Record>, Interrupted> {
    let watcher = Watcher::new(base);
    let states: Vec<Vec<Brdf>> =
        scenes.iter().map(|s| s.materials.iter().map(|m| m.brdf).collect()).collect();
    let fixed = base.vary.materials.len();
    let class = |material: u32| base.vary.place_of(material).unwrap_or(fixed);
    let [width, height] = settings.size;
    let progress = job.progress("tracing", u64::from(height));
    let pixel = |pixel: u32| {
        let mut classes = vec![(Seen::default(), vec![Shown::default(); states.len()]); fixed + 1];
        let (mut number, samples) = (0, gather.samples(pixel, settings.samples));
        gather.pixel(pixel, samples, |path| {
            Watcher::emitted(path, &mut classes[fixed].0);
            if let GatherPath::Surface(eye) = path {
                let (seen, shown) = &mut classes[class(eye.spot.material)];
                watcher.add(path, half_of(number, samples), seen);
                for (shown, materials) in shown.iter_mut().zip(&states) {
                    let brdf = |spot: &Spot, angles: &Angles| {
                        brdf::evaluate(&materials[spot.material as usize], spot.albedo, angles)
                    };
                    let [direct, indirect] = eye.early_light(brdf);
                    shown.add([direct, indirect, eye.later_light(brdf, brdf, brdf)]);
                }
            }
            number += 1;
        });
        let is_there = |(_, (seen, _)): &(u16, (Seen, Vec<Shown>))| *seen != Seen::default();
        let record = |(class, (seen, shown))| Record { pixel, class, seen, shown };
        (0..).zip(classes).filter(is_there).map(record).collect::<Vec<_>>()
    };
    let row = |y: u32| {
        progress.check()?;
        let row: Vec<Record> = (y * width..(y + 1) * width).flat_map(pixel).collect();
        progress.advance(1);
        Ok(row)
    };
    Ok((0..height)
        .into_par_iter()
        .map(row)
        .collect::<Result<Vec<_>, Interrupted>>()?
        .into_iter()
        .flatten()
        .collect())
}

/// What a fragment becomes in a state, and the variance of it.
fn filtered(filter: &Filter, rows: &[Row; LAYERS], shown: &[&[Shown]], state: usize) -> (DVec3, DVec3) {
    let (mut mean, mut variance) = (DVec3::ZERO, DVec3::ZERO);
    for (layer, row) in rows.iter().enumerate() {
        for (number, weight) in row {
            let (fragment, weight) = (&filter.fragments()[*number as usize], f64::from(*weight));
            let of = shown[*number as usize][state].mean_and_variance(layer, fragment.samples);
            mean += of.0 * weight;
            variance += of.1 * weight * weight;
        }
    }
    (mean, variance)
}
