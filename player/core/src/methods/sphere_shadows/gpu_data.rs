//! The structs of the shaders, as the CPU writes them.

use bytemuck::{Pod, Zeroable};
use relume_formats::evaluate::sphere_shadows::{CasterTriangle, Sides};

/// Receivers whose bitmaps share a buffer.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Pod, Zeroable)]
pub(super) struct Batch {
    pub(super) first: u32,
    pub(super) count: u32,
    /// Of all sets.
    pub(super) spheres: u32,
}

/// A triangle that casts shadows, by its vertices, and the heights above and below its plane beyond which it
/// counts for receivers of its own object, and for others.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub(super) struct Caster {
    pub(super) vertices: [u32; 3],
    pub(super) object: u32,
    pub(super) offsets: [f32; 3],
    pub(super) own: [f32; 2],
    pub(super) others: [f32; 2],
    pub(super) unused: u32,
}

impl Caster {
    pub(super) fn new(triangle: &CasterTriangle) -> Self {
        // What is infinite need not be so in a shader; no height is as large as this.
        let heights = |sides: Sides| [sides.above, sides.below].map(|height| height.min(f32::MAX));
        let [own, others] = triangle.sides.map(heights);
        let CasterTriangle { vertices, object, offsets, .. } = *triangle;
        Self { vertices, object, offsets, own, others, unused: 0 }
    }
}

/// Bytes of a triangle where it is now, which the CPU never sees.
pub(super) const TRIANGLE_BYTES: u64 = 80;

/// The lobes whose blend is that of a receiver's normal.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub(super) struct Lobes {
    pub(super) rows: [u32; 4],
    pub(super) weights: [f32; 4],
}

/// What of the light is kept.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub(super) struct Keep {
    pub(super) gain: [f32; 3],
    pub(super) terms: u32,
    /// 1 if terms of the finer two levels count.
    pub(super) fine: u32,
    pub(super) unused: [u32; 3],
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gpu::layout::{expect, layout_of};

    #[test]
    fn the_structs_have_the_shaders_layout() {
        for shader in [super::super::CAPS, super::super::SHADE] {
            expect(shader, "Batch", &layout_of!(Batch { first, count, spheres }));
        }
        expect(super::super::SHADE, "Lobes", &layout_of!(Lobes { rows, weights }));
        expect(super::super::TERMS, "Keep", &layout_of!(Keep { gain, terms, fine } unused));
    }
}
