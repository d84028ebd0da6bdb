//! Rounding of selected terms to blocks of integers with a scale per row.

use super::rows::Rows;
use crate::compress::quantise::step_for;
use half::f16;
use rayon::prelude::*;
use relume_formats::kinds::sparse_transfer::{Block, BlockShape, Steps};

/// Terms of each of the first blocks: short ones, so that there is something to see soon. The terms that
/// matter most are 16-bit integers: a byte's rounding of these would be the largest error of all.
const FIRST_BLOCKS: [BlockShape; 4] = [
    BlockShape { terms: 4, wide: true },
    BlockShape { terms: 4, wide: true },
    BlockShape { terms: 8, wide: true },
    BlockShape { terms: 16, wide: true },
];
/// Terms of the blocks after them.
const BLOCK_TERMS: u32 = 16;

/// The blocks of rows with `terms` terms.
pub fn shapes(terms: usize) -> Vec<BlockShape> {
    let mut left = terms as u32;
    let regular = std::iter::repeat(BlockShape { terms: BLOCK_TERMS, wide: false });
    let mut shapes = Vec::new();
    for shape in FIRST_BLOCKS.into_iter().chain(regular) {
        if left == 0 {
            break;
        }
        shapes.push(BlockShape { terms: shape.terms.min(left), ..shape });
        left -= shape.terms.min(left);
    }
    shapes
}

/// The first terms of `rows`, as many as `shapes` have, rounded; values are in `unit`.
pub fn blocks(rows: &Rows, shapes: &[BlockShape], unit: f32) -> Vec<Block> {
    let firsts = shapes.iter().scan(0, |next, shape| {
        let first = *next;
        *next += shape.terms as usize;
        Some(first)
    });
    let firsts: Vec<usize> = firsts.collect();
    shapes.par_iter().zip(firsts).map(|(shape, first)| block(rows, *shape, first, unit)).collect()
}

fn block(rows: &Rows, shape: BlockShape, first: usize, unit: f32) -> Block {
    let terms = first..first + shape.terms as usize;
    let at = |term: usize, row: usize| row * rows.terms + term;
    let of_term = |term: usize, row: usize| {
        rows.values[at(term, row) * rows.channels..(at(term, row) + 1) * rows.channels].iter().copied()
    };
    let by_column = || terms.clone().flat_map(|term| (0..rows.count()).map(move |row| (term, row)));
    let most = if shape.wide { f32::from(i16::MAX) } else { f32::from(i8::MAX) };
    let largest =
        |row: usize| terms.clone().flat_map(|term| of_term(term, row)).fold(0.0, |m: f32, v| m.max(v.abs()));
    let scales: Vec<f16> = (0..rows.count()).map(|row| step_for(largest(row) / unit, most)).collect();
    let steps = by_column().flat_map(|(term, row)| {
        let step = scales[row].to_f32() * unit;
        of_term(term, row).map(move |v| if step > 0.0 { (v / step).round().clamp(-most, most) } else { 0.0 })
    });
    let steps = if shape.wide {
        Steps::Wide(steps.map(|s| s as i16).collect())
    } else {
        Steps::Bytes(steps.map(|s| s as i8).collect())
    };
    Block { indices: by_column().map(|(term, row)| rows.indices[at(term, row)]).collect(), scales, steps }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compress::quantise::unit_for;
    use crate::trace::held_out_lights::{Exact, RADIANCES};
    use relume_formats::kinds::sparse_transfer::Meta;

    #[test]
    fn blocks_cover_any_number_of_terms() {
        for terms in [1, 4, 9, 16, 17, 100, 1024] {
            assert_eq!(shapes(terms).iter().map(|b| b.terms as usize).sum::<usize>(), terms);
        }
        assert!(shapes(100)[..4].iter().all(|b| b.wide) && shapes(100)[4..].iter().all(|b| !b.wide));
    }

    #[test]
    fn values_come_back_within_half_a_step() {
        let terms = 60;
        let mut rows = Rows::new(terms, 3);
        let value = |i: usize| ((i * 7919) % 1009) as f32 / 504.5 - 1.0;
        for row in 0..5 {
            let planes: Vec<Vec<f32>> = (0..3)
                .map(|c| {
                    (0..terms)
                        .map(|i| {
                            value(i * 3 + c + row * 77)
                                * 10f32.powi(-(i as i32) / 8)
                                * [1.0, 1e-3, 0.0, 1e3, 1.0][row]
                        })
                        .collect()
                })
                .collect();
            rows.push(&planes, &vec![1.0; terms], Exact { given: [0.0; RADIANCES], seen: [0.0; RADIANCES] });
        }
        let (shapes, unit) = (shapes(terms), unit_for(&rows.values));
        let meta = Meta {
            vertices: 5,
            face_size: 64,
            bounces: 1,
            rgb: true,
            unit,
            blocks: shapes.clone(),
            rays_per_texel: 1,
        };
        let blocks = blocks(&rows, &shapes, unit);
        let mut first = 0;
        for (block, shape) in blocks.iter().zip(&shapes) {
            for row in 0..5 {
                let of_term = |term: usize| &rows.values[(row * terms + term) * 3..][..3];
                let largest = (first..first + shape.terms as usize)
                    .flat_map(of_term)
                    .fold(0.0, |m: f32, v| m.max(v.abs()));
                for term in 0..shape.terms as usize {
                    assert_eq!(block.indices[term * 5 + row], rows.indices[row * terms + first + term]);
                    for (stored, v) in block.value(&meta, term, row).iter().zip(of_term(first + term)) {
                        // Half a step, which may be rounded up by 2⁻¹⁰ of itself.
                        let bound = largest / if shape.wide { 65_534.0 } else { 254.0 } * 1.002
                            + unit * 6e-8 * if shape.wide { 32_767.0 } else { 127.0 };
                        assert!((stored - v).abs() <= bound, "term {term} of row {row}: {stored} for {v}");
                    }
                }
            }
            first += shape.terms as usize;
        }
    }
}
