//! Radiance from bitmaps and folded weights.

use super::caps::Rows;
use super::fold::{Fine, TILE_ROWS, TILES, Weights};
use super::{LANES, Lanes};
use crate::basis::two_level::SIDE;
use crate::evaluate::sphere_shadows::Receiver;
use crate::kinds::HaarTable;
use crate::state::Rgb;

/// Visible texels of all tiles, in the order of counts, four to a word.
type Counts = [u32; 2 * TILE_ROWS];

/// Partial sums of red, green and blue: many, so that additions need not wait for each other.
type Sums = [[f32; SIDE]; 3];

#[inline(always)]
pub(super) fn radiance(
    rows: &Rows,
    receivers: &[Receiver],
    weights: &Weights,
    table: &HaarTable,
    out: &mut [Rgb],
) {
    match weights {
        Weights::Tiles { tiles, fine } => {
            let counts = visible(rows);
            let bits = fine_bits(rows, fine);
            for (lane, (receiver, out)) in receivers.iter().zip(out).enumerate() {
                let (lobes, count) = used(receiver);
                let mut sums = [[0.0; SIDE]; 3];
                add_tiles(&mut sums, &counts[lane], &lobes[..count], tiles);
                add_fine(&mut sums, &bits, lane, &lobes[..count], fine, table);
                *out = totals(&mut sums);
            }
        }
        Weights::Texels { texels } => {
            for (lane, (receiver, out)) in receivers.iter().zip(out).enumerate() {
                let (lobes, count) = used(receiver);
                let mut sums = [[0.0; SIDE]; 3];
                add_texels(&mut sums, rows, lane, &lobes[..count], texels);
                *out = totals(&mut sums);
            }
        }
    }
}

#[inline(always)]
fn totals(sums: &mut Sums) -> Rgb {
    for half in [16, 8, 4, 2, 1] {
        for sums in sums.iter_mut() {
            for k in 0..half {
                sums[k] += sums[k + half];
            }
        }
    }
    [sums[0][0], sums[1][0], sums[2][0]]
}

/// The lobes that a receiver uses.
#[inline(always)]
fn used(receiver: &Receiver) -> ([(usize, f32); 4], usize) {
    let (mut found, mut count) = ([(0, 0.0); 4], 0);
    for (lobe, weight) in receiver.lobes {
        if weight != 0.0 {
            found[count] = (lobe as usize, weight);
            count += 1;
        }
    }
    (found, count)
}

/// Visible texels of each tile, for each receiver.
#[inline(always)]
fn visible(rows: &Rows) -> Lanes<Counts> {
    let mut counts = [[0; 2 * TILE_ROWS]; LANES];
    for (tile_row, rows) in rows.as_chunks::<4>().0.iter().enumerate() {
        let mut words = [[0; LANES]; 2];
        for lane in 0..LANES {
            // Bits of a tile stand four in a row: their number, in each four bits, is at most 4; of four rows
            // at most 16, which needs eight.
            let (mut even, mut odd) = (0x1010_1010, 0x1010_1010);
            for row in rows {
                let pairs = row[lane] - ((row[lane] >> 1) & 0x5555_5555);
                let fours = (pairs & 0x3333_3333) + ((pairs >> 2) & 0x3333_3333);
                even -= fours & 0x0F0F_0F0F;
                odd -= (fours >> 4) & 0x0F0F_0F0F;
            }
            (words[0][lane], words[1][lane]) = (even, odd);
        }
        for lane in 0..LANES {
            counts[lane][2 * tile_row] = words[0][lane];
            counts[lane][2 * tile_row + 1] = words[1][lane];
        }
    }
    counts
}

#[inline(always)]
fn add_tiles(
    sums: &mut Sums,
    counts: &Counts,
    used: &[(usize, f32)],
    tiles: &[[[f32; TILE_ROWS * TILES]; 3]],
) {
    let mut visible = [0.0; TILE_ROWS * TILES];
    for (values, word) in visible.as_chunks_mut::<4>().0.iter_mut().zip(counts) {
        for (k, value) in values.iter_mut().enumerate() {
            *value = f32::from((word >> (8 * k)) as u8);
        }
    }
    for &(lobe, weight) in used {
        let [red, green, blue] = &tiles[lobe];
        for (at, visible) in visible.as_chunks::<SIDE>().0.iter().enumerate() {
            for k in 0..SIDE {
                let visible = weight * visible[k];
                sums[0][k] += visible * red[at * SIDE + k];
                sums[1][k] += visible * green[at * SIDE + k];
                sums[2][k] += visible * blue[at * SIDE + k];
            }
        }
    }
}

/// The bitmaps of the fine tiles that some receiver sees a part of: number of the tile, and 16 blocked texels
/// for each receiver.
#[inline(always)]
fn fine_bits(rows: &Rows, fine: &Fine) -> Vec<(usize, Lanes<u32>)> {
    let mut found = Vec::with_capacity(fine.tiles.len());
    for (tile, (first, x)) in fine.tiles.iter().enumerate() {
        let (mut bits, mut any) = ([0; LANES], 0);
        for lane in 0..LANES {
            for y in 0..4 {
                bits[lane] |= (rows[first + y][lane] >> (4 * x) & 15) << (4 * y);
            }
            any |= if bits[lane] != 0 && bits[lane] != 0xFFFF { 1 } else { 0 };
        }
        if any != 0 {
            found.push((tile, bits));
        }
    }
    found
}

/// Adds what the second level of visibility gives with the light's terms.
#[inline(always)]
fn add_fine(
    sums: &mut Sums,
    tiles: &[(usize, Lanes<u32>)],
    lane: usize,
    used: &[(usize, f32)],
    fine: &Fine,
    table: &HaarTable,
) {
    for (tile, bits) in tiles {
        let bits = bits[lane] as u16;
        // A tile that is all visible or all blocked has no details.
        if bits == 0 || bits == u16::MAX {
            continue;
        }
        let mut means = [0.0; 16];
        for &(lobe, weight) in used {
            let known = &fine.means[lobe][*tile];
            for k in 0..16 {
                means[k] += weight * known[k];
            }
        }
        let (visible, light) = (table.tile(!bits), &fine.light[*tile]);
        for k in 0..16 {
            let both = visible[k] * means[k];
            for c in 0..3 {
                sums[c][k] += light[c][k] * both;
            }
        }
    }
}

#[inline(always)]
fn add_texels(
    sums: &mut Sums,
    rows: &Rows,
    lane: usize,
    used: &[(usize, f32)],
    texels: &[[[f32; 6 * SIDE * SIDE]; 3]],
) {
    for &(lobe, weight) in used {
        for (sums, weights) in sums.iter_mut().zip(&texels[lobe]) {
            for (row, weights) in rows.iter().zip(weights.as_chunks::<SIDE>().0) {
                let visible = !row[lane];
                for x in 0..SIDE {
                    sums[x] += if (visible >> x) & 1 == 1 { weight * weights[x] } else { 0.0 };
                }
            }
        }
    }
}
