//! What fragments would be off by if they became this or that, estimated from two halves of the samples.

use super::TILE;
use super::film::{Film, Fragment};
use super::likeness::{Likeness, SAME, Samples};
use super::row::Neighbours;
use super::seen::{LAYERS, LOOKS, STATES, StateLight};
use crate::interrupted::Interrupted;
use crate::job::Job;
use rayon::prelude::*;

/// How many noises neighbours may differ by; the last looks at no light at all.
pub const STRENGTHS: [f32; 3] = [0.7, 1.5, f32::INFINITY];
/// What a fragment may become: itself, or as one of the strengths has it.
pub const CANDIDATES: usize = 1 + STRENGTHS.len();
/// How far estimates are averaged, pixels.
const RADIUS: i32 = 4;
/// Of squares of this side, one fragment of each class is looked at: estimates are averaged anyway.
const STRIDE: i32 = 2;

/// No noise is less, in parts of the largest light, squared.
const LEAST: f32 = 1e-20;

/// By layer and candidate.
pub type OfCandidates = [[f32; CANDIDATES]; LAYERS];

/// In all states that are looked at, by which strengths are chosen, and in the random ones, which are told of.
#[derive(Debug, Clone, Copy, Default)]
pub struct OfLooks {
    /// Sums over all states, each by its [`scales`].
    pub all: OfCandidates,
    /// Those over the random ones, which are means over these.
    pub random: OfCandidates,
}

/// What noise is left, as the root of the mean square over the random states of relative L2 errors.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Noise {
    /// Without the filter.
    pub before: f64,
    /// With it, and with what it takes for noise that is none.
    pub after: f64,
}

/// Estimates of squared errors, in parts of the square of all that the film shows, means over the random states, to
/// which the sharpest one is added where it counts.
pub struct Errors {
    /// See [`scales`].
    scales: StateLight,
    /// Of all candidates, of the fragments that are looked at.
    looked_at: Vec<Option<OfLooks>>,
    /// What of that is noise.
    of_noise: Vec<Option<OfLooks>>,
    /// Of all fragments as they are, for all candidates.
    as_is: Vec<Option<OfLooks>>,
}

impl Errors {
    /// Estimates those of `film`.
    ///
    /// # Errors
    /// If the job is interrupted.
    pub fn new(film: &Film, job: &Job) -> Result<Self, Interrupted> {
        let (scales, tiles) = (scales(film), tiles(film));
        let progress = job.progress("filtering", tiles.len() as u64);
        let of_tile = |tile: &[i32; 2]| {
            progress.check()?;
            let errors: Vec<_> =
                (0..film.classes()).flat_map(|class| errors_of(film, class, *tile, &scales)).collect();
            progress.advance(1);
            Ok(errors)
        };
        let found = tiles.par_iter().map(of_tile).collect::<Result<Vec<_>, Interrupted>>()?;
        let mut looked_at = vec![None; film.fragments().len()];
        let mut of_noise = looked_at.clone();
        for (number, [errors, noise]) in found.into_iter().flatten() {
            (looked_at[number as usize], of_noise[number as usize]) = (Some(errors), Some(noise));
        }
        let as_is = |f: &Fragment| f.has_halves.then(|| errors_as_is(f, &scales));
        let as_is = film.fragments().iter().map(as_is).collect();
        Ok(Self { scales, looked_at, of_noise, as_is })
    }

    /// Of every fragment, means over those around it, of some of the states.
    pub fn smoothed(&self, film: &Film, of: impl Fn(&OfLooks) -> &OfCandidates + Sync) -> Vec<OfCandidates> {
        let weights: Vec<_> = film.fragments().iter().map(|f| weights(f, &self.scales)).collect();
        let by_noise = |number: u32, layer: usize| weights[number as usize][layer];
        let smooth = |errors: &[Option<OfLooks>]| {
            smooth(film, |number| errors[number as usize].as_ref().map(&of), by_noise, RADIUS)
        };
        let mut smoothed = smooth(&self.looked_at);
        for (errors, noise) in smoothed.iter_mut().zip(smooth(&self.of_noise)) {
            let all = errors.as_flattened_mut().iter_mut().zip(noise.as_flattened());
            // What is not noise was made by the filter, and is no less than nothing.
            all.for_each(|(error, noise)| *error = error.max(*noise));
        }
        // That of a fragment as it is is known of all, and must be: where one sample found much light and was
        // not looked at, its neighbours as they are seem better than with it.
        for (errors, as_is) in smoothed.iter_mut().zip(smooth(&self.as_is)) {
            errors.iter_mut().zip(as_is).for_each(|(errors, as_is)| errors[0] = as_is[0]);
        }
        smoothed
    }

