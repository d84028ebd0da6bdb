//! The cells in which light that was reflected before is stored.
//!
//! A plane has square tiles of [`SIDE`] × [`SIDE`] cells, each transformed to Haar coefficients of its own
//! ([`crate::basis::haar`]). The first tiles lie over the film, row by row, the last of each row and column perhaps
//! beyond its edge. Of each pixel the fragment that covers most of it has the cell there, the first of those that
//! cover it alike; the others have the cells of the tiles that follow, one after the other.

use crate::kinds::transfer_images::Fragments;

/// Cells along each side of a tile.
pub const SIDE: usize = 32;
/// Cells of a tile.
pub const CELLS: usize = SIDE * SIDE;

/// Where fragments have their cells.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Planes {
    /// Number of tiles.
    pub tiles: usize,
    /// By fragment: tile · [`CELLS`] + row · [`SIDE`] + column.
    pub cells: Vec<u32>,
}

impl Planes {
    /// Of the fragments of a film of `size` pixels.
    pub fn new(size: [u32; 2], fragments: &Fragments) -> Self {
        let [columns, rows] = size.map(|side| (side as usize).div_ceil(SIDE));
        let width = size[0] as usize;
        let mut best: Vec<Option<u32>> = vec![None; width * size[1] as usize];
        for (fragment, pixel) in (0..).zip(&fragments.pixel) {
            let Some(best) = best.get_mut(*pixel as usize) else { continue };
            let coverage = |fragment: u32| fragments.coverage.get(fragment as usize);
            if best.is_none_or(|before| coverage(fragment) > coverage(before)) {
                *best = Some(fragment);
            }
        }
        let mut others = (columns * rows * CELLS) as u32..;
        let cell = |(fragment, pixel): (u32, &u32)| {
            let pixel = *pixel as usize;
            if best.get(pixel).is_some_and(|best| *best == Some(fragment)) {
                let (x, y) = (pixel % width, pixel / width);
                let tile = y / SIDE * columns + x / SIDE;
                (tile * CELLS + y % SIDE * SIDE + x % SIDE) as u32
            } else {
                others.next().unwrap_or_default()
            }
        };
        let cells: Vec<u32> = (0..).zip(&fragments.pixel).map(cell).collect();
        let beyond = others.start as usize - columns * rows * CELLS;
        Self { tiles: columns * rows + beyond.div_ceil(CELLS), cells }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use half::f16;

    #[test]
    fn every_fragment_has_a_cell_of_its_own_and_the_largest_that_of_its_pixel() {
        let fragments = Fragments {
            pixel: vec![0, 1, 33, 40, 1, 40, 40],
            class: vec![0, 0, 0, 1, 2, 2, 2],
            coverage: [1.0, 0.4, 1.0, 0.3, 0.6, 0.3, 0.4].map(f16::from_f32).to_vec(),
        };
        let planes = Planes::new([40, 2], &fragments);
        let beyond = 2 * CELLS as u32;
        assert_eq!(planes.tiles, 3);
        assert_eq!(planes.cells, [0, beyond, CELLS as u32 + 1, beyond + 1, 1, beyond + 2, SIDE as u32]);
    }

    #[test]
    fn a_film_without_fragments_has_its_own_tiles_alone() {
        let none = Fragments { pixel: Vec::new(), class: Vec::new(), coverage: Vec::new() };
        assert_eq!(Planes::new([33, 64], &none).tiles, 4);
    }
}
