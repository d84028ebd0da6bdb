//! The structs of the shaders, as the CPU writes them.

use bytemuck::{Pod, Zeroable};
use relume_formats::evaluate::sphere_shadows::{CasterTriangle, Receiver, Sides};

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

/// A vertex of a shape that deforms, and what moves it.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub(super) struct Vertex {
    pub(super) position: [f32; 3],
    pub(super) index: u32,
    pub(super) joints: [u32; 4],
    pub(super) weights: [f32; 4],
    pub(super) first_delta: u32,
    pub(super) end_delta: u32,
    pub(super) unused: [u32; 2],
}

/// What a morph target adds to a vertex.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub(super) struct Delta {
    pub(super) offset: [f32; 3],
    pub(super) morph: u32,
}

/// A vertex of a shape that deforms, and what turns its normal.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub(super) struct Surrounded {
    pub(super) normal: [f32; 3],
    pub(super) index: u32,
    pub(super) mean: [f32; 3],
    pub(super) first: u32,
    pub(super) end: u32,
    pub(super) unused: [u32; 3],
}

/// The lobes whose blend is that of a receiver's normal.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub(super) struct Lobes {
    pub(super) rows: [u32; 4],
    pub(super) weights: [f32; 4],
}

impl Lobes {
    pub(super) fn new(receiver: &Receiver) -> Self {
        Self { rows: receiver.lobes.map(|(row, _)| row), weights: receiver.lobes.map(|(_, weight)| weight) }
    }
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
        for shader in [super::super::TURN, super::super::SHADE] {
            expect(shader, "Lobes", &layout_of!(Lobes { rows, weights }));
        }
        let vertex = layout_of!(Vertex { position, index, joints, weights, first_delta, end_delta } unused);
        expect(super::super::POSE, "Vertex", &vertex);
        expect(super::super::POSE, "Delta", &layout_of!(Delta { offset, morph }));
        let surrounded = layout_of!(Surrounded { normal, index, mean, first, end } unused);
        expect(super::super::TURN, "Surrounded", &surrounded);
        expect(super::super::TERMS, "Keep", &layout_of!(Keep { gain, terms, fine } unused));
    }
}
