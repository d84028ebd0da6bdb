//! How much the coefficients of regions have to do with each other, as textures go: what a material has in common all
//! over, what regions have in common that are near to each other, and what each has alone.

use crate::compress::linalg::symmetric_eigen;
use ndarray::{Array1, Array2};
use ndarray_linalg::error::LinalgError;
use relume_formats::kinds::region_images::REGIONS;

/// Shares of the mean square of a coefficient that are common to all regions, and each region's own.
const COMMON: f64 = 0.4;
const OWN: f64 = 0.05;
/// The rest is common to regions so near, in regions, but for a factor of e.
const REACH: f64 = 4.0;

/// Of some regions, with a mean square of 1: K, by its roots.
pub struct Covariance {
    /// Which regions.
    pub regions: Vec<usize>,
    /// K^½.
    pub root: Array2<f64>,
    /// K^−½.
    pub inverse: Array2<f64>,
}

impl Covariance {
    /// Of these regions.
    ///
    /// # Errors
    /// If LAPACK does not converge.
    pub fn new(regions: Vec<usize>) -> Result<Self, LinalgError> {
        let count = regions.len();
        let matrix = Array2::from_shape_fn([count; 2], |(i, j)| between(regions[i], regions[j]));
        if count == 0 {
            return Ok(Self { regions, root: matrix.clone(), inverse: matrix });
        }
        let (values, vectors) = symmetric_eigen(&matrix)?;
        let power = |exponent: f64| {
            let scale = Array1::from_iter(values.iter().map(|value| value.max(OWN).powf(exponent)));
            (&vectors * &scale).dot(&vectors.t())
        };
        Ok(Self { regions, root: power(0.5), inverse: power(-0.5) })
    }
}

fn between(i: usize, j: usize) -> f64 {
    let [x, y] = [i % REGIONS, i / REGIONS].map(|at| at as f64);
    let distance = (x - (j % REGIONS) as f64).hypot(y - (j / REGIONS) as f64);
    let own = if i == j { OWN } else { 0.0 };
    COMMON + (1.0 - COMMON - OWN) * (-distance / REACH).exp() + own
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn roots_are_roots() {
        let regions = vec![0, 1, 33, 500, 1023];
        let covariance = Covariance::new(regions.clone()).unwrap();
        let square = covariance.root.dot(&covariance.root);
        let one = covariance.root.dot(&covariance.inverse);
        for (i, j) in (0..5).flat_map(|i| (0..5).map(move |j| (i, j))) {
            assert!((square[[i, j]] - between(regions[i], regions[j])).abs() < 1e-12);
            assert!((one[[i, j]] - if i == j { 1.0 } else { 0.0 }).abs() < 1e-12);
        }
        assert_eq!(between(7, 7), 1.0);
    }
}
