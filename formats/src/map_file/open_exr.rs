//! OpenEXR pictures: which part and layer of a file is the map or texture, and where its texels lie on the
//! sphere or in the square.
//!
//! The display window is the whole of it. Of a data window that differs, what lies outside is cropped and
//! what is missing is black. `whiteLuminance` tells nothing about light in our units and is left alone, as
//! other renderers do: `gain` says how bright a map is.

use super::primaries::Primaries;
use super::{expect_bounded, expect_equirect};
use crate::basis::EquirectMap;
use crate::state::Rgb;
use crate::{Error, Place, Result, open_regular};
use exr::meta::attribute::EnvironmentMap;
use exr::meta::header::Header;
use exr::prelude::{IntegerBounds, MetaData, ReadChannels, ReadLayers, ReadSpecificChannel as _, Text, Vec2};
use std::collections::BTreeSet;
use std::fs::File;
use std::io::{BufReader, Read};
use std::path::Path;

/// Most channels that a message lists.
const LISTED: usize = 12;

/// Channels of colour beside a luminance.
const CHROMA: [&str; 2] = ["ry", "by"];

/// The channels that make a picture, one of many in a file.
#[derive(Debug, Clone)]
struct Layer {
    /// Which part of the file.
    part: usize,
    /// The part's and the layer's name, empty if neither has one.
    name: String,
    channels: Channels,
}

#[derive(Debug, Clone)]
enum Channels {
    Colour([Text; 3]),
    Grey(Text),
}

/// What sizes pictures may have, width and height.
pub(crate) struct Sizes {
    /// Of the texels that a file has.
    pub bounded: fn(u64, u64, &Place) -> Result<()>,
    /// Of the whole picture.
    pub whole: fn(u64, u64, &Place) -> Result<()>,
}

/// Reads the map at `path`, and the primaries that it names.
pub(super) fn read(path: &Path, place: &Place) -> Result<(EquirectMap, Option<Primaries>)> {
    let maps = Sizes { bounded: expect_bounded, whole: expect_equirect };
    let ([width, height], texels, primaries) = picture(path, place, &maps)?;
    Ok((EquirectMap { width, height, texels }, primaries))
}

/// Width and height of a picture, its texels row by row, and the primaries that it names.
type Picture = ([u32; 2], Vec<Rgb>, Option<Primaries>);

/// Reads the picture at `path`; a grey one has three channels that are alike.
pub(crate) fn picture(path: &Path, place: &Place, sizes: &Sizes) -> Result<Picture> {
    let open = || open_regular(path).map(BufReader::new);
    expect_flat(&mut open()?, place)?;
    let meta = MetaData::read_from_buffered(open()?, false).map_err(|e| refused(e, place))?;
    meta.headers.iter().try_for_each(|h| {
        (sizes.bounded)(h.layer_size.width() as u64, h.layer_size.height() as u64, place)
    })?;
    let layer = choose(&meta.headers, place)?;
    let header = meta
        .headers
        .get(layer.part)
        .ok_or_else(|| Error::invalid(place, "not an OpenEXR picture: it has no picture"))?;
    let window = check(header, place, sizes)?;
    let canvas = Canvas::new(header, window, place)?;
    let texels = match layer.channels {
        Channels::Colour([r, g, b]) => colour(open()?, canvas, [r, g, b]),
        Channels::Grey(y) => grey(open()?, canvas, y),
    };
    let chromaticities = header.shared_attributes.chromaticities.map(|c| {
        let [red, green, blue, white] =
            [c.red, c.green, c.blue, c.white].map(|xy| [f64::from(xy.0), f64::from(xy.1)]);
        Primaries { red, green, blue, white }
    });
    let size = [canvas.width as u32, canvas.height as u32];
    Ok((size, texels.map_err(|e| refused(e, place))?, chromaticities))
}

/// Bit 11 of the file's flags, which follow the signature and the version.
const DEEP: u8 = 1 << (11 - 8);

/// The library knows of no more than flat pictures, and says of others what it happens to trip over.
fn expect_flat(file: &mut impl Read, place: &Place) -> Result<()> {
    let mut start = [0; 8];
    match file.read_exact(&mut start) {
        Ok(()) if start.starts_with(&[0x76, 0x2f, 0x31, 0x01]) && start[5] & DEEP != 0 => {
            Err(Error::unsupported(
                place,
                "holds deep data, many samples a texel; flatten it and save it as plain RGB scan lines",
            ))
        }
        _ => Ok(()),
    }
}

