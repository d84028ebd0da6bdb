//! Direct light as it is stored: blocks of terms as bytes, with a step for every vertex and column.

use super::rows::{MAX_TERMS, Rows};
use crate::compress::quantise::step_for;
use half::f16;
use rayon::prelude::*;
use relume_formats::kinds::transfer_tensor::Block;

/// Most terms of a block.
pub const MOST_TERMS: u32 = BLOCK_TERMS;
/// Terms of the first blocks: the more important, the fewer share a step.
const FIRST_BLOCKS: [u32; 5] = [4, 4, 8, 8, 16];
/// Terms of the blocks after them.
const BLOCK_TERMS: u32 = 32;

/// The numbers of terms of the blocks of rows with `terms` terms.
pub fn shapes(terms: usize) -> Vec<u32> {
    let mut left = terms as u32;
    let mut shapes = Vec::new();
    for shape in FIRST_BLOCKS.into_iter().chain(std::iter::repeat(BLOCK_TERMS)) {
        if left == 0 {
            break;
        }
        shapes.push(shape.min(left));
        left -= shape.min(left);
    }
    shapes
}

/// The first terms of `rows`, as many as `shapes` have, rounded; steps are in `unit`.
pub fn blocks(rows: &Rows, shapes: &[u32], unit: f32) -> Vec<Block> {
    let firsts = shapes.iter().scan(0, |next, terms| {
        *next += *terms as usize;
        Some(*next - *terms as usize)
    });
    let firsts: Vec<usize> = firsts.collect();
    shapes
        .par_iter()
        .zip(firsts)
        .map(|(terms, first)| block(rows, first..first + *terms as usize, unit))
        .collect()
}

fn block(rows: &Rows, terms: std::ops::Range<usize>, unit: f32) -> Block {
    const MOST: f32 = i8::MAX as f32;
    let (count, columns) = (rows.count(), rows.columns);
    let value =
        |term: usize, row: usize, column: usize| rows.values[(row * MAX_TERMS + term) * columns + column];
    let scale = |at: usize| {
        let size = |term: usize| value(term, at / columns, at % columns).abs();
        step_for(terms.clone().map(size).fold(0.0, f32::max) / unit, MOST)
    };
    let scales: Vec<f16> = (0..count * columns).map(scale).collect();
    let step = |term: usize, at: usize| {
        let step = scales[at].to_f32() * unit;
        let value = value(term, at / columns, at % columns);
        if step > 0.0 { (value / step).round().clamp(-MOST, MOST) as i8 } else { 0 }
    };
    Block {
        indices: terms
            .clone()
            .flat_map(|term| (0..count).map(move |row| rows.indices[row * MAX_TERMS + term]))
            .collect(),
        steps: terms.clone().flat_map(|term| (0..count * columns).map(move |at| step(term, at))).collect(),
        scales,
    }
}
