//! The structs of `sum.wgsl`, as the CPU writes them.

use bytemuck::{Pod, Zeroable};

/// One dispatch: a band of pixels × a chunk of slots.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Pod, Zeroable)]
pub(super) struct Dispatch {
    /// Pixels of the band.
    pub(super) pixels: u32,
    /// First slot of the chunk.
    pub(super) first_slot: u32,
    /// One past its last slot.
    pub(super) end_slot: u32,
    /// All slots of the bake.
    pub(super) slots: u32,
    /// 1 to add to what the film holds, 0 to overwrite it.
    pub(super) accumulate: u32,
}

/// Where a slot lies in its chunk.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Pod, Zeroable)]
pub(super) struct Slot {
    /// First plane, in halves from the start of the chunk; even.
    pub(super) offset: u32,
    /// From plane to plane, in halves; even.
    pub(super) stride: u32,
    /// Fragments that have a value in this slot.
    pub(super) fragments: u32,
    /// 1: three planes, 0: one.
    pub(super) rgb: u32,
}

/// A fragment of a pixel.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Pod, Zeroable)]
pub(super) struct Fragment {
    /// Position within a plane.
    pub(super) index: u32,
    /// Row of the coefficients.
    pub(super) material: u32,
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gpu::layout::{expect, layout_of};

    #[test]
    fn the_structs_have_the_shaders_layout() {
        let shader = super::super::SHADER;
        expect(shader, "Dispatch", &layout_of!(Dispatch { pixels, first_slot, end_slot, slots, accumulate }));
        expect(shader, "Slot", &layout_of!(Slot { offset, stride, fragments, rgb }));
        expect(shader, "Fragment", &layout_of!(Fragment { index, material }));
    }
}
