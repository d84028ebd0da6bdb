//! EXR frames: linear radiance in W/(sr·m²), before exposure.

use crate::error::{Error, Result};
use exr::prelude::{Encoding, Image, Layer, LayerAttributes, SpecificChannels, Vec2, WritableImage as _};
use relume_formats::state::Rgb;

/// An EXR file with 32-bit channels R, G and B; `radiance` is row by row, `width` pixels each.
pub fn encode(size: [u32; 2], radiance: &[Rgb]) -> Result<Vec<u8>> {
    let width = size[0] as usize;
    let pixel = |at: Vec2<usize>| {
        radiance.get(at.y() * width + at.x()).map_or((0.0, 0.0, 0.0), |p| (p[0], p[1], p[2]))
    };
    let layer = Layer::new(
        (width, size[1] as usize),
        LayerAttributes::default(),
        Encoding::SMALL_LOSSLESS,
        SpecificChannels::rgb(pixel),
    );
    let mut file = std::io::Cursor::new(Vec::new());
    Image::from_layer(layer)
        .write()
        .to_buffered(&mut file)
        .map_err(|e| Error::Failed(format!("cannot encode an EXR of {}x{} pixels: {e}", size[0], size[1])))?;
    Ok(file.into_inner())
}

#[cfg(test)]
mod tests {
    use exr::prelude::*;

    #[test]
    fn what_is_written_can_be_read() {
        let radiance: Vec<[f32; 3]> =
            (0..6).map(|i| [i as f32, -0.5 * i as f32, 1e9 / (1 + i) as f32]).collect();
        let file = super::encode([3, 2], &radiance).unwrap();
        let image = read()
            .no_deep_data()
            .largest_resolution_level()
            .rgb_channels(
                |size, _| vec![[0.0; 3]; size.area()],
                |pixels, at, (r, g, b): (f32, f32, f32)| pixels[at.y() * 3 + at.x()] = [r, g, b],
            )
            .first_valid_layer()
            .all_attributes()
            .from_buffered(std::io::Cursor::new(file))
            .unwrap();
        assert_eq!(image.layer_data.channel_data.pixels, radiance);
    }
}