/// What can be told before texels are read; returns the display window.
fn check(header: &Header, place: &Place, sizes: &Sizes) -> Result<IntegerBounds> {
    if header.own_attributes.environment_map == Some(EnvironmentMap::Cube) {
        return Err(Error::unsupported(
            place,
            "its envmap attribute is cube, expected latlong; convert it (exrenvmap -l in.exr out.exr)",
        ));
    }
    if header.channels.list.iter().any(|channel| channel.sampling != Vec2(1, 1)) {
        let reason = "some of its channels have fewer samples than texels; save it as plain RGB, every channel at full resolution";
        return Err(Error::unsupported(place, reason));
    }
    let window = header.shared_attributes.display_window;
    (sizes.whole)(window.size.width() as u64, window.size.height() as u64, place)?;
    Ok(window)
}

/// Where the texels of a data window lie in the map.
#[derive(Clone, Copy)]
struct Canvas {
    width: usize,
    height: usize,
    /// Of the data window's first texel; may be negative.
    offset: [i64; 2],
}

impl Canvas {
    fn new(header: &Header, window: IntegerBounds, place: &Place) -> Result<Self> {
        let (data, size) = (header.own_attributes.layer_position, header.layer_size);
        let offset = [
            i64::from(data.0) - i64::from(window.position.0),
            i64::from(data.1) - i64::from(window.position.1),
        ];
        let (width, height) = (window.size.width(), window.size.height());
        let meets =
            |offset: i64, length: usize, whole: usize| offset < whole as i64 && offset + length as i64 > 0;
        if !(meets(offset[0], size.0, width) && meets(offset[1], size.1, height)) {
            return Err(Error::invalid(
                place,
                "its data window lies outside its display window, so that nothing is left; save it uncropped",
            ));
        }
        Ok(Self { width, height, offset })
    }

    fn black(&self) -> Vec<Rgb> {
        vec![[0.0; 3]; self.width * self.height]
    }

    fn set(&self, texels: &mut [Rgb], at: Vec2<usize>, value: Rgb) {
        let place = |at: usize, offset: i64, length: usize| {
            usize::try_from(at as i64 + offset).ok().filter(|x| *x < length)
        };
        let (x, y) = (place(at.0, self.offset[0], self.width), place(at.1, self.offset[1], self.height));
        if let Some(texel) = x.zip(y).and_then(|(x, y)| texels.get_mut(y * self.width + x)) {
            *texel = value;
        }
    }
}

fn colour(file: BufReader<File>, canvas: Canvas, [r, g, b]: [Text; 3]) -> exr::error::Result<Vec<Rgb>> {
    let channels = exr::prelude::read()
        .no_deep_data()
        .largest_resolution_level()
        .specific_channels()
        .required(r)
        .required(g)
        .required(b);
    let layer = channels.collect_pixels(
        move |_, _| canvas.black(),
        move |texels: &mut Vec<Rgb>, at: Vec2<usize>, (r, g, b): (f32, f32, f32)| {
            canvas.set(texels, at, [r, g, b])
        },
    );
    Ok(layer.first_valid_layer().all_attributes().from_buffered(file)?.layer_data.channel_data.pixels)
}

fn grey(file: BufReader<File>, canvas: Canvas, y: Text) -> exr::error::Result<Vec<Rgb>> {
    let channels =
        exr::prelude::read().no_deep_data().largest_resolution_level().specific_channels().required(y);
    let layer = channels.collect_pixels(
        move |_, _| canvas.black(),
        move |texels: &mut Vec<Rgb>, at: Vec2<usize>, (y,): (f32,)| canvas.set(texels, at, [y; 3]),
    );
    Ok(layer.first_valid_layer().all_attributes().from_buffered(file)?.layer_data.channel_data.pixels)
}

