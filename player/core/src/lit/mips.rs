//! A texture at half its size, a quarter, and so on, for where it is seen so small that a sample of the
//! picture covers many texels.
//!
//! Every level is the mean of the last over boxes, in linear light, with the exact shares of texels that lie
//! across the edge of a box where a side is odd. Colour under a cut-off counts by alpha, for what is cut away
//! has none: the colour of a hole must not come in. (The shader weighs by alpha again where it samples.)

use relume_formats::basis::{Texture, linear_from_srgb, srgb_from_linear};

/// Linear red, green and blue, and alpha.
type Linear = [f32; 4];

/// All sizes of a texture side by side: the texture itself at the left, the others at its right, one below the
/// other.
#[derive(Debug)]
pub(super) struct Sheet {
    /// Texels of a row, and rows.
    pub(super) size: [u32; 2],
    /// Stored as in the texture.
    pub(super) texels: Vec<[u8; 4]>,
}

/// A size of a texture.
struct Level {
    size: [u32; 2],
    texels: Vec<Linear>,
}

/// In how many sizes there is a texture of `size`: each side half the last one's, rounded down, but 1 at
/// least, down to one texel.
pub(super) fn levels([width, height]: [u32; 2]) -> u32 {
    width.max(height).max(1).ilog2() + 1
}

impl Sheet {
    /// That of `texture`; `cut_out` tells whether its alpha cuts holes.
    pub(super) fn new(texture: &Texture, cut_out: bool) -> Self {
        let smaller = smaller(texture, cut_out);
        let end = |number: usize, level: &Level| {
            let [x, y] = corner(number as u32, texture.size);
            [x + level.size[0], y + level.size[1]]
        };
        let ends = (1..).zip(&smaller).map(|(number, level)| end(number, level));
        let size = ends.fold(texture.size, |size, end| [size[0].max(end[0]), size[1].max(end[1])]);
        let mut sheet = Self { size, texels: vec![[0; 4]; size[0] as usize * size[1] as usize] };
        sheet.place([0, 0], texture.size[0], texture.texels.iter().copied());
        for (number, level) in (1..).zip(smaller) {
            sheet.place(corner(number, texture.size), level.size[0], level.texels.into_iter().map(encoded));
        }
        sheet
    }

    /// Lays out texels in rows of `width`.
    fn place(&mut self, [x, y]: [u32; 2], width: u32, texels: impl Iterator<Item = [u8; 4]>) {
        for (index, texel) in (0..).zip(texels) {
            let [column, row] = [x + index % width, y + index / width].map(|n| n as usize);
            if let Some(place) = self.texels.get_mut(row * self.size[0] as usize + column) {
                *place = texel;
            }
        }
    }
}

/// Where size `number` of a texture of `size` begins on its sheet; the shader's `level_of` knows the same.
fn corner(number: u32, [width, height]: [u32; 2]) -> [u32; 2] {
    let Some(above) = number.checked_sub(1) else { return [0, 0] };
    // As many rows as all before it have, or more where halves were rounded down; sizes of one row follow one
    // another.
    [width, height - (height >> above) + above.saturating_sub(height.max(1).ilog2() + 1)]
}

/// All sizes of a texture but its own.
fn smaller(texture: &Texture, cut_out: bool) -> Vec<Level> {
    let texel = |index: usize| {
        let [r, g, b, a] = texture.texels.get(index).copied().unwrap_or([255; 4]);
        [linear_from_srgb(r), linear_from_srgb(g), linear_from_srgb(b), f32::from(a) / 255.0]
    };
    let mut smaller: Vec<Level> = Vec::new();
    for _ in 1..levels(texture.size) {
        smaller.push(match smaller.last() {
            None => halved(texture.size, texel, cut_out),
            Some(last) => {
                halved(last.size, |index| last.texels.get(index).copied().unwrap_or_default(), cut_out)
            }
        });
    }
    smaller
}

