//! Direct light: the blocks that have arrived, and the pass that sums them up.
//!
//! In a band block follows block, so that what has arrived is a prefix, and in a block tile follows tile.

use super::DIRECT;
use super::bands::{TILE, block_words, quads};
use super::gpu_data::{Block as Placed, Dispatch};
use crate::gpu::{Gpu, Passes};
use half::f16;
use relume_formats::kinds::transfer_tensor::{Block, Meta};
use std::ops::Range;
use wgpu::{Buffer, BufferUsages};

/// Columns of a workgroup, as in the shader, in words of four.
const QUADS: u32 = 3;

/// Blocks, and the direct light at every vertex.
pub(super) struct Direct {
    arrived: usize,
    pipeline: wgpu::ComputePipeline,
    bands: Vec<Band>,
}

struct Band {
    vertices: Range<u32>,
    words: Buffer,
    uniform: Buffer,
    bindings: wgpu::BindGroup,
    workgroups: [u32; 2],
}

impl Band {
    fn tiles(&self) -> u32 {
        tiles(&self.vertices)
    }
}

fn tiles(vertices: &Range<u32>) -> u32 {
    (vertices.len() as u32).div_ceil(TILE)
}

impl Direct {
    /// No blocks yet of those that `meta` announces, to be multiplied with `light`; `direct` is where each of the
    /// `bands` has the sums, [columns, vertices].
    pub(super) fn new(
        gpu: &Gpu,
        meta: &Meta,
        bands: &[Range<u32>],
        light: &Buffer,
        direct: &[Buffer],
    ) -> Self {
        let pipeline = gpu.compute_pipeline(DIRECT, "accumulate");
        let layout = pipeline.get_bind_group_layout(0);
        let band = |(vertices, direct): (&Range<u32>, &Buffer)| {
            let (placed, words) = placed(meta, tiles(vertices));
            let copied = |label, bytes, usage| gpu.buffer(label, bytes, usage | BufferUsages::COPY_DST);
            let words = copied("blocks", u64::from(words) * 4, BufferUsages::STORAGE);
            let uniform = copied("dispatch", size_of::<Dispatch>() as u64, BufferUsages::UNIFORM);
            let placed = gpu.storage("places of blocks", &placed);
            let bound = [&uniform, &placed, &words, light, direct].map(Buffer::as_entire_binding);
            let parts = quads(meta.columns).div_ceil(QUADS);
            Band {
                bindings: gpu.bind(&layout, bound),
                workgroups: gpu.workgroups(tiles(vertices) * parts, 1),
                vertices: vertices.clone(),
                words,
                uniform,
            }
        };
        Self { arrived: 0, bands: bands.iter().zip(direct).map(band).collect(), pipeline }
    }

    /// Uploads the next block.
    pub(super) fn block_arrived(&mut self, gpu: &Gpu, meta: &Meta, block: &Block) {
        for band in &self.bands {
            let place = placed(meta, band.tiles()).0.get(self.arrived).copied();
            let Some(Placed { first, terms, .. }) = place else { return };
            let words = pack(meta, terms as usize, block, band.vertices.clone());
            gpu.write(&band.words, u64::from(first) * 4, bytemuck::cast_slice(&words));
            let dispatch = Dispatch {
                vertices: band.vertices.len() as u32,
                tiles: band.tiles(),
                blocks: self.arrived as u32 + 1,
                columns: meta.columns,
                quads: quads(meta.columns),
                unit: meta.unit,
            };
            gpu.write(&band.uniform, 0, bytemuck::bytes_of(&dispatch));
        }
        self.arrived += 1;
    }

    /// Encodes the pass over all that has arrived.
    pub(super) fn encode(&self, passes: &mut Passes<'_>) {
        let mut pass = passes.compute("direct");
        pass.set_pipeline(&self.pipeline);
        for Band { bindings, workgroups: [x, y], .. } in &self.bands {
            pass.set_bind_group(0, bindings, &[]);
            pass.dispatch_workgroups(*x, *y, 1);
        }
    }

    /// Number of blocks that have arrived.
    pub(super) fn arrived(&self) -> usize {
        self.arrived
    }

    /// Bytes of blocks that the pass reads.
    pub(super) fn bytes(&self, meta: &Meta) -> u64 {
        let words: u32 = meta.blocks.iter().take(self.arrived).map(|terms| block_words(meta, *terms)).sum();
        self.bands.iter().map(|band| 4 * u64::from(band.tiles()) * u64::from(words)).sum()
    }
}

/// Where the blocks of a band of so many tiles are, and how many words they have together.
fn placed(meta: &Meta, tiles: u32) -> (Vec<Placed>, u32) {
    let mut first = 0;
    let mut place = |terms: &u32| {
        let stride = block_words(meta, *terms);
        let placed = Placed { first, stride, terms: *terms };
        // A band is no larger than a binding.
        first += tiles * stride;
        placed
    };
    let placed = meta.blocks.iter().map(&mut place).collect();
    (placed, first)
}

/// The words of a block of so many `terms` for the tiles of `vertices`, as the shader's `Block` says.
fn pack(meta: &Meta, terms: usize, block: &Block, vertices: Range<u32>) -> Vec<u32> {
    let (all, columns, end) = (meta.vertices as usize, meta.columns as usize, vertices.end);
    let scale = |vertex: usize, column: usize| {
        let scale = (column < columns).then(|| block.scales.get(vertex * columns + column)).flatten();
        scale.copied().map_or(0, f16::to_bits)
    };
    let index = |vertex: usize, term: usize| {
        (term < terms).then(|| block.indices.get(term * all + vertex)).flatten().copied().unwrap_or(0)
    };
    let step = |vertex: usize, term: usize, column: usize| {
        let at = (term * all + vertex) * columns + column;
        (column < columns).then(|| block.steps.get(at)).flatten().copied().unwrap_or(0)
    };
    let mut words = Vec::new();
    for first in vertices.step_by(TILE as usize) {
        let mut row = |word: &dyn Fn(usize) -> u32| {
            let of_vertex = |vertex: u32| if vertex < end { word(vertex as usize) } else { 0 };
            words.extend((first..first + TILE).map(of_vertex));
        };
        let pairs = |low: u16, high: u16| u32::from(low) | u32::from(high) << 16;
        (0..columns.div_ceil(4) * 2).for_each(|p| row(&|v| pairs(scale(v, 2 * p), scale(v, 2 * p + 1))));
        (0..terms.div_ceil(2)).for_each(|p| row(&|v| pairs(index(v, 2 * p), index(v, 2 * p + 1))));
        for (term, quad) in (0..terms).flat_map(|term| (0..columns.div_ceil(4)).map(move |quad| (term, quad)))
        {
            row(&|v| u32::from_le_bytes([0, 1, 2, 3].map(|k| step(v, term, 4 * quad + k) as u8)));
        }
    }
    words
}