    /// What noise those fragments that are `wanted` have left if candidates have these shares, in parts of all
    /// light; `None` if the film shows no light, or no fragment has two halves of samples.
    pub fn noise(
        &self,
        film: &Film,
        shares: &[OfCandidates],
        wanted: impl Fn(&Fragment) -> bool,
    ) -> Option<Noise> {
        let is_lit = self.scales.iter().any(|scale| *scale > 0.0);
        let is_known = is_lit && self.as_is.iter().any(Option::is_some);
        let sum = |errors: &[Option<OfLooks>]| sum(film, errors, shares, &wanted);
        is_known.then(|| Noise {
            before: sum(&self.as_is).sqrt(),
            after: sum(&self.looked_at).max(sum(&self.of_noise)).sqrt(),
        })
    }
}

/// Upper left pixels of the tiles of a film.
pub fn tiles(film: &Film) -> Vec<[i32; 2]> {
    let side = TILE as usize;
    let largest =
        |k: usize| film.fragments().iter().map(|f| film.pixel(f)[k]).max().map_or(0, |p| p as usize + 1);
    let [columns, rows] = [0, 1].map(|k| largest(k).div_ceil(side));
    (0..rows).flat_map(|y| (0..columns).map(move |x| [x * side, y * side].map(|p| p as i32))).collect()
}

/// By state, 1 over the sum of the squares of what the film shows, so that states count alike; 0 where they
/// show nothing. Of the sharpest state direct light is all that is looked at.
fn scales(film: &Film) -> StateLight {
    let mut sums = [0.0f64; LOOKS];
    for fragment in film.fragments() {
        for (state, sum) in sums.iter_mut().enumerate() {
            let light: f32 = (0..LAYERS).map(|layer| fragment.guide(layer)[state]).sum();
            *sum += f64::from(light * fragment.coverage).powi(2);
        }
    }
    sums.map(|sum| if sum > 0.0 { (1.0 / (STATES as f64 * sum)) as f32 } else { 0.0 })
}

/// The first fragment of a class that has two halves of samples, in each square of [`STRIDE`] pixels a side
/// of a tile.
fn looked_at(film: &Film, class: usize, tile: [i32; 2]) -> Vec<u32> {
    let squares = (0..TILE / STRIDE).flat_map(|y| (0..TILE / STRIDE).map(move |x| [x, y]));
    let first = |[x, y]: [i32; 2]| {
        let from = [tile[0] + x * STRIDE, tile[1] + y * STRIDE];
        let mut steps = (0..STRIDE * STRIDE).map(|k| [k % STRIDE, k / STRIDE]);
        let has_halves = |number: &u32| film.fragments()[*number as usize].has_halves;
        steps.find_map(|[dx, dy]| film.at(class, from[0] + dx, from[1] + dy).filter(has_halves))
    };
    squares.filter_map(first).collect()
}

/// Estimates of the squared errors of all candidates, of the fragments of a class that are looked at in a
/// tile, and what of them is noise.
fn errors_of(film: &Film, class: usize, tile: [i32; 2], scales: &StateLight) -> Vec<(u32, [OfLooks; 2])> {
    let numbers = looked_at(film, class, tile);
    if numbers.is_empty() {
        return Vec::new();
    }
    let neighbours: Vec<Neighbours> = numbers.iter().map(|n| Neighbours::new(film, *n)).collect();
    let mut errors: Vec<_> = numbers.into_iter().map(|n| (n, [OfLooks::default(); 2])).collect();
    for layer in 0..LAYERS {
        let is_lit = |(number, _): &(u32, [OfLooks; 2])| {
            film.fragments()[*number as usize].guide(layer) != [0.0; LOOKS]
        };
        if !errors.iter().any(is_lit) {
            continue;
        }
        let likeness = [0, 1].map(|half| Likeness::new(film, class, layer, tile, Samples::Half(half)));
        for ((number, [errors, noise]), neighbours) in errors.iter_mut().zip(&neighbours) {
            let [all, random] = errors_of_candidates(film, *number, layer, neighbours, &likeness, scales);
            [errors.all[layer], noise.all[layer]] = all;
            [errors.random[layer], noise.random[layer]] = random;
        }
    }
    errors
}

/// Estimates of the squared errors of a fragment as it is, those of all candidates.
fn errors_as_is(fragment: &Fragment, scales: &StateLight) -> OfLooks {
    let squared = |layer: usize, k: usize| {
        (fragment.guides[0][layer][k] - fragment.guides[1][layer][k]).powi(2) * scales[k]
    };
    let of = |looks: usize| {
        std::array::from_fn(|layer| [0.25 * (0..looks).map(|k| squared(layer, k)).sum::<f32>(); CANDIDATES])
    };
    OfLooks { all: of(LOOKS), random: of(STATES) }
}

