//! A few frames side by side, to see a whole animation at a glance.

use super::png;
use crate::error::Result;
use relume_formats::state::Rgb;

/// Most frames on a sheet.
const MAX_TILES: usize = 12;
/// Longest side of a tile in pixels; larger frames are reduced by a whole factor.
const MAX_TILE_SIDE: u32 = 512;
/// Pixels between tiles and around them.
const GAP: usize = 4;
/// Linear value of the gaps: dark, yet apart from black.
const GAP_VALUE: Rgb = [0.03; 3];

/// Collects the frames of one sheet.
pub struct ContactSheet {
    frames: usize,
    tiles: Vec<Tile>,
}

struct Tile {
    width: usize,
    height: usize,
    pixels: Vec<Rgb>,
}

impl ContactSheet {
    /// A sheet for an animation of `frames` frames.
    pub fn new(frames: usize) -> Self {
        Self { frames, tiles: Vec::new() }
    }

    /// Whether frame `index` belongs on the sheet: at most 12 frames, evenly spaced, the first and the last
    /// among them.
    pub fn wants(&self, index: usize) -> bool {
        let tiles = self.frames.min(MAX_TILES);
        let last = self.frames.saturating_sub(1);
        (0..tiles)
            .any(|tile| index == (tile * last + tiles.saturating_sub(1) / 2) / tiles.saturating_sub(1).max(1))
    }

    /// Adds the next frame: linear values in 0..=1, row by row.
    pub fn add(&mut self, size: [u32; 2], linear: &[Rgb]) {
        self.tiles.push(reduce(size, linear));
    }

    /// The sheet as a PNG file.
    pub fn encode(&self) -> Result<Vec<u8>> {
        let columns = (1..).find(|n| n * n >= self.tiles.len()).unwrap_or(1);
        let rows = self.tiles.len().div_ceil(columns);
        let (tile_width, tile_height) = self.tiles.first().map_or((1, 1), |t| (t.width, t.height));
        let (width, height) = (columns * (tile_width + GAP) + GAP, rows * (tile_height + GAP) + GAP);
        let mut sheet = vec![GAP_VALUE; width * height];
        for (index, tile) in self.tiles.iter().enumerate() {
            let left = index % columns * (tile_width + GAP) + GAP;
            let top = index / columns * (tile_height + GAP) + GAP;
            for (row, pixels) in tile.pixels.chunks_exact(tile_width).enumerate() {
                let start = (top + row) * width + left;
                if let Some(place) = sheet.get_mut(start..start + tile_width) {
                    place.copy_from_slice(pixels);
                }
            }
        }
        png::encode([width as u32, height as u32], &sheet)
    }
}

/// Averages blocks of pixels, in linear light, until the longer side fits; rows and columns left over are
/// dropped.
fn reduce(size: [u32; 2], linear: &[Rgb]) -> Tile {
    let factor = size[0].max(size[1]).div_ceil(MAX_TILE_SIDE) as usize;
    let source_width = size[0] as usize;
    let (width, height) = ((source_width / factor).max(1), (size[1] as usize / factor).max(1));
    let mean = |x: usize, y: usize| {
        let rows = linear.chunks(source_width).skip(y * factor).take(factor);
        let block = rows.flat_map(|row| row.iter().skip(x * factor).take(factor));
        let (sum, count) =
            block.fold(([0.0; 3], 0.0), |(s, n), p: &Rgb| ([s[0] + p[0], s[1] + p[1], s[2] + p[2]], n + 1.0));
        sum.map(|v: f32| v / f32::max(count, 1.0))
    };
    let pixels = (0..height).flat_map(|y| (0..width).map(move |x| (x, y))).map(|(x, y)| mean(x, y)).collect();
    Tile { width, height, pixels }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn wanted(frames: usize) -> Vec<usize> {
        let sheet = ContactSheet::new(frames);
        (0..frames).filter(|i| sheet.wants(*i)).collect()
    }

    #[test]
    fn frames_are_evenly_spaced_from_first_to_last() {
        assert_eq!(wanted(1), [0]);
        assert_eq!(wanted(2), [0, 1]);
        assert_eq!(wanted(12), (0..12).collect::<Vec<_>>());
        for frames in 13..200 {
            let chosen = wanted(frames);
            assert_eq!((chosen.len(), chosen[0], chosen[11]), (12, 0, frames - 1));
            let steps: Vec<_> = chosen.windows(2).map(|w| w[1] - w[0]).collect();
            assert!(steps.iter().max().unwrap() - steps.iter().min().unwrap() <= 1, "{chosen:?}");
        }
    }

    #[test]
    fn tiles_stand_in_a_grid_with_gaps() {
        let mut sheet = ContactSheet::new(3);
        for value in [0.0, 0.5, 1.0] {
            sheet.add([2, 1], &[[value; 3]; 2]);
        }
        let image = image::load_from_memory(&sheet.encode().unwrap()).unwrap().to_rgb8();
        assert_eq!(image.dimensions(), (2 * (2 + 4) + 4, 2 * (1 + 4) + 4));
        let gap = image.get_pixel(0, 0).0;
        assert_eq!(
            [image.get_pixel(4, 4).0[0], image.get_pixel(11, 4).0[0], image.get_pixel(5, 9).0[0]],
            [0, 188, 255]
        );
        assert_eq!(
            [image.get_pixel(6, 4).0, image.get_pixel(10, 9).0],
            [gap, gap],
            "between tiles, and where the fourth would be"
        );
    }

    #[test]
    fn large_frames_are_averaged() {
        let (width, height) = (1030, 6);
        let linear: Vec<Rgb> =
            (0..width * height).map(|i| [(i % 3) as f32, (i / width % 3) as f32, 1.0]).collect();
        let tile = reduce([width as u32, height as u32], &linear);
        assert_eq!((tile.width, tile.height), (343, 2));
        assert!(
            tile.pixels.iter().all(|p| (p[0] - 1.0).abs() < 1e-6 && (p[1] - 1.0).abs() < 1e-6 && p[2] == 1.0)
        );
    }
}
