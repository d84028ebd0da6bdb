//! Kind `region-images`, version 0: light between surfaces, by the regions of painted ones (thesis §4.2).
//!
//! | section              | type | shape                 | content |
//! |----------------------|------|-----------------------|---------|
//! | `meta`               | u8   | record                | [`Meta`] |
//! | `rows`               | u8   | record                | by basis of the eye, its [`Row`]s |
//! | `fragments/pixel`    | u32  | [fragments]           | as in `transfer-images` |
//! | `fragments/class`    | u16  | [fragments]           | as there |
//! | `fragments/coverage` | f16  | [fragments]           | as there |
//! | `taps/places`        | u16  | [painted, 4, 2]       | texture coordinates that fragments of painted materials show, 0..1 as 0..65535 |
//! | `taps/weights`       | u8   | [painted, 4]          | how much of the fragment each is of; not all 0 |
//! | `cover`              | u8   | [painted materials, [`COVER`]²/8] | which cells of the square of texture coordinates are on a surface: a bit each, row by row, the lowest first |
//! | `weights`            | f16  | [painted rows, regions] | what the regions of a material count in each row that is [`Source::Painted`], in the order of `rows` |
//! | `scales`             | f32  | [bases]               | factor on the halves of each direct image, a power of 2; 0 for one that is all 0 |
//! | `direct/NN`          | u16  | [1 + channels · fragments] | light without a reflection before, on a basis of the eye: as images of `transfer-images` |
//! | `indirect/NN/coarse` | u16  | [numbers]             | light reflected once before, on a basis of the eye: the first 8 × 8 Haar coefficients of every tile of its [`planes`] |
//! | `indirect/NN/fine`   | u16  | [numbers]             | the others |
//!
//! What a fragment of class k shows is Σₑ cₖₑ·(Dₑ + Sₑ·coverage): on basis e of the eye its mean coefficient at the taps, direct light D, which is
//! weighted by coverage already, and light S that was reflected before; fixed fragments have basis 0 alone, and coefficient 1. S is Σᵢ αᵢ·Bᵢ over the rows of the basis, Bᵢ an image with a number
//! in every cell ([`planes`]), and α what the materials make of the row ([`Row`]).

pub mod entries;
pub mod planes;

pub use entries::{Entries, Part};

use super::names::fault_of_names;
use super::scene::{MAX_PIXELS, is_legal_size};
use super::transfer_images::{Fragments, MAX_MATERIALS, Neighbours, codes, expect_scales, fragments};
use crate::container::{Kind, Section, Sections, Stored, Writer};
use crate::error::{Error, Result};
use crate::kinds::brdf_basis::MAX_BASES;
use crate::state::Rgb;
use half::f16;
use planes::Planes;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// Regions along each side of the square of texture coordinates.
pub const REGIONS: usize = 32;
/// Regions of a painted material.
pub const REGION_COUNT: usize = REGIONS * REGIONS;
/// Cells along each side of the square, by which it is known what is on a surface.
pub const COVER: usize = 1024;
/// Texture coordinates of a fragment.
pub const TAPS: usize = 4;
/// Most rows of a basis of the eye.
pub const MAX_ROWS: usize = 16_384;
/// Number of sections before the first image.
pub const HEAD_SECTIONS: usize = 10;
/// Largest step of a row, and largest size of a weight of its colour: beyond, sums could overflow.
const MAX_STEP: f32 = 1e18;

/// The small print.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Meta {
    /// Film size in pixels, width and height.
    pub size: [u32; 2],
    /// Names of the editable materials; a fragment's class is an index into this list.
    pub materials: Vec<String>,
    /// Which of them are painted.
    pub painted: Vec<bool>,
    /// Number of bases at the eye of direct light, the diffuse one included.
    pub bases: u32,
    /// Number of bases, the first ones, of light that was reflected before, at either surface.
    pub indirect_bases: u32,
    /// The one colour of all light, its largest channel 1; `None` if lights differ in colour.
    pub chromaticity: Option<Rgb>,
    /// Film samples a pixel.
    pub samples: u32,
    /// Seed of the paths.
    pub seed: u64,
    /// Number of fragments of editable materials; they come first.
    pub editable_fragments: u32,
}

/// Where light was reflected before.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
pub enum Source {
    /// On a fixed surface: α is 1.
    Fixed,
    /// On a material that is edited as a whole, wearing a basis: α is its coefficient.
    Whole {
        /// Index of the material.
        material: u16,
        /// Index of the basis.
        basis: u16,
    },
    /// On a painted material, wearing a basis: α is the sum over its regions of weight times mean coefficient.
    Painted {
        /// Index of the material.
        material: u16,
        /// Index of the basis.
        basis: u16,
    },
}

