//! How alike fragments look: distances between patches of their guides, in units of noise.

use super::TILE;
use super::film::{Film, Fragment};
use super::row::{RADIUS, WINDOW};
use super::seen::{LOOKS, StateLight, looks_of};

/// Radius of patches that are compared, pixels.
const PATCH: i32 = 3;
/// How far fragments are looked at around a tile, pixels.
const MARGIN: i32 = RADIUS + PATCH;
/// Side of what is looked at for one tile.
const SIDE: usize = (TILE + 2 * MARGIN) as usize;
/// Side of the places at which patches of one tile have something.
const REACH: usize = (TILE + 2 * PATCH) as usize;
/// No place of a patch differs by more: one sample that found much light says nothing of its neighbours.
const MOST: f32 = 25.0;
/// Differences that are not told apart, squared, in parts of the light.
pub const SAME: f32 = 1e-6;

/// What of the samples is looked at.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Samples {
    /// One half of them.
    Half(usize),
    /// All of them.
    All,
}

/// The guides of one class and layer around a tile.
struct Looks {
    /// Upper left pixel of the tile.
    tile: [i32; 2],
    /// How many of a place's guides are looked at.
    looks: usize,
    guides: Vec<StateLight>,
    variances: Vec<StateLight>,
    is_there: Vec<bool>,
}

impl Looks {
    fn new(film: &Film, class: usize, layer: usize, tile: [i32; 2], samples: Samples) -> Self {
        let look = |fragment: &Fragment| match samples {
            Samples::Half(half) => (fragment.guides[half][layer], fragment.variances[layer]),
            Samples::All => (fragment.guide(layer), fragment.variances[layer].map(|v| 0.5 * v)),
        };
        let count = SIDE * SIDE;
        let (mut guides, mut variances) = (vec![[0.0; LOOKS]; count], vec![[0.0; LOOKS]; count]);
        let mut is_there = vec![false; count];
        for place in 0..count {
            let [x, y] = [place % SIDE, place / SIDE].map(|k| k as i32 - MARGIN);
            if let Some(number) = film.at(class, tile[0] + x, tile[1] + y) {
                (guides[place], variances[place]) = look(&film.fragments()[number as usize]);
                is_there[place] = true;
            }
        }
        Self { tile, looks: looks_of(layer), guides, variances, is_there }
    }

    /// Between two places, and whether there is something at both.
    fn difference(&self, here: usize, there: usize) -> (f32, f32) {
        if !(self.is_there[here] && self.is_there[there]) {
            return (0.0, 0.0);
        }
        let (a, b) = (&self.guides[here], &self.guides[there]);
        let (va, vb) = (&self.variances[here], &self.variances[there]);
        let of_state = |k: usize| {
            let difference = a[k] - b[k];
            let noise = va[k] + va[k].min(vb[k]);
            (difference * difference - noise)
                / (va[k] + vb[k] + SAME * (a[k] * a[k] + b[k] * b[k]) + f32::MIN_POSITIVE)
        };
        (((0..self.looks).map(of_state).sum::<f32>() / self.looks as f32).min(MOST), 1.0)
    }
}

/// Distances of the fragments of one tile to all in their windows.
pub struct Likeness {
    tile: [i32; 2],
    /// [pixels of the tile, places in the window]
    distances: Vec<f32>,
}

impl Likeness {
    /// Of the fragments of `class` in the tile whose upper left pixel is `tile`, by the light of `layer`.
    pub fn new(film: &Film, class: usize, layer: usize, tile: [i32; 2], samples: Samples) -> Self {
        let looks = Looks::new(film, class, layer, tile, samples);
        let window = WINDOW as usize;
        let mut distances = vec![0.0; (TILE * TILE) as usize * window * window];
        let mut differences = vec![(0.0, 0.0); REACH * REACH];
        for place in 0..window * window {
            let step = [place % window, place / window].map(|k| k as i32 - RADIUS);
            for (number, difference) in differences.iter_mut().enumerate() {
                let [x, y] = [number % REACH, number / REACH].map(|k| k as i32 + RADIUS);
                let at = |x: i32, y: i32| y as usize * SIDE + x as usize;
                *difference = looks.difference(at(x, y), at(x + step[0], y + step[1]));
            }
            for (pixel, mean) in means(&differences).into_iter().enumerate() {
                distances[pixel * window * window + place] = mean;
            }
        }
        Self { tile: looks.tile, distances }
    }

    /// Of the fragment at this pixel, row by row of its window.
    pub fn at(&self, [x, y]: [i32; 2]) -> &[f32] {
        let pixel = ((y - self.tile[1]) * TILE + x - self.tile[0]) as usize;
        let places = (WINDOW * WINDOW) as usize;
        &self.distances[pixel * places..][..places]
    }
}

/// Means over the patches of all pixels of a tile.
fn means(differences: &[(f32, f32)]) -> Vec<f32> {
    let (tile, patch) = (TILE as usize, 2 * PATCH as usize + 1);
    let add = |a: (f32, f32), b: &(f32, f32)| (a.0 + b.0, a.1 + b.1);
    let rows: Vec<(f32, f32)> = (0..REACH * tile)
        .map(|place| {
            let from = place / tile * REACH + place % tile;
            differences[from..from + patch].iter().fold((0.0, 0.0), add)
        })
        .collect();
    (0..tile * tile)
        .map(|pixel| {
            let (sum, count) = (0..patch).map(|k| &rows[pixel + k * tile]).fold((0.0, 0.0), add);
            if count > 0.0 { sum / count } else { 0.0 }
        })
        .collect()
}
