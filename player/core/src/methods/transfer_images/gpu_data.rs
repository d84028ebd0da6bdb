//! The structs of the shaders, as the CPU writes them.

use bytemuck::{Pod, Zeroable};

/// One dispatch of `sum.wgsl`: a band of pixels.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Pod, Zeroable)]
pub(super) struct Dispatch {
    /// Tiles of the band.
    pub(super) tiles: u32,
    /// Row of the coefficients that is for what is fixed.
    pub(super) fixed_class: u32,
    /// The slots that it has values in, which come first.
    pub(super) fixed_slots: u32,
    /// All slots of the bake.
    pub(super) slots: u32,
}

/// Where a slot lies in its band, in wide words.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Pod, Zeroable)]
pub(super) struct Slot {
    /// First plane.
    pub(super) first: u32,
    /// From plane to plane; 0 if there is one alone.
    pub(super) stride: u32,
}

/// A pixel with several fragments, in `merge.wgsl`.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Pod, Zeroable)]
pub(super) struct SharedPixel {
    /// Number of the pixel in its band.
    pub(super) pixel: u32,
    /// First of its fragments among the sums of the band.
    pub(super) first: u32,
    /// One past the last.
    pub(super) end: u32,
}

#[cfg(test)]
mod tests {
    use super::super::{MERGE, SUM};
    use super::*;
    use crate::gpu::layout::{expect, layout_of};

    #[test]
    fn the_structs_have_the_shaders_layout() {
        expect(SUM, "Dispatch", &layout_of!(Dispatch { tiles, fixed_class, fixed_slots, slots }));
        expect(SUM, "Slot", &layout_of!(Slot { first, stride }));
        expect(MERGE, "SharedPixel", &layout_of!(SharedPixel { pixel, first, end }));
    }
}
