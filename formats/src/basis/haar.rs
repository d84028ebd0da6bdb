//! The orthonormal 2-D Haar basis on an n × n face, n a power of two: the square (non-standard) decomposition.
//!
//! **Order of coefficients.** Index 0 is the scaling function, which is 1/n everywhere. The wavelet of level l (0 coarsest, below log₂ n), type m and square
//! (i, j), i along x, j along y, both in 0..2^l, has index **4^l·m + j·2^l + i**. A cube's coefficients follow face after face: face·n² + index.
//!
//! | type m | called | positive on | negative on |
//! |--------|--------|-------------|-------------|
//! | 1      | 01     | the left half of its square | the right half |
//! | 2      | 10     | the upper half | the lower half |
//! | 3      | 11     | the upper left and lower right quarters | the other two |
//!
//! A wavelet of level l is ±2^l/n on its square of (n/2^l)² texels and 0 elsewhere, so the basis is orthonormal over texels; sign(11) = sign(01)·sign(10).
//!
//! In this order the three details of a level stand behind each other as images of 2^l × 2^l, right after the image of averages that the coarser levels
//! split further. A pass over one level therefore reads and writes whole rows.

use std::ops::{Add, Mul, Sub};

/// What can be transformed: `f32`, `f64`, or numbers that count.
pub trait Number: Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + From<f32> {}

impl<T: Copy + Add<Output = T> + Sub<Output = T> + Mul<Output = T> + From<f32>> Number for T {}

/// One function of the basis.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Wavelet {
    /// Constant over the face.
    Scaling,
    /// A wavelet proper.
    Detail {
        /// 0 is coarsest.
        level: u32,
        /// 1, 2 or 3, see the module.
        m: usize,
        /// Square along x, below 2^level.
        i: usize,
        /// Square along y, below 2^level.
        j: usize,
    },
}

/// What stands at `index` of a face of `n` × `n`, `n` a power of two; indices of a cube count as those of
/// their face.
pub fn describe(index: usize, n: usize) -> Wavelet {
    let index = index & (n * n - 1);
    let Some(log) = index.checked_ilog2() else { return Wavelet::Scaling };
    let level = log / 2;
    let within = index % (1 << (2 * level));
    Wavelet::Detail { level, m: index >> (2 * level), i: within % (1 << level), j: within >> level }
}

/// Where the wavelet of `level`, type `m` and square (`i`, `j`) stands in a face.
pub fn index(level: u32, m: usize, i: usize, j: usize) -> usize {
    (m << (2 * level)) + (j << level) + i
}

/// Texels on which the function at `index` is not 0, of a face of `n` × `n`; indices of a cube count as those
/// of their face.
pub fn support(index: usize, n: usize) -> usize {
    match describe(index, n) {
        Wavelet::Scaling => n * n,
        Wavelet::Detail { level, .. } => (n >> level) * (n >> level),
    }
}

/// Transforms the row-major texels of a face of `n` × `n` to coefficients, in place. `scratch` is resized as
/// needed; keep it for the next face.
///
/// # Panics
/// If `n` is not a power of two, or `face` not `n` × `n` long.
pub fn forward<T: Number>(face: &mut [T], n: usize, scratch: &mut Vec<T>) {
    let levels = prepare(face, n, scratch);
    for pass in 0..levels {
        // From the finest level up; results stand now in one buffer, now in the other, but details always
        // belong in the face.
        let h = n >> (pass + 1);
        if pass % 2 == 0 {
            split(face, scratch, h);
            let from = if h == 1 { 0 } else { h * h };
            face[from..4 * h * h].copy_from_slice(&scratch[from..4 * h * h]);
        } else {
            split(scratch, face, h);
        }
    }
}

/// Transforms the coefficients of a face of `n` × `n` to row-major texels, in place: the inverse of
/// [`forward`].
///
/// # Panics
/// If `n` is not a power of two, or `face` not `n` × `n` long.
pub fn inverse<T: Number>(face: &mut [T], n: usize, scratch: &mut Vec<T>) {
    let levels = prepare(face, n, scratch);
    for pass in (0..levels).rev() {
        // From the coarsest level down, such that the finest ends in the face.
        let h = n >> (pass + 1);
        if pass % 2 == 0 {
            let from = if h == 1 { 0 } else { h * h };
            scratch[from..4 * h * h].copy_from_slice(&face[from..4 * h * h]);
            join(scratch, face, h);
        } else {
            join(face, scratch, h);
        }
    }
}