/// One image of a basis of the eye.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Row {
    /// What its α follows.
    pub source: Source,
    /// Factor on α by channel: the colour of its light.
    pub colour: Rgb,
    /// Factor on its stored numbers, above 0.
    pub step: f32,
}

/// Everything but the images.
#[derive(Debug, Clone, PartialEq)]
pub struct Head {
    /// The small print.
    pub meta: Meta,
    /// By basis of the eye.
    pub rows: Vec<Vec<Row>>,
    /// What pixels show.
    pub fragments: Fragments,
    /// By fragment of a painted material.
    pub taps: Vec<[Tap; TAPS]>,
    /// By painted material: row by row whether a cell is on a surface.
    pub cover: Vec<Vec<bool>>,
    /// By row that is painted, basis after basis: by region.
    pub weights: Vec<Vec<f16>>,
    /// By direct image.
    pub scales: Vec<f32>,
}

/// A part of a fragment.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Tap {
    /// Texture coordinates, 0..1 as 0..65535.
    pub place: [u16; 2],
    /// How much of the fragment it is.
    pub weight: u8,
}

impl Tap {
    /// Texture coordinates.
    pub fn uv(&self) -> [f32; 2] {
        self.place.map(|x| f32::from(x) / 65_535.0)
    }
}

/// A whole file.
#[derive(Debug, Clone, PartialEq)]
pub struct RegionImages {
    /// Everything but the images.
    pub head: Arc<Head>,
    /// By basis of the eye: stored halves, row-major [channels, fragments that have any].
    pub direct: Vec<Vec<f16>>,
    /// By basis of the eye, of those of light that was reflected before.
    pub indirect: Vec<Entries>,
}

/// What a section after the head holds.
#[derive(Debug, Clone, PartialEq)]
pub enum Piece {
    /// A direct image: its basis, and halves.
    Direct(usize, Vec<f16>),
    /// Of the images of light that was reflected before: the basis of the eye, and a part of its coefficients.
    Indirect(usize, Part, Entries),
}

impl Meta {
    /// Whether the direct image of a basis of the eye has three channels; else it is per unit of chromaticity.
    pub fn is_rgb(&self, basis: usize) -> bool {
        basis == 0 || self.chromaticity.is_none()
    }

    /// Channels of a direct image.
    pub fn channels(&self, basis: usize) -> usize {
        if self.is_rgb(basis) { 3 } else { 1 }
    }

    /// Whether a class is of a painted material.
    pub fn is_painted(&self, class: u16) -> bool {
        self.painted.get(usize::from(class)).copied().unwrap_or(false)
    }

    fn validate(&self, section: &Section) -> Result<()> {
        if !is_legal_size(self.size) || self.samples == 0 {
            return Err(section.invalid(format!(
                "film size {:?} of {} samples is not one of 1 to {MAX_PIXELS} pixels",
                self.size, self.samples
            )));
        }
        let (bases, indirect) = (self.bases as usize, self.indirect_bases as usize);
        let materials = self.materials.len();
        if !(1..=MAX_MATERIALS).contains(&materials)
            || self.painted.len() != materials
            || !(2..=MAX_BASES).contains(&bases)
            || indirect > bases
        {
            return Err(section.invalid(format!(
                "{materials} materials, {bases} bases and {indirect} of indirect light are out of range"
            )));
        }
        section.expect(fault_of_names("materials", self.materials.iter().map(String::as_str)))?;
        let is_legal = |c: Rgb| c.iter().all(|v| (0.0..=1.0).contains(v)) && c.contains(&1.0);
        if !self.chromaticity.is_none_or(is_legal) {
            return Err(section.invalid("the chromaticity is outside 0..1, or has no channel of 1"));
        }
        Ok(())
    }
}

impl Row {
    fn is_legal(&self, meta: &Meta) -> bool {
        let of = |material: u16, basis: u16, painted: bool| {
            meta.painted.get(usize::from(material)) == Some(&painted)
                && u32::from(basis) < meta.indirect_bases
        };
        let is_known = match self.source {
            Source::Fixed => true,
            Source::Whole { material, basis } => of(material, basis, false),
            Source::Painted { material, basis } => of(material, basis, true),
        };
        is_known && self.step > 0.0 && self.step <= MAX_STEP && self.colour.iter().all(|c| c.abs() <= 1.0)
    }

    /// Whether its α follows the regions of a material.
    pub fn is_painted(&self) -> bool {
        matches!(self.source, Source::Painted { .. })
    }
}