/// A candidate made of one half is taken to be independent of the other half, which it is but for that both
/// are of one stratified sequence; so what they differ by is its error and the noise of the other, which is
/// known. Both halves together, which are what is wanted, have half of a candidate's own noise; that is what
/// two candidates differ by, and comes second. Both in all states, and in the random ones.
fn errors_of_candidates(
    film: &Film,
    number: u32,
    layer: usize,
    neighbours: &Neighbours,
    likeness: &[Likeness; 2],
    scales: &StateLight,
) -> [[[f32; CANDIDATES]; 2]; 2] {
    let fragment = &film.fragments()[number as usize];
    let pixel = film.pixel(fragment);
    let halves = [0, 1].map(|half| fragment.guides[half][layer]);
    let filtered = STRENGTHS.map(|strength| {
        [0, 1].map(|half| {
            let row = neighbours.row(likeness[half].at(pixel), strength);
            let mut value = [0.0; LOOKS];
            for (other, weight) in row {
                let guide = &film.fragments()[other as usize].guides[half][layer];
                value.iter_mut().zip(guide).for_each(|(value, guide)| *value += weight * guide);
            }
            value
        })
    });
    [LOOKS, STATES].map(|looks| {
        let sum = |of_state: &dyn Fn(usize) -> f32| (0..looks).map(|k| of_state(k) * scales[k]).sum::<f32>();
        let noise = sum(&|k| (halves[0][k] - halves[1][k]).powi(2));
        let [mut errors, mut of_noise] = [[0.25 * noise; CANDIDATES]; 2];
        for (candidate, [a, b]) in (1..).zip(&filtered) {
            let crossed = sum(&|k| (a[k] - halves[1][k]).powi(2) + (b[k] - halves[0][k]).powi(2));
            let own = sum(&|k| (a[k] - b[k]).powi(2));
            errors[candidate] = 0.5 * crossed - 0.5 * noise - 0.25 * own;
            of_noise[candidate] = 0.25 * own;
        }
        [errors, of_noise]
    })
}

/// How much an error counts among its neighbours': less where noise is more, lest a few samples that found
/// much light choose for all.
fn weights(fragment: &Fragment, scales: &StateLight) -> [f32; LAYERS] {
    std::array::from_fn(|layer| {
        let squares = |k: usize| fragment.variances[layer][k] + SAME * fragment.guide(layer)[k].powi(2);
        let noise: f32 = (0..LOOKS).map(|k| squares(k) * scales[k]).sum();
        fragment.samples / noise.max(LEAST)
    })
}

/// Means over those neighbours of the same class that have a value, by the weight of each in each layer.
pub fn smooth<'a>(
    film: &Film,
    values: impl Fn(u32) -> Option<&'a OfCandidates> + Sync,
    weight: impl Fn(u32, usize) -> f32 + Sync,
    radius: i32,
) -> Vec<OfCandidates> {
    let mean = |fragment: &Fragment| {
        let ([x, y], class) = (film.pixel(fragment), usize::from(fragment.class));
        let (mut sums, mut weights) = (OfCandidates::default(), [0.0; LAYERS]);
        for (dx, dy) in (-radius..=radius).flat_map(|dy| (-radius..=radius).map(move |dx| (dx, dy))) {
            let Some(number) = film.at(class, x + dx, y + dy) else { continue };
            let Some(value) = values(number) else { continue };
            for layer in 0..LAYERS {
                let weight = weight(number, layer);
                let all = sums[layer].iter_mut().zip(value[layer]);
                all.for_each(|(sum, value)| *sum += weight * value);
                weights[layer] += weight;
            }
        }
        let scaled = |layer: usize| if weights[layer] > 0.0 { 1.0 / weights[layer] } else { 0.0 };
        std::array::from_fn(|layer| sums[layer].map(|sum| sum * scaled(layer)))
    };
    film.fragments().par_iter().map(mean).collect()
}

/// The error of a fragment whose candidates have these errors and shares.
pub fn mix(errors: &OfCandidates, shares: &OfCandidates) -> f32 {
    errors.as_flattened().iter().zip(shares.as_flattened()).map(|(error, share)| error * share).sum()
}

/// The sum of the errors of all that are `wanted`, if those of them that have `errors` stand for all.
fn sum(
    film: &Film,
    errors: &[Option<OfLooks>],
    shares: &[OfCandidates],
    wanted: impl Fn(&Fragment) -> bool,
) -> f64 {
    let (mut sum, mut known, mut all) = (0.0, 0.0, 0.0);
    for ((fragment, errors), shares) in film.fragments().iter().zip(errors).zip(shares) {
        if !wanted(fragment) {
            continue;
        }
        let weight = f64::from(fragment.coverage).powi(2);
        all += weight;
        let Some(errors) = errors else { continue };
        sum += weight * f64::from(mix(&errors.random, shares));
        known += weight;
    }
    if known > 0.0 { sum * all / known } else { 0.0 }
}
