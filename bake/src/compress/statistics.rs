//! What many errors come to in one figure.

/// The largest error; no error at all, NaN, is none.
pub fn worst(errors: &[f64]) -> f64 {
    errors.iter().copied().fold(0.0, f64::max)
}

/// The middle error, or the mean of the two in the middle; 0 if there are none.
pub fn median(errors: &[f64]) -> f64 {
    let mut sorted = errors.to_vec();
    sorted.sort_by(f64::total_cmp);
    let at = |k: usize| sorted.get(k).copied().unwrap_or(0.0);
    0.5 * (at(sorted.len() / 2) + at(sorted.len().saturating_sub(1) / 2))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_middle_and_the_largest_are_found_in_any_order() {
        assert_eq!((median(&[3.0, 1.0, 2.0]), worst(&[3.0, 1.0, 2.0])), (2.0, 3.0));
        assert_eq!(median(&[4.0, 1.0, 3.0, 2.0]), 2.5, "the mean of two");
        assert_eq!((median(&[]), worst(&[]), worst(&[f64::NAN, 0.5])), (0.0, 0.0, 0.5));
    }
}
