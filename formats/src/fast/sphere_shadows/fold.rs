//! Light folded into lobes: what each part of the visibility is multiplied with.
//!
//! With light L and lobe ρ̃ given, the sum of [`crate::evaluate::sphere_shadows`] is linear in the
//! coefficients of V and in its means over squares. Here these factors are gathered term by term, in the same
//! three cases, and brought to tiles or texels by the inverse transform and by handing the weight of each
//! square to the four in it.

use crate::basis::haar::{Wavelet, describe, inverse};
use crate::basis::psum::{square, squares};
use crate::basis::triple::covering;
use crate::basis::two_level::SIDE;
use crate::evaluate::sphere_shadows::{Function, Levels};
use rayon::prelude::*;

/// Coefficients of a face.
const FACE: usize = SIDE * SIDE;
/// Tiles of 4 × 4 texels along a side of a face.
pub(super) const TILES: usize = SIDE / 4;
/// Rows of tiles of a cube.
pub(super) const TILE_ROWS: usize = 6 * TILES;

/// Tiles of a row in the order in which their texels are counted: those with even numbers first.
const COUNTED: [usize; TILES] = [0, 2, 4, 6, 1, 3, 5, 7];

/// What a visible texel gives, for each lobe.
#[derive(Debug)]
pub(super) enum Weights {
    /// By tile, for its first level; and what the second adds.
    Tiles { tiles: Vec<[[f32; TILE_ROWS * TILES]; 3]>, fine: Fine },
    /// By texel.
    Texels { texels: Vec<[[f32; 6 * FACE]; 3]> },
}

/// Tiles in which the light has terms of the second level of visibility, with the coefficients of a tile in
/// the order of [`crate::kinds::HaarTable`].
#[derive(Debug)]
pub(super) struct Fine {
    /// First row in the bitmap, and tile along x.
    pub(super) tiles: Vec<(usize, usize)>,
    /// Kept coefficients of light, 0 for others, [tile] of red, green and blue.
    pub(super) light: Vec<[[f32; 16]; 3]>,
    /// Means of each lobe over the square of each coefficient, [lobe][tile].
    pub(super) means: Vec<Vec<[f32; 16]>>,
}

impl Weights {
    pub(super) fn new(lobes: &[Function], light: &[Function; 3], levels: Levels) -> Self {
        let of = |side: usize, bringing: fn(&mut Factors) -> Vec<f32>| {
            move |lobe: &Function, channel: &Function| bringing(&mut Factors::new(lobe, channel, side))
        };
        if levels == Levels::All {
            let texels = of(SIDE, |factors| factors.weights());
            let fold = |lobe: &Function| light.each_ref().map(|channel| array(&texels(lobe, channel)));
            return Self::Texels { texels: lobes.par_iter().map(fold).collect() };
        }
        let tiles = of(TILES, |factors| in_order_of_counts(&factors.weights()));
        let fold = |lobe: &Function| light.each_ref().map(|channel| array(&tiles(lobe, channel)));
        let fine = Fine::new(lobes, light, levels);
        Self::Tiles { tiles: lobes.par_iter().map(fold).collect(), fine }
    }
}

fn array<const N: usize>(values: &[f32]) -> [f32; N] {
    std::array::from_fn(|k| values[k])
}

fn in_order_of_counts(tiles: &[f32]) -> Vec<f32> {
    tiles.as_chunks::<TILES>().0.iter().flat_map(|row| COUNTED.map(|x| row[x])).collect()
}

/// What V is multiplied with, V being an image of `side` × `side` a face at most.
struct Factors {
    side: usize,
    /// Of coefficients, [6·side·side].
    coefficients: Vec<f32>,
    /// Of means over squares, the smallest being a texel of that image, [6, squares].
    means: Vec<f32>,
}

impl Factors {
    fn new(lobe: &Function, light: &Function, side: usize) -> Self {
        // Squares one level finer than the finest wavelet are asked for too, as far as there are any.
        let levels = (side.ilog2() + 1).min(SIDE.ilog2());
        let mut found =
            Self { side, coefficients: vec![0.0; 6 * side * side], means: vec![0.0; 6 * squares(levels)] };
        lobe.terms().iter().for_each(|(index, value)| found.add_lobe(*index as usize, *value, light, levels));
        light.terms().iter().for_each(|(index, value)| found.add_light(*index as usize, *value, lobe));
        found
    }

    /// Where the coefficient `index` of a cube stands here, if V has it.
    fn place(&self, index: usize) -> Option<usize> {
        (index % FACE < self.side * self.side).then(|| index / FACE * self.side * self.side + index % FACE)
    }

