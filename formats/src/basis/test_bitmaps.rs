//! Bitmaps of texels, for tests.

use super::cap::{Bitmap, ROWS};
use super::cubemap::direction;
use super::two_level::SIDE;
use glam::DVec3;

/// Unit directions of all texel centres, in the order of bits.
pub fn centres() -> Vec<DVec3> {
    (0..ROWS * SIDE)
        .map(|i| direction(i / (SIDE * SIDE), SIDE, (i % SIDE) as f64 + 0.5, (i / SIDE % SIDE) as f64 + 0.5))
        .collect()
}

/// Whether a texel is in a bitmap.
pub fn bit(bitmap: &Bitmap, texel: usize) -> bool {
    (bitmap[texel / SIDE] >> (texel % SIDE)) & 1 == 1
}
