//! The selection of terms against a full sort.

use proptest::prelude::*;
use relume_formats::basis::approximate::{by_area, by_size, largest};

/// By sorting everything.
fn sorted(coefficients: &[f32], k: usize, weight: impl Fn(usize) -> f32) -> Vec<(u32, f32)> {
    let mut terms: Vec<(usize, f32)> =
        coefficients.iter().copied().enumerate().filter(|(_, v)| *v != 0.0).collect();
    // Stable, so equals stay in the order of their indices.
    terms.sort_by(|a, b| (b.1.abs() * weight(b.0)).total_cmp(&(a.1.abs() * weight(a.0))));
    terms.iter().take(k).map(|(at, value)| (*at as u32, *value)).collect()
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(256) })]

    /// Few different values, so that there are many equals.
    #[test]
    fn the_largest_are_those_of_a_full_sort(values in prop::collection::vec(-4i32..=4, 6 * 64), k in 0usize..500) {
        let coefficients: Vec<f32> = values.iter().map(|v| *v as f32 * 0.5).collect();
        prop_assert_eq!(largest(&coefficients, k, by_size), sorted(&coefficients, k, by_size));
        prop_assert_eq!(largest(&coefficients, k, by_area(8)), sorted(&coefficients, k, by_area(8)));
        let odd_only = |at: usize| (at % 2) as f32;
        let odd = largest(&coefficients, k, odd_only);
        prop_assert!(odd.iter().all(|(at, _)| at % 2 == 1), "what weighs nothing is never kept");
    }

    #[test]
    fn of_any_floats(coefficients in prop::collection::vec(any::<f32>().prop_filter("number", |v| v.is_finite()), 0..300), k in 0usize..300) {
        prop_assert_eq!(largest(&coefficients, k, by_size), sorted(&coefficients, k, by_size));
    }
}

#[test]
fn nothing_to_choose_from() {
    assert!(largest(&[], 5, by_size).is_empty());
    assert!(largest(&[0.0, -0.0], 5, by_size).is_empty());
    assert!(largest(&[1.0], 0, by_size).is_empty());
    assert_eq!(largest(&[1.0, 0.0, -2.0], usize::MAX, by_size), [(2, -2.0), (0, 1.0)]);
}

#[test]
fn area_is_the_number_of_texels() {
    let weight = by_area(64);
    // Scaling, levels 0 to 5; and the same on the last face.
    for (at, area) in [
        (0, 4096.0),
        (1, 4096.0),
        (3, 4096.0),
        (4, 1024.0),
        (16, 256.0),
        (64, 64.0),
        (1024, 4.0),
        (4095, 4.0),
    ] {
        assert_eq!([weight(at), weight(5 * 4096 + at)], [area; 2], "{at}");
    }
}
