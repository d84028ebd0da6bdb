//! Tiles of finished fragments, as the work log keeps them.

use crate::filter::Seen;
use crate::filter::seen::WORDS;

/// Side of a tile, pixels.
pub const SIDE: u32 = crate::filter::TILE as u32;

/// Tiles along each side of a film of `size` pixels.
pub fn tiles_of(size: [u32; 2]) -> [u32; 2] {
    size.map(|side| side.div_ceil(SIDE))
}

/// The pixels of tile number `tile` of such a film, in order.
pub fn pixels_of(tile: u32, [width, height]: [u32; 2]) -> impl Iterator<Item = u32> {
    let [columns, _] = tiles_of([width, height]);
    let (x0, y0) = (tile % columns * SIDE, tile / columns * SIDE);
    let row = move |y: u32| (x0..(x0 + SIDE).min(width)).map(move |x| y * width + x);
    (y0..(y0 + SIDE).min(height)).flat_map(row)
}

/// Bytes of the small print of a fragment.
const SMALL_PRINT: usize = 10 + 4 * WORDS;

/// One fragment of a tile.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TileFragment {
    /// y·width + x.
    pub pixel: u32,
    /// Class of material.
    pub class: u16,
    /// Film samples that fell on it.
    pub count: u32,
    /// What is seen beside its channels.
    pub seen: Seen,
}

/// The fragments of one tile and their channel sums, one record after the other.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Tile {
    /// Fragments in order of pixel and class.
    pub fragments: Vec<TileFragment>,
    /// Channels of all fragments, in their order.
    pub values: Vec<f32>,
}

impl Tile {
    /// As bytes for the log.
    pub fn encode(&self) -> Vec<u8> {
        let mut bytes = Vec::with_capacity(4 + SMALL_PRINT * self.fragments.len() + 4 * self.values.len());
        bytes.extend((self.fragments.len() as u32).to_le_bytes());
        for f in &self.fragments {
            bytes.extend(f.pixel.to_le_bytes());
            bytes.extend(f.class.to_le_bytes());
            bytes.extend(f.count.to_le_bytes());
            f.seen.words().iter().for_each(|word| bytes.extend(word.to_le_bytes()));
        }
        self.values.iter().for_each(|v| bytes.extend(v.to_le_bytes()));
        bytes
    }

    /// The inverse of [`Tile::encode`], on bytes whose checksum was right.
    pub fn decode(bytes: &[u8]) -> Self {
        let (count, rest) = bytes.split_at(4);
        let count = u32::from_le_bytes([count[0], count[1], count[2], count[3]]) as usize;
        let (fragments, values) = rest.split_at(SMALL_PRINT * count);
        let fragments = fragments.chunks_exact(SMALL_PRINT).map(fragment).collect();
        let values = values.as_chunks().0.iter().map(|b| f32::from_le_bytes(*b)).collect();
        Self { fragments, values }
    }
}

fn fragment(bytes: &[u8]) -> TileFragment {
    let word = |at: usize| u32::from_le_bytes([bytes[at], bytes[at + 1], bytes[at + 2], bytes[at + 3]]);
    let words = std::array::from_fn(|k| f32::from_bits(word(10 + 4 * k)));
    TileFragment {
        pixel: word(0),
        class: u16::from_le_bytes([bytes[4], bytes[5]]),
        count: word(6),
        seen: Seen::from_words(&words),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tiles_come_back() {
        for n in [0u32, 1, 7] {
            let fragments = (0..n)
                .map(|i| {
                    let seen = Seen::from_words(&std::array::from_fn(|k| k as f32 + 0.5 * i as f32));
                    TileFragment { pixel: i * 7 + n, class: (i % 3) as u16, count: i + 1, seen }
                })
                .collect();
            let tile = Tile { fragments, values: (0..n * 5).map(|i| i as f32 * 0.25 - n as f32).collect() };
            assert_eq!(Tile::decode(&tile.encode()), tile);
        }
    }
}