    /// The sums in which a term of the lobe is.
    fn add_lobe(&mut self, index: usize, value: f32, light: &Function, levels: u32) {
        let (ls, face) = (light.coefficients(), index / FACE);
        let (Wavelet::Detail { level, m, i, j }, Some(covering)) =
            (describe(index, SIDE), covering(index, SIDE))
        else {
            if let Some(place) = self.place(index) {
                self.coefficients[place] += value * ls[index] / SIDE as f32;
            }
            return;
        };
        // V is flat within its finest squares, so their means stand for those of smaller ones.
        let up = (level + 1).saturating_sub(levels);
        self.means[face * squares(levels) + square(level - up, i >> up, j >> up)] += value * ls[index];
        let Some(place) = self.place(index) else { return };
        self.coefficients[place] += value * light.psums()[covering];
        let of_type = |at: usize, other: usize| at - (m << (2 * level)) + (other << (2 * level));
        let (second, third) = (m % 3 + 1, (m + 1) % 3 + 1);
        let scale = (1 << level) as f32 / SIDE as f32 * value;
        self.coefficients[of_type(place, second)] += scale * ls[of_type(index, third)];
        self.coefficients[of_type(place, third)] += scale * ls[of_type(index, second)];
    }

    /// The sum in which a term of the light is.
    fn add_light(&mut self, index: usize, value: f32, lobe: &Function) {
        if let (Some(place), Some(covering)) = (self.place(index), covering(index, SIDE)) {
            self.coefficients[place] += value * lobe.psums()[covering];
        }
    }

    /// What a visible texel of 32 × 32 gives in each texel of the image.
    fn weights(&mut self) -> Vec<f32> {
        let (side, mut scratch) = (self.side, Vec::new());
        let per_face = self.means.len() / 6;
        for (face, means) in
            self.coefficients.chunks_exact_mut(side * side).zip(self.means.chunks_exact_mut(per_face))
        {
            inverse(face, side, &mut scratch);
            // A wavelet of this image is larger than one of 32 × 32 by the ratio of sides.
            let scale = side as f32 / SIDE as f32;
            let finest = hand_down(means);
            let shift = side.ilog2() - finest.ilog2();
            for (k, weight) in face.iter_mut().enumerate() {
                let (x, y) = ((k % side) >> shift, (k / side) >> shift);
                *weight = *weight * scale + means[per_face - finest * finest + y * finest + x];
            }
        }
        std::mem::take(&mut self.coefficients)
    }
}

/// Turns factors of means into factors of texels, in the finest squares those of all coarser ones too;
/// returns how many of these there are along a side.
fn hand_down(means: &mut [f32]) -> usize {
    let levels = (3 * means.len() + 1).ilog2() / 2;
    for level in 0..levels {
        let (known, this) = means.split_at_mut(squares(level));
        let side = 1 << level;
        // Texels in a square of this level.
        let texels = (FACE >> (2 * level)) as f32;
        for (k, weight) in this[..side * side].iter_mut().enumerate() {
            let (i, j) = (k % side, k / side);
            *weight = *weight / texels + if level > 0 { known[square(level - 1, i / 2, j / 2)] } else { 0.0 };
        }
    }
    1 << (levels - 1)
}

impl Fine {
    fn new(lobes: &[Function], light: &[Function; 3], levels: Levels) -> Self {
        let mut found = Self { tiles: Vec::new(), light: Vec::new(), means: Vec::new() };
        if levels == Levels::Two {
            light.iter().enumerate().for_each(|(channel, light)| found.add(channel, light));
        }
        found.means = lobes
            .par_iter()
            .map(|lobe| found.tiles.iter().map(|(row, x)| means(lobe, *row, *x)).collect())
            .collect();
        found
    }

    fn add(&mut self, channel: usize, light: &Function) {
        for (index, value) in light.terms() {
            let Wavelet::Detail { level: level @ 3.., m, i, j } = describe(*index as usize, SIDE) else {
                continue;
            };
            let (x, y, within) =
                if level == 3 { (i, j, m) } else { (i / 2, j / 2, 4 * m + 2 * (j % 2) + i % 2) };
            let tile = (*index as usize / FACE * SIDE + 4 * y, x);
            let at = self.tiles.iter().position(|known| *known == tile).unwrap_or_else(|| {
                self.tiles.push(tile);
                self.light.push([[0.0; 16]; 3]);
                self.tiles.len() - 1
            });
            self.light[at][channel][within] = *value;
        }
    }
}

/// Means of a lobe over the squares of a tile's coefficients.
fn means(lobe: &Function, row: usize, x: usize) -> [f32; 16] {
    let psums = &lobe.psums()[row / SIDE * squares(SIDE.ilog2())..];
    let y = row % SIDE / 4;
    std::array::from_fn(|k| {
        if k < 4 { psums[square(3, x, y)] } else { psums[square(4, 2 * x + k % 2, 2 * y + k / 2 % 2)] }
    })
}
