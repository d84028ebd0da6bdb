//! The Haar transform of a bitmap in two levels (sphere shadows §3.4): table look-ups for tiles of 4 × 4
//! texels, then the plain transform of the 8 × 8 averages of each face. It is the plain transform of the
//! image of zeros and ones, bit for bit, for about 1/16 of its additions and multiplications.
//!
//! **Order of bits.** A bitmap has 6 × 32 × 32 bits in 768 bytes, 128 a face: texel (x, y) of `face` is bit x
//! mod 8, lowest first, of byte (face·32 + y)·4 + ⌊x/8⌋. A tile has 16: texel (x, y) of the tile is bit 4y +
//! x.

use super::cubemap::FACES;
use super::haar::{Number, forward, index};
use crate::kinds::HaarTable;

/// Texels along a side of a face.
pub const SIDE: usize = 32;
/// Bytes of a bitmap.
pub const BYTES: usize = FACES * SIDE * SIDE / 8;
/// Tiles along a side of a face.
const TILES: usize = SIDE / 4;
/// Levels that the averages of the tiles are split into; the finer two are in the table.
const COARSE_LEVELS: u32 = TILES.ilog2();

/// Coefficients of a bitmap, in the order of [`super::haar`], written to `out`, [6·32·32].
///
/// # Panics
/// If `out` is of another length.
pub fn two_level<T: Number>(bitmap: &[u8; BYTES], table: &HaarTable, out: &mut [T]) {
    assert_eq!(out.len(), FACES * SIDE * SIDE, "a cube of 32 × 32 a face");
    let (faces, _) = bitmap.as_chunks::<{ SIDE * SIDE / 8 }>();
    let mut scratch = Vec::new();
    for (bits, coefficients) in faces.iter().zip(out.as_chunks_mut::<{ SIDE * SIDE }>().0) {
        look_up(bits, table, coefficients);
        forward(&mut coefficients[..TILES * TILES], TILES, &mut scratch);
    }
}

/// The averages of the tiles to the front of the face, details to their places.
fn look_up<T: Number>(bits: &[u8; SIDE * SIDE / 8], table: &HaarTable, face: &mut [T; SIDE * SIDE]) {
    for (tile_y, rows) in bits.as_chunks::<16>().0.iter().enumerate() {
        let rows: [u32; 4] = std::array::from_fn(|y| {
            u32::from_le_bytes([rows[4 * y], rows[4 * y + 1], rows[4 * y + 2], rows[4 * y + 3]])
        });
        for tile_x in 0..TILES {
            let tile = rows.iter().rev().fold(0, |tile, row| (tile << 4) | (row >> (4 * tile_x)) & 15);
            put(&table.tile(tile as u16).map(T::from), tile_x, tile_y, face);
        }
    }
}

/// A tile's own levels 0 and 1 are the face's levels 3 and 4.
#[inline(always)]
fn put<T: Number>(tile: &[T; 16], tile_x: usize, tile_y: usize, face: &mut [T; SIDE * SIDE]) {
    face[tile_y * TILES + tile_x] = tile[0];
    for m in 1..=3 {
        face[index(COARSE_LEVELS, m, tile_x, tile_y)] = tile[m];
        for j in 0..2 {
            // Squares beside each other stand beside each other, here and there.
            let (to, from) = (index(COARSE_LEVELS + 1, m, 2 * tile_x, 2 * tile_y + j), index(1, m, 0, j));
            face[to..to + 2].copy_from_slice(&tile[from..from + 2]);
        }
    }
}