/// [`forward`] on each face of a cube, [6·n·n].
///
/// # Panics
/// If `n` is not a power of two, or `values` no whole number of faces long.
pub fn forward_cube<T: Number>(values: &mut [T], n: usize) {
    on_faces(values, n, forward);
}

/// [`inverse`] on each face of a cube, [6·n·n].
///
/// # Panics
/// If `n` is not a power of two, or `values` no whole number of faces long.
pub fn inverse_cube<T: Number>(values: &mut [T], n: usize) {
    on_faces(values, n, inverse);
}

fn on_faces<T: Number>(values: &mut [T], n: usize, transform: fn(&mut [T], usize, &mut Vec<T>)) {
    assert_eq!(values.len() % (n * n).max(1), 0, "whole faces");
    let mut scratch = Vec::new();
    values.chunks_exact_mut(n * n).for_each(|face| transform(face, n, &mut scratch));
}

/// Checks the sizes; returns the number of levels.
fn prepare<T: Number>(face: &[T], n: usize, scratch: &mut Vec<T>) -> u32 {
    assert!(n.is_power_of_two() && face.len() == n * n, "a face of a power of two squared");
    if scratch.len() < face.len() {
        scratch.resize(face.len(), T::from(0.0));
    }
    n.ilog2()
}

/// Splits the image of 2h × 2h at the start of `from` into its averages and three details, images of h × h
/// behind each other in `to`.
fn split<T: Number>(from: &[T], to: &mut [T], h: usize) {
    let (averages, details) = to[..4 * h * h].split_at_mut(h * h);
    let (left_right, rest) = details.split_at_mut(h * h);
    let (up_down, crossed) = rest.split_at_mut(h * h);
    let rows = averages
        .chunks_exact_mut(h)
        .zip(left_right.chunks_exact_mut(h))
        .zip(up_down.chunks_exact_mut(h))
        .zip(crossed.chunks_exact_mut(h));
    for (pair, (((a, x), y), d)) in from[..4 * h * h].chunks_exact(4 * h).zip(rows) {
        let (top, bottom) = pair.split_at(2 * h);
        split_rows(top, bottom, a, x, y, d);
    }
}

/// Two rows of texels to one row of each kind.
fn split_rows<T: Number>(top: &[T], bottom: &[T], a: &mut [T], x: &mut [T], y: &mut [T], d: &mut [T]) {
    let half = T::from(0.5);
    let h = a.len();
    let (top, bottom) = (&top.as_chunks::<2>().0[..h], &bottom.as_chunks::<2>().0[..h]);
    let (x, y, d) = (&mut x[..h], &mut y[..h], &mut d[..h]);
    for i in 0..h {
        let ([t0, t1], [b0, b1]) = (top[i], bottom[i]);
        let (left, right, left_drop, right_drop) = (t0 + b0, t1 + b1, t0 - b0, t1 - b1);
        a[i] = half * (left + right);
        x[i] = half * (left - right);
        y[i] = half * (left_drop + right_drop);
        d[i] = half * (left_drop - right_drop);
    }
}

/// The inverse of [`split`].
fn join<T: Number>(from: &[T], to: &mut [T], h: usize) {
    let (averages, details) = from[..4 * h * h].split_at(h * h);
    let (left_right, rest) = details.split_at(h * h);
    let (up_down, crossed) = rest.split_at(h * h);
    let rows = averages
        .chunks_exact(h)
        .zip(left_right.chunks_exact(h))
        .zip(up_down.chunks_exact(h))
        .zip(crossed.chunks_exact(h));
    for (pair, (((a, x), y), d)) in to[..4 * h * h].chunks_exact_mut(4 * h).zip(rows) {
        let (top, bottom) = pair.split_at_mut(2 * h);
        join_rows(a, x, y, d, top, bottom);
    }
}

/// One row of each kind to two rows of texels.
fn join_rows<T: Number>(a: &[T], x: &[T], y: &[T], d: &[T], top: &mut [T], bottom: &mut [T]) {
    let half = T::from(0.5);
    let h = a.len();
    let (x, y, d) = (&x[..h], &y[..h], &d[..h]);
    let (top, bottom) = (&mut top.as_chunks_mut::<2>().0[..h], &mut bottom.as_chunks_mut::<2>().0[..h]);
    for i in 0..h {
        let (left, right, left_drop, right_drop) = (a[i] + x[i], a[i] - x[i], y[i] + d[i], y[i] - d[i]);
        top[i] = [half * (left + left_drop), half * (right + right_drop)];
        bottom[i] = [half * (left - left_drop), half * (right - right_drop)];
    }
}