/// The one picture of the file: that of channels R, G and B without a layer's name, else the one layer that
/// has them, else the one that is grey.
fn choose(headers: &[Header], place: &Place) -> Result<Layer> {
    let layers: Vec<Layer> =
        headers.iter().enumerate().flat_map(|(part, header)| layers_of(part, header)).collect();
    let colour: Vec<&Layer> =
        layers.iter().filter(|layer| matches!(layer.channels, Channels::Colour(_))).collect();
    let grey: Vec<&Layer> =
        layers.iter().filter(|layer| matches!(layer.channels, Channels::Grey(_))).collect();
    for kind in [&colour, &grey] {
        let plain: Vec<&Layer> = kind.iter().copied().filter(|layer| layer.channels.are_plain()).collect();
        match (&plain[..], &kind[..]) {
            ([one], _) | ([], [one]) => return Ok((*one).clone()),
            ([], []) => {}
            ([], many) | (many, _) => return Err(ambiguous(many, place)),
        }
    }
    Err(no_picture(headers, place))
}

impl Channels {
    /// Whether no layer's name stands before theirs.
    fn are_plain(&self) -> bool {
        let (Self::Colour([name, ..]) | Self::Grey(name)) = self;
        split(name).0.is_empty()
    }
}

/// A channel's layer, empty if it has none, and its own name in small letters.
fn split(name: &Text) -> (String, String) {
    let name = name.to_string();
    let (layer, channel) = name.rsplit_once('.').unwrap_or(("", &name));
    (layer.to_owned(), channel.to_lowercase())
}

/// The pictures of one part of a file.
fn layers_of(part: usize, header: &Header) -> Vec<Layer> {
    let channels: Vec<_> =
        header.channels.list.iter().map(|channel| (split(&channel.name), &channel.name)).collect();
    let names: BTreeSet<&str> = channels.iter().map(|((layer, _), _)| layer.as_str()).collect();
    let part_name = header.own_attributes.layer_name.as_ref().map(Text::to_string).unwrap_or_default();
    let layer = |name: &str| {
        let find = |wanted: &[&str]| {
            let found = channels
                .iter()
                .find(|((layer, channel), _)| layer == name && wanted.contains(&channel.as_str()));
            found.map(|(_, name)| (*name).clone())
        };
        let colour = find(&["r", "red"]).zip(find(&["g", "green"])).zip(find(&["b", "blue"]));
        let channels = match (colour, find(&["y"]), find(&CHROMA)) {
            (Some(((r, g), b)), ..) => Channels::Colour([r, g, b]),
            (None, Some(y), None) => Channels::Grey(y),
            _ => return None,
        };
        let name = [part_name.as_str(), name]
            .into_iter()
            .filter(|name| !name.is_empty())
            .collect::<Vec<_>>()
            .join(".");
        Some(Layer { part, name, channels })
    };
    names.into_iter().filter_map(layer).collect()
}

fn ambiguous(layers: &[&Layer], place: &Place) -> Error {
    let names: Vec<String> = layers.iter().take(LISTED).map(|layer| format!("`{}`", layer.name)).collect();
    let reason = format!(
        "has {} pictures, in the layers {}; save the one that is meant as a file of its own",
        layers.len(),
        names.join(", ")
    );
    Error::unsupported(place, reason)
}

fn no_picture(headers: &[Header], place: &Place) -> Error {
    let channels =
        || headers.iter().flat_map(|header| header.channels.list.iter().map(|channel| &channel.name));
    if channels().any(|name| CHROMA.contains(&split(name).1.as_str())) {
        let reason = "its texels are luminance and chroma (Y, RY, BY), this version reads R, G and B; save it as plain RGB";
        return Error::unsupported(place, reason);
    }
    let names: Vec<String> = channels().take(LISTED).map(|name| format!("`{name}`")).collect();
    Error::invalid(
        place,
        format!(
            "no layer has R, G and B, its channels are {}; save the picture as plain RGB",
            names.join(", ")
        ),
    )
}

fn refused(error: exr::error::Error, place: &Place) -> Error {
    match error {
        // How the library says that the file ends too early.
        exr::error::Error::Invalid(what) if what == "reference to missing bytes" => {
            Error::invalid(place, "not an OpenEXR picture, or cut short; save it again")
        }
        exr::error::Error::Io(e) => Error::io(place, e),
        exr::error::Error::NotSupported(what) => {
            Error::unsupported(place, format!("{what}; save it as plain RGB scan lines"))
        }
        other => Error::invalid(place, format!("not an OpenEXR picture ({other}); save it again")),
    }
}

#[cfg(test)]
mod tests;
