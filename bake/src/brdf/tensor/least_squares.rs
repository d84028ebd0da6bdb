//! Least squares of shares that may not be below 0, from products alone: Lawson and Hanson's active set (1974,
//! "Solving least squares problems", ch. 23) on normal equations (Bro and De Jong 1997, "A fast non-negativity
//! constrained least squares algorithm").

use crate::compress::linalg::inverse_of_positive;
use ndarray::{Array1, Array2, ArrayView1};
use ndarray_linalg::error::LinalgError;

/// What is added to a column's own product, in parts of it: of shapes that can stand for each other all take part.
const RIDGE: f64 = 1e-9;
/// A gradient below this part of the largest product wanted is none.
const FLAT: f64 = 1e-12;

/// The x ≥ 0 that makes xᵀ·`products`·x − 2·`wanted`·x least, `products` being those of columns with each other and
/// `wanted` those with what they are to be the sum of.
///
/// # Errors
/// If the columns depend on each other.
pub fn non_negative(products: &Array2<f64>, wanted: &[f64]) -> Result<Vec<f64>, LinalgError> {
    let count = wanted.len();
    let mut x = Array1::zeros(count);
    let mut free: Vec<usize> = Vec::new();
    let flat = FLAT * wanted.iter().fold(0.0f64, |most, value| most.max(value.abs()));
    // Each round adds a column; none is expected to come back more often than this.
    for _ in 0..3 * count {
        let gradient = &ArrayView1::from(wanted) - &products.dot(&x);
        let bound = (0..count).filter(|k| !free.contains(k) && gradient[*k] > flat);
        let Some(steepest) = bound.reduce(|a, b| if gradient[b] > gradient[a] { b } else { a }) else {
            break;
        };
        free.push(steepest);
        free.sort_unstable();
        settle(products, wanted, &mut free, &mut x)?;
    }
    Ok(x.to_vec())
}

/// Goes to the least of the free columns as far as none gets below 0, gives up those that would, and again.
fn settle(
    products: &Array2<f64>,
    wanted: &[f64],
    free: &mut Vec<usize>,
    x: &mut Array1<f64>,
) -> Result<(), LinalgError> {
    while !free.is_empty() {
        let least = of_free(products, wanted, free)?;
        let step = |(k, to): (&usize, &f64)| {
            if *to > 0.0 { 1.0 } else { x[*k] / (x[*k] - to).max(f64::MIN_POSITIVE) }
        };
        let far = free.iter().zip(&least).map(step).fold(1.0, f64::min);
        let mut kept = Vec::new();
        for (k, to) in free.iter().zip(&least) {
            let ends = *to <= 0.0 && x[*k] / (x[*k] - to).max(f64::MIN_POSITIVE) <= far;
            x[*k] = if ends { 0.0 } else { x[*k] + far * (to - x[*k]) };
            if !ends {
                kept.push(*k);
            }
        }
        let done = kept.len() == free.len();
        *free = kept;
        if done {
            break;
        }
    }
    Ok(())
}

fn of_free(products: &Array2<f64>, wanted: &[f64], free: &[usize]) -> Result<Vec<f64>, LinalgError> {
    let of_pair = |(a, b): (usize, usize)| {
        let own = if a == b { 1.0 + RIDGE } else { 1.0 };
        products[[free[a], free[b]]] * own
    };
    let inverse = inverse_of_positive(&Array2::from_shape_fn((free.len(), free.len()), of_pair))?;
    let wanted: Array1<f64> = free.iter().map(|k| wanted[*k]).collect();
    Ok(inverse.dot(&wanted).to_vec())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn noise(seed: &mut u64) -> f64 {
        *seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (*seed >> 11) as f64 / (1u64 << 53) as f64 - 0.5
    }

    fn value(products: &Array2<f64>, wanted: &[f64], x: &Array1<f64>) -> f64 {
        x.dot(&products.dot(x)) - 2.0 * x.dot(&ArrayView1::from(wanted))
    }

    /// Against the best of all 2⁶ choices of columns, each solved by itself.
    #[test]
    fn shares_are_the_best_of_all_choices_of_columns() {
        let (count, mut seed, mut at_bounds) = (6, 1, 0);
        for _ in 0..40 {
            let columns = Array2::from_shape_fn((8, count), |_| noise(&mut seed) + 0.3);
            let products = columns.t().dot(&columns);
            let target = Array1::from_shape_fn(8, |_| noise(&mut seed));
            let wanted = columns.t().dot(&target).to_vec();
            let found = Array1::from(non_negative(&products, &wanted).unwrap());
            assert!(found.iter().all(|share| *share >= 0.0));
            let mut best = 0.0f64;
            for choice in 1..1usize << count {
                let free: Vec<usize> = (0..count).filter(|k| choice >> k & 1 == 1).collect();
                let shares = of_free(&products, &wanted, &free).unwrap();
                if shares.iter().all(|share| *share >= 0.0) {
                    let mut x = Array1::zeros(count);
                    free.iter().zip(shares).for_each(|(k, share)| x[*k] = share);
                    best = best.min(value(&products, &wanted, &x));
                }
            }
            let ours = value(&products, &wanted, &found);
            // The ridge moves shares by that part, of which the least value has the square; rounding is less.
            assert!((ours - best).abs() < 1e-9, "{ours} is not {best}");
            at_bounds += found.iter().filter(|share| **share == 0.0).count();
        }
        assert!((40..200).contains(&at_bounds), "{at_bounds} of 240 shares are 0");
    }

    /// A mixture is found again, where nothing keeps it from being met.
    #[test]
    fn a_mixture_is_found_again() {
        let mut seed = 5;
        let columns = Array2::from_shape_fn((20, 5), |_| noise(&mut seed) + 0.5);
        let shares = Array1::from(vec![0.0, 0.3, 0.0, 2.0, 0.7]);
        let target = columns.dot(&shares);
        let found = non_negative(&columns.t().dot(&columns), &columns.t().dot(&target).to_vec()).unwrap();
        assert!(found.iter().zip(&shares).all(|(a, b)| (a - b).abs() < 1e-7), "{found:?}");
        assert_eq!(non_negative(&Array2::eye(3), &[-1.0, 0.0, -2.0]).unwrap(), [0.0; 3]);
    }
}
