//! Tiles of finished fragments, as the work log keeps them.

/// One fragment of a tile.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TileFragment {
    /// y·width + x.
    pub pixel: u32,
    /// Class of material.
    pub class: u16,
    /// Film samples that fell on it.
    pub count: u32,
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
        let mut bytes = Vec::with_capacity(4 + 10 * self.fragments.len() + 4 * self.values.len());
        bytes.extend((self.fragments.len() as u32).to_le_bytes());
        for f in &self.fragments {
            bytes.extend(f.pixel.to_le_bytes());
            bytes.extend(f.class.to_le_bytes());
            bytes.extend(f.count.to_le_bytes());
        }
        self.values.iter().for_each(|v| bytes.extend(v.to_le_bytes()));
        bytes
    }

    /// The inverse of [`Tile::encode`], on bytes whose checksum was right.
    pub fn decode(bytes: &[u8]) -> Self {
        let word = |at: usize| u32::from_le_bytes([bytes[at], bytes[at + 1], bytes[at + 2], bytes[at + 3]]);
        let count = word(0) as usize;
        let fragment = |i: usize| {
            let at = 4 + 10 * i;
            TileFragment {
                pixel: word(at),
                class: u16::from_le_bytes([bytes[at + 4], bytes[at + 5]]),
                count: word(at + 6),
            }
        };
        let fragments = (0..count).map(fragment).collect();
        let values = bytes[4 + 10 * count..].as_chunks().0.iter().map(|b| f32::from_le_bytes(*b)).collect();
        Self { fragments, values }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tiles_come_back() {
        for n in [0u32, 1, 7] {
            let fragments = (0..n)
                .map(|i| TileFragment { pixel: i * 7 + n, class: (i % 3) as u16, count: i + 1 })
                .collect();
            let tile = Tile { fragments, values: (0..n * 5).map(|i| i as f32 * 0.25 - n as f32).collect() };
            assert_eq!(Tile::decode(&tile.encode()), tile);
        }
    }
}
