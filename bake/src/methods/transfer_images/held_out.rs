//! Errors on states that a bake was not made for: the bake's own paths with the analytic BRDF against what
//! bases and storage make of it.
//!
//! As the paths are the same, noise cancels and what is left is the error of bases and storage. Pixels that
//! show a light or the background are left out: nothing there depends on bases, and one lamp in view can
//! outshine, and so hide, the errors of a whole room.

use super::settings::Settings;
use super::states::{State, all_materials};
use crate::brdf;
use crate::compress::statistics::{median, worst};
use crate::error::Result;
use crate::interrupted::Interrupted;
use crate::job::Job;
use crate::trace::gather::{Gather, GatherPath};
use crate::trace::reference::early_radiance_of;
use crate::trace::sampler::PixelSampler;
use crate::trace::spot::Spot;
use glam::{DVec3, Vec3A};
use half::f16;
use rayon::prelude::*;
use relume_formats::basis::Angles;
use relume_formats::evaluate::transfer_images::evaluate;
use relume_formats::kinds::brdf_basis::MAX_BASES;
use relume_formats::kinds::transfer_images::{Head, Image, Later, Meta};
use relume_formats::kinds::{BrdfBasis, TransferImages};
use relume_formats::state::{Brdf, Rgb};
use relume_scenes::Scene;
use std::collections::HashMap;
use std::sync::Arc;

pub use crate::random_state::random_state;

/// Number of held-out states.
pub const STATES: u32 = 16;
/// Fewest and most bases that [`choose_bases`] considers.
pub(super) const CHOICE: std::ops::RangeInclusive<usize> = 4..=16;
/// What rounding of what is stored adds to the error of bases, relative L2.
const ROUNDING: f64 = 0.0003;
/// About how many pixels [`choose_bases`] looks at in a bake.
pub const CHOICE_PIXELS: u32 = 2048;
/// Paths of each of these.
pub(super) const CHOICE_PATHS: u32 = 16;
/// [`measure`] looks at one pixel of every square of so many a side.
pub const SPACING: u32 = 4;

/// Errors over the held-out states.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HeldOutErrors {
    /// Median of the relative L2 errors.
    pub median: f64,
    /// Largest of the relative L2 errors.
    pub worst: f64,
}

impl HeldOutErrors {
    /// Of those that there are; `None` without any.
    pub(super) fn of(errors: &[Option<f64>]) -> Option<Self> {
        let errors: Vec<f64> = errors.iter().flatten().copied().collect();
        (!errors.is_empty()).then(|| Self { median: median(&errors), worst: worst(&errors) })
    }
}

/// What [`measure`] compares.
pub fn measured_on(later: bool) -> String {
    let one_in = SPACING * SPACING;
    let measured = format!(
        "{STATES} states of the materials that were not baked, one pixel in {one_in}, against the analytic BRDF on the bake's own paths before noise is filtered out"
    );
    if later {
        measured
            + " of at most two reflections; of_nodes: all light, later reflections by the albedos and lobes that are kept of materials; of_albedos: what these are off by, noise taken off"
    } else {
        measured
    }
}

/// Measures what `baked` has of at most two reflections, at one pixel in 16 of the paths of `gather`.
///
/// `None` if no state shows anything at these pixels.
///
/// # Errors
/// If the job is interrupted.
pub fn measure(
    scene: &Scene,
    gather: &Gather<'_>,
    settings: &Settings,
    basis: &BrdfBasis,
    baked: &TransferImages,
    job: &Job,
) -> Result<Option<HeldOutErrors>> {
    let layout = baked.head.layout();
    let is_early = |image: &&Image| !layout.slots[image.slot].first.is_later();
    let images = baked.images.iter().filter(is_early).cloned().collect();
    let early = TransferImages { head: baked.head.clone(), images };
    measure_images(scene, gather, settings, basis, (&early, None), job)
}

