//! The one place that calls LAPACK.

use ndarray::{Array2, ArrayView2, Axis, ShapeBuilder as _, concatenate, s};
use ndarray_linalg::error::LinalgError;
use ndarray_linalg::{
    AllocatedArray as _, AllocatedArrayMut as _, Eigh as _, IntoTriangular as _, InverseC as _, JobSvd,
    Lapack as _, QR as _, SVDDC as _, UPLO,
};
use std::sync::Once;

#[allow(unsafe_code, reason = "OpenBLAS has no other switch that works after the program has started")]
mod openblas {
    unsafe extern "C" {
        /// Has no precondition; it only sets the size of the library's own thread pool.
        pub safe fn openblas_set_num_threads(threads: i32);
    }
}

/// Keeps OpenBLAS on one thread, as products of matrices need, too: our own loops use the cores, and sums
/// must not depend on how many there are.
pub fn single_thread() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| openblas::openblas_set_num_threads(1));
}

/// The first of a thin singular value decomposition a = u · diag(s) · vᵀ.
pub struct Svd {
    /// [rows, k], orthonormal columns.
    pub u: Array2<f64>,
    /// [k], decreasing.
    pub s: Vec<f64>,
    /// [k, columns], orthonormal rows.
    pub vt: Array2<f64>,
}

/// Rows that one QR decomposition takes at most: what fits a core's cache with the columns of a basis.
const BLOCK_ROWS: usize = 2048;

/// The `k` largest singular values of `a`, which has more rows than columns, and their vectors, with signs
/// fixed by rule: in each column of `u` the entry of largest magnitude is positive.
///
/// The right vectors are those of R in a = Q·R, which is found by blocks of rows on all cores (Demmel et al.
/// 2012, "Communication-optimal parallel and sequential QR and LU factorizations"); where blocks begin does
/// not depend on how many cores there are.
///
/// # Errors
/// If LAPACK does not converge.
pub fn first_singular(a: &Array2<f64>, k: usize) -> Result<Svd, LinalgError> {
    single_thread();
    let (_, s, vt) = triangle(&a.view())?.svddc(JobSvd::Some)?;
    let missing =
        || LinalgError::Shape(ndarray::ShapeError::from_kind(ndarray::ErrorKind::IncompatibleShape));
    let mut vt = vt.ok_or_else(missing)?.slice(s![..k, ..]).to_owned();
    // a·v = u·s. The vectors of small values are what rounding left of large ones: made orthogonal again.
    let (mut u, r) = a.dot(&vt.t()).qr()?;
    for ((mut column, mut row), diagonal) in u.columns_mut().into_iter().zip(vt.rows_mut()).zip(r.diag()) {
        let largest = column.iter().fold(0.0f64, |m, x| if x.abs() > m.abs() { *x } else { m });
        if largest < 0.0 {
            column.mapv_inplace(|x| -x);
        }
        if (largest < 0.0) != (*diagonal < 0.0) {
            row.mapv_inplace(|x| -x);
        }
    }
    Ok(Svd { u, s: s.iter().take(k).copied().collect(), vt })
}

/// Eigenvalues of the symmetric `a`, decreasing, and their orthonormal vectors as columns, whose signs, and
/// rotations among equal values, are LAPACK's.
///
/// # Errors
/// If LAPACK does not converge.
pub fn symmetric_eigen(a: &Array2<f64>) -> Result<(Vec<f64>, Array2<f64>), LinalgError> {
    single_thread();
    let (values, vectors) = a.eigh(UPLO::Lower)?;
    let decreasing = vectors.slice(s![.., ..;-1]).to_owned();
    Ok((values.iter().rev().copied().collect(), decreasing))
}

/// Orthonormal columns that span what those of `a` do, and, if these depend on each other, more: as many as
/// it has columns, or rows if these are fewer.
///
/// # Errors
/// If LAPACK fails.
pub fn orthonormal(a: &Array2<f64>) -> Result<Array2<f64>, LinalgError> {
    single_thread();
    // LAPACK's wrapper does not take a single row.
    if a.nrows() == 1 { Ok(Array2::ones((1, 1))) } else { Ok(a.qr()?.0) }
}

/// The inverse of a symmetric matrix with positive eigenvalues only.
///
/// # Errors
/// If any is not positive.
pub fn inverse_of_positive(a: &Array2<f64>) -> Result<Array2<f64>, LinalgError> {
    single_thread();
    if a.nrows() == 1 { Ok(a.mapv(f64::recip)) } else { a.invc() }
}

