//! Textures that are painted on materials, from the files that states name: PNG and JPEG pictures, and OpenEXR.
//!
//! An OpenEXR file holds the values themselves. In a picture black and white stand for the ends of what a key may
//! be, see [`Layer::from_unit`], and colours are sRGB. Alpha means nothing.

use crate::basis::linear_from_srgb_unit;
use crate::map_file::expect_kind;
use crate::map_file::open_exr::{self, Sizes};
use crate::name::plain;
use crate::near::nearest_file;
use crate::regular::read_regular;
use crate::state::{Brdf, Layer, MAX_PAINT_SIDE, MaterialState, Model, Paint, Rgb};
use crate::{Error, Place, Result, has_extension};
use image::{DynamicImage, ImageError, ImageFormat, ImageReader, Limits};
use std::io::{Cursor, Error as IoError, ErrorKind};
use std::path::{Path, PathBuf};

/// Longest file of a picture: what the largest one takes without compression, and as much again.
const MAX_FILE_BYTES: u64 = 2 * 8 * (MAX_PAINT_SIDE as u64).pow(2);

/// A material that textures are painted on.
#[derive(Debug, Clone, Copy)]
pub struct Canvas<'a> {
    /// Its name.
    pub name: &'a str,
    /// What it is without them.
    pub brdf: &'a Brdf,
    /// The sharpest lobe that it may have.
    pub sharpest: f32,
}

/// One texture, as large as its file has it.
struct Texture {
    size: [u32; 2],
    texels: Vec<Rgb>,
}

impl Canvas<'_> {
    /// The material with the textures and numbers of `change`, which stands at `place`; files are sought from the
    /// folder of that. Textures of several sizes are brought to the largest width and height. Adds what was
    /// mended to `warnings`.
    ///
    /// # Errors
    /// `Io` for a file that is not there, `Unsupported` for one of another kind, `Invalid` for one that is broken
    /// or too large, and for keys and texels that the material cannot have.
    pub fn paint(&self, change: &MaterialState, place: &Place, warnings: &mut Vec<String>) -> Result<Paint> {
        let brdf = self.brdf.replaced(change, self.name, place)?;
        let mut textures = Vec::new();
        for layer in Layer::ALL {
            let Some(file) = change.textures.get(layer.key(brdf.model())) else { continue };
            let path = self.locate(file, place)?;
            textures.push((layer, self.read(&path, layer, warnings)?));
        }
        let size = [0, 1].map(|k| textures.iter().map(|(_, texture)| texture.size[k]).fold(1, u32::max));
        let mut paint = Paint::uniform(&brdf, size);
        paint.replaces_texture = textures.iter().any(|(layer, _)| *layer == Layer::Colour);
        for (layer, texture) in textures {
            paint.set(layer, texture.size, &texture.texels);
        }
        paint.validate(self.sharpest, self.name, place)?;
        Ok(paint)
    }

    fn locate(&self, file: &str, place: &Place) -> Result<PathBuf> {
        let folder = place.file.parent().unwrap_or(Path::new(""));
        let path = folder.join(file);
        if path.exists() {
            return Ok(path);
        }
        let remedy = nearest_file(folder, Path::new(file))
            .map_or("correct the path or add the file".to_owned(), |meant| {
                format!("did you mean `{meant}`?")
            });
        let reason = format!("material `{}`: no such file: `{}`; {remedy}", self.name, plain(file));
        Err(Error::io(place, IoError::new(ErrorKind::NotFound, reason)))
    }

    fn read(&self, path: &Path, layer: Layer, warnings: &mut Vec<String>) -> Result<Texture> {
        let place = Place::file(path);
        if has_extension(path, "exr") {
            return exact(path, &place);
        }
        if !["png", "jpg", "jpeg"].iter().any(|ending| has_extension(path, ending)) {
            return Err(Error::unsupported(
                &place,
                "not a texture this version reads; it reads .png, .jpg and .exr, convert it",
            ));
        }
        let picture = decode(&read_regular(path, MAX_FILE_BYTES, "scale the picture down")?, &place)?;
        Ok(self.meant(picture, layer, &place, warnings))
    }

    /// The values that the texels of a picture stand for. Those that are too smooth are raised: black, of all
    /// colours, would be.
    fn meant(
        &self,
        picture: DynamicImage,
        layer: Layer,
        place: &Place,
        warnings: &mut Vec<String>,
    ) -> Texture {
        let model = self.brdf.model();
        let value = |code: u16| {
            let unit = f64::from(code) / f64::from(u16::MAX);
            let unit = if layer.is_colour(model) { linear_from_srgb_unit(unit) } else { unit };
            layer.from_unit(model, self.sharpest, unit as f32)
        };
        let values: Vec<f32> = (0..=u16::MAX).map(value).collect();
        let size = [picture.width(), picture.height()];
        let codes = picture.into_rgb16().into_raw();
        let codes = codes.as_chunks::<3>().0.iter();
        let mut texels: Vec<Rgb> = codes.map(|texel| texel.map(|code| values[usize::from(code)])).collect();
        if layer == Layer::Sharpness && model != Model::BlinnPhong {
            let too_smooth = texels.iter_mut().filter(|texel| texel.iter().any(|x| *x < self.sharpest));
            let raised = too_smooth.map(|texel| *texel = texel.map(|x| x.max(self.sharpest))).count();
            if raised > 0 {
                let (all, least, key) = (texels.len(), self.sharpest, layer.key(model));
                warnings.push(format!(
                    "{place}: raised {raised} of {all} texels to {key} {least}, the least of `{}`",
                    self.name
                ));
            }
        }
        Texture { size, texels }
    }
}

