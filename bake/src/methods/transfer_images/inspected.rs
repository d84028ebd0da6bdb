//! Transfer images: what they are of, every value by fragment as arrays, and every light path as a picture.

use crate::inspected::out::{Out, file_name_part};
use crate::inspected::words::{grouped, list, many, pixels};
use crate::inspected::{Described, Facts, Inspected};
use relume_formats::container::{Kind, Stored};
use relume_formats::kinds::transfer_images::{FirstReflection, Head, Image, Meta, Slot, TransferImages};
use relume_formats::state::Rgb;
use relume_formats::{Error, Place, Result};
use serde::Serialize;
use serde_json::{Value, json};
use std::path::Path;

/// See there.
pub(super) const INSPECTED: Inspected = Inspected { kind: Kind::TransferImages, describe, export };

#[derive(Serialize)]
struct Details {
    size: [u32; 2],
    bases: u32,
    chromaticity: Option<Rgb>,
    samples: u32,
    seed: u64,
    rgb_images: usize,
    single_channel_images: usize,
    /// Of the RGB images, those of third and later reflections.
    #[serde(skip_serializing_if = "Option::is_none")]
    later_images: Option<usize>,
    fragments: usize,
    classes: Vec<ClassInfo>,
}

/// The fragments of one class.
#[derive(Serialize)]
struct ClassInfo {
    /// The editable material; `None` for everything fixed.
    material: Option<String>,
    fragments: usize,
}

fn describe(path: &Path) -> Result<Described> {
    let details = Details::of(&TransferImages::open(path)?.read_first(Head::decode)?);
    Ok(Described { facts: details.facts(), details: Box::new(details) })
}

impl Details {
    fn of(head: &Head) -> Self {
        let layout = head.layout();
        let rgb_images = layout.slots.iter().filter(|s| s.rgb).count();
        let fragments_of = |class: usize| head.class.iter().filter(|c| usize::from(**c) == class).count();
        let materials = head.meta.materials.iter().cloned().map(Some).chain([None]);
        Self {
            size: head.meta.size,
            bases: head.meta.bases,
            chromaticity: head.meta.chromaticity,
            samples: head.meta.samples,
            seed: head.meta.seed,
            rgb_images,
            single_channel_images: layout.slots.len() - rgb_images,
            later_images: head.later.as_ref().map(|later| later.images().count(later.textures.len())),
            fragments: head.pixel.len(),
            classes: materials
                .enumerate()
                .map(|(class, material)| ClassInfo { material, fragments: fragments_of(class) })
                .collect(),
        }
    }

    fn facts(&self) -> Facts {
        let Self {
            size,
            bases,
            chromaticity,
            samples,
            seed,
            rgb_images,
            single_channel_images,
            later_images,
            fragments,
            classes,
        } = self;
        let class = |c: &ClassInfo| {
            format!("{} {}", c.material.as_deref().unwrap_or("(fixed)"), grouped(c.fragments as u64))
        };
        vec![
            (
                "size",
                format!(
                    "{}, {} a pixel, seed {seed}",
                    pixels(*size),
                    many(*samples as usize, "sample", "samples")
                ),
            ),
            ("bases", bases.to_string()),
            (
                "light",
                chromaticity.map_or("of several colours".to_owned(), |c| format!("of one colour, {c:?}")),
            ),
            (
                "images",
                format!(
                    "{rgb_images} RGB, {single_channel_images} single-channel{}",
                    later_images
                        .map_or_else(String::new, |n| format!(", {n} of third and later reflections"))
                ),
            ),
            ("fragments", format!("{}: {}", grouped(*fragments as u64), list(classes.iter().map(class)))),
        ]
    }
}

const EDITABLE_ARRAY: &str = "transfer_editable.npy";
const FIXED_ARRAY: &str = "transfer_fixed.npy";

/// The fragments that an image is of.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
enum Surface {
    Editable,
    Fixed,
}