/// Measures all light of `baked`, third and later reflections by what it keeps of materials there, as [`measure`]
/// does: what nodes add to its error, and to its noise.
///
/// # Errors
/// If the job is interrupted.
pub fn measure_nodes(
    scene: &Scene,
    gather: &Gather<'_>,
    settings: &Settings,
    basis: &BrdfBasis,
    baked: &TransferImages,
    job: &Job,
) -> Result<Option<HeldOutErrors>> {
    measure_images(scene, gather, settings, basis, (baked, baked.head.later.as_ref()), job)
}

/// Measures images, with later reflections or without.
///
/// `None` if no state shows anything at these pixels.
///
/// # Errors
/// If the job is interrupted.
fn measure_images(
    scene: &Scene,
    gather: &Gather<'_>,
    settings: &Settings,
    basis: &BrdfBasis,
    (baked, later): (&TransferImages, Option<&Later>),
    job: &Job,
) -> Result<Option<HeldOutErrors>> {
    let pixels = one_pixel_in(SPACING, settings.size);
    let progress = job.progress("measuring", pixels.len() as u64);
    let varying: Vec<_> = (0..STATES).map(|s| random_state(s, scene)).collect();
    let on_bases =
        |materials: &Vec<Brdf>| materials.iter().filter_map(|m| basis.coefficients_of(m)).collect::<Vec<_>>();
    let looked_at = at_pixels(baked, &pixels);
    let images: Vec<_> = varying.par_iter().map(|state| evaluate(&looked_at, &on_bases(state))).collect();
    let states: Vec<_> = varying.iter().map(|v| State::new(scene, v, later, basis)).collect();

    let sums = pixels.par_iter().enumerate().map(|(number, &pixel)| {
        progress.check()?;
        let samples = gather.samples(pixel, settings.samples);
        let truth = true_radiance(gather, pixel, samples, &states, later.is_some());
        progress.advance(1);
        let squares = |(truth, image): (&DVec3, &Vec<Rgb>)| {
            let stored = DVec3::from_array(image[number].map(f64::from));
            Squares { difference: truth.distance_squared(stored), norm: truth.length_squared() }
        };
        Ok(truth.map_or_else(Vec::new, |truth| truth.iter().zip(&images).map(squares).collect()))
    });
    let sums = sums.collect::<std::result::Result<Vec<Vec<Squares>>, Interrupted>>()?;
    Ok(HeldOutErrors::of(&relative_errors(&sums, states.len())))
}

/// The images of `baked` at `pixels` alone, in one row.
fn at_pixels(baked: &TransferImages, pixels: &[u32]) -> TransferImages {
    let head = &baked.head;
    let numbers: HashMap<u32, u32> = pixels.iter().copied().zip(0..).collect();
    let number = |fragment: usize| numbers.get(&head.pixel[fragment]).copied();
    let kept: Vec<(usize, u32)> =
        (0..head.pixel.len()).filter_map(|fragment| Some((fragment, number(fragment)?))).collect();
    let layout = head.layout();
    let image = |image: &Image| {
        let fragments = head.fragments_of(&layout.slots[image.slot]);
        let plane =
            |plane: &[f16]| kept.iter().map_while(|(fragment, _)| plane.get(*fragment)).copied().collect();
        let planes: Vec<Vec<f16>> = image.values.chunks(fragments.max(1)).map(plane).collect();
        Image { slot: image.slot, values: planes.concat() }
    };
    let editable = head.meta.editable_fragments as usize;
    let meta = Meta {
        size: [pixels.len() as u32, 1],
        editable_fragments: kept.partition_point(|(fragment, _)| *fragment < editable) as u32,
        ..head.meta.clone()
    };
    let of_kept = |(fragment, _): &(usize, u32)| (head.class[*fragment], head.coverage[*fragment]);
    let (class, coverage) = kept.iter().map(of_kept).unzip();
    let pixel = kept.iter().map(|(_, number)| *number).collect();
    TransferImages {
        head: Arc::new(Head {
            meta,
            later: head.later.clone(),
            pixel,
            class,
            coverage,
            scales: head.scales.clone(),
        }),
        images: baked.images.par_iter().map(image).collect(),
    }
}

