//! Scales and steps of numbers that are rounded to fewer bits.

use half::f16;
use relume_formats::kinds::transfer_images::LARGEST_HALF;

/// The factor on halves that stand for values up to `largest`: a power of two; 0 if there is nothing.
pub fn scale_for(largest: f32) -> f32 {
    if largest > 0.0 { largest.log2().ceil().exp2() / LARGEST_HALF } else { 0.0 }
}

/// A power of two, 2⁻²² of the largest of `values` or up to twice that: with it the steps of bytes do not
/// overflow halves, and those of wide values keep their precision in rows that are a millionth as large.
pub fn unit_for(values: &[f32]) -> f32 {
    let largest = values.iter().fold(0.0, |m: f32, v| m.max(v.abs()));
    if largest > 0.0 { (largest / 4_194_304.0).log2().ceil().exp2() } else { 1.0 }
}

/// The step of which `largest` is no more than `most`: rounded up, so that nothing is cut.
pub fn step_for(largest: f32, most: f32) -> f16 {
    let step = f16::from_f32(largest / most);
    if step.to_f32() * most < largest { f16::from_bits(step.to_bits() + 1) } else { step }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scales_are_powers_of_two_and_no_half_overflows() {
        for largest in [1e-30f32, 1e-3, 0.5, 1.0, 1.1, 65_504.0, 1e9, 3e30] {
            let scale = scale_for(largest);
            assert_eq!(scale.log2().fract(), 0.0);
            let half = f16::from_f32(largest / scale);
            assert!(half.is_finite() && half.to_f32() > LARGEST_HALF / 2.0 * 0.99, "{largest}: {half}");
        }
        assert_eq!(scale_for(0.0), 0.0);
    }

    #[test]
    fn steps_are_the_least_halves_that_reach_the_largest() {
        for (largest, most) in [(1.0f32, 127.0f32), (3.7, 127.0), (0.01, 32_767.0), (900.0, 127.0)] {
            let step = step_for(largest, most);
            assert!(step.to_f32() * most >= largest, "{largest}");
            assert!(
                f16::from_bits(step.to_bits() - 1).to_f32() * most < largest,
                "{largest}: a smaller step would do"
            );
        }
        assert_eq!(step_for(0.0, 127.0), f16::ZERO);
    }

    #[test]
    fn units_are_powers_of_two_within_a_factor_of_two() {
        for largest in [1e-20f32, 0.3, 1.0, 4_194_304.0, 1e20] {
            let unit = unit_for(&[0.0, -largest, largest / 2.0]);
            assert_eq!(unit.log2().fract(), 0.0);
            // Logarithms of single precision may be off in the last digit.
            assert!((0.999..2.001).contains(&(unit * 4_194_304.0 / largest)), "{largest}: {unit}");
        }
        assert_eq!(unit_for(&[]), 1.0);
    }
}