/// One light path seen on one group of fragments.
#[derive(Serialize)]
struct LightPath {
    slot: usize,
    surface: Surface,
    /// The picture, fragments summed into pixels.
    file: String,
    /// The basis worn by the surface that the eye sees; fixed surfaces wear their own material.
    eye_basis: Option<usize>,
    first: Value,
    channels: &'static [&'static str],
    /// Factor on the stored halves; arrays and pictures have it multiplied in.
    scale: f32,
    array: &'static str,
    /// Row of the array that holds the first channel; the others follow.
    first_row: usize,
}

/// `fragments_*.npy`, `transfer_editable.npy` and `transfer_fixed.npy` [rows, fragments], a picture for every
/// light path, `transfer-images.json`.
fn export(path: &Path, out: &mut Out) -> Result<()> {
    let images = &TransferImages::read_file(path)?;
    let head = &images.head;
    let fragments = head.pixel.len();
    out.npy("fragments_pixel.npy", &[fragments], head.pixel.iter().copied())?;
    out.npy("fragments_class.npy", &[fragments], head.class.iter().copied())?;
    out.npy("fragments_coverage.npy", &[fragments], head.coverage.iter().map(|c| c.to_f32()))?;
    let by_slot = by_slot(images);
    let editable = paths(head, Surface::Editable);
    let fixed = paths(head, Surface::Fixed);
    for paths in [&editable, &fixed] {
        array(paths, head, &by_slot, out)?;
        paths.iter().try_for_each(|path| picture(path, head, &by_slot, out))?;
    }
    out.json("transfer-images.json", &metadata(head, &editable, &fixed))
}

/// The images in the order of the layout; a file read back has every one of them.
fn by_slot(images: &TransferImages) -> Vec<&Image> {
    let mut sorted: Vec<_> = images.images.iter().collect();
    sorted.sort_by_key(|image| image.slot);
    sorted
}

/// Every light path that `surface` has fragments for.
fn paths(head: &Head, surface: Surface) -> Vec<LightPath> {
    if range(head, surface).is_empty() {
        return Vec::new();
    }
    let mut first_row = 0;
    let mut paths = Vec::new();
    for (slot, (meaning, &scale)) in head.layout().slots.iter().zip(&head.scales).enumerate() {
        let first = match surface {
            Surface::Editable => meaning.first,
            Surface::Fixed => match meaning.fixed {
                Some(first) => first,
                None => continue,
            },
        };
        paths.push(LightPath {
            slot,
            surface,
            file: file_name(slot, surface, meaning, first, &head.meta),
            eye_basis: (surface == Surface::Editable).then_some(meaning.eye_basis),
            first: first_json(first, &head.meta),
            channels: if meaning.rgb { &["R", "G", "B"] } else { &["Y"] },
            scale,
            array: if surface == Surface::Editable { EDITABLE_ARRAY } else { FIXED_ARRAY },
            first_row,
        });
        first_row += meaning.channels();
    }
    paths
}

/// The fragments of `surface`.
fn range(head: &Head, surface: Surface) -> std::ops::Range<usize> {
    let editable = head.meta.editable_fragments as usize;
    match surface {
        Surface::Editable => 0..editable,
        Surface::Fixed => editable..head.pixel.len(),
    }
}

fn file_name(slot: usize, surface: Surface, meaning: &Slot, first: FirstReflection, meta: &Meta) -> String {
    let eye = match surface {
        Surface::Editable => format!("eye-b{}", meaning.eye_basis),
        Surface::Fixed => "fixed".to_owned(),
    };
    let name = |material: usize| file_name_part(meta.materials.get(material).map_or("", String::as_str));
    let first = match first {
        FirstReflection::None => "direct".to_owned(),
        FirstReflection::Fixed => "first-fixed".to_owned(),
        FirstReflection::Later { node } => format!("later-{node}"),
        FirstReflection::Editable { material, basis } => format!("first-{}-b{basis}", name(material)),
        FirstReflection::LaterLobe { material, basis, node } => {
            format!("later-{}-b{basis}-{node}", name(material))
        }
    };
    format!("image_{slot:04}_{eye}_{first}.exr")
}

