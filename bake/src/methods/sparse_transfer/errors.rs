//! Errors at the vertices under the held-out lights: what is left out and what is rounded, against the whole
//! rows. Direct light of suns is in what is seen, with the visibility that the rows have, and in what errors are
//! relative to, but has none itself: a player draws it with shadow maps.

use super::rows::Rows;
use crate::trace::held_out_lights::{HeldOutLights, RADIANCES, STATES, add};
use rayon::prelude::*;
use relume_formats::kinds::SparseTransfer;

/// Rows that one thread takes at a time; sums run over them in order.
const CHUNK: usize = 256;

/// Errors over all vertices, relative L2 of all that is seen, one per held-out light; NaN where that is nothing.
pub type Errors = [f64; STATES];

/// What [`of_stored`] compares.
pub fn measured_on() -> String {
    format!(
        "{STATES} held-out lights, the scene's maps turned, at every vertex, against the whole rows; shadow maps of suns are taken to be exact"
    )
}

/// Errors of the first 1, 2, … terms of `rows`, before they are rounded.
pub fn by_terms(rows: &Rows, lights: &HeldOutLights) -> Vec<Errors> {
    let squares = |chunk: usize| {
        let mut squares = vec![[0.0; STATES]; rows.terms];
        for row in chunk * CHUNK..((chunk + 1) * CHUNK).min(rows.count()) {
            let mut sums = [0.0; RADIANCES];
            for (term, square) in squares.iter_mut().enumerate() {
                let at = row * rows.terms + term;
                add(
                    &mut sums,
                    &rows.values[at * rows.channels..(at + 1) * rows.channels],
                    light_of(lights, rows.indices[at]),
                );
                add_squares(square, &sums, &rows.exact[row].given);
            }
        }
        squares
    };
    let chunks: Vec<_> = (0..rows.count().div_ceil(CHUNK)).into_par_iter().map(squares).collect();
    let norms = norms(rows);
    (0..rows.terms).map(|term| relative(chunks.iter().map(|chunk| &chunk[term]), &norms)).collect()
}

/// Errors of `stored`, which was made of `rows`.
pub fn of_stored(stored: &SparseTransfer, rows: &Rows, lights: &HeldOutLights) -> Errors {
    let meta = &stored.meta;
    let squares = |chunk: usize| {
        let mut squares = [0.0; STATES];
        for row in chunk * CHUNK..((chunk + 1) * CHUNK).min(rows.count()) {
            let mut sums = [0.0; RADIANCES];
            for (block, shape) in stored.blocks.iter().zip(&meta.blocks) {
                for term in 0..shape.terms as usize {
                    let index = block.indices[term * rows.count() + row];
                    add(&mut sums, &block.value(meta, term, row)[..meta.channels()], light_of(lights, index));
                }
            }
            add_squares(&mut squares, &sums, &rows.exact[row].given);
        }
        squares
    };
    let chunks: Vec<_> = (0..rows.count().div_ceil(CHUNK)).into_par_iter().map(squares).collect();
    relative(chunks.iter(), &norms(rows))
}

/// The row of `lights` that the coefficient called `index` is multiplied with.
pub fn light_of(lights: &HeldOutLights, index: u16) -> &[f32] {
    &lights.coefficients[usize::from(index) * RADIANCES..][..RADIANCES]
}

/// Adds squared differences, channels together.
fn add_squares(squares: &mut [f64; STATES], sums: &[f32; RADIANCES], exact: &[f32; RADIANCES]) {
    for ((square, sums), exact) in
        squares.iter_mut().zip(sums.as_chunks::<3>().0).zip(exact.as_chunks::<3>().0)
    {
        *square += (0..3).map(|c| f64::from(sums[c] - exact[c]).powi(2)).sum::<f64>();
    }
}

/// Squared norms of what is seen.
fn norms(rows: &Rows) -> [f64; STATES] {
    let mut norms = [0.0; STATES];
    rows.exact.iter().for_each(|exact| add_squares(&mut norms, &[0.0; RADIANCES], &exact.seen));
    norms
}

/// NaN under a light that shows nothing: there is no error.
pub(in crate::methods) fn relative<'a>(
    squares: impl Iterator<Item = &'a [f64; STATES]>,
    norms: &[f64; STATES],
) -> Errors {
    let mut total = [0.0; STATES];
    squares.for_each(|squares| total.iter_mut().zip(squares).for_each(|(t, s)| *t += s));
    std::array::from_fn(
        |state| if norms[state] > 0.0 { (total[state] / norms[state]).sqrt() } else { f64::NAN },
    )
}
