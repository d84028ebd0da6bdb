//! Environment maps: Radiance `.hdr` and OpenEXR `.exr` (half or float, any compression).

use crate::library::has_extension;
use exr::prelude::{MetaData, ReadChannels, ReadLayers, Vec2};
use image::DynamicImage;
use image::codecs::hdr::HdrDecoder;
use relume_formats::basis::EquirectMap;
use relume_formats::state::Rgb;
use relume_formats::{Error, Place, Result};
use std::fs::File;
use std::io::BufReader;
use std::path::Path;

/// Largest map, in texels: 8192 × 4096. While it is read there are two copies of 12 bytes each, and a file of a few bytes may claim to be so large.
const MAX_TEXELS: u64 = 1 << 25;

/// What an infinite texel becomes: the largest half float, whose overflow it was.
const LARGEST_HALF: f32 = 65_504.0;

/// Evenly white. It has more than one texel because tracers sample maps by rows of equal latitude.
pub(super) fn white_map() -> EquirectMap {
    let (width, height) = (32, 16);
    EquirectMap { width, height, texels: vec![[1.0; 3]; (width * height) as usize] }
}

/// Reads the map at `path`. Adds what was mended to `warnings`.
pub(super) fn read_map(path: &Path, warnings: &mut Vec<String>) -> Result<EquirectMap> {
    let place = Place::file(path);
    let mut map = if has_extension(path, "hdr") {
        read_hdr(path, &place)?
    } else if has_extension(path, "exr") {
        read_exr(path, &place)?
    } else {
        return Err(Error::unsupported(&place, "not an environment map this version reads; it reads .hdr and .exr"));
    };
    let mended = mend(&mut map.texels);
    if mended > 0 {
        warnings.push(format!("{place}: mended {mended} of {} texels, which are negative, infinite or NaN", map.texels.len()));
    }
    Ok(map)
}

/// Sets negative and NaN values to 0 and infinite ones to the largest half float. Returns the number of texels concerned.
fn mend(texels: &mut [Rgb]) -> usize {
    let legal = |x: &f32| x.is_finite() && *x >= 0.0;
    let broken = texels.iter_mut().filter(|texel| !texel.iter().all(legal));
    let mended = |x: f32| {
        if x == f32::INFINITY {
            LARGEST_HALF
        } else if x > 0.0 {
            x
        } else {
            0.0
        }
    };
    broken.map(|texel| *texel = texel.map(mended)).count()
}

fn check_size(width: u64, height: u64, place: &Place) -> Result<()> {
    if width == 0 || height == 0 || width.saturating_mul(height) > MAX_TEXELS {
        return Err(Error::invalid(place, format!("{width}×{height} texels, expected 1 to {MAX_TEXELS} in all; scale it down")));
    }
    Ok(())
}

fn read_hdr(path: &Path, place: &Place) -> Result<EquirectMap> {
    let refuse = |e: image::ImageError| Error::invalid(place, format!("not a Radiance map ({e})"));
    let file = File::open(path).map_err(|e| Error::io(place, e))?;
    let decoder = HdrDecoder::new(BufReader::new(file)).map_err(refuse)?;
    let (width, height) = (decoder.metadata().width, decoder.metadata().height);
    check_size(width.into(), height.into(), place)?;
    let image = DynamicImage::from_decoder(decoder).map_err(refuse)?.into_rgb32f();
    Ok(EquirectMap { width, height, texels: image.as_raw().as_chunks().0.to_vec() })
}

fn read_exr(path: &Path, place: &Place) -> Result<EquirectMap> {
    let file = File::open(path).map_err(|e| Error::io(place, e))?;
    check_exr_header(BufReader::new(file), place)?;
    let file = File::open(path).map_err(|e| Error::io(place, e))?;
    let image = exr::prelude::read()
        .no_deep_data()
        .largest_resolution_level()
        .rgb_channels(
            |size, _| (size.width(), vec![[0.0; 3]; size.area()]),
            |(width, texels): &mut (usize, Vec<Rgb>), at: Vec2<usize>, (r, g, b): (f32, f32, f32)| {
                if let Some(texel) = texels.get_mut(at.y() * *width + at.x()) {
                    *texel = [r, g, b];
                }
            },
        )
        .first_valid_layer()
        .all_attributes()
        .from_buffered(BufReader::new(file))
        .map_err(|e| exr_error(e, place))?;
    let layer = image.layer_data;
    let (width, height) = (layer.size.width() as u32, layer.size.height() as u32);
    if layer.size != image.attributes.display_window.size {
        return Err(Error::unsupported(place, "its data window is not its display window; save it uncropped"));
    }
    Ok(EquirectMap { width, height, texels: layer.channel_data.pixels.1 })
}

/// Caps the sizes before the pixels are allocated.
fn check_exr_header(file: BufReader<File>, place: &Place) -> Result<()> {
    let meta = MetaData::read_from_buffered(file, false).map_err(|e| exr_error(e, place))?;
    meta.headers.iter().try_for_each(|h| check_size(h.layer_size.width() as u64, h.layer_size.height() as u64, place))
}

fn exr_error(error: exr::error::Error, place: &Place) -> Error {
    match error {
        exr::error::Error::Io(e) => Error::io(place, e),
        exr::error::Error::NotSupported(what) => Error::unsupported(place, format!("{what}; save it as plain RGB scan lines")),
        other => Error::invalid(place, format!("not an OpenEXR map with R, G and B ({other})")),
    }
}

#[cfg(test)]
mod tests;