fn encoded([r, g, b, a]: Linear) -> [u8; 4] {
    [srgb_from_linear(r), srgb_from_linear(g), srgb_from_linear(b), (255.0 * a).round() as u8]
}

/// Half of a level of `size` texels.
fn halved(size: [u32; 2], texel: impl Fn(usize) -> Linear, cut_out: bool) -> Level {
    let half = size.map(|side| (side / 2).max(1));
    let [columns, rows] =
        [0, 1].map(|axis| (0..half[axis]).map(|i| shares(i, size[axis])).collect::<Vec<_>>());
    let mean = |row: &Shares, column: &Shares| {
        let (mut plain, mut weighed) = ([0.0; 4], [0.0; 3]);
        for (y, down) in (row.first..).zip(row.shares).filter(|(_, share)| *share > 0.0) {
            for (x, across) in (column.first..).zip(column.shares).filter(|(_, share)| *share > 0.0) {
                let texel = texel(y as usize * size[0] as usize + x as usize);
                let share = down * across;
                (0..4).for_each(|k| plain[k] += share * texel[k]);
                (0..3).for_each(|k| weighed[k] += share * texel[3] * texel[k]);
            }
        }
        let [r, g, b, alpha] = plain;
        match cut_out && alpha > 0.0 {
            true => [weighed[0] / alpha, weighed[1] / alpha, weighed[2] / alpha, alpha],
            false => [r, g, b, alpha],
        }
    };
    let texels = rows.iter().flat_map(|row| columns.iter().map(move |column| mean(row, column))).collect();
    Level { size: half, texels }
}

/// The texels of a side that one of half as many covers: the first, and the share of each in it.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Shares {
    first: u32,
    shares: [f32; 3],
}

/// Those of texel `index` of the half of a side of `count`.
fn shares(index: u32, count: u32) -> Shares {
    let half = count / 2;
    let of = |part: u32| part as f32 / count as f32;
    let shares = match count {
        1 => [1.0, 0.0, 0.0],
        _ if count.is_multiple_of(2) => [0.5, 0.5, 0.0],
        // Texel i covers 2i + i/half to 2i + 2 + (i + 1)/half.
        _ => [of(half - index), of(half), of(index + 1)],
    };
    Shares { first: 2 * index, shares }
}

#[cfg(test)]
mod tests {
    use super::*;
    use relume_formats::basis::{Filter, Wrap};

    fn texture([width, height]: [u32; 2], texel: impl Fn(u32, u32) -> [u8; 4]) -> Texture {
        let texels = (0..width * height).map(|i| texel(i % width, i / width)).collect();
        Texture { size: [width, height], wrap: [Wrap::Repeat; 2], filter: Filter::Linear, texels }
    }

    const SIZES: [[u32; 2]; 9] =
        [[1, 1], [8, 8], [8, 1], [1, 8], [13, 3], [3, 13], [7, 5], [100, 2], [33, 17]];

    #[test]
    fn what_is_even_stays_so_to_the_bit() {
        for size in SIZES {
            for colour in [[0, 0, 0, 255], [255; 4], [1, 77, 200, 3], [188, 10, 254, 128]] {
                for cut_out in [false, true] {
                    for level in smaller(&texture(size, |_, _| colour), cut_out) {
                        assert!(level.texels.iter().all(|texel| encoded(*texel) == colour), "{size:?}");
                    }
                }
            }
        }
    }

    #[test]
    fn checks_become_their_mean_in_linear_light() {
        let checks = texture([8, 8], |x, y| if (x + y) % 2 == 0 { [255; 4] } else { [0, 0, 0, 255] });
        let levels = smaller(&checks, false);
        assert_eq!(levels.iter().map(|level| level.size).collect::<Vec<_>>(), [[4, 4], [2, 2], [1, 1]]);
        for texel in levels.iter().flat_map(|level| &level.texels) {
            // Half as much light is 188 of 255 in sRGB; half of 255 would be a fifth of it.
            assert_eq!((*texel, encoded(*texel)), ([0.5, 0.5, 0.5, 1.0], [188, 188, 188, 255]));
        }
    }

