//! Errors on textures that a bake was not made for, on the bake's own paths.
//!
//! What the method leaves out: the analytic BRDFs of texels where paths meet them, against what bases, regions and
//! components make of them. A path meets one texel of a region, so that there is noise in the difference, if less than
//! in light; it is taken off, as the product of the differences of two halves of the paths. What compression leaves
//! out: the sums of fragments against what a file makes of them. The error is that of both, which have nothing to do
//! with each other.

use super::layout::Layout;
use super::model::{Model, Parts, State, numbers, worn};
use super::project::Reflectors;
use super::rows::{RowOf, rows_of};
use super::settings::Settings;
use super::weights::Weights;
use crate::compress::statistics::{median, worst};
use crate::error::Result;
use crate::filter::seen::half_of;
use crate::fragments::{Record, Records, tiles_of};
use crate::interrupted::Interrupted;
use crate::job::Job;
use crate::methods::transfer_images::held_out::one_pixel_in;
use crate::random_paint::in_random_paint;
use crate::trace::coat::Coat;
use crate::trace::gather::{Gather, GatherPath};
use crate::trace::reference::early_radiance_of;
use crate::trace::spot::Spot;
use glam::{DVec3, Vec3A};
use rayon::prelude::*;
use relume_formats::basis::Angles;
use relume_formats::evaluate::region_images::{before_eye, evaluate, row_factors};
use relume_formats::kinds::region_images::Head;
use relume_formats::kinds::{BrdfBasis, RegionImages};
use relume_formats::state::Rgb;
use relume_scenes::Scene;

/// Number of held-out states.
pub const STATES: u32 = 8;
/// One pixel of every square of so many a side is looked at.
pub const SPACING: u32 = 4;

/// Relative L2 errors of every state that shows anything.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Errors {
    /// Of all that is left out.
    pub all: Vec<f64>,
    /// Of what compression leaves out alone.
    pub of_compression: Vec<f64>,
}

impl Errors {
    /// Median and largest of some, by name.
    pub fn named(errors: &[f64], ending: &str) -> Vec<(String, f64)> {
        if errors.is_empty() {
            return Vec::new();
        }
        [("median", median(errors)), ("worst", worst(errors))]
            .map(|(which, error)| (format!("relative_l2_{which}{ending}"), error))
            .to_vec()
    }
}

/// What errors are measured of.
pub struct Measuring<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// Its paths.
    pub gather: &'a Gather<'a>,
    /// The basis of its materials.
    pub basis: &'a BrdfBasis,
    /// The settings of the bake.
    pub settings: Settings,
    /// What channels are of.
    pub layout: &'a Layout,
    /// What regions count.
    pub weights: &'a Weights,
}

/// A state, and what it is compared by.
struct Looked<'a> {
    /// Materials as they are.
    coats: Vec<Coat>,
    /// As a bake has them.
    state: State<'a>,
    /// Factors of every row, by basis of the eye, but for their steps.
    factors: Vec<Vec<Rgb>>,
    /// What the file shows.
    film: Vec<Rgb>,
}

/// A pixel in one state.
#[derive(Debug, Clone, Copy, Default)]
struct Shown {
    truth: DVec3,
    /// What the method is off by, by half of the paths.
    off: [DVec3; 2],
}

