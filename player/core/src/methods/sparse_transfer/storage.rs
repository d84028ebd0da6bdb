//! Where the stored columns lie on the GPU.
//!
//! A workgroup sums the rows of a tile of vertices, so tiles stand in bands, each of as many as a binding
//! holds, and a band has all columns of its tiles. In a band block follows block, so that what has arrived is
//! a prefix; in a block tile follows tile. Of a block a tile has the scales of its vertices and then units of
//! four columns, the last filled up with zeros, arranged as the shader's `Unit` says: so that a lane gets the
//! numbers of its four vertices in wide words, and lanes side by side read wide words in a row.

use super::gpu_data::Unit;
use half::f16;
use relume_formats::kinds::sparse_transfer::{Block, BlockShape, Meta, Steps};
use std::ops::Range;

/// Vertices of a tile.
pub(super) const TILE: u32 = 64;
/// Bytes of a wide word.
pub(super) const WORD_BYTES: u64 = 16;
/// Columns of a unit.
const UNIT_TERMS: u32 = 4;
/// Vertices of a lane.
const LANE_VERTICES: u32 = 4;
/// Wide words of a tile in a row: one for each lane.
const ROW_WORDS: u32 = TILE / LANE_VERTICES;
/// Wide words of the scales of a tile.
const SCALE_WORDS: u32 = TILE * size_of::<f16>() as u32 / WORD_BYTES as u32;

/// Units of a block.
fn units_of(shape: &BlockShape) -> u32 {
    shape.terms.div_ceil(UNIT_TERMS)
}

/// Wide words of a tile in a unit of a block.
fn unit_words(meta: &Meta, shape: &BlockShape) -> u32 {
    let rows_of_values = if shape.wide { 2 } else { 1 };
    ROW_WORDS * (2 + rows_of_values * meta.channels() as u32)
}

/// Wide words of a tile in a block.
fn tile_words(meta: &Meta, shape: &BlockShape) -> u64 {
    u64::from(SCALE_WORDS) + u64::from(units_of(shape)) * u64::from(unit_words(meta, shape))
}

/// Bytes of a tile in the first `blocks` blocks.
pub(super) fn tile_bytes(meta: &Meta, blocks: usize) -> u64 {
    WORD_BYTES * meta.blocks.iter().take(blocks).map(|shape| tile_words(meta, shape)).sum::<u64>()
}

/// Cuts all tiles into bands of at most `limit` bytes, or tells how many bytes a single tile needs that fits
/// in none.
pub(super) fn arrange(meta: &Meta, limit: u64) -> Result<Vec<Range<u32>>, u64> {
    let (tiles, bytes) = (meta.vertices.div_ceil(TILE), tile_bytes(meta, meta.blocks.len()));
    let most = (limit / bytes).min(u64::from(tiles)) as u32;
    if most == 0 {
        return Err(bytes);
    }
    Ok((0..tiles).step_by(most as usize).map(|first| first..first.saturating_add(most).min(tiles)).collect())
}

/// The units of the first `blocks` blocks in a band of `tiles` tiles.
pub(super) fn units(meta: &Meta, blocks: usize, tiles: u32) -> Vec<Unit> {
    let of_block = |(number, shape): (usize, &BlockShape)| {
        // A band is no larger than a binding, and so are its parts.
        let scales = (u64::from(tiles) * tile_bytes(meta, number) / WORD_BYTES) as u32;
        let (stride, wide, words) =
            (tile_words(meta, shape) as u32, u32::from(shape.wide), unit_words(meta, shape));
        let terms = scales + SCALE_WORDS;
        (0..units_of(shape)).map(move |unit| Unit { scales, terms: terms + unit * words, stride, wide })
    };
    meta.blocks.iter().take(blocks).enumerate().flat_map(of_block).collect()
}

/// The bytes of block number `number` for these `tiles`.
pub(super) fn pack(meta: &Meta, number: usize, block: &Block, tiles: Range<u32>) -> Vec<u8> {
    let Some(shape) = meta.blocks.get(number) else { return Vec::new() };
    let (vertices, terms, channels) = (meta.vertices as usize, shape.terms as usize, meta.channels());
    let mut bytes = Vec::with_capacity(tiles.len() * (WORD_BYTES * tile_words(meta, shape)) as usize);
    for first in tiles.map(|tile| (tile * TILE) as usize) {
        for vertex in first..first + TILE as usize {
            bytes.extend(block.scales.get(vertex).copied().unwrap_or_default().to_le_bytes());
        }
        for unit in (0..terms).step_by(UNIT_TERMS as usize) {
            // Where a number is, if there is one.
            let place = |term: usize, vertex: usize| {
                let (term, vertex) = (unit + term, first + vertex);
                (term < terms && vertex < vertices).then_some(term * vertices + vertex)
            };
            let value = |term, vertex, channel| Some(place(term, vertex)? * channels + channel);
            push(&mut bytes, 2, |term, vertex| place(term, vertex).and_then(|at| block.indices.get(at)));
            for channel in 0..channels {
                match &block.steps {
                    Steps::Wide(steps) => {
                        push(&mut bytes, 2, |t, v| value(t, v, channel).and_then(|at| steps.get(at)))
                    }
                    Steps::Bytes(steps) => {
                        push(&mut bytes, 4, |t, v| value(t, v, channel).and_then(|at| steps.get(at)))
                    }
                }
            }
        }
    }
    bytes
}

