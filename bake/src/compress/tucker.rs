//! Tucker's decomposition of a tensor of three modes (thesis eq. 2-16, 2-17): T ≈ Z ×₀ U₀ ×₁ U₁ ×₂ U₂ with
//! orthonormal columns in every U.
//!
//! It begins with the higher-order singular value decomposition, truncated mode by mode (Vannieuwenhoven et
//! al. 2012, "A new truncation strategy for the higher-order singular value decomposition"), and goes on with
//! alternating least squares: every U in turn is the best beside the others (De Lathauwer et al. 2000, "On
//! the best rank-1 and rank-(R₁, …, R_N) approximation of higher-order tensors").
//!
//! Columns have the order of their singular values, and signs are fixed by rule. Where values are equal, as
//! they come in pairs from whatever is the same in all azimuths, any rotation of the columns is as good, and
//! LAPACK's choice depends on rounding; so these are chosen by rule, too, see [`in_order`].

use super::linalg::{Svd, first_singular, single_thread, symmetric_eigen};
use ndarray::{Array1, Array2, Array3, ArrayView2, Axis, s};
use ndarray_linalg::error::LinalgError;
use rayon::prelude::*;

/// Modes of a tensor.
pub const MODES: usize = 3;
/// Most rounds of alternating least squares.
const SWEEPS: usize = 8;
/// What ‖Z‖² grows by at least in a round that is not the last, in parts of itself.
const GROWTH: f64 = 1e-9;
/// Eigenvalues this near to each other, in parts of the largest, count as equal: some orders above what
/// rounding makes of equal ones.
const EQUAL: f64 = 1e-10;
/// Rows of a subspace whose squared lengths differ by less than this part count as equally long.
const AS_LONG: f64 = 1e-6;

/// A tensor as a core and a matrix for each mode.
#[derive(Debug, Clone)]
pub struct Tucker {
    /// Z, of the shape of the ranks.
    pub core: Array3<f64>,
    /// U of each mode, [size of the mode, rank], with orthonormal columns.
    pub factors: [Array2<f64>; MODES],
    /// What is lost by projecting each mode alone on its columns, and all of them: squared norms in parts of
    /// the tensor's.
    pub errors: TuckerErrors,
    /// Rounds of alternating least squares that were made.
    pub sweeps: usize,
}

/// Relative squared errors, ‖T − T̂‖²/‖T‖².
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TuckerErrors {
    /// Of each mode, if only that one is truncated.
    pub of_modes: [f64; MODES],
    /// Of all.
    pub whole: f64,
}

/// Decomposes `tensor` to at most `ranks`. A rank is also at most the size of its mode and the product of the
/// other ranks, beyond which nothing is gained. Of a tensor of zeros the core is zero, too.
///
/// # Errors
/// If LAPACK does not converge.
pub fn tucker(tensor: &Array3<f64>, ranks: [usize; MODES]) -> Result<Tucker, LinalgError> {
    single_thread();
    let ranks = within(tensor.dim(), ranks);
    let mut factors = started(tensor, ranks)?;
    let mut kept = squared_norm(&projected(tensor, &factors));
    let mut sweeps = 0;
    while sweeps < SWEEPS {
        sweeps += 1;
        for mode in 0..MODES {
            let beside = projected_beside(tensor, &factors, mode);
            factors[mode] = leading(&unfolded(&beside, mode).view(), ranks[mode])?;
        }
        let now = squared_norm(&projected(tensor, &factors));
        let grown = now > kept * (1.0 + GROWTH);
        kept = now;
        if !grown {
            break;
        }
    }
    let core = projected(tensor, &factors);
    Ok(Tucker { errors: errors(tensor, &factors, &core), core, factors, sweeps })
}

#[cfg(test)]
impl Tucker {
    /// The tensor that this stands for.
    pub fn rebuilt(&self) -> Array3<f64> {
        let transposed = |mode: usize| self.factors[mode].t().to_owned();
        (0..MODES).fold(self.core.clone(), |tensor, mode| times(&tensor, mode, &transposed(mode)))
    }
}