impl Head {
    /// Number of fragments that have a direct image on a basis of the eye.
    pub fn direct_fragments(&self, basis: usize) -> usize {
        if basis == 0 { self.fragments.pixel.len() } else { self.meta.editable_fragments as usize }
    }

    /// The planes of light that was reflected before.
    pub fn planes(&self) -> Planes {
        Planes::new(self.meta.size, &self.fragments)
    }

    /// What predicts the values of direct images.
    pub fn neighbours(&self) -> Neighbours {
        let Fragments { pixel, class, .. } = &self.fragments;
        Neighbours::new(self.meta.size[0], self.meta.editable_fragments as usize, (pixel, class))
    }

    /// Reads the sections before the first image.
    ///
    /// # Errors
    /// `Invalid` for what breaks the rules of the module.
    pub fn decode(sections: &mut Sections<'_>) -> Result<Self> {
        let section = sections.take("meta")?;
        let meta: Meta = section.record()?;
        meta.validate(&section)?;
        let section = sections.take("rows")?;
        let rows: Vec<Vec<Row>> = section.record()?;
        if rows.len() != meta.indirect_bases as usize
            || rows.iter().any(|rows| rows.len() > MAX_ROWS)
            || !rows.iter().flatten().all(|row| row.is_legal(&meta))
        {
            return Err(section.invalid("holds a row of a source that is not there, or out of range"));
        }
        let fragments =
            Fragments::decode(sections, meta.size, meta.materials.len(), meta.editable_fragments as usize)?;
        let painted = fragments.class.iter().filter(|class| meta.is_painted(**class)).count();
        let taps = decode_taps(sections, painted)?;

        let section = sections.take("cover")?;
        let materials = meta.painted.iter().filter(|painted| **painted).count();
        let bytes = section.u8s()?;
        section.expect_shape(&[materials as u64, (COVER * COVER / 8) as u64])?;
        let bits = |bytes: &[u8]| (0..8 * bytes.len()).map(|i| bytes[i / 8] >> (i % 8) & 1 == 1).collect();
        let cover = bytes.chunks_exact(COVER * COVER / 8).map(bits).collect();

        let section = sections.take("weights")?;
        let count = rows.iter().flatten().filter(|row| row.is_painted()).count();
        let weights = section.f16s()?;
        section.expect_shape(&[count as u64, REGION_COUNT as u64])?;
        if !weights.iter().all(|weight| weight.is_finite()) {
            return Err(section.invalid("a weight is not a finite number"));
        }
        let weights = weights.chunks_exact(REGION_COUNT).map(<[f16]>::to_vec).collect();

        let section = sections.take("scales")?;
        let scales = section.f32s()?;
        section.expect_shape(&[u64::from(meta.bases)])?;
        expect_scales(&section, &scales)?;
        Ok(Self { meta, rows, fragments, taps, cover, weights, scales })
    }

    /// Reads a section after those of the head.
    ///
    /// # Errors
    /// `Invalid` for what breaks the rules of the module.
    pub fn decode_piece(&self, neighbours: &Neighbours, planes: &Planes, section: &Section) -> Result<Piece> {
        let stranger = || section.invalid("is no image of this layout");
        let mut words = section.info.name.split('/');
        let (what, basis) = (words.next(), words.next().and_then(|number| number.parse::<usize>().ok()));
        let basis = basis.ok_or_else(stranger)?;
        match (what, words.next(), words.next()) {
            (Some("direct"), None, None) if basis < self.meta.bases as usize => {
                let channels = self.meta.channels(basis);
                section.expect_shape(&[1 + (channels * self.direct_fragments(basis)) as u64])?;
                let scale = self.scales.get(basis).copied().unwrap_or_default();
                Ok(Piece::Direct(basis, codes::read(section, channels, neighbours, scale)?))
            }
            (Some("indirect"), Some(part), None) if basis < self.rows.len() => {
                let part = Part::named(part).ok_or_else(stranger)?;
                let entries = Entries::decode(&section.u16s()?, part, planes.tiles, self.rows[basis].len());
                entries
                    .map(|entries| Piece::Indirect(basis, part, entries))
                    .ok_or_else(|| section.invalid("holds coefficients of no row or no place"))
            }
            _ => Err(stranger()),
        }
    }

