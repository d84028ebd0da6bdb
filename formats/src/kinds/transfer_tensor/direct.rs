//! Blocks of terms of direct light.

use super::{FACE_SIZE, Meta};
use crate::basis::cubemap::FACES;
use crate::container::Sections;
use crate::error::{Error, Result};
use half::f16;

/// Number of sections of a block.
pub const BLOCK_SECTIONS: usize = 3;
/// Largest value: no function of the light's basis is above 1, and what arrives from everywhere, times a column of a
/// BRDF space, is some tens.
const MAX_VALUE: f32 = 1e4;

/// Some terms of every vertex.
#[derive(Debug, Clone, PartialEq)]
pub struct Block {
    /// Row-major [terms, vertices].
    pub indices: Vec<u16>,
    /// What a step is worth, row-major [vertices, columns].
    pub scales: Vec<f16>,
    /// Row-major [terms, vertices, columns].
    pub steps: Vec<i8>,
}

impl Meta {
    /// Reads block number `number`: its [`BLOCK_SECTIONS`] sections.
    ///
    /// # Errors
    /// If it is broken, or there is none.
    pub fn decode_block(&self, number: usize, sections: &mut Sections<'_>) -> Result<Block> {
        let Some(terms) = self.blocks.get(number).copied().map(u64::from) else {
            return Err(Error::invalid(&sections.place, "has more blocks than it lists; bake it again"));
        };
        let (vertices, columns) = (u64::from(self.vertices), u64::from(self.columns));
        let section = sections.take(&format!("index/{number:04}"))?;
        section.expect_shape(&[terms, vertices])?;
        let indices = section.u16s()?;
        let beyond = indices.iter().any(|index| usize::from(*index) >= FACES * FACE_SIZE * FACE_SIZE);
        section.expect(beyond.then(|| "an index is beyond the light's coefficients".to_owned()))?;
        let section = sections.take(&format!("scale/{number:04}"))?;
        section.expect_shape(&[vertices, columns])?;
        let scales = section.f16s()?;
        section.expect(self.fault_of_scales(&scales))?;
        let section = sections.take(&format!("value/{number:04}"))?;
        section.expect_shape(&[terms, vertices, columns])?;
        Ok(Block { indices, scales, steps: section.i8s()? })
    }

    fn fault_of_scales(&self, scales: &[f16]) -> Option<String> {
        let largest = |scale: &f16| scale.to_f32() * self.unit * f32::from(i8::MAX);
        let at = scales.iter().position(|scale| !(0.0..=MAX_VALUE).contains(&largest(scale)))?;
        Some(format!("the values of element {at} reach {}, outside 0..{MAX_VALUE}", largest(&scales[at])))
    }
}

impl Block {
    /// The value of `term` (within the block) at `vertex` in `column`.
    pub fn value(&self, meta: &Meta, term: usize, vertex: usize, column: usize) -> f32 {
        let (vertices, columns) = (meta.vertices as usize, meta.columns as usize);
        let step = self.scales[vertex * columns + column].to_f32() * meta.unit;
        step * f32::from(self.steps[(term * vertices + vertex) * columns + column])
    }
}
