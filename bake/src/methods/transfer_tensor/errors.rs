//! Errors of direct light at some vertices under the held-out lights: what is left out and what is rounded, of all columns
//! by what they usually count for, in parts of what white diffuse surfaces show. Direct light of suns is in the latter.

use super::rows::{Exact, MAX_TERMS, Rows};
use crate::methods::sparse_transfer::errors::{Errors, light_of, relative};
use crate::trace::held_out_lights::{HeldOutLights, RADIANCES, STATES, add};
use rayon::prelude::*;
use relume_formats::kinds::TransferTensor;

/// Errors of the first 1, 2, … terms of `rows`, before they are rounded.
pub fn by_terms(rows: &Rows, lights: &HeldOutLights) -> Vec<Errors> {
    let squares = |exact: &Exact| {
        let mut squares = vec![[0.0; STATES]; MAX_TERMS];
        let mut sums = vec![[0.0; RADIANCES]; exact.given.len()];
        for (term, square) in squares.iter_mut().enumerate() {
            let at = exact.row * MAX_TERMS + term;
            let light = light_of(lights, rows.indices[at]);
            for (sum, value) in sums.iter_mut().zip(&rows.values[at * rows.columns..]) {
                add(sum, &[*value], light);
            }
            add_squares(square, &sums, exact);
        }
        squares
    };
    let each: Vec<_> = rows.exact.par_iter().map(squares).collect();
    let norms = norms(rows);
    (0..MAX_TERMS).map(|term| relative(each.iter().map(|each| &each[term]), &norms)).collect()
}

/// Errors of `stored`, which was made of `rows`.
pub fn of_stored(stored: &TransferTensor, rows: &Rows, lights: &HeldOutLights) -> Errors {
    let vertices = stored.meta.vertices as usize;
    let squares = |exact: &Exact| {
        let mut sums = vec![[0.0; RADIANCES]; exact.given.len()];
        for (block, terms) in stored.blocks.iter().zip(&stored.meta.blocks) {
            for term in 0..*terms as usize {
                let light = light_of(lights, block.indices[term * vertices + exact.row]);
                for (column, sum) in sums.iter_mut().enumerate() {
                    add(sum, &[block.value(&stored.meta, term, exact.row, column)], light);
                }
            }
        }
        let mut square = [0.0; STATES];
        add_squares(&mut square, &sums, exact);
        square
    };
    let each: Vec<_> = rows.exact.par_iter().map(squares).collect();
    relative(each.iter(), &norms(rows))
}

fn add_squares(squares: &mut Errors, sums: &[[f32; RADIANCES]], exact: &Exact) {
    for ((sum, given), weight) in sums.iter().zip(&exact.given).zip(&exact.importance) {
        let pairs = sum.as_chunks::<3>().0.iter().zip(given.as_chunks::<3>().0);
        for (square, (sum, given)) in squares.iter_mut().zip(pairs) {
            *square += (0..3).map(|c| f64::from(weight * (sum[c] - given[c])).powi(2)).sum::<f64>();
        }
    }
}

fn norms(rows: &Rows) -> Errors {
    let mut norms = [0.0; STATES];
    for exact in &rows.exact {
        for (norm, seen) in norms.iter_mut().zip(exact.seen.as_chunks::<3>().0) {
            *norm += seen.iter().map(|value| f64::from(*value).powi(2)).sum::<f64>();
        }
    }
    norms
}

/// Mean square of what errors are in parts of: what a white diffuse surface shows, channels together.
pub fn mean_squares(rows: &Rows) -> Errors {
    norms(rows).map(|norm| norm / rows.exact.len().max(1) as f64)
}

/// What errors are of.
pub fn measured_on() -> String {
    format!(
        "{STATES} held-out lights, the scene's maps turned, and as many random materials, at some vertices, against whole rows and \
         tensors; shadow maps of suns are taken to be exact, and the light's coarse texels and the BRDF's columns are not in it"
    )
}