    /// The mean over a box of texels, given by its ends along both axes, by the areas of its parts.
    fn mean_over(texture: &Texture, [x0, x1]: [f64; 2], [y0, y1]: [f64; 2]) -> f64 {
        let part = |i: u32, from: f64, to: f64| (to.min(f64::from(i + 1)) - from.max(f64::from(i))).max(0.0);
        let [width, height] = texture.size;
        let of = |x: u32, y: u32| {
            let value = f64::from(linear_from_srgb(texture.texels[(y * width + x) as usize][0]));
            value * part(x, x0, x1) * part(y, y0, y1)
        };
        let sum: f64 = (0..height).flat_map(|y| (0..width).map(move |x| (x, y))).map(|(x, y)| of(x, y)).sum();
        sum / ((x1 - x0) * (y1 - y0))
    }

    #[test]
    fn boxes_of_odd_sides_count_texels_by_their_share() {
        for size in SIZES {
            let uneven = texture(size, |x, y| [(x * 89 + y * 151 + x * y * 7) as u8, 0, 0, 255]);
            let levels = smaller(&uneven, false);
            let whole = mean_over(&uneven, [0.0, f64::from(size[0])], [0.0, f64::from(size[1])]);
            let Some(first) = levels.first() else { continue };
            let [w, h] = first.size;
            for (index, texel) in (0..).zip(&first.texels) {
                let ends = |i: u32, half: u32, count: u32| {
                    [i, i + 1].map(|i| f64::from(i) * f64::from(count) / f64::from(half))
                };
                let expected = mean_over(&uneven, ends(index % w, w, size[0]), ends(index / w, h, size[1]));
                assert!((f64::from(texel[0]) - expected).abs() < 1e-6, "{size:?} {index}");
            }
            // Whatever the sides, no light is lost on the way down.
            let last = levels.last().unwrap();
            assert_eq!(last.size, [1, 1]);
            assert!((f64::from(last.texels[0][0]) - whole).abs() < 1e-6, "{size:?}");
        }
    }

    #[test]
    fn the_colour_of_holes_counts_for_nothing() {
        // The left half is red, but for green texels of which nothing is seen; the right half is a hole.
        let holes = texture([8, 8], |x, y| match (x < 4, (x + y) % 2 == 0) {
            (true, true) => [255, 0, 0, 255],
            _ => [0, 255, 0, 0],
        });
        for level in smaller(&holes, true) {
            let width = level.size[0];
            for (index, texel) in (0..).zip(&level.texels) {
                assert!(texel[3] == 0.0 || texel[..3] == [1.0, 0.0, 0.0], "{width} {index}");
                let alpha =
                    if width == 1 { 0.25 } else { f32::from(u8::from(index % width < width / 2)) / 2.0 };
                assert_eq!(texel[3], alpha, "{width} {index}");
            }
        }
        // Where alpha cuts nothing, it is as good as not there.
        let last = smaller(&holes, false).pop().unwrap();
        assert_eq!(last.texels, [[0.25, 0.75, 0.0, 0.25]]);
    }

    #[test]
    fn all_sizes_have_places_of_their_own_on_the_sheet() {
        for size in SIZES.into_iter().chain([[4096, 3], [3, 4096], [64, 64]]) {
            let sheet = Sheet::new(&texture(size, |_, _| [9; 4]), false);
            let area: u32 = (0..levels(size)).map(|k| (size[0] >> k).max(1) * (size[1] >> k).max(1)).sum();
            assert_eq!(
                sheet.texels.iter().filter(|texel| **texel == [9; 4]).count(),
                area as usize,
                "{size:?}"
            );
            assert_eq!(sheet.texels.len(), (sheet.size[0] * sheet.size[1]) as usize);
            assert!(sheet.size[0] <= size[0] + (size[0] / 2).max(1) && sheet.size[1] <= size[1] + 12);
        }
    }
}