fn within((a, b, c): (usize, usize, usize), ranks: [usize; MODES]) -> [usize; MODES] {
    let [i, j, k] = [(a, 0), (b, 1), (c, 2)].map(|(size, mode)| ranks[mode].clamp(1, size.max(1)));
    [i.min(j * k), j.min(i * k), k.min(i * j)]
}

fn started(tensor: &Array3<f64>, ranks: [usize; MODES]) -> Result<[Array2<f64>; MODES], LinalgError> {
    let first = leading(&unfolded(tensor, 0).view(), ranks[0])?;
    let rest = times(tensor, 0, &first);
    let second = leading(&unfolded(&rest, 1).view(), ranks[1])?;
    let rest = times(&rest, 1, &second);
    Ok([first, second, leading(&unfolded(&rest, 2).view(), ranks[2])?])
}

/// The tensor times Uᵀ in `mode`.
fn times(tensor: &Array3<f64>, mode: usize, factor: &Array2<f64>) -> Array3<f64> {
    let rank = factor.ncols();
    let mut shape = tensor.raw_dim();
    shape[mode] = rank;
    let mut product = Array3::zeros(shape);
    // Slices in which `mode` is the first axis, or the last if it is the last of the tensor.
    let across = Axis(usize::from(mode == 0));
    let slices: Vec<_> = product.axis_iter_mut(across).zip(tensor.axis_iter(across)).collect();
    slices.into_par_iter().for_each(|(mut to, from)| {
        to.assign(&if mode == 2 { from.dot(factor) } else { factor.t().dot(&from) });
    });
    product
}

/// Modes that shrink most first, which is cheapest.
fn projected(tensor: &Array3<f64>, factors: &[Array2<f64>; MODES]) -> Array3<f64> {
    let last = times(tensor, 2, &factors[2]);
    times(&times(&last, 1, &factors[1]), 0, &factors[0])
}

/// The tensor projected in all modes but `mode`.
fn projected_beside(tensor: &Array3<f64>, factors: &[Array2<f64>; MODES], mode: usize) -> Array3<f64> {
    let [first, second] = [[2, 1], [2, 0], [1, 0]][mode];
    times(&times(tensor, first, &factors[first]), second, &factors[second])
}

/// The matrix [size of the mode, product of the others].
fn unfolded(tensor: &Array3<f64>, mode: usize) -> Array2<f64> {
    let turned = tensor.view().permuted_axes([[0, 1, 2], [1, 0, 2], [2, 0, 1]][mode]);
    let (rows, _, inner) = turned.dim();
    let mut matrix = Array2::zeros((rows, tensor.len() / rows.max(1)));
    for (mut row, slice) in matrix.rows_mut().into_iter().zip(turned.outer_iter()) {
        for (mut part, values) in row.exact_chunks_mut(inner).into_iter().zip(slice.rows()) {
            part.assign(&values);
        }
    }
    matrix
}

fn squared_norm(tensor: &Array3<f64>) -> f64 {
    tensor.iter().map(|x| x * x).sum()
}

fn errors(tensor: &Array3<f64>, factors: &[Array2<f64>; MODES], core: &Array3<f64>) -> TuckerErrors {
    let whole = squared_norm(tensor);
    // What is kept is the norm of the projection, for columns are orthonormal.
    let lost = |kept: f64| if whole > 0.0 { ((whole - kept) / whole).max(0.0) } else { 0.0 };
    let alone = |mode: usize| lost(squared_norm(&times(tensor, mode, &factors[mode])));
    TuckerErrors { of_modes: [0, 1, 2].map(alone), whole: lost(squared_norm(core)) }
}