    fn encode(&self, out: &mut Writer) -> Result<()> {
        out.record("meta", &self.meta)?;
        out.record("rows", &self.rows)?;
        let Fragments { pixel, class, coverage } = &self.fragments;
        fragments::encode(out, (pixel, class, coverage))?;
        let places: Vec<u16> = self.taps.iter().flatten().flat_map(|tap| tap.place).collect();
        let weights: Vec<u8> = self.taps.iter().flatten().map(|tap| tap.weight).collect();
        out.u16s("taps/places", &[self.taps.len() as u64, TAPS as u64, 2], &places)?;
        out.u8s("taps/weights", &[self.taps.len() as u64, TAPS as u64], &weights)?;
        let byte = |bits: &[bool]| (0..8).fold(0, |byte, i| byte | u8::from(bits[i]) << i);
        let cover: Vec<u8> = self.cover.iter().flat_map(|c| c.chunks_exact(8).map(byte)).collect();
        out.u8s("cover", &[self.cover.len() as u64, (COVER * COVER / 8) as u64], &cover)?;
        let shape = [self.weights.len() as u64, REGION_COUNT as u64];
        out.f16s("weights", &shape, &self.weights.concat())?;
        out.f32s("scales", &[self.scales.len() as u64], &self.scales)
    }
}

fn decode_taps(sections: &mut Sections<'_>, painted: usize) -> Result<Vec<[Tap; TAPS]>> {
    let section = sections.take("taps/places")?;
    let places = section.u16s()?;
    section.expect_shape(&[painted as u64, TAPS as u64, 2])?;
    let section = sections.take("taps/weights")?;
    let weights = section.u8s()?;
    section.expect_shape(&[painted as u64, TAPS as u64])?;
    let (places, weights) = (places.as_chunks::<2>().0.as_chunks::<TAPS>().0, weights.as_chunks::<TAPS>().0);
    if weights.contains(&[0; TAPS]) {
        return Err(section.invalid("a fragment shows no place of its texture"));
    }
    let tap = |(place, weight): (&[u16; 2], &u8)| Tap { place: *place, weight: *weight };
    let taps = |(places, weights): (&[[u16; 2]; TAPS], &[u8; TAPS])| {
        std::array::from_fn(|k| tap((&places[k], &weights[k])))
    };
    Ok(places.iter().zip(weights).map(taps).collect())
}

impl Stored for RegionImages {
    const KIND: Kind = Kind::RegionImages;
    const VERSION: u32 = 0;

    fn encode(&self, out: &mut Writer) -> Result<()> {
        let (head, neighbours) = (&self.head, self.head.neighbours());
        head.encode(out)?;
        for (basis, halves) in self.direct.iter().enumerate() {
            let stored = codes::written(halves, head.meta.channels(basis), &neighbours);
            out.u16s(&format!("direct/{basis:02}"), &[stored.len() as u64], &stored)?;
        }
        for part in Part::ALL {
            for (basis, entries) in self.indirect.iter().enumerate() {
                let stored = entries.encode(part);
                let name = format!("indirect/{basis:02}/{}", part.name());
                out.u16s(&name, &[stored.len() as u64], &stored)?;
            }
        }
        Ok(())
    }

    fn decode(sections: &mut Sections<'_>) -> Result<Self> {
        let mut pieces = Vec::new();
        let head = for_each_piece(sections, |piece| pieces.push(piece))?;
        let mut direct = vec![Vec::new(); head.meta.bases as usize];
        let mut indirect: Vec<Vec<Entries>> = vec![Vec::new(); head.rows.len()];
        pieces.sort_by_key(|piece| matches!(piece, Piece::Indirect(_, Part::Fine, _)));
        for piece in pieces {
            match piece {
                Piece::Direct(basis, halves) => direct[basis] = halves,
                Piece::Indirect(basis, _, entries) => indirect[basis].push(entries),
            }
        }
        let indirect = indirect.iter().map(|parts| Entries::joined(parts)).collect();
        Ok(Self { head: Arc::new(head), direct, indirect })
    }

    fn check(sections: &mut Sections<'_>) -> Result<()> {
        Self::checked_head(sections).map(drop)
    }
}

impl RegionImages {
    /// Checks all sections, one at a time, and returns the head.
    ///
    /// # Errors
    /// `Invalid` for what breaks the rules of the module.
    pub fn checked_head(sections: &mut Sections<'_>) -> Result<Head> {
        for_each_piece(sections, drop)
    }
}

/// Reads head and images, one at a time. Names of sections differ, so as many as there should be are one of each.
fn for_each_piece(sections: &mut Sections<'_>, mut each: impl FnMut(Piece)) -> Result<Head> {
    let head = Head::decode(sections)?;
    let (neighbours, planes) = (head.neighbours(), head.planes());
    let mut count = 0;
    while let Some(section) = sections.take_any()? {
        each(head.decode_piece(&neighbours, &planes, &section)?);
        count += 1;
    }
    let expected = head.meta.bases as usize + 2 * head.rows.len();
    if count != expected {
        return Err(Error::invalid(
            &sections.place,
            format!("{count} images, expected {expected}; bake it again"),
        ));
    }
    Ok(head)
}
