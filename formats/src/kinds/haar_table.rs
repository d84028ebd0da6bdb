//! Kind `haar-table`, version 0: the Haar coefficients of every bitmap of 4 × 4 texels (sphere shadows §3.4, the "64K table").
//!
//! | section        | type | shape       | content |
//! |----------------|------|-------------|---------|
//! | `coefficients` | f16  | [16, 65536] | the coefficient of the order of [`crate::basis::haar`] with n = 4, of the bitmap with that number |
//!
//! Bit 4y + x of a bitmap's number is texel (x, y), y down; a set bit is 1. All coefficients are multiples of 1/4 of at most 4, which halves hold exactly.
//! A coefficient's values stand together because bitmaps that follow each other differ in few of them: so the file is small.
//! There is one such table, and a reader compares every value with it.

use crate::basis::haar;
use crate::container::{Kind, Sections, Stored, Writer};
use crate::error::Result;
use half::f16;

/// Bitmaps of 4 × 4.
const BITMAPS: usize = 1 << 16;
/// Coefficients of each.
const COEFFICIENTS: usize = 16;
/// Of the stored section.
const SHAPE: [u64; 2] = [COEFFICIENTS as u64, BITMAPS as u64];

/// The Haar coefficients of every 4 × 4 bitmap.
#[derive(Debug, Clone, PartialEq)]
pub struct HaarTable {
    /// One row for each bitmap, neither more nor fewer.
    tiles: Vec<[f32; COEFFICIENTS]>,
}

impl HaarTable {
    /// Computes the table.
    pub fn bake() -> Self {
        let mut scratch = Vec::new();
        let mut tile = |bits: usize| {
            let mut tile = std::array::from_fn(|texel| ((bits >> texel) & 1) as f32);
            haar::forward(&mut tile, 4, &mut scratch);
            tile
        };
        Self { tiles: (0..BITMAPS).map(&mut tile).collect() }
    }

    /// The 16 coefficients of the bitmap `bits`.
    pub fn tile(&self, bits: u16) -> &[f32; COEFFICIENTS] {
        &self.tiles[usize::from(bits)]
    }

    /// Row-major [65536, 16].
    pub fn coefficients(&self) -> &[f32] {
        self.tiles.as_flattened()
    }

    /// The stored form, [16, 65536].
    fn columns(&self) -> Vec<f16> {
        (0..COEFFICIENTS).flat_map(|k| self.tiles.iter().map(move |tile| f16::from_f32(tile[k]))).collect()
    }
}

impl Stored for HaarTable {
    const KIND: Kind = Kind::HaarTable;
    const VERSION: u32 = 0;

    fn encode(&self, out: &mut Writer) -> Result<()> {
        out.f16s("coefficients", &SHAPE, &self.columns())
    }

    fn decode(sections: &mut Sections<'_>) -> Result<Self> {
        let section = sections.take("coefficients")?;
        section.expect_shape(&SHAPE)?;
        let table = Self::bake();
        // Bits, for -0 equals 0 and yet is another file.
        let differs = |(stored, right): (&f16, &f16)| stored.to_bits() != right.to_bits();
        match section.f16s()?.iter().zip(&table.columns()).position(differs) {
            None => Ok(table),
            Some(at) => Err(section.invalid(format!(
                "coefficient {} of bitmap {} is wrong",
                at / BITMAPS,
                at % BITMAPS
            ))),
        }
    }
}
