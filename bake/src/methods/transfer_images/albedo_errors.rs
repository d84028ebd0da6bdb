//! What effective albedos and the lobes beside them leave of the light after three reflections and more, its
//! error against the analytic BRDF at all of them on paths that find highlights, and what lobes have of it.

use super::held_out::{HeldOutErrors, STATES, Squares, random_state, relative_errors};
use super::states::State;
use crate::error::Result;
use crate::interrupted::Interrupted;
use crate::job::{Job, Progress};
use crate::trace::gather::{Gather, GatherPath};
use crate::trace::reference::{early_radiance_of, later_radiance_of, radiance_of};
use crate::trace::spot::Spot;
use glam::{DVec3, Vec3A};
use rayon::prelude::*;
use relume_formats::basis::Angles;
use relume_formats::kinds::BrdfBasis;
use relume_formats::kinds::transfer_images::Later;
use relume_scenes::Scene;

/// What the baked kind of later reflections is off by over the held-out states at `pixels`, relative to all light
/// there; pixels that show a light are left out. The noise of two halves of the samples is independent, so that
/// the product of what they show has no bias by it, and none of it is in the errors but for what they are
/// uncertain by. `None` with a single sample.
///
/// # Errors
/// If the job is interrupted.
pub fn albedo_errors(
    scene: &Scene,
    gather: &Gather<'_>,
    kept: (&BrdfBasis, &Later),
    samples: u32,
    pixels: &[u32],
    job: &Job,
) -> Result<Option<HeldOutErrors>> {
    let error = |state: &State<'_>, path: &GatherPath| {
        let brdf = |spot: &Spot, angles: &Angles| state.brdf(spot, angles);
        let later = later_radiance_of(path, brdf, brdf, brdf);
        [later - state.later_as_baked(path), early_radiance_of(path, brdf) + later]
    };
    let progress = job.progress("measuring albedos", pixels.len() as u64);
    let samples = |pixel| gather.samples(pixel, samples);
    changes(scene, &gather.with_later_highlights(), kept, (&samples, pixels), &progress, error)
}

/// The same of what lobes have beyond albedos, on so many `samples` of every pixel's paths in a bake.
///
/// # Errors
/// If the job is interrupted.
pub fn share_of_lobes(
    scene: &Scene,
    gather: &Gather<'_>,
    kept: (&BrdfBasis, &Later),
    samples: u32,
    pixels: &[u32],
    job: &Job,
) -> Result<Option<HeldOutErrors>> {
    let lobes = |state: &State<'_>, path: &GatherPath| {
        let brdf = |spot: &Spot, angles: &Angles| state.brdf(spot, angles);
        [state.lobes_as_baked(path), radiance_of(path, brdf)]
    };
    let progress = job.progress("light of lobes", pixels.len() as u64);
    changes(scene, gather, kept, (&|_| samples, pixels), &progress, lobes)
}

/// How large a change is over the held-out states, in parts of all light, by those of a path: see
/// [`albedo_errors`].
fn changes(
    scene: &Scene,
    gather: &Gather<'_>,
    (basis, later): (&BrdfBasis, &Later),
    (samples, pixels): (&(dyn Fn(u32) -> u32 + Sync), &[u32]),
    progress: &Progress,
    of_path: impl Fn(&State<'_>, &GatherPath) -> [Vec3A; 2] + Sync,
) -> Result<Option<HeldOutErrors>> {
    let state = |state| State::new(scene, &random_state(state, scene), Some(later), basis);
    let states: Vec<State<'_>> = (0..STATES).map(state).collect();
    let squares = pixels.par_iter().map(|pixel| {
        progress.check()?;
        let squares = changes_of_pixel(gather, *pixel, samples(*pixel), &states, &of_path);
        progress.advance(1);
        Ok(squares)
    });
    let squares = squares.collect::<std::result::Result<Vec<Vec<Squares>>, Interrupted>>()?;
    Ok(HeldOutErrors::of(&relative_errors(&squares, states.len())))
}

/// By state: what changes, squared, and all light, squared; nothing if the pixel shows a light, or has a single
/// sample.
fn changes_of_pixel(
    gather: &Gather<'_>,
    pixel: u32,
    samples: u32,
    states: &[State<'_>],
    of_path: impl Fn(&State<'_>, &GatherPath) -> [Vec3A; 2],
) -> Vec<Squares> {
    let mut sums = vec![[[DVec3::ZERO; 2]; 2]; states.len()];
    let (mut shows_light, mut number) = (false, 0);
    gather.pixel(pixel, samples, |path| {
        shows_light |= path.shows_light();
        let half = usize::from(2 * number >= samples);
        number += 1;
        for (sums, state) in sums.iter_mut().zip(states) {
            let both = of_path(state, path);
            sums.iter_mut().zip(both).for_each(|(sum, light)| sum[half] += light.as_dvec3());
        }
    });
    let first = samples.div_ceil(2);
    let pairs = f64::from(first) * f64::from(samples - first);
    let squares = |sums: &[[DVec3; 2]; 2]| {
        let [difference, norm] = sums.map(|[a, b]| a.dot(b) / pairs);
        Squares { difference, norm }
    };
    if shows_light || samples < 2 { Vec::new() } else { sums.iter().map(squares).collect() }
}
