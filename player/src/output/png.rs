//! PNG frames: exposed, clamped, sRGB, 8 bit.

use crate::error::{Error, Result};
use image::{ExtendedColorType, ImageEncoder as _, codecs::png::PngEncoder};
use relume_formats::basis::srgb_from_linear;
use relume_formats::state::Rgb;

/// What the display shows of linear radiance at exposure `ev`: clamp(2^ev · L) to 0..=1, still linear.
pub fn display_value(radiance: Rgb, ev: f32) -> Rgb {
    let gain = ev.exp2();
    radiance.map(|v| (v * gain).clamp(0.0, 1.0))
}

/// A PNG file of linear values in 0..=1, row by row.
pub fn encode(size: [u32; 2], linear: &[Rgb]) -> Result<Vec<u8>> {
    let bytes: Vec<u8> = linear.iter().flatten().map(|v| srgb_from_linear(*v)).collect();
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
    fn exposure_comes_before_the_clamp() {
        assert_eq!(display_value([0.125, 2.0, -1.0], 2.0), [0.5, 1.0, 0.0]);
        assert_eq!(display_value([f32::NEG_INFINITY, f32::INFINITY, 4.0], -3.0), [0.0, 1.0, 0.5]);
    }
}
