//! Pictures for textures: PNG and JPEG, from a file or from within a glTF file, each decoded once.

use crate::library::read_bytes;
use image::{DynamicImage, ImageDecoder, ImageError, ImageFormat, ImageReader, Limits};
use relume_formats::basis::{Filter, Texture, Wrap};
use relume_formats::{Error, Place, Result};
use std::collections::HashMap;
use std::io::Cursor;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Most texels on a side.
const MAX_SIDE: u32 = 8192;

/// Largest texture in memory.
const MAX_DECODED_BYTES: u64 = 64 << 20;

/// What makes a texture: a file, the picture's number in it if it holds several, and how it goes on beyond
/// its edge.
#[derive(PartialEq, Eq, Hash)]
pub(crate) struct TextureKey {
    /// The file that holds the picture or names it.
    pub file: PathBuf,
    /// Index of a glTF file's image.
    pub image: Option<usize>,
    /// Along u and along v.
    pub wrap: [Wrap; 2],
    /// Between its texels.
    pub filter: Filter,
}

/// Every texture of a scene so far.
#[derive(Default)]
pub(crate) struct Textures(HashMap<TextureKey, Arc<Texture>>);

impl Textures {
    /// The texture in the file at `path`, repeated beyond its edge.
    pub fn read(&mut self, path: &Path) -> Result<Arc<Texture>> {
        let key = TextureKey {
            file: path.to_path_buf(),
            image: None,
            wrap: [Wrap::Repeat; 2],
            filter: Filter::Linear,
        };
        let place = Place::file(path);
        self.get_or_decode(key, &place, || read_bytes(path))
    }

    /// The texture of that key, made from the picture that `read` gives if there is none yet.
    pub fn get_or_decode(
        &mut self,
        key: TextureKey,
        place: &Place,
        read: impl FnOnce() -> Result<Vec<u8>>,
    ) -> Result<Arc<Texture>> {
        if let Some(texture) = self.0.get(&key) {
            return Ok(texture.clone());
        }
        let texture = Arc::new(Texture { wrap: key.wrap, filter: key.filter, ..decode(&read()?, place)? });
        self.0.insert(key, texture.clone());
        Ok(texture)
    }
}

/// Decodes a picture to 8 bits per channel, repeated and smooth. Its sizes are capped before its texels are
/// allocated.
fn decode(bytes: &[u8], place: &Place) -> Result<Texture> {
    let format = image::guess_format(bytes)
        .ok()
        .filter(|format| matches!(format, ImageFormat::Png | ImageFormat::Jpeg));
    let format = format.ok_or_else(|| {
        Error::unsupported(place, "not a picture this version reads; it reads PNG and JPEG")
    })?;
    let mut reader = ImageReader::with_format(Cursor::new(bytes), format);
    let mut limits = Limits::default();
    (limits.max_image_width, limits.max_image_height) = (Some(MAX_SIDE), Some(MAX_SIDE));
    // Decoders hold 16-bit channels for a while, and a copy.
    limits.max_alloc = Some(4 * MAX_DECODED_BYTES);
    reader.limits(limits);
    let decoder = reader.into_decoder().map_err(|e| refused(&e, place))?;
    let (width, height) = decoder.dimensions();
    if width == 0 || height == 0 || 4 * u64::from(width) * u64::from(height) > MAX_DECODED_BYTES {
        return Err(too_large(&format!("{width}×{height} texels"), place));
    }
    let image = DynamicImage::from_decoder(decoder).map_err(|e| refused(&e, place))?.into_rgba8();
    let texels = image.as_raw().as_chunks().0.to_vec();
    Ok(Texture { size: [width, height], wrap: [Wrap::Repeat; 2], filter: Filter::Linear, texels })
}

fn too_large(what: &str, place: &Place) -> Error {
    let reason = format!(
        "{what}, at most {MAX_SIDE} a side and {} in all are read; scale the picture down",
        MAX_DECODED_BYTES / 4
    );
    Error::invalid(place, reason)
}

fn refused(error: &ImageError, place: &Place) -> Error {
    match error {
        ImageError::Limits(_) => too_large("too many texels", place),
        _ => Error::invalid(
            place,
            format!("broken picture ({}); save it again", error.to_string().replace('\n', " ")),
        ),
    }
}

#[cfg(test)]
mod tests;
