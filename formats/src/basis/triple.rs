//! Σ A·B·C over the texels of faces or cubes, from Haar coefficients alone (Ng et al. 2004; sphere shadows
//! §3.5).
//!
//! The product of three functions of the basis of [`super::haar`], summed over the n × n texels, is not 0 in
//! three cases only:
//!
//! 1. three scaling functions: 1/n;
//! 2. three wavelets on the same square of level l, of three different types, in any of the six assignments:
//!    2^l/n;
//! 3. two equal wavelets and a third function that is coarser and covers them, the scaling function or a
//!    wavelet of level l: ±2^l/n, the sign by the quarter in which they lie. Summed over all coarser
//!    functions that is the mean of the third operand over the square: its psum.
//!
//! The source prints one of the six assignments of case 2 twice and leaves another out; here all six stand.

use super::haar::{Number, Wavelet, describe};
use super::psum::{square, squares};

/// One factor: a face or a cube of `n` × `n` coefficients each, with its means.
#[derive(Debug, Clone, Copy)]
pub struct Operand<'a, T> {
    /// [faces·n·n].
    pub coefficients: &'a [T],
    /// What [`super::psum::psum`] makes of them.
    pub psums: &'a [T],
}

/// A factor of which few coefficients are not 0.
#[derive(Debug, Clone, Copy)]
pub struct Sparse<'a, T> {
    /// Index and value of every coefficient that is not 0, in any order.
    pub terms: &'a [(u32, T)],
    /// The same, dense.
    pub dense: Operand<'a, T>,
}

/// Partial sums kept apart, so that vector units can add them at once; it also keeps rounding errors small.
const LANES: usize = 4;

