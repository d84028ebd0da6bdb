//! How many paths each part of a film has.

/// Samples a pixel, by square tiles of a film.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct TileCounts {
    /// Of the film, pixels.
    size: [u32; 2],
    /// Of a tile, pixels.
    side: u32,
    /// Row by row.
    counts: Vec<u32>,
}

impl TileCounts {
    /// Of a film of `size` pixels in tiles of `side`, row by row, the last of each row and column perhaps
    /// smaller; every tile has a count of its own.
    pub fn new(size: [u32; 2], side: u32, counts: Vec<u32>) -> Self {
        Self { size, side, counts }
    }

    /// Samples of pixel number `pixel`.
    pub fn of(&self, pixel: u32) -> u32 {
        let [x, y] = [pixel % self.size[0], pixel / self.size[0]].map(|at| at / self.side);
        self.counts[(y * self.size[0].div_ceil(self.side) + x) as usize]
    }

    /// Mean over the pixels.
    pub fn mean(&self) -> f64 {
        let pixels = self.size[0] * self.size[1];
        let sum: u64 = (0..pixels).map(|pixel| u64::from(self.of(pixel))).sum();
        sum as f64 / f64::from(pixels)
    }
}
