//! Kind `sparse-transfer`, version 0: for every vertex the most important Haar coefficients of its transfer from the environment.
//!
//! | section       | type | shape                       | content |
//! |---------------|------|-----------------------------|---------|
//! | `meta`        | u8   | record                      | [`Meta`] |
//! | `index/NNNN`  | u16  | [terms, vertices]           | block NNNN: which coefficient of the light each term multiplies |
//! | `scale/NNNN`  | f16  | [vertices]                  | what one step of the block's values is worth in each row, in [`Meta::unit`]; at least 0 |
//! | `value/NNNN`  | i16 or i8 | [terms, vertices, channels] | its values in steps: i16 in wide blocks |
//!
//! A *row* is a vertex, in the order of kind `scene`; a *column* is every row's k-th most important term. Columns stand in *blocks*, the most
//! important first, so any number of whole blocks is a complete, coarser bake. Terms that a row lacks have value 0. No value may be able to exceed
//! [`MAX_VALUE`]: unit × scale × 32767, or 127 where steps are bytes.
//!
//! The light is a cube map of [`Meta::face_size`]² texels a face, each the mean radiance over its solid angle, Haar-transformed face by face
//! ([`crate::basis::haar`]). What shines directly is the map without its suns ([`crate::basis::suns`]), which a player draws with shadows of its own.
//! With [`Meta::bounces`] above 0 light that other surfaces reflect, in their colours, is added; that is lit by all there is, and so the coefficients
//! of a second cube, of the whole map, stand behind those of the first: bounced light has terms of its own. The sum of value × coefficient is the
//! radiance that a white diffuse surface reflects at the vertex, W/(sr·m²), without the suns' direct light; the player multiplies it by the albedo.

use crate::basis::cubemap::FACES;
use crate::container::{Kind, Section, Sections, Stored, Writer};
use crate::error::{Error, Result};
use crate::state::Rgb;
use half::f16;
use serde::{Deserialize, Serialize};

/// Largest side of a face of the light.
pub const MAX_FACE_SIZE: u32 = 64;
/// Most bounces.
pub const MAX_BOUNCES: u32 = 2;
/// Largest value. A white surface reflects what arrives and no more, each of [`MAX_BOUNCES`] bounces brings
/// at most as much again, and no function of the light's basis is above 1: that makes 3, and this leaves room
/// for the errors of a coarse gather.
pub const MAX_VALUE: f32 = 16.0;
/// Number of sections of a block.
pub const BLOCK_SECTIONS: usize = 3;

/// The small print.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Meta {
    /// Number of rows.
    pub vertices: u32,
    /// Texels along a side of the light's faces: a power of two.
    pub face_size: u32,
    /// Reflections before the one towards the eye.
    pub bounces: u32,
    /// Whether values are RGB.
    pub rgb: bool,
    /// What a stored 1 is worth.
    pub unit: f32,
    /// The blocks of columns, in the order of the file.
    pub blocks: Vec<BlockShape>,
    /// Rays a texel where visibility changes.
    pub rays_per_texel: u32,
}

/// How a block is stored.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct BlockShape {
    /// Number of columns.
    pub terms: u32,
    /// Whether values are 16-bit integers; else they are bytes.
    pub wide: bool,
}

/// Some columns.
#[derive(Debug, Clone, PartialEq)]
pub struct Block {
    /// Row-major [terms, vertices].
    pub indices: Vec<u16>,
    /// The step of each row, [vertices].
    pub scales: Vec<f16>,
    /// What the light's coefficients are multiplied with, in steps.
    pub steps: Steps,
}

/// The values of a block, row-major [terms, vertices, channels].
#[derive(Debug, Clone, PartialEq)]
pub enum Steps {
    /// Of a wide block.
    Wide(Vec<i16>),
    /// Of any other.
    Bytes(Vec<i8>),
}

/// A whole file.
#[derive(Debug, Clone, PartialEq)]
pub struct SparseTransfer {
    /// The small print.
    pub meta: Meta,
    /// As many blocks as the meta lists.
    pub blocks: Vec<Block>,
}

impl Meta {
    /// Number of values of a term: 1, or 3 for RGB.
    pub fn channels(&self) -> usize {
        if self.rgb { 3 } else { 1 }
    }

    /// Number of coefficients of the light: those of the map without its suns, and of the whole map where light
    /// bounces.
    pub fn coefficients(&self) -> usize {
        let cubes = if self.bounces > 0 { 2 } else { 1 };
        cubes * FACES * (self.face_size * self.face_size) as usize
    }

    /// Number of columns.
    pub fn terms(&self) -> usize {
        self.blocks.iter().map(|b| b.terms as usize).sum()
    }

    /// Reads the first section.
    pub fn decode(sections: &mut Sections<'_>) -> Result<Self> {
        let section = sections.take("meta")?;
        let meta: Self = section.record()?;
        meta.validate(&section)?;
        Ok(meta)
    }