/// R of the QR decomposition of `a`, but for signs of its rows.
fn triangle(a: &ArrayView2<'_, f64>) -> Result<Array2<f64>, LinalgError> {
    let rows = a.nrows();
    if rows <= BLOCK_ROWS.max(2 * a.ncols()) {
        // LAPACK is at its best where columns are contiguous.
        let mut block = Array2::zeros(a.dim().f());
        block.assign(a);
        let layout = block.layout()?;
        // Q is not needed.
        f64::householder(layout, block.as_allocated_mut()?)?;
        return Ok(block.slice(s![..a.ncols().min(rows), ..]).to_owned().into_triangular(UPLO::Upper));
    }
    let (above, below) = a.split_at(Axis(0), rows / 2);
    let (above, below) = rayon::join(|| triangle(&above), || triangle(&below));
    triangle(&concatenate(Axis(0), &[above?.view(), below?.view()])?.view())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Columns that are about as independent as a hash can make them.
    fn noise(rows: usize, columns: usize) -> Array2<f64> {
        let value = |(i, j): (usize, usize)| {
            let hash = ((i * columns + j) as u64 + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
            (hash ^ (hash >> 29)).wrapping_mul(0xbf58_476d_1ce4_e5b9) as f64 / u64::MAX as f64 - 0.5
        };
        Array2::from_shape_fn((rows, columns), value)
    }

    fn assert_orthonormal(columns: &Array2<f64>) {
        let products = columns.t().dot(columns);
        let error = &products - &Array2::<f64>::eye(columns.ncols());
        assert!(error.iter().all(|e| e.abs() < 1e-13), "{error}");
    }

    #[test]
    fn rebuilds_the_matrix_with_fixed_signs() {
        let small = Array2::from_shape_fn((40, 7), |(i, j)| ((i * 13 + j * j * 5) % 17) as f64 - 8.0);
        // Of several blocks, with a remainder.
        for a in [small.clone(), -small, noise(3 * BLOCK_ROWS + 5, 7)] {
            let Svd { u, s, vt } = first_singular(&a, 7).unwrap();
            let back = (&u * &ndarray::ArrayView1::from(&s)).dot(&vt);
            assert!((&back - &a).iter().all(|e| e.abs() < 1e-12 * s[0]));
            assert!(s.windows(2).all(|w| w[0] >= w[1]));
            assert_orthonormal(&u);
            assert_orthonormal(&vt.t().to_owned());
            for column in u.columns() {
                let largest = column.iter().copied().max_by(|x, y| x.abs().total_cmp(&y.abs())).unwrap();
                assert!(largest > 0.0);
            }
        }
    }

    /// LAPACK's own decomposition of the whole, of a matrix whose singular values fall by nine orders: known
    /// to the rounding of the largest, vectors to that over the distance to the next value.
    #[test]
    fn blocks_give_what_the_whole_gives() {
        let (u, _) = noise(2 * BLOCK_ROWS + 77, 10).qr().unwrap();
        let (v, _) = noise(10, 10).qr().unwrap();
        let values: Vec<f64> = (0..10).map(|i| 10f64.powi(-i)).collect();
        let a = (&u * &ndarray::ArrayView1::from(&values)).dot(&v.t());
        let (whole_u, whole_s, whole_vt) = a.svddc(JobSvd::Some).unwrap();
        let (whole_u, whole_vt) = (whole_u.unwrap(), whole_vt.unwrap());
        let found = first_singular(&a, 8).unwrap();
        assert_eq!((found.u.dim(), found.s.len(), found.vt.dim()), ((a.nrows(), 8), 8, (8, 10)));
        for k in 0..8 {
            assert!((found.s[k] - values[k]).abs() < 1e-14 && (found.s[k] - whole_s[k]).abs() < 1e-14);
            let sign = found.u.column(k).dot(&whole_u.column(k)).signum();
            let bound = 1e-14 / (0.9 * values[k]);
            let off = |ours: ArrayViewOf<'_>, theirs: ArrayViewOf<'_>| {
                (&ours - &(&theirs * sign)).pow2().sum().sqrt()
            };
            assert!(off(found.u.column(k), whole_u.column(k)) < bound, "u {k}");
            assert!(off(found.vt.row(k), whole_vt.row(k)) < bound, "v {k}");
        }
        assert_orthonormal(&found.u);
    }

    type ArrayViewOf<'a> = ndarray::ArrayView1<'a, f64>;
}