/// The values of an OpenEXR file.
fn exact(path: &Path, place: &Place) -> Result<Texture> {
    expect_kind(path, place)?;
    let sizes = Sizes { bounded: expect_small, whole: expect_small };
    let (size, texels, _) = open_exr::picture(path, place, &sizes)?;
    if let Some(index) = texels.iter().position(|texel| !texel.iter().all(|x| x.is_finite())) {
        let [x, y] = [index as u32 % size[0], index as u32 / size[0]];
        let reason = "is not finite; save numbers";
        return Err(Error::invalid(
            &place.part(format!("texel ({x}, {y}) of {} × {}", size[0], size[1])),
            reason,
        ));
    }
    Ok(Texture { size, texels })
}

/// Decodes a PNG or JPEG, whatever its name says. Its sizes are capped before its texels are allocated.
fn decode(bytes: &[u8], place: &Place) -> Result<DynamicImage> {
    let format = image::guess_format(bytes).ok();
    let Some(format) = format.filter(|format| matches!(format, ImageFormat::Png | ImageFormat::Jpeg)) else {
        return Err(Error::invalid(place, "is neither PNG nor JPEG, though its name says so; save it again"));
    };
    let mut reader = ImageReader::with_format(Cursor::new(bytes), format);
    let mut limits = Limits::default();
    (limits.max_image_width, limits.max_image_height) = (Some(MAX_PAINT_SIDE), Some(MAX_PAINT_SIDE));
    // Four channels of 16 bits, and copies while they are decoded.
    limits.max_alloc = Some(4 * 8 * u64::from(MAX_PAINT_SIDE).pow(2));
    reader.limits(limits);
    let picture = reader.decode().map_err(|error| match error {
        ImageError::Limits(_) => too_large("too many texels", place),
        _ => Error::invalid(
            place,
            format!("broken picture ({}); save it again", error.to_string().replace('\n', " ")),
        ),
    })?;
    expect_small(picture.width().into(), picture.height().into(), place)?;
    Ok(picture)
}

fn expect_small(width: u64, height: u64, place: &Place) -> Result<()> {
    let is_small = [width, height].iter().all(|side| (1..=u64::from(MAX_PAINT_SIDE)).contains(side));
    if is_small { Ok(()) } else { Err(too_large(&format!("{width} × {height} texels"), place)) }
}

fn too_large(what: &str, place: &Place) -> Error {
    Error::invalid(place, format!("{what}, 1 to {MAX_PAINT_SIDE} a side are read; scale the picture down"))
}

#[cfg(test)]
mod tests;
