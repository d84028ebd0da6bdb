//! Files of environment maps, as scenes and players are given them: Radiance `.hdr` and OpenEXR `.exr`,
//! equirectangular, in whatever primaries they name.

pub(crate) mod open_exr;
mod primaries;
mod radiance;
mod signatures;

use crate::basis::EquirectMap;
use crate::state::Rgb;
use crate::{Error, Place, Result, has_extension, open_regular};
use primaries::convert;
use std::io::{BufReader, Read as _};
use std::path::Path;

/// Largest map, in texels: 8192 × 4096. While it is read there are two copies of 12 bytes each, and a file of
/// a few bytes may claim to be so large.
const MAX_TEXELS: u64 = 1 << 25;

/// What an infinite texel becomes: the largest half float, whose overflow it was.
const LARGEST_HALF: f32 = 65_504.0;

/// Whether `path` is called as environment maps are, so that it names a file.
pub fn is_named_so(path: &Path) -> bool {
    ["hdr", "exr"].into_iter().any(|extension| has_extension(path, extension))
}

/// Reads the map at `path`, in linear Rec. 709. Adds what was mended to `warnings`.
///
/// # Errors
/// `Io` for a file that is not there, `Invalid` for one that is broken, too large or no equirectangular map,
/// `Unsupported` for what this version does not read.
pub fn read_map(path: &Path, warnings: &mut Vec<String>) -> Result<EquirectMap> {
    let place = Place::file(path);
    expect_kind(path, &place)?;
    let (mut map, primaries) = if has_extension(path, "hdr") {
        radiance::read(BufReader::new(open_regular(path)?), &place)?
    } else if has_extension(path, "exr") {
        open_exr::read(path, &place)?
    } else {
        return Err(Error::unsupported(
            &place,
            "not an environment map this version reads; it reads .hdr and .exr, convert it",
        ));
    };
    let taken = negative_light(&map);
    let (mended, count) = (mend(&mut map.texels), map.texels.len());
    if mended > 0 {
        let gain = gain_note(taken, light(&map, |x| x));
        warnings.push(format!(
            "{place}: mended {mended} of {count} texels, which are negative, infinite or NaN{gain}"
        ));
    }
    match primaries.filter(|primaries| !primaries.are_rec_709()).map(|primaries| primaries.rec_709_from_rgb())
    {
        None => {}
        Some(None) => warnings.push(format!(
            "{place}: its chromaticities span no colour space; its colours are taken for Rec. 709"
        )),
        Some(Some(rec_709_from_rgb)) => {
            let clipped = convert(&mut map.texels, &rec_709_from_rgb);
            if clipped > 0 {
                warnings.push(format!("{place}: clipped the colours of {clipped} of {count} texels, which Rec. 709 does not reach"));
            }
        }
    }
    Ok(map)
}

/// Refuses a file that is of another kind than its name says, by what it seems to be.
pub(crate) fn expect_kind(path: &Path, place: &Place) -> Result<()> {
    let (is_of_kind, kind): (fn(&[u8]) -> bool, _) = if has_extension(path, "exr") {
        (|start| start.starts_with(&[0x76, 0x2f, 0x31, 0x01]), "OpenEXR")
    } else if has_extension(path, "hdr") {
        (|start| start.starts_with(b"#?"), "Radiance")
    } else {
        return Ok(());
    };
    let mut start = Vec::new();
    let file = open_regular(path)?;
    file.take(signatures::LENGTH as u64).read_to_end(&mut start).map_err(|e| Error::io(place, e))?;
    let is_cut = |start: &[u8]| start.len() < 4 && !start.is_empty();
    match is_of_kind(&start) || is_cut(&start) {
        true => Ok(()),
        false => Err(Error::invalid(
            place,
            format!("is no {kind} file, though its name says so, but {}", signatures::seems(&start)),
        )),
    }
}

/// The sum of what `value` makes of the channels of all texels, each by its solid angle.
fn light(map: &EquirectMap, value: impl Fn(f64) -> f64) -> f64 {
    let row = |row: &[Rgb]| row.as_flattened().iter().map(|x| value(f64::from(*x))).sum::<f64>();
    let height = f64::from(map.height);
    let solid_angle = |y: usize| ((y as f64 + 0.5) / height * std::f64::consts::PI).sin();
    map.texels.chunks(map.width as usize).enumerate().map(|(y, texels)| solid_angle(y) * row(texels)).sum()
}

/// The light, as a positive number, that finite negative values take away.
fn negative_light(map: &EquirectMap) -> f64 {
    light(map, |x| if x.is_finite() { (-x).max(0.0) } else { 0.0 })
}

/// What to tell of a map that has the light `after` without the negative values that took `taken` away:
/// nothing up to a thousandth.
fn gain_note(taken: f64, after: f64) -> String {
    let before = after - taken;
    if taken <= 1e-3 * before {
        String::new()
    } else if before > 0.0 {
        format!("; that adds {:.1} % to its light", 100.0 * taken / before)
    } else {
        "; with its negative values it has no light in all".to_owned()
    }
}

/// Sets negative and NaN values to 0 and infinite ones to the largest half float. Returns the number of
/// texels concerned.
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

/// Caps the sizes before texels are allocated, and refuses pictures that are no map of a whole sphere.
fn expect_equirect(width: u64, height: u64, place: &Place) -> Result<()> {
    expect_bounded(width, height, place)?;
    // Programs that scale round to whole texels, so one of them may be missing or too many; in a small map
    // that matters.
    let off = width.abs_diff(2 * height);
    if off == 0 || (off <= 2 && width >= 32) {
        return Ok(());
    }
    let looks_like = SHAPES
        .iter()
        .find(|([w, h], _)| width * h == height * w)
        .map(|(_, what)| format!(", {what}"))
        .unwrap_or_default();
    let reason = format!(
        "{width} × {height} texels{looks_like}; an equirectangular map is twice as wide as high, convert it to one"
    );
    Err(Error::unsupported(place, reason))
}

/// Shapes of other maps of a sphere, and of pictures that are none.
const SHAPES: [([u64; 2], &str); 7] = [
    ([1, 1], "square as mirror balls and angular probes are"),
    ([4, 3], "as photographs are, or a cube map's horizontal cross"),
    ([3, 4], "as photographs are, or a cube map's vertical cross"),
    ([6, 1], "as a strip of a cube map's faces"),
    ([1, 6], "as a strip of a cube map's faces"),
    ([3, 2], "as photographs are, or two rows of a cube map's faces"),
    ([2, 3], "as photographs are, or two columns of a cube map's faces"),
];

fn expect_bounded(width: u64, height: u64, place: &Place) -> Result<()> {
    if width == 0 || height == 0 || width.saturating_mul(height) > MAX_TEXELS {
        return Err(Error::invalid(
            place,
            format!("{width} × {height} texels, expected 1 to {MAX_TEXELS} in all; scale it down"),
        ));
    }
    Ok(())
}

#[cfg(test)]
mod tests;
