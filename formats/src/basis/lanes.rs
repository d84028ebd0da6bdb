//! Sums in several lanes, which vector units do at once, in the same order everywhere.

use std::iter::Sum;
use std::ops::{Add, Mul};

/// The inner product of `a` and `b`, as far as the shorter goes, summed in four lanes.
pub fn dot<T>(a: &[T], b: &[T]) -> T
where
    T: Copy + Default + Sum + Add<Output = T> + Mul<Output = T>,
{
    let mut lanes = [T::default(); 4];
    let length = a.len().min(b.len());
    let (a4, a_rest) = a[..length].as_chunks::<4>();
    let (b4, b_rest) = b[..length].as_chunks::<4>();
    for (a, b) in a4.iter().zip(b4) {
        for k in 0..4 {
            lanes[k] = lanes[k] + a[k] * b[k];
        }
    }
    let rest: T = a_rest.iter().zip(b_rest).map(|(a, b)| *a * *b).sum();
    (lanes[0] + lanes[1]) + (lanes[2] + lanes[3]) + rest
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Whole numbers, whose sums are exact in any order.
    #[test]
    fn it_is_the_sum_of_products() {
        for length in 0..13 {
            let numbers = |from: i32| (0..length).map(|k| f64::from(from + k)).collect::<Vec<_>>();
            let (a, b) = (numbers(-3), numbers(5));
            let sum: f64 = a.iter().zip(&b).map(|(a, b)| a * b).sum();
            assert_eq!(
                (dot(&a, &b), dot(&a, &b[..b.len().min(2)])),
                (sum, (0..length.min(2)).map(|k| f64::from((k - 3) * (k + 5))).sum())
            );
        }
    }
}
