//! Kind `transfer-images`, version 0: one image per light path × BRDF basis, by fragment (thesis §4.1.3, table 4-1).
//!
//! | section              | type | shape                 | content |
//! |----------------------|------|-----------------------|---------|
//! | `meta`               | u8   | record                | [`Meta`]; in bakes of all reflections [`Later`] behind it |
//! | `fragments/pixel`    | u32  | [fragments]           | y·width + x |
//! | `fragments/class`    | u16  | [fragments]           | index of the editable material, or their number for everything fixed |
//! | `fragments/coverage` | f16  | [fragments]           | share of the pixel's film samples that fell on the class, above 0; of a pixel 1 at most in all. The least half where the fixed class only shows what others emit |
//! | `scales`             | f32  | [slots]               | factor on the stored halves of each slot, a power of 2 up to [`MAX_SCALE`]; 0 for an all-zero slot |
//! | `image/NNNN`         | u16  | [1 + channels · fragments] | one slot of the [`Layout`]: a step, then halves in it, channel by channel, as [`codes`] has them; brightest slots first |
//!
//! A *fragment* is one class of material seen through one pixel. Values are weighted by coverage already, so a pixel's radiance is the plain
//! sum over its fragments and silhouettes stay antialiased for any materials. Fragments of editable materials come first, then the fixed
//! ones, each group sorted by (pixel, class). Slots that also serve fixed fragments hold all fragments, the others only the editable ones.
//! The largest half of a slot is from [`LARGEST_HALF`]/2 to [`LARGEST_HALF`] in size, which is what its scale is for. Slots of the diffuse basis alone
//! ([`Slot::is_positive`]) hold no value below 0; the others may, for basis functions are negative in places.
//!
//! Bakes of one or two reflections have nothing of [`Later`]; those of all have its images beside theirs, which are the same but for their rounding.
//!
//! Values are radiance in W/(sr·m²) per unit coefficient, except that single-channel slots hold it per unit of [`Meta::chromaticity`].

pub mod codes;
pub(crate) mod fragments;
mod later;
mod layout;

pub use codes::Neighbours;
pub use fragments::Fragments;
pub use later::{Later, MAX_ALBEDO, MAX_DEGREE, node_count};
pub use layout::{FirstReflection, LaterImages, Layout, Slot};

use super::names::fault_of_names;
use super::scene::{MAX_PIXELS, is_legal_size};
use crate::container::{Kind, Section, Sections, Stored, Writer};
use crate::error::{Error, Result};
use crate::kinds::brdf_basis::MAX_BASES;
use crate::state::Rgb;
use half::f16;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// Most editable materials that one bake may hold.
pub const MAX_MATERIALS: usize = 64;
/// Largest factor of a slot. A pixel is a sum over at most 65 fragments of 65,600 slots, each a half times
/// two coefficients of materials of at most 2·10⁴: with this factor that is below 2·10³⁸, still a number.
pub const MAX_SCALE: f32 = 1e18;
/// The largest stored half of an image: a power of two well below the largest half, so that scales are powers
/// of two and scaling is exact.
pub const LARGEST_HALF: f32 = 32_768.0;
/// Number of sections before the first image.
pub const HEAD_SECTIONS: usize = 5;

/// The small print.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Meta {
    /// Film size in pixels, width and height.
    pub size: [u32; 2],
    /// Names of the editable materials; a fragment's class is an index into this list.
    pub materials: Vec<String>,
    /// Number of bases, the diffuse one included.
    pub bases: u32,
    /// The one colour of all light, its largest channel 1; `None` if lights differ in colour, then every slot
    /// is RGB.
    pub chromaticity: Option<Rgb>,
    /// Film samples a pixel; the most in the mean of bakes that were to have no more noise than so much.
    pub samples: u32,
    /// Seed of the paths.
    pub seed: u64,
    /// Number of fragments of editable materials; they come first.
    pub editable_fragments: u32,
}

