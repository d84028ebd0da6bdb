//! The Haar transform against its definition, inner products in double precision, and itself.

use proptest::prelude::*;
use relume_formats::basis::haar::{
    Wavelet, describe, forward, forward_cube, index, inverse, inverse_cube, support,
};

/// The function at `at` by its definition, row-major.
fn by_definition(at: usize, n: usize) -> Vec<f64> {
    let value = |x: usize, y: usize| {
        if at == 0 {
            return 1.0 / n as f64;
        }
        // The levels below l hold 4^l functions.
        let level = (0..).find(|l| at < 4usize.pow(l + 1)).unwrap();
        let squares = 2usize.pow(level);
        let (m, j, i) = (at / (squares * squares), at / squares % squares, at % squares);
        let side = n / squares;
        if x / side != i || y / side != j {
            return 0.0;
        }
        let (left, upper) = (x % side < side / 2, y % side < side / 2);
        let positive = match m {
            1 => left,
            2 => upper,
            _ => left == upper,
        };
        squares as f64 / n as f64 * if positive { 1.0 } else { -1.0 }
    };
    (0..n * n).map(|k| value(k % n, k / n)).collect()
}

#[test]
fn every_basis_function_is_as_defined() {
    for n in [1usize, 2, 4, 8, 16, 32] {
        let mut scratch = Vec::new();
        for at in 0..n * n {
            let mut unit = vec![0.0f32; n * n];
            unit[at] = 1.0;
            let mut face = unit.clone();
            inverse(&mut face, n, &mut scratch);
            let truth = by_definition(at, n);
            // Powers of two all along, so there is nothing to round.
            assert!(
                face.iter().zip(&truth).all(|(ours, truth)| f64::from(*ours) == *truth),
                "function {at} of n = {n}"
            );
            // The transform of a function is its index and nothing else: orthonormality.
            forward(&mut face, n, &mut scratch);
            assert_eq!(face, unit, "function {at} of n = {n}");
            assert_eq!(support(at, n), truth.iter().filter(|v| **v != 0.0).count());
        }
    }
}

#[test]
fn indices_and_descriptions_are_each_others_inverse() {
    let n = 32;
    assert_eq!(describe(0, n), Wavelet::Scaling);
    let mut expected = 1;
    for level in 0..5 {
        for (m, j, i) in
            (1..=3).flat_map(|m| (0..1 << level).flat_map(move |j| (0..1 << level).map(move |i| (m, j, i))))
        {
            assert_eq!(index(level, m, i, j), expected);
            assert_eq!(describe(expected, n), Wavelet::Detail { level, m, i, j });
            assert_eq!(describe(4 * n * n + expected, n), describe(expected, n), "on every face alike");
            assert_eq!(support(5 * n * n + expected, n), support(expected, n));
            expected += 1;
        }
    }
    assert_eq!(expected, n * n);
}

#[test]
fn coefficients_are_inner_products() {
    let n = 16;
    let texels: Vec<f32> = (0..n * n).map(|i| ((i * 7919 + i * i) % 1009) as f32 * 0.37 - 100.0).collect();
    let mut ours = texels.clone();
    forward(&mut ours, n, &mut Vec::new());
    let norm = texels.iter().map(|v| f64::from(*v).powi(2)).sum::<f64>().sqrt();
    for (at, coefficient) in ours.iter().enumerate() {
        let truth: f64 = by_definition(at, n).iter().zip(&texels).map(|(b, t)| b * f64::from(*t)).sum();
        // Three roundings a level, four levels, each relative to a sum no larger than the norm.
        assert!(
            (f64::from(*coefficient) - truth).abs() < 12.0 * f64::from(f32::EPSILON) * norm,
            "{at}: {coefficient} against {truth}"
        );
    }
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(64) })]

    /// Whole numbers below 1024 and their sums over 32 × 32 need 20 bits, and 5 more behind the point:
    /// nothing is rounded on either way.
    #[test]
    fn whole_numbers_come_back_bit_for_bit(log in 0u32..6, seed in prop::collection::vec(-512i32..512, 6 * 1024)) {
        let n = 1usize << log;
        let texels: Vec<f32> = seed[..6 * n * n].iter().map(|v| *v as f32 * 0.0625).collect();
        let mut cube = texels.clone();
        forward_cube(&mut cube, n);
        // The same in double precision, face by face.
        let mut doubles: Vec<f64> = texels.iter().map(|v| f64::from(*v)).collect();
        doubles.chunks_exact_mut(n * n).for_each(|face| forward(face, n, &mut Vec::new()));
        prop_assert!(cube.iter().zip(&doubles).all(|(a, b)| f64::from(*a) == *b));
        inverse_cube(&mut cube, n);
        prop_assert_eq!(cube, texels);
    }

    #[test]
    fn texels_come_back_and_energy_is_kept(texels in prop::collection::vec(prop_oneof![-1e5f32..1e5, -1e-3f32..1e-3], 64 * 64)) {
        let n = 64;
        let energy = |v: &[f32]| v.iter().map(|x| f64::from(*x).powi(2)).sum::<f64>();
        let mut face = texels.clone();
        let mut scratch = vec![f32::NAN; 3];
        forward(&mut face, n, &mut scratch);
        // Each of six levels rounds three times, with relative error at most 2^-24 of the values at hand,
        // whose norm stays the texels'.
        let bound = 6.0 * 3.0 * f64::from(f32::EPSILON);
        prop_assert!((energy(&face) / energy(&texels) - 1.0).abs() < bound);
        inverse(&mut face, n, &mut scratch);
        let difference: Vec<f32> = face.iter().zip(&texels).map(|(a, b)| a - b).collect();
        prop_assert!(energy(&difference).sqrt() < 2.0 * bound * energy(&texels).sqrt());
    }
}

#[test]
#[should_panic(expected = "power of two")]
fn other_sizes_are_a_mistake_of_the_caller() {
    forward(&mut [0.0f32; 9], 3, &mut Vec::new());
}