impl Measuring<'_> {
    /// Measures `images`, made of the records that are `kept`.
    ///
    /// # Errors
    /// If a log cannot be read or the job is interrupted.
    pub fn measure(&self, kept: &Records<'_>, images: &RegionImages, job: &Job) -> Result<Errors> {
        let mut pixels = one_pixel_in(SPACING, self.settings.size);
        pixels.sort_unstable();
        let progress = job.progress("measuring", u64::from(STATES) + pixels.len() as u64);
        let scenes: Vec<Scene> = (0..STATES).map(|state| in_random_paint(state, self.scene)).collect();
        let model = self.model(&images.head);
        let mut looked = Vec::new();
        for scene in &scenes {
            progress.check().map_err(|Interrupted| Interrupted)?;
            looked.extend(self.looked(&model, scene, images));
            progress.advance(1);
        }
        let of_kept = self.sums(&model, kept, &pixels, &looked)?;
        let shown = pixels.par_iter().map(|pixel| {
            progress.check()?;
            let shown = self.shown(&model, *pixel, &looked, (None, Parts::BAKED));
            progress.advance(1);
            Ok(shown)
        });
        let shown = shown.collect::<std::result::Result<Vec<Option<Vec<Shown>>>, Interrupted>>()?;
        let mut errors = Errors::default();
        for (state, Looked { film, .. }) in looked.iter().enumerate() {
            let [mut norm, mut of_method, mut of_compression] = [0.0; 3];
            for ((pixel, shown), kept) in pixels.iter().zip(&shown).zip(&of_kept) {
                let Some(Shown { truth, off: [first, second] }) = shown.as_ref().map(|shown| shown[state])
                else {
                    continue;
                };
                norm += truth.length_squared();
                of_method += first.dot(second);
                let film = DVec3::from_array(film[*pixel as usize].map(f64::from));
                of_compression += film.distance_squared(kept[state]);
            }
            if norm > 0.0 {
                errors.all.push(((of_method.max(0.0) + of_compression) / norm).sqrt());
                errors.of_compression.push((of_compression / norm).sqrt());
            }
        }
        Ok(errors)
    }

    /// Relative L2 by state of what `parts` are off by beside others, or beside the analytic BRDFs, without noise.
    ///
    /// # Errors
    /// If the job is interrupted.
    pub fn alone(
        &self,
        images: &RegionImages,
        (beside, parts): (Option<Parts>, Parts),
        job: &Job,
    ) -> Result<Vec<f64>> {
        let pixels = one_pixel_in(SPACING, self.settings.size);
        let progress = job.progress("measuring", pixels.len() as u64);
        let scenes: Vec<Scene> = (0..STATES).map(|state| in_random_paint(state, self.scene)).collect();
        let model = self.model(&images.head);
        let looked: Vec<Looked<'_>> =
            scenes.iter().filter_map(|scene| self.looked(&model, scene, images)).collect();
        let shown = pixels.par_iter().map(|pixel| {
            progress.check()?;
            progress.advance(1);
            Ok(self.shown(&model, *pixel, &looked, (beside, parts)))
        });
        let shown = shown.collect::<std::result::Result<Vec<Option<Vec<Shown>>>, Interrupted>>()?;
        let error = |state: usize| {
            let of_state = shown.iter().flatten().map(|shown| shown[state]);
            let (off, norm) = of_state.fold((0.0, 0.0), |(off, norm), shown| {
                (off + shown.off[0].dot(shown.off[1]), norm + shown.truth.length_squared())
            });
            (off.max(0.0) / norm).sqrt()
        };
        Ok((0..looked.len()).map(error).collect())
    }

    fn model(&self, head: &Head) -> Model<'_> {
        let Self { scene, basis, layout, weights, .. } = *self;
        Model { basis, layout, weights, reflectors: Reflectors::new(scene), numbers: numbers(head) }
    }

    fn looked<'b>(&self, model: &Model<'_>, scene: &'b Scene, images: &RegionImages) -> Option<Looked<'b>> {
        let (head, worn) = (&images.head, worn(scene));
        let mut factors = row_factors(head, self.basis.bases(), &before_eye(head, self.basis, &worn)?);
        for (factor, row) in factors.iter_mut().flatten().zip(head.rows.iter().flatten()) {
            *factor = factor.map(|factor| factor / row.step);
        }
        let (state, film) = (model.state(scene, head)?, evaluate(images, self.basis, &worn)?);
        Some(Looked { coats: Coat::all_of(scene), state, factors, film })
    }

    /// What the records of some pixels show in each state.
    fn sums(
        &self,
        model: &Model<'_>,
        records: &Records<'_>,
        pixels: &[u32],
        looked: &[Looked<'_>],
    ) -> Result<Vec<Vec<DVec3>>> {
        let rows = rows_of(self.layout, self.weights);
        let [columns, tiles_down] = tiles_of(self.settings.size);
        let of_tiles = (0..columns * tiles_down).into_par_iter().map(|number| {
            let tile = records.mean_tile(number)?;
            let mut found = Vec::new();
            for record in records.of(&tile)? {
                if let Ok(place) = pixels.binary_search(&record.0.pixel) {
                    let key = (record.0.pixel, record.0.class);
                    let Some(number) = model.numbers.get(&key) else { continue };
                    let of =
                        |looked: &Looked<'_>| self.of_record(&record, records.fixed, &rows, looked, *number);
                    found.push((place, looked.iter().map(of).collect::<Vec<DVec3>>()));
                }
            }
            Ok(found)
        });
        let mut sums = vec![vec![DVec3::ZERO; looked.len()]; pixels.len()];
        for (place, shown) in of_tiles.collect::<Result<Vec<_>>>()?.into_iter().flatten() {
            sums[place].iter_mut().zip(shown).for_each(|(sum, shown)| *sum += shown);
        }
        Ok(sums)
    }

    /// What a fragment adds to its pixel.
    fn of_record(
        &self,
        (fragment, record): &Record<'_>,
        fixed: u16,
        rows: &[Vec<RowOf>],
        looked: &Looked<'_>,
        number: usize,
    ) -> DVec3 {
        let is_fixed = fragment.class == fixed;
        let mut sum = DVec3::ZERO;
        for (eye, c) in looked.state.at_eye[number].iter().enumerate() {
            let block = self.layout.blocks(is_fixed).iter().find(|b| b.eye == eye && b.source.is_none());
            let light = block.map_or([0.0; 3], |block| match &record[block.start..][..block.colours] {
                [grey] => self.layout.chromaticity.unwrap_or([1.0; 3]).map(|colour| colour * grey),
                colour => std::array::from_fn(|k| colour[k]),
            });
            let mut light = DVec3::from_array(light.map(f64::from));
            let rows = rows.get(eye).into_iter().flatten();
            for (row, factor) in rows.zip(looked.factors.get(eye).into_iter().flatten()) {
                let value = f64::from(row.value(self.layout, is_fixed, record));
                light += DVec3::from_array(factor.map(f64::from)) * value;
            }
            sum += DVec3::from_array(c.map(f64::from)) * light;
        }
        sum
    }

    /// A pixel in every state, and what `parts` make of it beside others or the analytic BRDFs; `None` if it shows a
    /// light or the background.
    fn shown(
        &self,
        model: &Model<'_>,
        pixel: u32,
        looked: &[Looked<'_>],
        (beside, parts): (Option<Parts>, Parts),
    ) -> Option<Vec<Shown>> {
        let samples = self.gather.samples(pixel, self.settings.samples);
        let mut sums = vec![Shown::default(); looked.len()];
        let (mut shows_light, mut number) = (false, 0);
        self.gather.pixel(pixel, samples, |path: &GatherPath| {
            shows_light |= path.shows_light();
            for (sum, Looked { coats, state, .. }) in sums.iter_mut().zip(looked) {
                let exact = early_radiance_of(path, |spot: &Spot, angles: &Angles| -> Vec3A {
                    coats[spot.material as usize].evaluate(spot, angles)
                });
                sum.truth += exact.as_dvec3();
                let light = |parts| model.light(path, pixel, state, parts);
                let off = light(parts) - beside.map_or(exact, light);
                sum.off[half_of(number, samples)] += off.as_dvec3();
            }
            number += 1;
        });
        let mean = |sum: Shown| Shown {
            truth: sum.truth / f64::from(samples),
            off: sum.off.map(|off| off * 2.0 / f64::from(samples)),
        };
        (!shows_light && samples > 1).then(|| sums.into_iter().map(mean).collect())
    }
}

/// What errors are measured on.
pub fn measured_on() -> String {
    let one_in = SPACING * SPACING;
    format!(
        "{STATES} states of random textures and materials that were not baked, one pixel in {one_in}, against the analytic BRDF of each texel on the bake's own paths before noise is filtered out"
    )
}
