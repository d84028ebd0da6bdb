//! Numbers that are known better than they matter, as bytes that zstd makes small.

use relume_formats::container::planes;

/// Bits of a significand that are kept, the one that is never written left out.
pub const SIGNIFICAND: u32 = 12;
/// What rounding changes at most, in parts of a value.
pub const LARGEST_ERROR: f32 = 1.0 / (1 << (SIGNIFICAND + 1)) as f32;

/// The number of [`SIGNIFICAND`] bits that is nearest to `value`, which is finite.
fn rounded(value: f32) -> f32 {
    let left_out = f32::MANTISSA_DIGITS - 1 - SIGNIFICAND;
    // A carry out of the significand is one into the exponent, as it should be.
    let nearest = value.to_bits().wrapping_add(1 << (left_out - 1)) >> left_out << left_out;
    f32::from_bits(nearest)
}

/// `values`, rounded: the lowest byte of each, then the next byte of each, and so on.
pub fn to_planes(values: &[f32]) -> Vec<u8> {
    let bytes: Vec<u8> = values.iter().flat_map(|value| rounded(*value).to_le_bytes()).collect();
    planes::split(&bytes, size_of::<f32>())
}

/// The inverse of [`to_planes`], but for the rounding.
pub fn from_planes(bytes: &[u8]) -> Vec<f32> {
    planes::join(bytes, size_of::<f32>()).as_chunks().0.iter().map(|b| f32::from_le_bytes(*b)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_come_back_as_near_as_is_said() {
        let mut values = vec![0.0, -0.0, 1.0, 0.1, -3.7e-5, 1.0 - f32::EPSILON / 2.0, 1e-20, 6e4];
        values.extend((1..2000u32).map(|i| (i.wrapping_mul(2_654_435_761) as f32 / 4.3e9).powi(9)));
        let planes = to_planes(&values);
        assert_eq!(planes.len(), 4 * values.len());
        assert!(planes[..values.len()].iter().all(|byte| *byte == 0), "the lowest bytes are gone");
        let back = from_planes(&planes);
        assert_eq!(back.len(), values.len());
        let mut worst = 0.0f32;
        for (value, back) in values.iter().zip(&back) {
            assert!((value - back).abs() <= LARGEST_ERROR * value.abs(), "{value} {back}");
            worst = worst.max((value - back).abs() / value.abs().max(f32::MIN_POSITIVE));
        }
        assert!(worst > 0.5 * LARGEST_ERROR, "the bound is no larger than it must be: {worst}");
        assert_eq!(from_planes(&to_planes(&back)), back, "what is rounded stays");
        assert!(from_planes(&[]).is_empty());
    }
}