    fn validate(&self, section: &Section) -> Result<()> {
        if !self.face_size.is_power_of_two() || self.face_size > MAX_FACE_SIZE || self.bounces > MAX_BOUNCES {
            return Err(section.invalid(format!(
                "a light of {} texels a side and {} bounces are out of range",
                self.face_size, self.bounces
            )));
        }
        if !(self.unit.is_finite() && self.unit > 0.0) {
            return Err(section.invalid(format!("unit {} is not above 0", self.unit)));
        }
        let terms = self.blocks.iter().map(|b| u64::from(b.terms)).sum::<u64>();
        if self.vertices == 0
            || self.blocks.iter().any(|b| b.terms == 0)
            || !(1..=self.coefficients() as u64).contains(&terms)
        {
            let (vertices, most) = (self.vertices, self.coefficients());
            return Err(section.invalid(format!(
                "{vertices} vertices of {terms} terms; a row has 1 to {most}, and no block is empty"
            )));
        }
        Ok(())
    }

    /// Reads block number `block`: its [`BLOCK_SECTIONS`] sections.
    pub fn decode_block(&self, block: usize, sections: &mut Sections<'_>) -> Result<Block> {
        let shape = self
            .blocks
            .get(block)
            .ok_or_else(|| Error::invalid(&sections.place, "has more blocks than it lists; bake it again"))?;
        let (terms, vertices, channels) =
            (u64::from(shape.terms), u64::from(self.vertices), self.channels() as u64);
        let section = sections.take(&format!("index/{block:04}"))?;
        section.expect_shape(&[terms, vertices])?;
        let indices = section.u16s()?;
        if indices.iter().any(|i| usize::from(*i) >= self.coefficients()) {
            return Err(section.invalid("an index is beyond the light's coefficients"));
        }
        let section = sections.take(&format!("scale/{block:04}"))?;
        section.expect_shape(&[vertices])?;
        let scales = section.f16s()?;
        section.expect(self.fault_of_scales(&scales, shape.wide))?;
        let section = sections.take(&format!("value/{block:04}"))?;
        section.expect_shape(&[terms, vertices, channels])?;
        let steps = if shape.wide { Steps::Wide(section.i16s()?) } else { Steps::Bytes(section.i8s()?) };
        Ok(Block { indices, scales, steps })
    }
}

impl Meta {
    fn fault_of_scales(&self, scales: &[f16], wide: bool) -> Option<String> {
        if let Some(at) = scales.iter().position(|scale| !scale.is_finite()) {
            return Some(format!("element {at} is not a finite number"));
        }
        let step = self.unit * if wide { f32::from(i16::MAX) } else { f32::from(i8::MAX) };
        // What rounding up to halves adds is far less than the room above what is possible.
        let at = scales.iter().position(|scale| !(0.0..=MAX_VALUE).contains(&(scale.to_f32() * step)))?;
        Some(format!(
            "the values of vertex {at} reach {}, outside 0..{MAX_VALUE}",
            scales[at].to_f32() * step
        ))
    }
}

impl Block {
    /// The value of `term` (within the block) at `vertex`; one number stands for all three channels if the
    /// file is not RGB.
    pub fn value(&self, meta: &Meta, term: usize, vertex: usize) -> Rgb {
        let first = (term * meta.vertices as usize + vertex) * meta.channels();
        let step = self.scales[vertex].to_f32() * meta.unit;
        std::array::from_fn(|c| {
            let at = first + if meta.rgb { c } else { 0 };
            step * match &self.steps {
                Steps::Wide(steps) => f32::from(steps[at]),
                Steps::Bytes(steps) => f32::from(steps[at]),
            }
        })
    }
}

impl SparseTransfer {
    /// Checks all sections, a block at a time, and returns the small print.
    pub fn checked_meta(sections: &mut Sections<'_>) -> Result<Meta> {
        let meta = Meta::decode(sections)?;
        (0..meta.blocks.len()).try_for_each(|block| meta.decode_block(block, sections).map(drop))?;
        Ok(meta)
    }
}

impl Stored for SparseTransfer {
    const KIND: Kind = Kind::SparseTransfer;
    const VERSION: u32 = 0;

    fn encode(&self, out: &mut Writer) -> Result<()> {
        out.record("meta", &self.meta)?;
        let (vertices, channels) = (u64::from(self.meta.vertices), self.meta.channels() as u64);
        for (number, (block, shape)) in self.blocks.iter().zip(&self.meta.blocks).enumerate() {
            let terms = u64::from(shape.terms);
            out.u16s(&format!("index/{number:04}"), &[terms, vertices], &block.indices)?;
            out.f16s(&format!("scale/{number:04}"), &[vertices], &block.scales)?;
            let (name, shape) = (format!("value/{number:04}"), [terms, vertices, channels]);
            match &block.steps {
                Steps::Wide(steps) => out.i16s(&name, &shape, steps)?,
                Steps::Bytes(steps) => out.i8s(&name, &shape, steps)?,
            }
        }
        Ok(())
    }

    fn decode(sections: &mut Sections<'_>) -> Result<Self> {
        let meta = Meta::decode(sections)?;
        let blocks =
            (0..meta.blocks.len()).map(|block| meta.decode_block(block, sections)).collect::<Result<_>>()?;
        Ok(Self { meta, blocks })
    }

    fn check(sections: &mut Sections<'_>) -> Result<()> {
        Self::checked_meta(sections).map(drop)
    }
}