/// Everything but the images.
#[derive(Debug, Clone, PartialEq)]
pub struct Head {
    /// The small print.
    pub meta: Meta,
    /// In bakes of all reflections: what the images of three and more are of.
    pub later: Option<Later>,
    /// Pixel of each fragment.
    pub pixel: Vec<u32>,
    /// Class of each fragment.
    pub class: Vec<u16>,
    /// Coverage of each fragment, 0..=1.
    pub coverage: Vec<f16>,
    /// Factor of each slot.
    pub scales: Vec<f32>,
}

/// The stored halves of one slot.
#[derive(Debug, Clone, PartialEq)]
pub struct Image {
    /// Index into the layout's slots.
    pub slot: usize,
    /// Row-major [channels, fragments of the slot].
    pub values: Vec<f16>,
}

/// A whole file.
#[derive(Debug, Clone, PartialEq)]
pub struct TransferImages {
    /// Everything but the images. Shared, for a player keeps it while images come and go.
    pub head: Arc<Head>,
    /// The images in the order of the file, most important first.
    pub images: Vec<Image>,
}

impl Head {
    /// The meaning of the slots.
    pub fn layout(&self) -> Layout {
        let Meta { materials, bases, chromaticity, .. } = &self.meta;
        let later = self.later.as_ref().map(|later| later.images());
        Layout::new(materials.len(), *bases as usize, chromaticity.is_some(), later)
    }

    /// Number of fragments that `slot` holds values for.
    pub fn fragments_of(&self, slot: &Slot) -> usize {
        if slot.fixed.is_some() { self.pixel.len() } else { self.meta.editable_fragments as usize }
    }

    /// What predicts the values of images.
    pub fn neighbours(&self) -> Neighbours {
        Neighbours::new(self.meta.size[0], self.meta.editable_fragments as usize, (&self.pixel, &self.class))
    }

    /// Reads the sections before the first image.
    pub fn decode(sections: &mut Sections<'_>) -> Result<Self> {
        let section = sections.take("meta")?;
        let (meta, later) = small_print(&section)?;
        meta.validate(&section)?;
        let (materials, bases) = (meta.materials.len(), meta.bases as usize);
        section.expect(later.as_ref().and_then(|later| later.fault(materials, bases)))?;

        let Fragments { pixel, class, coverage } =
            Fragments::decode(sections, meta.size, materials, meta.editable_fragments as usize)?;

        let section = sections.take("scales")?;
        let scales = section.f32s()?;
        let head = Self { meta, later, pixel, class, coverage, scales };
        section.expect_shape(&[head.layout().slots.len() as u64])?;
        expect_scales(&section, &head.scales)?;
        Ok(head)
    }

    /// Reads one image section; `neighbours` are those of this head.
    pub fn decode_image(&self, layout: &Layout, neighbours: &Neighbours, section: &Section) -> Result<Image> {
        let slot = section
            .info
            .name
            .strip_prefix("image/")
            .and_then(|n| n.parse::<usize>().ok())
            .filter(|slot| *slot < layout.slots.len() && section.info.name == image_name(*slot))
            .ok_or_else(|| section.invalid("is no image of this layout"))?;
        let channels = layout.slots[slot].channels();
        section.expect_shape(&[1 + (channels * self.fragments_of(&layout.slots[slot])) as u64])?;
        let scale = self.scales.get(slot).copied().unwrap_or_default();
        let values = codes::read(section, channels, neighbours, scale)?;
        if layout.slots[slot].is_positive() && values.iter().any(|v| v.to_bits() > 0x8000) {
            return Err(section.invalid("radiance of diffuse paths is below 0"));
        }
        Ok(Image { slot, values })
    }
}

/// What the section `meta` holds: a record, or two. The first ends where the second begins, so that one is
/// never taken for the other.
fn small_print(section: &Section) -> Result<(Meta, Option<Later>)> {
    match section.record() {
        Ok(meta) => Ok((meta, None)),
        Err(error) => {
            let (meta, later) = section.record().map_err(|_| error)?;
            Ok((meta, Some(later)))
        }
    }
}

