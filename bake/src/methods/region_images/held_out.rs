//! Errors on textures that a bake was not made for, on the bake's own paths.
//!
//! What the method leaves out: the analytic BRDFs of texels where paths meet them, against what bases, regions and
//! components make of them. A path meets one texel of a region, so that there is noise in the difference, if less than
//! in light; it is taken off, as the product of the differences of two halves of the paths. What compression leaves
//! out: the sums of fragments against what a file makes of them. The error is that of both, which have nothing to do
//! with each other.

use super::layout::Layout;
use super::project::{Reflector, Reflectors, values};
use super::rows::{RowOf, rows_of};
use super::settings::Settings;
use super::weights::Weights;
use crate::brdf;
use crate::compress::statistics::{median, worst};
use crate::error::Result;
use crate::filter::seen::half_of;
use crate::fragments::{Record, Records, tiles_of};
use crate::interrupted::Interrupted;
use crate::job::Job;
use crate::methods::transfer_images::held_out::one_pixel_in;
use crate::random_paint::{RandomMaterial, random_paintings};
use crate::trace::gather::{FirstVertex, Gather, GatherPath, Reflection};
use crate::trace::reference::early_radiance_of;
use crate::trace::spot::Spot;
use glam::{DVec3, Vec3A};
use rayon::prelude::*;
use relume_formats::basis::Angles;
use relume_formats::evaluate::region_images::{
    OnBases, Worn, at_fragments, before_eye, evaluate, row_factors,
};
use relume_formats::kinds::region_images::{Head, Source};
use relume_formats::kinds::{BrdfBasis, RegionImages};
use relume_formats::state::Rgb;
use relume_scenes::Scene;
use relume_scenes::painting::region_of;
use std::collections::HashMap;

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

