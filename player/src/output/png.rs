//! PNG frames: what a display shows, sRGB, 8 bit.

use crate::error::{Error, Result};
use image::{ExtendedColorType, ImageEncoder as _, codecs::png::PngEncoder};
use relume_formats::basis::srgb_from_linear;
use relume_formats::state::Rgb;

/// A PNG file of linear values in 0..=1, row by row.
pub fn encode(size: [u32; 2], linear: &[Rgb]) -> Result<Vec<u8>> {
    let bytes: Vec<u8> = linear.iter().flatten().map(|v| srgb_from_linear(*v)).collect();
    let mut file = Vec::new();
    PngEncoder::new(&mut file)
        .write_image(&bytes, size[0], size[1], ExtendedColorType::Rgb8)
        .map_err(|e| Error::Failed(format!("cannot encode a PNG of {}x{} pixels: {e}", size[0], size[1])))?;
    Ok(file)
}
