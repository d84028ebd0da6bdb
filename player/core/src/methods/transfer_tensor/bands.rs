//! Bands of vertices: of each no more than all that is stored of it fits into bindings.

use relume_formats::basis::hemisphere::TEXELS;
use relume_formats::basis::sh;
use relume_formats::kinds::transfer_tensor::Meta;
use std::ops::Range;

/// Vertices of a tile.
pub(super) const TILE: u32 = 64;

/// Words of four numbers each that hold so many.
pub(super) fn quads(numbers: u32) -> u32 {
    numbers.div_ceil(4)
}

/// Words of a tile in a block of so many `terms`: what steps are worth, indices, values.
pub(super) fn block_words(meta: &Meta, terms: u32) -> u32 {
    TILE * (2 * quads(meta.columns) + terms.div_ceil(2) + terms * quads(meta.columns))
}

/// Bytes of the largest thing that is stored of each vertex of a tile in one piece.
fn tile_bytes(meta: &Meta) -> u64 {
    let blocks: u64 = meta.blocks.iter().map(|terms| u64::from(block_words(meta, *terms))).sum();
    let shares = meta.sources.len() as u32 * quads(meta.ranks[0]);
    let wide = u64::from(meta.columns).max(sh::COUNT as u64 + 1) * size_of::<[f32; 4]>() as u64;
    let of_vertex = wide.max(TEXELS as u64).max(u64::from(4 * shares.max(quads(meta.vectors))));
    (4 * blocks).max(u64::from(TILE) * of_vertex)
}

/// Cuts all vertices into bands of whole tiles whose bindings have at most `limit` bytes, or tells how many
/// bytes a single tile needs that fits in none.
pub(super) fn cut(meta: &Meta, limit: u64) -> Result<Vec<Range<u32>>, u64> {
    let (vertices, bytes) = (meta.vertices, tile_bytes(meta));
    let most = (limit / bytes).min(u64::from(vertices.div_ceil(TILE))) as u32 * TILE;
    if most == 0 {
        return Err(bytes);
    }
    let band = |first: u32| first..first.saturating_add(most).min(vertices);
    Ok((0..vertices).step_by(most as usize).map(band).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::support::tensors;

    #[test]
    fn every_vertex_lies_in_a_band_that_is_not_too_large() {
        let meta = tensors::transfer(150).meta;
        let bytes = tile_bytes(&meta);
        assert_eq!(cut(&meta, 3 * bytes).map(|bands| bands.len()), Ok(1));
        assert_eq!(cut(&meta, 3 * bytes - 1), Ok(vec![0..128, 128..150]));
        assert_eq!(cut(&meta, bytes), Ok(vec![0..64, 64..128, 128..150]));
        assert_eq!(cut(&meta, bytes - 1), Err(bytes));
    }
}