/// What materials make of light.
struct State {
    materials: Vec<RandomMaterial>,
    /// Coefficients of each class at the surface before the eye's, by region of painted ones.
    before: Vec<OnBases>,
    /// Those of painted ones as components have them, by group, region by region.
    of_components: Vec<Vec<Rgb>>,
    /// Factors of every row, by basis of the eye, but for their steps.
    factors: Vec<Vec<Rgb>>,
    /// Coefficients of each fragment of the file at the eye.
    at_eye: Vec<Vec<Rgb>>,
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
        let rows = rows_of(self.layout, self.weights);
        let (mut states, mut films) = (Vec::new(), Vec::new());
        for number in 0..STATES {
            progress.check().map_err(|Interrupted| Interrupted)?;
            let materials = random_paintings(number, self.scene);
            let worn: Vec<Worn<'_>> = materials.iter().map(worn).collect();
            let (state, film) = (self.state(&images.head, &worn), evaluate(images, self.basis, &worn));
            if let Some((state, film)) = state.zip(film) {
                states.push(State { materials, ..state });
                films.push(film);
            }
            progress.advance(1);
        }
        let numbers = numbers(&images.head);
        let of_kept = self.sums(kept, &pixels, &rows, &states, &numbers)?;
        let shown = pixels.par_iter().map(|pixel| {
            progress.check()?;
            let shown = self.shown(*pixel, &states, &numbers);
            progress.advance(1);
            Ok(shown)
        });
        let shown = shown.collect::<std::result::Result<Vec<Option<Vec<Shown>>>, Interrupted>>()?;
        let mut errors = Errors::default();
        for (state, film) in films.iter().enumerate() {
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

    /// Of these materials, which are left out of it.
    fn state(&self, head: &Head, worn: &[Worn<'_>]) -> Option<State> {
        let bases = self.basis.bases();
        let before: Vec<OnBases> = before_eye(head, self.basis, worn)?;
        let mut factors = row_factors(head, bases, &before);
        for (factor, row) in factors.iter_mut().flatten().zip(head.rows.iter().flatten()) {
            *factor = factor.map(|factor| factor / row.step);
        }
        let of_components = self.weights.groups.iter().map(|group| {
            group.seen_through(|region| {
                before[usize::from(group.material)].of(region, group.basis.into(), bases)
            })
        });
        Some(State {
            materials: Vec::new(),
            of_components: of_components.collect(),
            before,
            factors,
            at_eye: at_fragments(head, self.basis, worn)?,
        })
    }

    /// What the records of some pixels show in each state.
    fn sums(
        &self,
        records: &Records<'_>,
        pixels: &[u32],
        rows: &[Vec<RowOf>],
        states: &[State],
        numbers: &HashMap<(u32, u16), usize>,
    ) -> Result<Vec<Vec<DVec3>>> {
        let [columns, tiles_down] = tiles_of(self.settings.size);
        let of_tiles = (0..columns * tiles_down).into_par_iter().map(|number| {
            let tile = records.mean_tile(number)?;
            let mut found = Vec::new();
            for record in records.of(&tile)? {
                if let Ok(place) = pixels.binary_search(&record.0.pixel) {
                    let Some(number) = numbers.get(&(record.0.pixel, record.0.class)) else { continue };
                    let of = |state: &State| self.of_record(&record, records.fixed, rows, state, *number);
                    found.push((place, states.iter().map(of).collect::<Vec<DVec3>>()));
                }
            }
            Ok(found)
        });
        let mut sums = vec![vec![DVec3::ZERO; states.len()]; pixels.len()];
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
        state: &State,
        number: usize,
    ) -> DVec3 {
        let is_fixed = fragment.class == fixed;
        let mut sum = DVec3::ZERO;
        for (eye, c) in state.at_eye[number].iter().enumerate() {
            let c = DVec3::from_array(c.map(f64::from));
            let block = self.layout.blocks(is_fixed).iter().find(|b| b.eye == eye && b.source.is_none());
            let light = block.map_or([0.0; 3], |block| match &record[block.start..][..block.colours] {
                [grey] => self.layout.chromaticity.unwrap_or([1.0; 3]).map(|colour| colour * grey),
                colour => std::array::from_fn(|k| colour[k]),
            });
            let mut light = DVec3::from_array(light.map(f64::from));
            let rows = rows.get(eye).into_iter().flatten().zip(state.factors.get(eye).into_iter().flatten());
            for (row, factor) in rows {
                let value = f64::from(row.value(self.layout, is_fixed, record));
                light += DVec3::from_array(factor.map(f64::from)) * value;
            }
            sum += c * light;
        }
        sum
    }

    /// A pixel in every state; `None` if it shows a light or the background.
    fn shown(
        &self,
        pixel: u32,
        states: &[State],
        numbers: &HashMap<(u32, u16), usize>,
    ) -> Option<Vec<Shown>> {
        let reflectors = Reflectors::new(self.scene);
        let samples = self.gather.samples(pixel, self.settings.samples);
        let mut sums = vec![Shown::default(); states.len()];
        let (mut shows_light, mut number) = (false, 0);
        self.gather.pixel(pixel, samples, |path: &GatherPath| {
            shows_light |= path.shows_light();
            for (sum, state) in sums.iter_mut().zip(states) {
                let exact = early_radiance_of(path, |spot: &Spot, angles: &Angles| {
                    self.exact(&reflectors, state, spot, angles)
                });
                sum.truth += exact.as_dvec3();
                let of_method = self.of_method(path, pixel, &reflectors, state, numbers);
                sum.off[half_of(number, samples)] += (of_method - exact).as_dvec3();
            }
            number += 1;
        });
        let mean = |sum: Shown| Shown {
            truth: sum.truth / f64::from(samples),
            off: sum.off.map(|off| off * 2.0 / f64::from(samples)),
        };
        (!shows_light && samples > 1).then(|| sums.into_iter().map(mean).collect())
    }

    fn exact(&self, reflectors: &Reflectors, state: &State, spot: &Spot, angles: &Angles) -> Vec3A {
        let class = match reflectors.of(spot) {
            Reflector::Fixed(brdf) => return brdf::evaluate(&brdf, spot.albedo, angles),
            Reflector::Whole(class) | Reflector::Painted(class) => class,
        };
        match &state.materials[class] {
            RandomMaterial::Whole(brdf) => brdf::evaluate(brdf, spot.albedo, angles),
            RandomMaterial::Painted(paint) => {
                let of = paint.brdf.channels(&paint.at(spot.uv));
                let [r, g, b] = of.map(|brdf| brdf::evaluate(&brdf, Vec3A::ONE, angles));
                Vec3A::new(r.x, g.y, b.z)
            }
        }
    }

    /// What a path shows by bases, texels of fragments, and components of regions.
    fn of_method(
        &self,
        path: &GatherPath,
        pixel: u32,
        reflectors: &Reflectors,
        state: &State,
        numbers: &HashMap<(u32, u16), usize>,
    ) -> Vec3A {
        let GatherPath::Surface(eye) = path else { return Vec3A::ZERO };
        let [bases, indirect] = self.layout.bases;
        let (at_eye, albedo) = match reflectors.of(&eye.spot) {
            Reflector::Fixed(brdf) => {
                let [direct, _] = eye.early_light(|spot, angles| brdf::evaluate(&brdf, spot.albedo, angles));
                let Some(first) = &eye.indirect else { return eye.emitted + direct };
                let reflectance = brdf::evaluate(&brdf, eye.spot.albedo, &first.eye_angles);
                return eye.emitted + direct + self.sent_on(first, 0, reflectors, state) * reflectance;
            }
            reflector @ (Reflector::Whole(class) | Reflector::Painted(class)) => {
                let Some(number) = numbers.get(&(pixel, class as u16)) else { return eye.emitted };
                (&state.at_eye[*number], reflector.albedo(&eye.spot))
            }
        };
        let seen = |e: usize, value: f32| {
            let light = Vec3A::from(at_eye[e]) * value;
            if e == 0 { light * albedo } else { light }
        };
        let mut sum = eye.emitted;
        for Reflection { angles, light } in eye.direct.iter().flatten() {
            let values = values(self.basis, angles, bases);
            sum += *light * (0..bases).map(|e| seen(e, values[e])).sum::<Vec3A>();
        }
        if let Some(first) = &eye.indirect {
            let values = values(self.basis, &first.eye_angles, indirect);
            sum += (0..indirect)
                .map(|e| seen(e, values[e]) * self.sent_on(first, e, reflectors, state))
                .sum::<Vec3A>();
        }
        sum
    }

    /// What the surface before the eye's sends on to a basis of the eye.
    fn sent_on(&self, first: &FirstVertex, eye: usize, reflectors: &Reflectors, state: &State) -> Vec3A {
        let (spot, indirect) = (&first.spot, self.layout.bases[1]);
        let reflector = reflectors.of(spot);
        let coefficient = |class: usize, basis: usize| match reflector {
            Reflector::Painted(_) => {
                let source = Source::Painted { material: class as u16, basis: basis as u16 };
                let group = self.weights.group(eye, source);
                group.map_or([0.0; 3], |group| state.of_components[group][region_of(spot.uv) as usize])
            }
            _ => state.before[class].of(0, basis, self.basis.bases()),
        };
        let sent = |Reflection { angles, light }: &Reflection| {
            let class = match reflector {
                Reflector::Fixed(brdf) => return *light * brdf::evaluate(&brdf, spot.albedo, angles),
                Reflector::Whole(class) | Reflector::Painted(class) => class,
            };
            let values = values(self.basis, angles, indirect);
            let of = |basis: usize| {
                let reflected = Vec3A::from(coefficient(class, basis)) * values[basis];
                if basis == 0 { reflected * reflector.albedo(spot) } else { reflected }
            };
            *light * (0..indirect).map(of).sum::<Vec3A>()
        };
        first.reflections.iter().flatten().map(sent).sum()
    }
}

/// The number in the file of every fragment.
fn numbers(head: &Head) -> HashMap<(u32, u16), usize> {
    let fragments = &head.fragments;
    fragments.pixel.iter().copied().zip(fragments.class.iter().copied()).zip(0..).collect()
}

fn worn(material: &RandomMaterial) -> Worn<'_> {
    match material {
        RandomMaterial::Whole(brdf) => Worn::Whole(brdf),
        RandomMaterial::Painted(paint) => Worn::Painted(paint),
    }
}

/// What errors are measured on.
pub fn measured_on() -> String {
    let one_in = SPACING * SPACING;
    format!(
        "{STATES} states of random textures and materials that were not baked, one pixel in {one_in}, against the analytic BRDF of each texel on the bake's own paths before noise is filtered out"
    )
}