/// Fails unless factors on halves are what they may be.
pub(crate) fn expect_scales(section: &Section, scales: &[f32]) -> Result<()> {
    section.expect_at_most(scales, MAX_SCALE)?;
    if scales.iter().any(|s| *s < 0.0) {
        return Err(section.invalid("a scale is negative"));
    }
    // As f64 even the least f32 has its leading 1 in front of the mantissa.
    let is_power = |scale: f32| f64::from(scale).to_bits() << 12 == 0;
    let wrong = scales.iter().find(|scale| !is_power(**scale));
    section.expect(wrong.map(|scale| format!("scale {scale:e} is no power of 2")))
}

/// Name of the section that holds `slot`.
fn image_name(slot: usize) -> String {
    format!("image/{slot:04}")
}

impl Meta {
    fn validate(&self, section: &Section) -> Result<()> {
        if !is_legal_size(self.size) || self.samples == 0 {
            return Err(section.invalid(format!(
                "film size {:?} of {} samples is not one of 1 to {MAX_PIXELS} pixels",
                self.size, self.samples
            )));
        }
        if !(1..=MAX_MATERIALS).contains(&self.materials.len())
            || !(2..=MAX_BASES).contains(&(self.bases as usize))
        {
            return Err(section.invalid(format!(
                "{} materials and {} bases are out of range",
                self.materials.len(),
                self.bases
            )));
        }
        section.expect(fault_of_names("materials", self.materials.iter().map(String::as_str)))?;
        if self.chromaticity.is_some_and(|c| !c.iter().all(|v| (0.0..=1.0).contains(v)) || !c.contains(&1.0))
        {
            return Err(section.invalid("the chromaticity is outside 0..1, or has no channel of 1"));
        }
        Ok(())
    }
}

impl Stored for TransferImages {
    const KIND: Kind = Kind::TransferImages;
    const VERSION: u32 = 0;

    fn encode(&self, out: &mut Writer) -> Result<()> {
        let head = &self.head;
        match &head.later {
            None => out.record("meta", &head.meta)?,
            Some(later) => out.record("meta", &(&head.meta, later))?,
        }
        fragments::encode(out, (&head.pixel, &head.class, &head.coverage))?;
        out.f32s("scales", &[head.scales.len() as u64], &head.scales)?;
        let (layout, neighbours) = (head.layout(), head.neighbours());
        for image in &self.images {
            let channels = layout.slots[image.slot].channels();
            let stored = codes::written(&image.values, channels, &neighbours);
            out.u16s(&image_name(image.slot), &[stored.len() as u64], &stored)?;
        }
        Ok(())
    }

    fn decode(sections: &mut Sections<'_>) -> Result<Self> {
        let mut images = Vec::new();
        let head = for_each_image(sections, |image| images.push(image))?;
        Ok(Self { head: Arc::new(head), images })
    }

    fn check(sections: &mut Sections<'_>) -> Result<()> {
        Self::checked_head(sections).map(drop)
    }
}

impl TransferImages {
    /// Checks all sections, an image at a time, and returns the head.
    pub fn checked_head(sections: &mut Sections<'_>) -> Result<Head> {
        for_each_image(sections, drop)
    }
}

/// Reads head and images, one at a time. Names of sections differ, so as many images as slots are one of
/// each.
fn for_each_image(sections: &mut Sections<'_>, mut each: impl FnMut(Image)) -> Result<Head> {
    let head = Head::decode(sections)?;
    let (layout, neighbours) = (head.layout(), head.neighbours());
    let mut count = 0;
    while let Some(section) = sections.take_any()? {
        each(head.decode_image(&layout, &neighbours, &section)?);
        count += 1;
    }
    if count != layout.slots.len() {
        return Err(Error::invalid(
            &sections.place,
            format!("{count} images, expected {}; bake it again", layout.slots.len()),
        ));
    }
    Ok(head)
}
