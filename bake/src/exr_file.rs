//! OpenEXR files as named planes of 32-bit floats.
//!
//! One flat part; layers are channel names with a dot, such as `variance.R`. Lossless, and the same planes
//! always make the same bytes.

use exr::image::{AnyChannel, AnyChannels, Encoding, FlatSamples, Image};
use exr::meta::attribute::{LineOrder, Text};
use exr::prelude::{Compression, ReadChannels as _, ReadLayers as _, WritableImage as _};
use relume_formats::container::replace_file;
use relume_formats::{Error, Place, Result, open_regular};
use std::io::{BufReader, Cursor};
use std::path::Path;

/// An image read back from a file.
#[derive(Debug, Clone, PartialEq)]
pub struct Planes {
    /// Pixels per row.
    pub width: usize,
    /// Rows, from the top down.
    pub height: usize,
    /// Channel names, sorted, each with its row-major values.
    pub channels: Vec<(String, Vec<f32>)>,
}

impl Planes {
    /// The values of the channel called `name`.
    pub fn channel(&self, name: &str) -> Option<&[f32]> {
        self.channels.iter().find(|(n, _)| n == name).map(|(_, values)| values.as_slice())
    }
}

/// Writes `channels`, each a name and row-major values from the top down, to `path`: the whole file or
/// nothing.
///
/// # Errors
/// If a plane is not `width` × `height` long, a name cannot stand in an EXR file, or the file cannot be
/// written.
pub fn write_exr(path: &Path, width: usize, height: usize, channels: &[(&str, &[f32])]) -> Result<()> {
    let place = Place::file(path);
    let list = channels
        .iter()
        .map(|(name, values)| channel(name, values, width * height, &place))
        .collect::<Result<_>>()?;
    // Scan lines in increasing order: otherwise the order of blocks would depend on which thread is done
    // first.
    let encoding = Encoding {
        compression: Compression::ZIP16,
        line_order: LineOrder::Increasing,
        ..Encoding::SMALL_LOSSLESS
    };
    let encoding = Encoding { blocks: exr::image::Blocks::ScanLines, ..encoding };
    let image = Image::from_encoded_channels((width, height), encoding, AnyChannels::sort(list));
    let mut bytes = Cursor::new(Vec::new());
    image.write().to_buffered(&mut bytes).map_err(|e| error(e, &place))?;
    replace_file(path, &bytes.into_inner())
}

fn channel(name: &str, values: &[f32], pixels: usize, place: &Place) -> Result<AnyChannel<FlatSamples>> {
    let place = place.part(format!("channel `{name}`"));
    if values.len() != pixels {
        return Err(Error::invalid(&place, format!("{} values for {pixels} pixels", values.len())));
    }
    let text = Text::new_or_none(name)
        .ok_or_else(|| Error::invalid(&place, "the name has characters that EXR does not allow"))?;
    Ok(AnyChannel::new(text, FlatSamples::F32(values.to_vec())))
}

/// Reads the first part of an EXR file; other sample types are converted to `f32`.
///
/// # Errors
/// If the file cannot be read or holds no flat image.
pub fn read_exr(path: &Path) -> Result<Planes> {
    let place = Place::file(path);
    let file = open_regular(path)?;
    let reader = exr::prelude::read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .first_valid_layer()
        .all_attributes();
    let image = reader.from_buffered(BufReader::new(file)).map_err(|e| error(e, &place))?;
    let layer = image.layer_data;
    let channels = layer
        .channel_data
        .list
        .into_iter()
        .map(|c| (c.name.to_string(), c.sample_data.values_as_f32().collect()));
    Ok(Planes { width: layer.size.width(), height: layer.size.height(), channels: channels.collect() })
}

fn error(error: exr::error::Error, place: &Place) -> Error {
    use exr::error::Error as Exr;
    match error {
        Exr::Io(e) => Error::io(place, e),
        Exr::NotSupported(reason) => Error::unsupported(place, format!("EXR: {reason}")),
        Exr::Invalid(reason) => Error::invalid(place, format!("EXR: {reason}")),
        Exr::Aborted => Error::invalid(place, "EXR: aborted"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn named_planes_come_back_bit_for_bit_and_bytes_repeat() {
        let folder = tempfile::tempdir().unwrap();
        let (width, height) = (37, 41); // more than two blocks of 16 lines, no multiple of anything
        let plane = |k: usize| -> Vec<f32> {
            (0..width * height).map(|i| ((i * 7919 + k * 31) % 1009) as f32 * 1.7e3 - 0.1).collect()
        };
        let mut red = plane(0);
        red[..4].copy_from_slice(&[f32::MAX, f32::MIN_POSITIVE, -0.0, 1e-40]);
        let (green, variance) = (plane(1), plane(2));
        let channels: [(&str, &[f32]); 3] = [("variance.R", &variance), ("R", &red), ("G", &green)];
        let (a, b) = (folder.path().join("a.exr"), folder.path().join("b.exr"));
        write_exr(&a, width, height, &channels).unwrap();
        write_exr(&b, width, height, &channels).unwrap();
        assert_eq!(std::fs::read(&a).unwrap(), std::fs::read(&b).unwrap());

        let read = read_exr(&a).unwrap();
        assert_eq!((read.width, read.height, read.channels.len()), (width, height, 3));
        let bits = |values: &[f32]| values.iter().map(|v| v.to_bits()).collect::<Vec<_>>();
        for (name, values) in channels {
            assert_eq!(bits(read.channel(name).unwrap()), bits(values), "{name}");
        }
    }

    #[test]
    fn faults_name_the_file_and_leave_nothing() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.exr");
        let message = write_exr(&path, 2, 2, &[("R", &[0.0; 3])]).unwrap_err().to_string();
        assert!(message.contains("a.exr: channel `R`: 3 values for 4 pixels"), "{message}");
        assert!(!path.exists());
        std::fs::write(&path, b"not an image").unwrap();
        let message = read_exr(&path).unwrap_err().to_string();
        assert!(message.contains("a.exr: EXR: "), "{message}");
    }
}
