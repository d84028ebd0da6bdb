//! The structs of the shaders, as the CPU writes them.

use bytemuck::{Pod, Zeroable};

/// Most cones that points are drawn with.
pub(super) const MAX_CONES: usize = 16;

/// The sum over blocks for the vertices of a band.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub(super) struct Dispatch {
    pub(super) vertices: u32,
    pub(super) tiles: u32,
    /// Blocks that have arrived.
    pub(super) blocks: u32,
    pub(super) columns: u32,
    /// Words of four columns.
    pub(super) quads: u32,
    /// What a stored 1 is worth.
    pub(super) unit: f32,
}

/// Where a block lies in its band, in words, and its terms.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Pod, Zeroable)]
pub(super) struct Block {
    /// Of the first tile.
    pub(super) first: u32,
    /// From tile to tile.
    pub(super) stride: u32,
    pub(super) terms: u32,
}

/// Functions of vertices of some clusters.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Pod, Zeroable)]
pub(super) struct Batch {
    pub(super) first: u32,
    pub(super) count: u32,
    pub(super) vertex_rank: u32,
    /// The same in whole words of shares.
    pub(super) vertex_room: u32,
    pub(super) light_rank: u32,
}

/// Vertices of a band that are of one cluster, in the order of clusters.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Pod, Zeroable)]
pub(super) struct Tile {
    pub(super) cluster: u32,
    pub(super) first: u32,
    pub(super) count: u32,
}

/// What vertices of a band receive after one reflection.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Pod, Zeroable)]
pub(super) struct Bounce {
    pub(super) vertices: u32,
    pub(super) sources: u32,
    /// Words of four shares, of each source.
    pub(super) quads: u32,
}

/// Vectors of some clusters.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Pod, Zeroable)]
pub(super) struct Vectors {
    pub(super) first: u32,
    pub(super) count: u32,
    pub(super) pairs: u32,
    /// Of a vector.
    pub(super) words: u32,
}

/// What vertices of a band receive after two reflections.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Pod, Zeroable)]
pub(super) struct Second {
    pub(super) vertices: u32,
    pub(super) vectors: u32,
    /// Words of four shares.
    pub(super) quads: u32,
}

/// A BRDF space, and where its tables begin.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Pod, Zeroable)]
pub(super) struct Space {
    pub(super) columns: u32,
    pub(super) profiles: u32,
    pub(super) cones: u32,
    pub(super) harmonics: u32,
    pub(super) orders: u32,
    pub(super) even: u32,
    pub(super) first_cone: u32,
    pub(super) unused: u32,
}

/// All spaces.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Pod, Zeroable)]
pub(super) struct Spaces {
    pub(super) spaces: [Space; 3],
    /// Where the directions of harmonics begin in the tables.
    pub(super) directions: u32,
}

/// A cone of highlights.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub(super) struct Cone {
    /// Sine and cosine of its tilt, sine and cosine of what it is turned to the side.
    pub(super) turned: [f32; 4],
    /// Where the map filtered for it begins, and its columns and rows; number of Gaussians.
    pub(super) map: [u32; 4],
}

/// What highlights of a material are made of.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub(super) struct Mirror {
    pub(super) cones: [Cone; MAX_CONES],
    pub(super) count: u32,
    pub(super) unused: [u32; 3],
}

/// How the vertices of a band are looked at.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub(super) struct Look {
    pub(super) eye: [f32; 3],
    pub(super) first_vertex: u32,
    pub(super) vertices: u32,
    pub(super) unused: [u32; 3],
}

/// A vertex.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub(super) struct Place {
    pub(super) position: [f32; 3],
    pub(super) material: u32,
    pub(super) normal: [f32; 3],
    pub(super) unused: u32,
}

#[cfg(test)]
mod tests {
    use super::super::{BOUNCE, CORE, DIRECT, GATHER, GLOSSY, LOOK, PAIRS, SECOND};
    use super::*;
    use crate::gpu::layout::{expect, layout_of};

    #[test]
    fn the_structs_have_the_shaders_layout() {
        expect(DIRECT, "Dispatch", &layout_of!(Dispatch { vertices, tiles, blocks, columns, quads, unit }));
        expect(DIRECT, "Block", &layout_of!(Block { first, stride, terms }));
        expect(CORE, "Batch", &layout_of!(Batch { first, count, vertex_rank, vertex_room, light_rank }));
        for shader in [BOUNCE, SECOND] {
            expect(shader, "Tile", &layout_of!(Tile { cluster, first, count }));
        }
        expect(BOUNCE, "Bounce", &layout_of!(Bounce { vertices, sources, quads }));
        expect(PAIRS, "Vectors", &layout_of!(Vectors { first, count, pairs, words }));
        expect(SECOND, "Second", &layout_of!(Second { vertices, vectors, quads }));
        let space =
            layout_of!(Space { columns, profiles, cones, harmonics, orders, even, first_cone, unused });
        let spaces = layout_of!(Spaces { spaces, directions });
        expect(GLOSSY, "Cone", &layout_of!(Cone { turned, map }));
        expect(GLOSSY, "Mirror", &layout_of!(Mirror { cones, count } unused));
        for shader in [GATHER, LOOK] {
            expect(shader, "Space", &space);
            expect(shader, "Spaces", &spaces);
        }
        for shader in [GATHER, LOOK] {
            expect(shader, "Look", &layout_of!(Look { eye, first_vertex, vertices } unused));
            expect(shader, "Place", &layout_of!(Place { position, material, normal } unused));
        }
    }
}