/// Σ a·b·c over all texels, looking at every coefficient: O(n²).
///
/// # Panics
/// If the operands are not of one size, whole faces of `n` × `n`.
pub fn dense<T: Number>([a, b, c]: [Operand<'_, T>; 3], n: usize) -> T {
    let means = squares(n.ilog2());
    let faces = a.coefficients.len() / (n * n);
    (0..faces).fold(T::from(0.0), |sum, face| {
        let coefficients = [a, b, c].map(|o| &o.coefficients[face * n * n..(face + 1) * n * n]);
        let psums = [a, b, c].map(|o| &o.psums[face * means..(face + 1) * means]);
        sum + dense_face(coefficients, psums, n)
    })
}

fn dense_face<T: Number>(coefficients: [&[T]; 3], psums: [&[T]; 3], n: usize) -> T {
    let [a, b, c] = coefficients.map(|x| x[0]);
    let scaling = a * b * c * T::from(1.0 / n as f32);
    (0..n.ilog2()).fold(scaling, |sum, level| {
        let area = 1 << (2 * level);
        let details = coefficients.map(|x| [1, 2, 3].map(|m| &x[m * area..(m + 1) * area]));
        let means = psums.map(|p| &p[squares(level)..][..area]);
        sum + level_sum(details, means, T::from((1 << level) as f32 / n as f32))
    })
}

/// Cases 2 and 3 on all squares of one level: three operands of three details, and their means.
fn level_sum<T: Number>([a, b, c]: [[&[T]; 3]; 3], means: [&[T]; 3], scale: T) -> T {
    let ([a4, b4, c4], [pa4, pb4, pc4]) = ([a, b, c].map(|o| o.map(lanes)), means.map(lanes));
    let mut sums = [T::from(0.0); LANES];
    for k in 0..pa4.len() {
        let ([a1, a2, a3], [b1, b2, b3], [c1, c2, c3]) =
            (a4.map(|x| &x[k]), b4.map(|x| &x[k]), c4.map(|x| &x[k]));
        let (pa, pb, pc) = (&pa4[k], &pb4[k], &pc4[k]);
        for i in 0..LANES {
            let details = [[a1[i], a2[i], a3[i]], [b1[i], b2[i], b3[i]], [c1[i], c2[i], c3[i]]];
            sums[i] = sums[i] + square_sum(details, [pa[i], pb[i], pc[i]], scale);
        }
    }
    // Only the coarsest level, of one square, is no multiple of the lanes.
    let whole = pa4.len() * LANES;
    let rest = (whole..means[0].len())
        .map(|k| square_sum([a, b, c].map(|o| o.map(|x| x[k])), means.map(|p| p[k]), scale));
    sums.into_iter().chain(rest).fold(T::from(0.0), |sum, x| sum + x)
}

fn lanes<T>(values: &[T]) -> &[[T; LANES]] {
    values.as_chunks().0
}

/// Cases 2 and 3 on one square.
#[inline(always)]
fn square_sum<T: Number>(
    [[a1, a2, a3], [b1, b2, b3], [c1, c2, c3]]: [[T; 3]; 3],
    [pa, pb, pc]: [T; 3],
    scale: T,
) -> T {
    let different = a1 * (b2 * c3 + b3 * c2) + a2 * (b1 * c3 + b3 * c1) + a3 * (b1 * c2 + b2 * c1);
    let equal = (a1 * b1 + a2 * b2 + a3 * b3) * pc
        + (a1 * c1 + a2 * c2 + a3 * c3) * pb
        + (b1 * c1 + b2 * c2 + b3 * c3) * pa;
    scale * different + equal
}

/// Σ a·b·c over all texels, looking only at the terms of `a`, which should be the sparsest, and for case 3
/// without `a` at those of `b`.
///
/// # Panics
/// If a term lies outside the operands, or these are not of one size, whole faces of `n` × `n`.
pub fn sparse<T: Number>(a: &Sparse<'_, T>, b: &Sparse<'_, T>, c: &Operand<'_, T>, n: usize) -> T {
    with_terms(a.terms, &b.dense, c, n) + of_equals(b.terms, c.coefficients, a.dense.psums, n)
}

/// The part of Σ a·b·c in which `a` enters with a coefficient of its own, one of `terms`: all but case 3 with
/// equal wavelets of `b` and `c`.
///
/// # Panics
/// If a term lies outside the operands, or these are not of one size, whole faces of `n` × `n`.
pub fn with_terms<T: Number>(terms: &[(u32, T)], b: &Operand<'_, T>, c: &Operand<'_, T>, n: usize) -> T {
    terms
        .iter()
        .map(|&(index, value)| value * around(index as usize, b, c, n))
        .fold(T::from(0.0), |sum, x| sum + x)
}

/// The part of Σ a·b·c in which `b` and `c` have equal wavelets and `a` only its means `psums`: case 3, at
/// the `terms` of `b`.
///
/// # Panics
/// If a term lies outside the operands, or these are not of one size, whole faces of `n` × `n`.
pub fn of_equals<T: Number>(terms: &[(u32, T)], c: &[T], psums: &[T], n: usize) -> T {
    let at = |&(index, value): &(u32, T)| {
        let index = index as usize;
        // The scaling function as one of two equal ones is case 1, which is not done here.
        covering(index, n).map_or(T::from(0.0), |square| value * c[index] * psums[square])
    };
    terms.iter().map(at).fold(T::from(0.0), |sum, x| sum + x)
}

/// What the coefficient of the first operand at `index` is multiplied with, but for the case in which the
/// other two are the equal wavelets.
fn around<T: Number>(index: usize, b: &Operand<'_, T>, c: &Operand<'_, T>, n: usize) -> T {
    let (bs, cs) = (b.coefficients, c.coefficients);
    let (Wavelet::Detail { level, m, .. }, Some(square)) = (describe(index, n), covering(index, n)) else {
        return bs[index] * cs[index] * T::from(1.0 / n as f32);
    };
    let first = index - (m << (2 * level));
    let [second, third] = [m % 3 + 1, (m + 1) % 3 + 1].map(|m| first + (m << (2 * level)));
    let scale = T::from((1 << level) as f32 / n as f32);
    scale * (bs[second] * cs[third] + bs[third] * cs[second])
        + bs[index] * c.psums[square]
        + cs[index] * b.psums[square]
}

/// Where the mean over a wavelet's square stands; `None` for a scaling function.
pub(crate) fn covering(index: usize, n: usize) -> Option<usize> {
    match describe(index, n) {
        Wavelet::Scaling => None,
        Wavelet::Detail { level, i, j, .. } => {
            Some(index / (n * n) * squares(n.ilog2()) + square(level, i, j))
        }
    }
}