/// The fewest first functions of `basis`, which has as many as may be chosen, that keep the error of every
/// held-out state below `max_error`, found on 16 paths of `gather` at each of `pixels`; the most there are if
/// none do.
///
/// # Errors
/// If the job is interrupted.
pub fn choose_bases(
    scene: &Scene,
    gather: &Gather<'_>,
    basis: &BrdfBasis,
    samples: u32,
    max_error: f64,
    pixels: &[u32],
    job: &Job,
) -> Result<usize> {
    let varying: Vec<_> = (0..STATES).map(|s| random_state(s, scene)).collect();
    let states: Vec<_> = varying.iter().map(|v| all_materials(scene, v)).collect();
    // A smaller basis is the beginning of a larger one.
    let coefficients: Vec<Vec<Option<Vec<Rgb>>>> =
        states.iter().map(|materials| editable_coefficients(scene, basis, materials)).collect();

    let samples = samples.min(CHOICE_PATHS);
    let progress = job.progress("choosing", pixels.len() as u64);
    let sums = pixels.par_iter().map(|&pixel| {
        progress.check()?;
        let mut paths = Vec::with_capacity(samples as usize);
        gather.pixel(pixel, samples, |path| paths.push(path.clone()));
        let shows_light = paths.iter().any(GatherPath::shows_light);
        let squares = states
            .iter()
            .zip(&coefficients)
            .flat_map(|(materials, c)| compare_bases(&paths, basis, materials, c));
        let squares = if shows_light { Vec::new() } else { squares.collect() };
        progress.advance(1);
        Ok(squares)
    });
    let sums = sums.collect::<std::result::Result<Vec<Vec<Squares>>, Interrupted>>()?;
    let candidates = CHOICE.count();
    let errors = relative_errors(&sums, candidates * states.len());
    let worst = |candidate: usize| {
        errors.iter().skip(candidate).step_by(candidates).flatten().fold(0.0, |m: f64, e| m.max(*e))
    };
    let enough = (0..candidates).find(|c| worst(*c).hypot(ROUNDING) <= max_error);
    Ok(CHOICE.start() + enough.unwrap_or(candidates - 1))
}

/// Squared difference and squared truth at one pixel.
#[derive(Debug, Clone, Copy)]
pub(super) struct Squares {
    pub(super) difference: f64,
    pub(super) norm: f64,
}

/// Relative L2 over all pixels that have values; none where everything is black.
pub(super) fn relative_errors(pixels: &[Vec<Squares>], states: usize) -> Vec<Option<f64>> {
    let relative = |state: usize| {
        let at = pixels.iter().filter_map(|squares| squares.get(state));
        let (difference, norm) = at.fold((0.0, 0.0), |(d, n), s| (d + s.difference, n + s.norm));
        // An estimate of a square without bias may be below 0.
        (norm > 0.0).then(|| (difference.max(0.0) / norm).sqrt())
    };
    (0..states).map(relative).collect()
}

/// What [`measure`] does at `pixels` before it compares.
pub(super) fn trace(
    gather: &Gather<'_>,
    scene: &Scene,
    (basis, later): (&BrdfBasis, Option<&Later>),
    pixels: &[u32],
    samples: u32,
) {
    let states: Vec<_> =
        (0..STATES).map(|s| State::new(scene, &random_state(s, scene), later, basis)).collect();
    pixels
        .par_iter()
        .for_each(|pixel| drop(true_radiance(gather, *pixel, samples, &states, later.is_some())));
}