/// The `rank` leading left singular vectors of `matrix`, by rule where they are free.
fn leading(matrix: &ArrayView2<'_, f64>, rank: usize) -> Result<Array2<f64>, LinalgError> {
    let (rows, columns) = matrix.dim();
    // Of one row or column there is nothing to decompose, and LAPACK's wrapper does not take it.
    if rows == 1 {
        return Ok(Array2::ones((1, 1)));
    }
    if columns == 1 {
        let length = matrix.iter().map(|x| x * x).sum::<f64>().sqrt();
        let first = |(row, _)| if row == 0 { 1.0 } else { 0.0 };
        let column = if length > 0.0 { matrix / length } else { Array2::from_shape_fn((rows, 1), first) };
        return Ok(in_order(&[length * length], &column, rank));
    }
    let (squares, vectors): (Vec<f64>, _) = if rows > columns {
        let Svd { u, s, .. } = first_singular(&matrix.to_owned(), columns)?;
        (s.iter().map(|s| s * s).collect(), u)
    } else {
        symmetric_eigen(&gram(matrix))?
    };
    Ok(in_order(&squares, &vectors, rank))
}

/// A·Aᵀ, summed by blocks of columns of the same size whatever the number of cores.
fn gram(matrix: &ArrayView2<'_, f64>) -> Array2<f64> {
    const BLOCK: usize = 8192;
    let blocks: Vec<ArrayView2<'_, f64>> = matrix.axis_chunks_iter(Axis(1), BLOCK).collect();
    let products: Vec<Array2<f64>> = blocks.par_iter().map(|block| block.dot(&block.t())).collect();
    products.into_iter().fold(Array2::zeros((matrix.nrows(), matrix.nrows())), |sum, product| sum + product)
}

/// The first `rank` columns of `vectors`, which are orthonormal and belong to `squares`, squared singular
/// values that fall. Those of equal values are turned among each other: the first is what the subspace has of
/// the first coordinate of which it has (nearly) the most, made as long as 1, the next is the same in the
/// rest. A column alone thereby has its (nearly) largest entry positive. Where values are as good as 0, all
/// that is orthogonal to the columns before is as good, of which `vectors` need not have all.
pub(super) fn in_order(squares: &[f64], vectors: &Array2<f64>, rank: usize) -> Array2<f64> {
    let tolerance = EQUAL * squares.first().copied().unwrap_or(0.0).max(f64::MIN_POSITIVE);
    let mut ordered = Array2::zeros((vectors.nrows(), rank));
    let mut first = 0;
    while first < rank {
        if squares.get(first).is_none_or(|square| *square <= tolerance) {
            let before = ordered.slice(s![.., ..first]);
            let beside = Array2::eye(vectors.nrows()) - before.dot(&before.t());
            ordered.slice_mut(s![.., first..rank]).assign(&turned(&beside.view(), rank - first));
            break;
        }
        let mut after = first + 1;
        while after < squares.len() && squares[after - 1] - squares[after] <= tolerance {
            after += 1;
        }
        let turned = turned(&vectors.slice(s![.., first..after]), rank.min(after) - first);
        ordered.slice_mut(s![.., first..rank.min(after)]).assign(&turned);
        first = after;
    }
    ordered
}

/// The first `count` vectors by the rule of [`in_order`] of the space that the columns of `basis` span, which
/// are orthonormal, or those of the projection on the space.
fn turned(basis: &ArrayView2<'_, f64>, count: usize) -> Array2<f64> {
    let mut rows = basis.to_owned();
    let mut turned = Array2::zeros((basis.nrows(), count));
    for mut column in turned.columns_mut() {
        let lengths: Vec<f64> = rows.rows().into_iter().map(|row| row.dot(&row)).collect();
        let longest = lengths.iter().copied().fold(0.0, f64::max);
        let chosen = lengths.iter().position(|length| *length >= longest * (1.0 - AS_LONG)).unwrap_or(0);
        let row: Array1<f64> = rows.row(chosen).to_owned();
        let direction = &row / row.dot(&row).sqrt().max(f64::MIN_POSITIVE);
        column.assign(&basis.dot(&direction));
        for mut row in rows.rows_mut() {
            let along = row.dot(&direction);
            row.scaled_add(-along, &direction);
        }
    }
    turned
}

#[cfg(test)]
mod tests;