/// Appends a number for each term of a unit and each vertex of a tile, by [row, lane, term, vertex] with
/// `terms_a_word` terms in each row; 0 where there is none.
fn push<'a, T: bytemuck::Pod>(
    bytes: &mut Vec<u8>,
    terms_a_word: usize,
    number: impl Fn(usize, usize) -> Option<&'a T>,
) {
    for row in (0..UNIT_TERMS as usize).step_by(terms_a_word) {
        for lane in (0..TILE as usize).step_by(LANE_VERTICES as usize) {
            for term in row..row + terms_a_word {
                for vertex in lane..lane + LANE_VERTICES as usize {
                    let number = number(term, vertex).copied().unwrap_or(T::zeroed());
                    bytes.extend_from_slice(bytemuck::bytes_of(&number));
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::support::sparse;

    #[test]
    fn every_tile_lies_in_a_band_that_is_not_too_large() {
        for rgb in [false, true] {
            let meta = sparse::transfer(777, 16, rgb).meta;
            let tile = tile_bytes(&meta, meta.blocks.len());
            assert_eq!(arrange(&meta, 13 * tile).map(|bands| bands.len()), Ok(1));
            assert_eq!(arrange(&meta, tile - 1), Err(tile));
            assert_eq!(arrange(&meta, 12 * tile), Ok(vec![0..12, 12..13]));
            assert_eq!(arrange(&meta, 4 * tile - 1), Ok(vec![0..3, 3..6, 6..9, 9..12, 12..13]));
        }
    }

    /// The number at `at` of what is `packed`, counted in numbers of its size.
    fn number<T: bytemuck::Pod>(packed: &[u8], at: usize) -> T {
        bytemuck::pod_read_unaligned(&packed[at * size_of::<T>()..][..size_of::<T>()])
    }

    /// Reads every number of a band as the shader does.
    #[test]
    fn every_number_is_where_the_shader_looks_for_it() {
        for (rgb, tiles) in [(false, 0..2), (true, 0..2), (true, 1..2)] {
            let transfer = sparse::transfer(77, 16, rgb);
            let (meta, channels) = (&transfer.meta, transfer.meta.channels());
            let packed: Vec<u8> = (0..meta.blocks.len())
                .flat_map(|n| pack(meta, n, &transfer.blocks[n], tiles.clone()))
                .collect();
            assert_eq!(packed.len() as u64, tiles.len() as u64 * tile_bytes(meta, meta.blocks.len()));
            let mut units = units(meta, meta.blocks.len(), tiles.len() as u32).into_iter();
            for (shape, block) in meta.blocks.iter().zip(&transfer.blocks) {
                for first in (0..shape.terms as usize).step_by(4) {
                    let unit = units.next().unwrap();
                    for (term, vertex) in (0..4).flat_map(|term| (0..64).map(move |vertex| (term, vertex))) {
                        for tile in tiles.clone() {
                            let start = (tile - tiles.start) * unit.stride;
                            let at = (unit.terms + start) as usize + vertex / 4;
                            let of_pairs = |row: usize| 8 * (at + row + 16 * (term / 2)) + 4 * (term % 2);
                            let of_fours = |row: usize| 16 * (at + row) + 4 * term;
                            let global = tile as usize * 64 + vertex;
                            let there = global < 77 && first + term < shape.terms as usize;
                            let element = (first + term) * 77 + global;
                            let index: u16 = number(&packed, of_pairs(0) + vertex % 4);
                            assert_eq!(index, if there { block.indices[element] } else { 0 });
                            let scale: u16 = number(&packed, 8 * (unit.scales + start) as usize + vertex);
                            assert_eq!(scale, if global < 77 { block.scales[global].to_bits() } else { 0 });
                            for channel in 0..channels {
                                let element = element * channels + channel;
                                let (found, expected) = match &block.steps {
                                    Steps::Wide(steps) => (
                                        number(&packed, of_pairs(32 * (1 + channel)) + vertex % 4),
                                        if there { steps[element] } else { 0 },
                                    ),
                                    Steps::Bytes(steps) => {
                                        let at = of_fours(16 * (2 + channel)) + vertex % 4;
                                        let found = i16::from(number::<i8>(&packed, at));
                                        (found, if there { i16::from(steps[element]) } else { 0 })
                                    }
                                };
                                assert_eq!((found, unit.wide == 1), (expected, shape.wide));
                            }
                        }
                    }
                }
            }
            assert!(units.next().is_none());
        }
    }
}