/// What a pixel shows in every state; `None` if it shows a light or the background.
fn true_radiance(
    gather: &Gather<'_>,
    pixel: u32,
    samples: u32,
    states: &[State<'_>],
    later: bool,
) -> Option<Vec<DVec3>> {
    let mut sums = vec![DVec3::ZERO; states.len()];
    let mut shows_light = false;
    gather.pixel(pixel, samples, |path| {
        shows_light |= path.shows_light();
        for (sum, state) in sums.iter_mut().zip(states) {
            let brdf = |spot: &Spot, angles: &Angles| state.brdf(spot, angles);
            *sum += early_radiance_of(path, brdf).as_dvec3();
            if later {
                *sum += state.later_as_baked(path).as_dvec3();
            }
        }
    });
    (!shows_light).then(|| sums.into_iter().map(|sum| sum / f64::from(samples)).collect())
}

/// What each number of bases in [`CHOICE`] makes of the sum over `paths`, up to two reflections, against the
/// analytic BRDF; fixed materials stay analytic.
fn compare_bases(
    paths: &[GatherPath],
    basis: &BrdfBasis,
    materials: &[Brdf],
    coefficients: &[Option<Vec<Rgb>>],
) -> Vec<Squares> {
    let analytic = |spot: &Spot, angles: &Angles| {
        brdf::evaluate(&materials[spot.material as usize], spot.albedo, angles)
    };
    let on = OnBases { basis, materials, coefficients };
    let truth: DVec3 = paths.iter().map(|path| early_radiance_of(path, analytic).as_dvec3()).sum();
    let squares = |bases: usize| {
        let sum: DVec3 = paths
            .iter()
            .map(|path| early_radiance_of(path, |spot, angles| on.evaluate(bases, spot, angles)).as_dvec3())
            .sum();
        Squares { difference: truth.distance_squared(sum), norm: truth.length_squared() }
    };
    CHOICE.map(squares).collect()
}

/// Materials of which those that vary are seen through a basis.
pub struct OnBases<'a> {
    /// The basis.
    pub basis: &'a BrdfBasis,
    /// All materials of the scene.
    pub materials: &'a [Brdf],
    /// On the basis, for those that vary.
    pub coefficients: &'a [Option<Vec<Rgb>>],
}

impl OnBases<'_> {
    /// The BRDF of a material with the first `bases` of the basis.
    pub fn evaluate(&self, bases: usize, spot: &Spot, angles: &Angles) -> Vec3A {
        let Some(coefficients) = &self.coefficients[spot.material as usize] else {
            return brdf::evaluate(&self.materials[spot.material as usize], spot.albedo, angles);
        };
        let mut values = [0.0; MAX_BASES];
        self.basis.evaluate(angles, &mut values[..self.basis.bases()]);
        let mut terms = coefficients[..bases].iter().zip(&values).map(|(c, v)| Vec3A::from(*c) * *v);
        // The texture acts on the diffuse basis only.
        terms.next().unwrap_or_default() * spot.albedo + terms.sum::<Vec3A>()
    }
}

/// For every material: its coefficients if it varies.
pub fn editable_coefficients(scene: &Scene, basis: &BrdfBasis, materials: &[Brdf]) -> Vec<Option<Vec<Rgb>>> {
    let of =
        |(index, material)| basis.coefficients_of(material).filter(|_| scene.vary.materials.contains(&index));
    materials.iter().enumerate().map(of).collect()
}

/// About so many pixels of a film of `size`, spread over it; fewer rather than more.
pub fn some_pixels(count: u32, size: [u32; 2]) -> Vec<u32> {
    let area = f64::from(size[0]) * f64::from(size[1]);
    one_pixel_in((area / f64::from(count)).sqrt().ceil().max(1.0) as u32, size)
}

/// One pixel of every block of `side` × `side`, at a place that changes from block to block.
pub fn one_pixel_in(side: u32, [width, height]: [u32; 2]) -> Vec<u32> {
    let mut pixels = Vec::new();
    for y0 in (0..height).step_by(side as usize) {
        for x0 in (0..width).step_by(side as usize) {
            let [dx, dy] =
                PixelSampler::new(1, y0 * width + x0).sample(0).pair(0).map(|u| (u * side as f32) as u32);
            pixels.push((y0 + dy).min(height - 1) * width + (x0 + dx).min(width - 1));
        }
    }
    pixels
}
