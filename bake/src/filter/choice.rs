//! How strong the filter is where, and what fragments become by it.

use super::TILE;
use super::errors::{CANDIDATES, Errors, Noise, OfCandidates, STRENGTHS, mix, smooth, tiles};
use super::film::{Film, Fragment};
use super::likeness::{Likeness, Samples};
use super::row::{Neighbours, Row, WINDOW};
use super::seen::LAYERS;
use crate::interrupted::Interrupted;
use crate::job::Job;

/// How far choices are averaged, pixels.
const CHOICE_RADIUS: i32 = 1;
/// A fragment stays as it is where the errors of all strengths seem so many times its own, by layer: what noise does
/// to a fragment is known well, what a filter does to it is an estimate that is noisy itself. Direct light has
/// little noise, and highlights that must not be blurred.
const DOUBT: [f32; LAYERS] = [1.0, 3.0, 3.0];

/// What every fragment of a film becomes.
pub struct Filter {
    film: Film,
    /// Of the candidates of each fragment.
    shares: Vec<OfCandidates>,
    /// See there; `None` without light.
    noise: Option<Noise>,
}

impl Filter {
    /// Chooses the strengths for `film`.
    ///
    /// # Errors
    /// If the job is interrupted.
    pub fn new(film: Film, job: &Job) -> Result<Self, Interrupted> {
        let (errors, shares) = choose(&film, job)?;
        let noise = errors.noise(&film, &shares, |_| true);
        Ok(Self { film, shares, noise })
    }

    /// See [`Noise`]; `None` if the film shows no light.
    pub fn noise(&self) -> Option<Noise> {
        self.noise
    }

    /// The fragments that it knows.
    pub fn fragments(&self) -> &[Fragment] {
        self.film.fragments()
    }

    /// The number of the fragment of a class in a pixel, if a surface is seen there.
    pub fn number(&self, pixel: u32, class: u16) -> Option<u32> {
        self.film.number(pixel, class)
    }

    /// Upper left pixels of the squares that [`Filter::rows`] takes.
    pub fn tiles(&self) -> Vec<[i32; 2]> {
        tiles(&self.film)
    }

    /// What the fragments in a tile become: their numbers, and what each is made of by layer.
    pub fn rows(&self, tile: [i32; 2]) -> Vec<(u32, [Row; LAYERS])> {
        (0..self.film.classes()).flat_map(|class| self.rows_of(class, tile)).collect()
    }

    fn rows_of(&self, class: usize, tile: [i32; 2]) -> Vec<(u32, [Row; LAYERS])> {
        let numbers = in_tile(&self.film, class, tile);
        if numbers.is_empty() {
            return Vec::new();
        }
        let looked_at = |layer: usize| {
            let by_light = |number: &u32| {
                let of_strengths = &self.shares[*number as usize][layer][1..CANDIDATES - 1];
                of_strengths.iter().any(|share| *share > 0.0)
            };
            let needed = numbers.iter().any(by_light);
            needed.then(|| Likeness::new(&self.film, class, layer, tile, Samples::All))
        };
        let likeness: [Option<Likeness>; LAYERS] = std::array::from_fn(looked_at);
        let row = |number: u32| {
            let neighbours = Neighbours::new(&self.film, number);
            let pixel = self.film.pixel(&self.film.fragments()[number as usize]);
            let of_layer = |layer: usize| {
                let distances = likeness[layer].as_ref().map(|likeness| likeness.at(pixel));
                mixed(number, &neighbours, distances, &self.shares[number as usize][layer])
            };
            (number, std::array::from_fn(of_layer))
        };
        numbers.into_iter().map(row).collect()
    }
}

/// What noise fragments of `film` that are `wanted` would have; `None` if these show no light.
///
/// # Errors
/// If the job is interrupted.
pub fn noise_of(
    film: &Film,
    wanted: impl Fn(&Fragment) -> bool,
    job: &Job,
) -> Result<Option<Noise>, Interrupted> {
    let (errors, shares) = choose(film, job)?;
    Ok(errors.noise(film, &shares, wanted))
}

/// Squared errors that fragments of `film`, filtered, are expected to have, in parts of the square of all that it
/// shows, means over the random states that are looked at and over the fragments around; 0 where nothing is known.
///
/// # Errors
/// If the job is interrupted.
pub fn expected_errors(film: &Film, job: &Job) -> Result<Vec<f32>, Interrupted> {
    let (errors, shares) = choose(film, job)?;
    let smoothed = errors.smoothed(film, |looks| &looks.random);
    Ok(smoothed.iter().zip(&shares).map(|(errors, shares)| mix(errors, shares)).collect())
}

/// What errors are expected of the candidates of fragments that are looked at, and the shares that the candidates of
/// each fragment get by those around it, in all states.
fn choose(film: &Film, job: &Job) -> Result<(Errors, Vec<OfCandidates>), Interrupted> {
    let errors = Errors::new(film, job)?;
    let chosen: Vec<_> = errors.smoothed(film, |looks| &looks.all).iter().map(best).collect();
    let by_samples = |number: u32, _| film.fragments()[number as usize].samples;
    let shares = smooth(film, |number| chosen.get(number as usize), by_samples, CHOICE_RADIUS);
    Ok((errors, shares))
}

/// The row of a fragment whose candidates have these shares.
fn mixed(own: u32, neighbours: &Neighbours, distances: Option<&[f32]>, shares: &[f32; CANDIDATES]) -> Row {
    const NO_LIGHT: [f32; (WINDOW * WINDOW) as usize] = [0.0; (WINDOW * WINDOW) as usize];
    let mut mixed: Row = vec![(own, shares[0])];
    for (strength, share) in STRENGTHS.into_iter().zip(&shares[1..]).filter(|(_, share)| **share > 0.0) {
        let row = neighbours.row(distances.unwrap_or(&NO_LIGHT), strength);
        mixed.extend(row.into_iter().map(|(number, weight)| (number, weight * share)));
    }
    mixed.sort_by_key(|(number, _)| *number);
    mixed.dedup_by(|next, kept| {
        let same = next.0 == kept.0;
        if same {
            kept.1 += next.1;
        }
        same
    });
    mixed.retain(|(_, weight)| *weight > 0.0);
    mixed
}

/// Fragments of a class in a tile.
fn in_tile(film: &Film, class: usize, tile: [i32; 2]) -> Vec<u32> {
    let pixels = (0..TILE).flat_map(|y| (0..TILE).map(move |x| [tile[0] + x, tile[1] + y]));
    pixels.filter_map(|[x, y]| film.at(class, x, y)).collect()
}

/// In each layer all of the share to the candidate with the least error, the weaker if two have; see [`DOUBT`].
fn best(layers: &OfCandidates) -> OfCandidates {
    std::array::from_fn(|layer| {
        let errors = layers[layer];
        let told =
            |candidate: usize| if candidate == 0 { DOUBT[layer] * errors[0] } else { errors[candidate] };
        let least = (0..CANDIDATES).min_by(|a, b| told(*a).total_cmp(&told(*b))).unwrap_or(0);
        std::array::from_fn(|candidate| if candidate == least { 1.0 } else { 0.0 })
    })
}
