//! Means over squares from Haar coefficients: psum(X, s), which triple products need for every square s of
//! every level.
//!
//! psum of the whole face is X₀/n; a square's is its parent's plus (2^l/n)·Σ ±X[parent, m], l the parent's
//! level, the signs by the quarter that it is (sphere shadows §3.5 has the recursion, here for the basis of
//! [`super::haar`], in which it gives exactly the mean of X over the square). All of them take time linear in
//! their number.
//!
//! **Order.** Square (i, j) of level l, one of 2^l × 2^l, has index **(4^l − 1)/3 + j·2^l + i**: level after
//! level, each an image.

use super::haar::Number;

/// Squares of all levels below `levels`.
pub fn squares(levels: u32) -> usize {
    ((1 << (2 * levels)) - 1) / 3
}

/// Where square (`i`, `j`) of `level` stands among the squares of a face.
pub fn square(level: u32, i: usize, j: usize) -> usize {
    squares(level) + (j << level) + i
}

/// Means over all squares that carry wavelets, of each face of `n` × `n` coefficients: [faces,
/// [`squares`]\(log₂ n\)].
///
/// # Panics
/// If `n` is not a power of two, or `coefficients` no whole number of faces long.
pub fn psum<T: Number>(coefficients: &[T], n: usize) -> Vec<T> {
    assert!(
        n.is_power_of_two() && coefficients.len().is_multiple_of(n * n),
        "whole faces of a power of two squared"
    );
    let levels = n.ilog2();
    let mut out = vec![T::from(0.0); coefficients.len() / (n * n) * squares(levels)];
    if levels > 0 {
        coefficients
            .chunks_exact(n * n)
            .zip(out.chunks_exact_mut(squares(levels)))
            .for_each(|(face, out)| psum_face(face, n, out));
    }
    out
}

/// Means over as many levels of squares as `out` holds, of one face of `n` × `n`.
///
/// Only wavelets coarser than the last level are looked at, so a prefix of the face will do. That is how
/// means come from the first stage of the [`super::two_level`] transform alone: its 64 coefficients give the
/// [`squares`]\(4\) = 85 squares down to the tiles of 4 × 4 texels.
///
/// # Panics
/// If `out` is not as long as some number of levels, or `face` lacks coefficients.
pub fn psum_face<T: Number>(face: &[T], n: usize, out: &mut [T]) {
    let levels = (3 * out.len() + 1).ilog2() / 2;
    assert_eq!(out.len(), squares(levels), "whole levels of squares");
    let Some(first) = out.first_mut() else { return };
    *first = face[0] * T::from(1.0 / n as f32);
    for level in 0..levels - 1 {
        let scale = T::from((1 << level) as f32 / n as f32);
        let (known, next) = out.split_at_mut(squares(level + 1));
        quarter(&known[squares(level)..], &face[1 << (2 * level)..], scale, 1 << level, next);
    }
}

/// The four squares in each of `side` × `side` squares with the given means; `details` are those of their
/// level.
fn quarter<T: Number>(means: &[T], details: &[T], scale: T, side: usize, out: &mut [T]) {
    let area = side * side;
    let [left_right, up_down, crossed] =
        [0, 1, 2].map(|m| details[m * area..(m + 1) * area].chunks_exact(side));
    let rows = means.chunks_exact(side).zip(left_right).zip(up_down).zip(crossed);
    for (pair, (((p, x), y), d)) in out.chunks_exact_mut(4 * side).zip(rows) {
        let (top, bottom) = pair.split_at_mut(2 * side);
        quarter_row(scale, p, x, y, d, top, bottom);
    }
}

fn quarter_row<T: Number>(scale: T, p: &[T], x: &[T], y: &[T], d: &[T], top: &mut [T], bottom: &mut [T]) {
    let side = p.len();
    let (x, y, d) = (&x[..side], &y[..side], &d[..side]);
    let (top, bottom) = (&mut top.as_chunks_mut::<2>().0[..side], &mut bottom.as_chunks_mut::<2>().0[..side]);
    for i in 0..side {
        let (x, y, d) = (scale * x[i], scale * y[i], scale * d[i]);
        top[i] = [p[i] + ((x + y) + d), p[i] + ((y - x) - d)];
        bottom[i] = [p[i] + ((x - y) - d), p[i] + ((d - x) - y)];
    }
}
