//! The structs of the shaders, as the CPU writes them.

use bytemuck::{Pod, Zeroable};

/// One dispatch over a band of tiles.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub(super) struct Dispatch {
    /// All vertices of the bake.
    pub(super) vertices: u32,
    pub(super) first_tile: u32,
    pub(super) tiles: u32,
    /// Units that have arrived.
    pub(super) units: u32,
    pub(super) channels: u32,
    /// What a stored 1 is worth.
    pub(super) unit: f32,
}

/// Consecutive columns of one block; offsets are in wide words from the start of their band, for its first
/// tile.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Pod, Zeroable)]
pub(super) struct Unit {
    pub(super) scales: u32,
    pub(super) terms: u32,
    /// From tile to tile.
    pub(super) stride: u32,
    /// 1 if values are 16-bit integers, 0 for bytes.
    pub(super) wide: u32,
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gpu::layout::{expect, layout_of};

    #[test]
    fn the_structs_have_the_shaders_layout() {
        expect(
            super::super::ACCUMULATE,
            "Dispatch",
            &layout_of!(Dispatch { vertices, first_tile, tiles, units, channels, unit }),
        );
        expect(super::super::ACCUMULATE, "Unit", &layout_of!(Unit { scales, terms, stride, wide }));
    }
}
