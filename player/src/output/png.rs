//! PNG frames: exposed, clamped, sRGB, 8 bit.

use crate::error::{Error, Result};
use image::{ExtendedColorType, ImageEncoder as _, codecs::png::PngEncoder};
use relume_formats::state::Rgb;

/// What the display shows of linear radiance at exposure `ev`: clamp(2^ev · L) to 0..=1, still linear.
pub fn display_value(radiance: Rgb, ev: f32) -> Rgb {
    let gain = ev.exp2();
    radiance.map(|v| (v * gain).clamp(0.0, 1.0))
}

/// The sRGB transfer function (IEC 61966-2-1), rounded to 8 bits; `linear` is in 0..=1.
fn srgb8(linear: f32) -> u8 {
    let encoded = if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 };
    (encoded * 255.0).round() as u8
}

/// A PNG file of linear values in 0..=1, row by row.
pub fn encode(size: [u32; 2], linear: &[Rgb]) -> Result<Vec<u8>> {
    let bytes: Vec<u8> = linear.iter().flatten().map(|v| srgb8(*v)).collect();
    let mut file = Vec::new();
    PngEncoder::new(&mut file)
        .write_image(&bytes, size[0], size[1], ExtendedColorType::Rgb8)
        .map_err(|e| Error::Failed(format!("cannot encode a PNG of {}x{} pixels: {e}", size[0], size[1])))?;
    Ok(file)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_points_of_the_curve() {
        // 0.5 encodes to 187.5 within a hundredth: 1.055·0.5^(1/2.4) − 0.055 = 0.735357.
        for (linear, expected) in [(0.0, 0), (1.0, 255), (0.5, 188), (0.001, 3), (0.215_860_5, 128), (0.003_130_8, 10)] {
            assert_eq!(srgb8(linear), expected, "{linear}");
        }
    }

    #[test]
    fn every_8_bit_value_survives_its_exact_inverse() {
        for value in 0..=255_u8 {
            let v = f64::from(value) / 255.0;
            let linear = if v <= 0.04045 { v / 12.92 } else { ((v + 0.055) / 1.055).powf(2.4) };
            assert_eq!(srgb8(linear as f32), value);
        }
    }

    #[test]
    fn exposure_comes_before_the_clamp() {
        assert_eq!(display_value([0.125, 2.0, -1.0], 2.0), [0.5, 1.0, 0.0]);
        assert_eq!(display_value([f32::NEG_INFINITY, f32::INFINITY, 4.0], -3.0), [0.0, 1.0, 0.5]);
    }
}
