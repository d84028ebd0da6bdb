//! The structs of the shaders, as the CPU writes them.

use bytemuck::{Pod, Zeroable};

/// One dispatch over a band of columns.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub(super) struct Dispatch {
    pub(super) vertices: u32,
    /// Runs that have arrived.
    pub(super) runs: u32,
    pub(super) channels: u32,
    /// 1 to add to what is there, 0 to overwrite it.
    pub(super) accumulate: u32,
    /// What a stored 1 is worth.
    pub(super) unit: f32,
}

/// Consecutive columns of one block; offsets are in words from the start of their band.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Pod, Zeroable)]
pub(super) struct Run {
    pub(super) terms: u32,
    /// 1 if values are 16-bit integers, 0 for bytes.
    pub(super) wide: u32,
    pub(super) indices: u32,
    pub(super) values: u32,
    pub(super) scales: u32,
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
            &layout_of!(Dispatch { vertices, runs, channels, accumulate, unit }),
        );
        expect(super::super::ACCUMULATE, "Run", &layout_of!(Run { terms, wide, indices, values, scales }));
    }
}
