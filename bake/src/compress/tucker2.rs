//! Tucker's decomposition of the first and the second mode of a tensor, the third left as it is ("Tucker2",
//! Kolda and Bader 2009, "Tensor decompositions and applications", §4.1; thesis §5.3.3.4): T ≈ Z ×₀ U₀ ×₁ U₁.
//!
//! [`tucker`] does it, in a smaller tensor: beforehand the second mode is projected on the leading
//! eigenvectors of its Gram matrix, and the first, for which that matrix would be too large, on what two
//! rounds of subspace iteration find (Halko et al. 2011, "Finding structure with randomness", algorithm 4.4),
//! each on more columns than are asked for. So no decomposition is of a matrix larger than a few hundred
//! squared. What the larger subspaces leave out could only have made columns better that are the last; the
//! error that is told is of all that is lost.

use super::linalg::{orthonormal, single_thread, symmetric_eigen};
use super::tucker::{in_order, tucker};
use ndarray::{Array2, Array3, ArrayView2, ArrayView4, Axis, s};
use ndarray_linalg::error::LinalgError;
use rayon::prelude::*;

/// Columns that the first mode is projected on beforehand, for each that is asked for.
const WIDER_FIRST: usize = 4;
/// The same of the second.
const WIDER_SECOND: usize = 2;
/// Slices of the first mode whose products are summed at once.
const BLOCK: usize = 32;

/// A tensor as a core and a matrix for each of two modes.
#[derive(Debug, Clone)]
pub struct Tucker2 {
    /// [size of the first mode, rank] with orthonormal columns, their largest entries positive.
    pub first: Array2<f64>,
    /// The same of the second.
    pub second: Array2<f64>,
    /// Z, [rank of the first, rank of the second, size of the third].
    pub core: Array3<f64>,
    /// ‖T − T̂‖²/‖T‖²; 0 of a tensor of zeros.
    pub error: f64,
}

/// Decomposes a tensor whose third mode is two, [first, third, second, third]: columns and harmonics beside
/// texels between, as tensors of light are stored. The third mode of the result has columns outside. Ranks
/// are at most `ranks` and the sizes of the modes.
///
/// # Errors
/// If LAPACK does not converge.
pub fn tucker2(tensor: &ArrayView4<'_, f32>, ranks: [usize; 2]) -> Result<Tucker2, LinalgError> {
    single_thread();
    let (rows, columns, texels, harmonics) = tensor.dim();
    let (gram, whole) = gram_of_second(tensor);
    let second = if texels > 1 {
        let (squares, vectors) = symmetric_eigen(&gram)?;
        in_order(&squares, &vectors, (WIDER_SECOND * ranks[1]).min(texels))
    } else {
        Array2::eye(texels)
    };
    let reduced = projected(tensor, &second);
    let first = range(&reduced.view(), (WIDER_FIRST * ranks[0]).min(rows))?;
    let shape = (first.ncols(), second.ncols(), columns * harmonics);
    let small = first.t().dot(&reduced).as_standard_layout().into_owned();
    let small = small.into_shape_with_order(shape).map_err(LinalgError::Shape)?;
    let found = tucker(&small, [ranks[0], ranks[1], shape.2])?;
    let core = times_third(&found.core, &found.factors[2]);
    let mut result = Tucker2 {
        first: first.dot(&found.factors[0]),
        second: second.dot(&found.factors[1]),
        error: 0.0,
        core,
    };
    let kept: f64 = result.core.iter().map(|z| z * z).sum();
    result.error = if whole > 0.0 { ((whole - kept) / whole).max(0.0) } else { 0.0 };
    result.fix_signs();
    Ok(result)
}

impl Tucker2 {
    /// The tensor that this stands for, its second mode multiplied with `weights`, [size of the second mode,
    /// any]: [first, third, any].
    pub fn contracted(&self, weights: &ArrayView2<'_, f64>) -> Array3<f64> {
        let weights = self.second.t().dot(weights);
        let (rank, _, third) = self.core.dim();
        let mut core = Array3::zeros((rank, third, weights.ncols()));
        for (mut to, from) in core.outer_iter_mut().zip(self.core.outer_iter()) {
            to.assign(&from.t().dot(&weights));
        }
        let mut all = Array3::zeros((self.first.nrows(), third, weights.ncols()));
        for (mut to, from) in all.axis_iter_mut(Axis(2)).zip(core.axis_iter(Axis(2))) {
            to.assign(&self.first.dot(&from));
        }
        all
    }

