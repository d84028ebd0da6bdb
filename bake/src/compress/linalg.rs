//! The one place that calls LAPACK.

use ndarray::{Array1, Array2};
use ndarray_linalg::error::LinalgError;
use ndarray_linalg::{JobSvd, SVDDC};
use std::sync::Once;

#[allow(unsafe_code, reason = "OpenBLAS has no other switch that works after the program has started")]
mod openblas {
    unsafe extern "C" {
        /// Has no precondition; it only sets the size of the library's own thread pool.
        pub safe fn openblas_set_num_threads(threads: i32);
    }
}

/// Keeps OpenBLAS on one thread: our own loops use the cores, and sums must not depend on how many there are.
fn single_thread() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| openblas::openblas_set_num_threads(1));
}

/// A thin singular value decomposition a = u · diag(s) · vᵀ.
pub struct Svd {
    /// [rows, k], orthonormal columns.
    pub u: Array2<f64>,
    /// [k], decreasing.
    pub s: Array1<f64>,
    /// [k, columns], orthonormal rows.
    pub vt: Array2<f64>,
}

/// The thin SVD of `a`, with signs fixed by rule: in each column of `u` the entry of largest magnitude is
/// positive.
///
/// # Errors
/// If LAPACK does not converge.
pub fn thin_svd(a: &Array2<f64>) -> Result<Svd, LinalgError> {
    single_thread();
    let (u, s, vt) = a.svddc(JobSvd::Some)?;
    let missing =
        || LinalgError::Shape(ndarray::ShapeError::from_kind(ndarray::ErrorKind::IncompatibleShape));
    let (mut u, mut vt) = (u.ok_or_else(missing)?, vt.ok_or_else(missing)?);
    for (mut column, mut row) in u.columns_mut().into_iter().zip(vt.rows_mut()) {
        let largest = column.iter().fold(0.0f64, |m, x| if x.abs() > m.abs() { *x } else { m });
        if largest < 0.0 {
            column.mapv_inplace(|x| -x);
            row.mapv_inplace(|x| -x);
        }
    }
    Ok(Svd { u, s, vt })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rebuilds_the_matrix_with_fixed_signs() {
        let a = Array2::from_shape_fn((40, 7), |(i, j)| ((i * 13 + j * j * 5) % 17) as f64 - 8.0);
        for a in [a.clone(), -a] {
            let Svd { u, s, vt } = thin_svd(&a).unwrap();
            let back = (&u * &s).dot(&vt);
            assert!((&back - &a).iter().all(|e| e.abs() < 1e-12 * s[0]));
            assert!(s.windows(2).into_iter().all(|w| w[0] >= w[1]));
            for column in u.columns() {
                let largest = column.iter().copied().max_by(|x, y| x.abs().total_cmp(&y.abs())).unwrap();
                assert!(largest > 0.0);
            }
        }
    }
}