fn first_json(first: FirstReflection, meta: &Meta) -> Value {
    match first {
        FirstReflection::None => json!({ "on": "none" }),
        FirstReflection::Fixed => json!({ "on": "fixed" }),
        FirstReflection::Later { node } => json!({ "on": "later", "node": node }),
        FirstReflection::Editable { material, basis } => {
            json!({ "on": "editable", "material": meta.materials.get(material), "basis": basis })
        }
        FirstReflection::LaterLobe { material, basis, node } => {
            let material = meta.materials.get(material);
            json!({ "on": "later-lobe", "material": material, "basis": basis, "node": node })
        }
    }
}

/// Scaled values of one channel of a path, fragment by fragment.
fn channel<'a>(
    path: &LightPath,
    channel: usize,
    head: &Head,
    by_slot: &[&'a Image],
) -> impl Iterator<Item = f32> + use<'a> {
    let range = range(head, path.surface);
    // A slot that serves fixed fragments holds all of them, another only the editable ones.
    let values: &'a [_] = by_slot.get(path.slot).map_or(&[], |image| &image.values);
    let stride = values.len() / path.channels.len();
    let scale = path.scale;
    values.iter().skip(channel * stride + range.start).take(range.len()).map(move |v| v.to_f32() * scale)
}

fn array(paths: &[LightPath], head: &Head, by_slot: &[&Image], out: &mut Out) -> Result<()> {
    let Some(first) = paths.first() else { return Ok(()) };
    let rows = paths.iter().map(|p| p.channels.len()).sum();
    let values =
        paths.iter().flat_map(|p| (0..p.channels.len()).flat_map(move |c| channel(p, c, head, by_slot)));
    out.npy(first.array, &[rows, range(head, first.surface).len()], values)
}

fn picture(path: &LightPath, head: &Head, by_slot: &[&Image], out: &mut Out) -> Result<()> {
    let pixels = head.meta.size.iter().map(|n| *n as usize).product();
    let of_fragments = head.pixel.get(range(head, path.surface)).unwrap_or_default();
    let mut planes = Vec::new();
    for (index, name) in path.channels.iter().enumerate() {
        let mut plane = vec![0.0; pixels];
        for (&pixel, value) in of_fragments.iter().zip(channel(path, index, head, by_slot)) {
            *plane.get_mut(pixel as usize).ok_or_else(|| {
                Error::invalid(&Place::file(&path.file), "a fragment lies outside the film")
            })? += value;
        }
        planes.push((*name, plane));
    }
    let channels: Vec<_> = planes.iter().map(|(name, plane)| (*name, plane.as_slice())).collect();
    out.exr(&path.file, head.meta.size, &channels)
}

fn metadata(head: &Head, editable: &[LightPath], fixed: &[LightPath]) -> Value {
    let Meta { size, materials, bases, chromaticity, samples, seed, editable_fragments } = &head.meta;
    let mut told = json!({
        "kind": "transfer-images",
        "meaning": "radiance of a fragment = sum over its paths of value * coefficients; on editable surfaces the coefficients are those \
            of the surface's own material on eye_basis and of the first reflection's material on its basis, on fixed surfaces the latter \
            alone; a single channel Y is multiplied by the chromaticity; a pixel is the sum of its fragments",
        "unit": "W/(sr m^2) per unit coefficient, linear Rec. 709",
        "size": size,
        "materials": materials,
        "bases": bases,
        "chromaticity": chromaticity,
        "samples": samples,
        "seed": seed,
        "fragments": {
            "editable": editable_fragments,
            "fixed": head.pixel.len() - *editable_fragments as usize,
            "pixel": "fragments_pixel.npy: y * width + x, editable fragments first",
            "class": "fragments_class.npy: index into materials, or their number for everything fixed",
            "coverage": "fragments_coverage.npy: share of the pixel, multiplied into all values already",
        },
        "paths": editable.iter().chain(fixed).collect::<Vec<_>>(),
    });
    if let (Some(later), Some(told)) = (&head.later, told.as_object_mut()) {
        told.insert("later".to_owned(), json!(later));
        told.insert("later_nodes".to_owned(), json!(later.node_albedos()));
        if later.lobes > 0 {
            told.insert("later_lobe_nodes".to_owned(), json!(later.lobe_nodes()));
        }
    }
    told
}