    /// How many numbers there are: of coefficients, one row of which each entry of the first mode has, and of
    /// what they share.
    pub fn numbers(&self) -> [usize; 2] {
        [self.first.len(), self.second.len() + self.core.len()]
    }

    fn fix_signs(&mut self) {
        for (mode, factor) in [&mut self.first, &mut self.second].into_iter().enumerate() {
            let of_core = self.core.axis_iter_mut(Axis(mode));
            for (mut column, mut of_core) in factor.columns_mut().into_iter().zip(of_core) {
                if column.iter().fold(0.0f64, |m, x| if x.abs() > m.abs() { *x } else { m }) < 0.0 {
                    column.mapv_inplace(|x| -x);
                    of_core.mapv_inplace(|x| -x);
                }
            }
        }
    }
}

/// The Gram matrix of the second mode, and its trace. Blocks have the same size whatever the number of cores.
fn gram_of_second(tensor: &ArrayView4<'_, f32>) -> (Array2<f64>, f64) {
    let (_, columns, texels, harmonics) = tensor.dim();
    let of_block = |block: ArrayView4<'_, f32>| {
        let mut matrix = Array2::<f64>::zeros((texels, block.dim().0 * columns * harmonics));
        for (row, slice) in block.outer_iter().enumerate() {
            for (column, slice) in slice.outer_iter().enumerate() {
                let at = (row * columns + column) * harmonics;
                matrix.slice_mut(s![.., at..at + harmonics]).assign(&slice.mapv(f64::from));
            }
        }
        matrix.dot(&matrix.t())
    };
    let blocks: Vec<ArrayView4<'_, f32>> =
        tensor.axis_chunks_iter(Axis(0), BLOCK.div_ceil(columns.max(1))).collect();
    let mut gram = Array2::zeros((texels, texels));
    // Not all at once, for products are as large as the sum.
    for some in blocks.chunks(16) {
        let products: Vec<Array2<f64>> = some.par_iter().map(|block| of_block(block.view())).collect();
        products.into_iter().for_each(|product| gram += &product);
    }
    let trace = gram.diag().sum();
    (gram, trace)
}

/// The second mode times the transpose of `second`, unfolded: [first, rank · columns · harmonics].
fn projected(tensor: &ArrayView4<'_, f32>, second: &Array2<f64>) -> Array2<f64> {
    let (rows, columns, _, harmonics) = tensor.dim();
    let (rank, third) = (second.ncols(), columns * harmonics);
    let mut reduced = Array2::zeros((rows, rank * third));
    let all: Vec<_> = reduced.rows_mut().into_iter().zip(tensor.outer_iter()).collect();
    all.into_par_iter().for_each(|(mut to, from)| {
        for (column, slice) in from.outer_iter().enumerate() {
            let product = second.t().dot(&slice.mapv(f64::from));
            for (k, values) in product.rows().into_iter().enumerate() {
                let at = k * third + column * harmonics;
                to.slice_mut(s![at..at + harmonics]).assign(&values);
            }
        }
    });
    reduced
}

/// Orthonormal columns, `count` of them or as many as `matrix` has columns, that nearly span what its first
/// so many left singular vectors do; all of them if it has no more rows.
fn range(matrix: &ArrayView2<'_, f64>, count: usize) -> Result<Array2<f64>, LinalgError> {
    let (rows, columns) = matrix.dim();
    if rows <= count || rows == 1 {
        return Ok(Array2::eye(rows));
    }
    let count = count.min(columns).max(1);
    let start = Array2::from_shape_fn((columns, count), |(i, j)| {
        // Weyl's sequence: numbers without order are all that is asked of them.
        (((i * count + j + 1) as f64 * 0.618_033_988_749_894_9).fract() * 7919.0).fract() - 0.5
    });
    let mut span = orthonormal(&matrix.dot(&start))?;
    for _ in 0..2 {
        let back = orthonormal(&matrix.t().dot(&span))?;
        span = orthonormal(&matrix.dot(&back))?;
    }
    Ok(span)
}

/// The core with its third mode as it was.
fn times_third(core: &Array3<f64>, factor: &Array2<f64>) -> Array3<f64> {
    let (a, b, _) = core.dim();
    let mut whole = Array3::zeros((a, b, factor.nrows()));
    for (mut to, from) in whole.outer_iter_mut().zip(core.outer_iter()) {
        to.assign(&from.dot(&factor.t()));
    }
    whole
}

#[cfg(test)]
mod tests;
