//! From records of fragments to Haar coefficients, tile by tile of the planes: how small steps must be, and then the
//! coefficients that are at least a step.

use super::layout::Layout;
use super::rows::RowOf;
use crate::error::Result;
use crate::fragments::{Records, SIDE as TRACED, TileFragment, tiles_of};
use crate::interrupted::Interrupted;
use crate::job::Job;
use half::f16;
use rayon::prelude::*;
use relume_formats::basis::haar;
use relume_formats::kinds::region_images::Entries;
use relume_formats::kinds::region_images::planes::{CELLS, Planes, SIDE};
use relume_formats::kinds::transfer_images::Fragments;

/// Tiles of paths along each side of a tile of cells.
const RATIO: u32 = SIDE as u32 / TRACED;
/// Bins of sizes of coefficients: so many for each factor of two, from 2^[`LOWEST`] on.
const BINS_PER_OCTAVE: f64 = 8.0;
const LOWEST: f64 = -100.0;
const BINS: usize = 1600;
/// Tiles of cells that are in memory at a time.
const BATCH: usize = 16;

/// All that is baked of light that was reflected before.
pub struct Cells<'a> {
    /// Sums of the fragments.
    pub records: &'a Records<'a>,
    /// What they are of.
    pub layout: &'a Layout,
    /// By basis of the eye.
    pub rows: &'a [Vec<RowOf>],
    /// Pixels of the film.
    pub size: [u32; 2],
    /// The fragments in the order of the file.
    pub fragments: &'a Fragments,
    /// Number of those of materials that vary.
    pub editable: usize,
    /// Where they have their cells.
    pub planes: &'a Planes,
}

/// What coefficients there are, by their size over what a unit shows.
pub struct Sizes {
    counts: Vec<u64>,
    squares: Vec<f64>,
}

/// By row of all bases of the eye, one after the other: the cells of a tile.
type Tile = Vec<Vec<f32>>;

/// The rows that have anything at a place, and how many steps.
type Place = Vec<(u16, i16)>;

impl Cells<'_> {
    fn row_count(&self) -> usize {
        self.rows.iter().map(Vec::len).sum()
    }

    /// The number of a fragment in the file.
    fn number(&self, fragment: &TileFragment) -> Option<usize> {
        let Fragments { pixel, class, .. } = self.fragments;
        let is_fixed = fragment.class == self.records.fixed;
        let (start, end) = if is_fixed { (self.editable, pixel.len()) } else { (0, self.editable) };
        let key = |at: usize| (pixel[at], class[at]);
        let wanted = (fragment.pixel, fragment.class);
        let (mut low, mut high) = (start, end);
        while low < high {
            let middle = low + (high - low) / 2;
            if key(middle) < wanted { low = middle + 1 } else { high = middle }
        }
        (low < end && key(low) == wanted).then_some(low)
    }

    /// The numbers of the tiles of paths that a tile of cells lies over.
    fn traced_below(&self, tile: usize) -> Vec<u32> {
        let ([columns, rows], [wide, _]) =
            (tiles_of(self.size), self.size.map(|side| side.div_ceil(SIDE as u32)));
        let (x0, y0) = (tile as u32 % wide * RATIO, tile as u32 / wide * RATIO);
        let across = move |y: u32| (x0..(x0 + RATIO).min(columns)).map(move |x| y * columns + x);
        (y0..(y0 + RATIO).min(rows)).flat_map(across).collect()
    }

    /// Number of tiles of cells that lie over the film.
    fn over_film(&self) -> usize {
        let [columns, rows] = self.size.map(|side| (side as usize).div_ceil(SIDE));
        columns * rows
    }

    /// What each row is in the fragments of some tiles of paths, with their cells, as far as these are `wanted`.
    fn values(&self, traced: &[u32], wanted: impl Fn(usize) -> bool) -> Result<Vec<(usize, Vec<f32>)>> {
        let mut found = Vec::new();
        for number in traced {
            let tile = self.records.tile(*number)?;
            for (fragment, record) in self.records.of(&tile)? {
                let Some(number) = self.number(&fragment) else { continue };
                let cell = self.planes.cells[number] as usize;
                if !wanted(cell) {
                    continue;
                }
                let samples = (self.records.samples)(fragment.pixel) as f32;
                let share = 1.0 / (samples * self.fragments.coverage[number].to_f32());
                let is_fixed = fragment.class == self.records.fixed;
                let of_row = |row: &RowOf| row.value(self.layout, is_fixed, record) * share;
                found.push((cell, self.rows.iter().flatten().map(of_row).collect()));
            }
        }
        Ok(found)
    }

    /// The Haar coefficients of a tile that holds such values of cells.
    fn transformed(&self, values: &[(usize, Vec<f32>)]) -> Tile {
        let mut known = vec![false; CELLS];
        values.iter().for_each(|(cell, _)| known[cell % CELLS] = true);
        let filling = Filling::new(&known);
        let mut scratch = Vec::new();
        (0..self.row_count())
            .map(|row| {
                let mut cells = vec![0.0; CELLS];
                values.iter().for_each(|(cell, values)| cells[cell % CELLS] = values[row]);
                filling.fill(&mut cells);
                haar::forward(&mut cells, SIDE, &mut scratch);
                cells
            })
            .collect()
    }

    /// Hands over the coefficients of all tiles, in their order.
    fn for_each_tile(&self, name: &'static str, job: &Job, mut each: impl FnMut(Tile)) -> Result<()> {
        let (over_film, all) = (self.over_film(), self.planes.tiles);
        let progress = job.progress(name, all as u64);
        // Fragments without a cell on the film are few, and anywhere.
        let mut beyond: Vec<Vec<(usize, Vec<f32>)>> = vec![Vec::new(); all - over_film];
        let numbers: Vec<usize> = (0..over_film).collect();
        for batch in numbers.chunks(BATCH) {
            progress.check().map_err(|Interrupted| Interrupted)?;
            let done = batch.par_iter().map(|tile| {
                let values = self.values(&self.traced_below(*tile), |_| true)?;
                let (others, own): (Vec<_>, Vec<_>) =
                    values.into_iter().partition(|(cell, _)| cell / CELLS >= over_film);
                Ok((self.transformed(&own), others))
            });
            for (tile, others) in done.collect::<Result<Vec<_>>>()? {
                each(tile);
                others.into_iter().for_each(|value| beyond[value.0 / CELLS - over_film].push(value));
            }
            progress.advance(batch.len() as u64);
        }
        for batch in beyond.chunks(BATCH) {
            let tiles: Vec<Tile> = batch.par_iter().map(|values| self.transformed(values)).collect();
            tiles.into_iter().for_each(&mut each);
            progress.advance(batch.len() as u64);
        }
        Ok(())
    }

    /// What a unit of each row shows, in the mean over states.
    fn units(&self) -> Vec<f64> {
        self.rows.iter().flatten().map(|row| row.square.sqrt()).collect()
    }

    /// What coefficients there are.
    ///
    /// # Errors
    /// If the log cannot be read or the job is interrupted.
    pub fn sizes(&self, job: &Job) -> Result<Sizes> {
        let units = self.units();
        let mut sizes = Sizes { counts: vec![0; BINS], squares: vec![0.0; BINS] };
        self.for_each_tile("measuring light between surfaces", job, |tile| {
            for (cells, unit) in tile.iter().zip(&units) {
                cells.iter().for_each(|value| sizes.add(f64::from(value.abs()) * unit));
            }
        })?;
        Ok(sizes)
    }

    /// The entries of each basis of the eye whose coefficients show at least `step`, and the steps of its rows.
    ///
    /// # Errors
    /// If the log cannot be read or the job is interrupted.
    pub fn entries(&self, step: f64, job: &Job) -> Result<Vec<(Vec<f32>, Entries)>> {
        let steps: Vec<f32> =
            self.units().iter().map(|unit| (step / unit.max(f64::MIN_POSITIVE)) as f32).collect();
        let mut places: Vec<Vec<Place>> = vec![Vec::new(); self.rows.len()];
        self.for_each_tile("compressing light between surfaces", job, |tile| {
            let mut first = 0;
            for (places, rows) in places.iter_mut().zip(self.rows) {
                let range = first..first + rows.len();
                let (tile, steps) = (&tile[range.clone()], &steps[range]);
                places.extend(
                    (0..CELLS).into_par_iter().map(|place| of_place(tile, steps, place)).collect::<Vec<_>>(),
                );
                first += rows.len();
            }
        })?;
        let mut steps = steps.as_slice();
        let of_eye = |(places, rows): (Vec<Place>, &Vec<RowOf>)| {
            let (own, rest) = steps.split_at(rows.len());
            steps = rest;
            (own.to_vec(), Entries::of_places(&places))
        };
        Ok(places.into_iter().zip(self.rows).map(of_eye).collect())
    }
}

/// The coefficients at a place that are at least a step of their row.
fn of_place(tile: &[Vec<f32>], steps: &[f32], place: usize) -> Place {
    let of_row = |(row, (cells, step)): (u16, (&Vec<f32>, &f32))| {
        let steps = cells[place] / step;
        (steps.abs() >= 1.0).then(|| (row, steps.round().clamp(-32_767.0, 32_767.0) as i16))
    };
    (0..).zip(tile.iter().zip(steps)).filter_map(of_row).collect()
}

impl Sizes {
    fn add(&mut self, size: f64) {
        if size > 0.0 {
            let bin = ((size.log2() - LOWEST) * BINS_PER_OCTAVE).clamp(0.0, BINS as f64 - 1.0) as usize;
            self.counts[bin] += 1;
            self.squares[bin] += size * size;
        }
    }

    /// The largest step of which coefficients that are less than one, and the rounding of the others, show no more
    /// than `budget`, a sum of squares.
    pub fn step_for(&self, budget: f64) -> f64 {
        let kept: u64 = self.counts.iter().sum();
        let (mut dropped, mut kept, mut best) = (0.0, kept as f64, LOWEST.exp2());
        for (bin, (count, squares)) in self.counts.iter().zip(&self.squares).enumerate() {
            let step = (LOWEST + bin as f64 / BINS_PER_OCTAVE).exp2();
            if dropped + kept * step * step / 12.0 > budget {
                break;
            }
            best = step;
            (dropped, kept) = (dropped + squares, kept - *count as f64);
        }
        best
    }
}

/// Gives cells of a tile that nothing is known of values that take the fewest coefficients: the mean of what is known
/// in the least square of the transform around them that anything is known of.
struct Filling {
    /// From the finest level up: by square, how many of its four parts are known.
    counts: Vec<Vec<u8>>,
    is_full: bool,
}

impl Filling {
    fn new(known: &[bool]) -> Self {
        let mut counts: Vec<Vec<u8>> = vec![known.iter().map(|known| u8::from(*known)).collect()];
        let mut side = SIDE;
        while side > 1 {
            let below = &counts[counts.len() - 1];
            let known = |x: usize, y: usize| u8::from(below[y * side + x] > 0);
            let half = side / 2;
            let square = |i: usize| {
                let (x, y) = (2 * (i % half), 2 * (i / half));
                known(x, y) + known(x + 1, y) + known(x, y + 1) + known(x + 1, y + 1)
            };
            counts.push((0..half * half).map(square).collect());
            side = half;
        }
        Self { is_full: known.iter().all(|known| *known), counts }
    }

    fn fill(&self, cells: &mut [f32]) {
        if self.is_full {
            return;
        }
        // Means of what is known, up.
        let mut means: Vec<Vec<f32>> = vec![cells.to_vec()];
        let mut side = SIDE;
        for level in 1..self.counts.len() {
            let (below, known, half) = (&means[level - 1], &self.counts[level - 1], side / 2);
            let square = |i: usize| {
                let (x, y) = (2 * (i % half), 2 * (i / half));
                let parts = [y * side + x, y * side + x + 1, (y + 1) * side + x, (y + 1) * side + x + 1];
                let sum: f32 = parts.iter().filter(|part| known[**part] > 0).map(|part| below[*part]).sum();
                sum / f32::from(self.counts[level][i].max(1))
            };
            let next = (0..half * half).map(square).collect();
            means.push(next);
            side = half;
        }
        // And down to what is not.
        for level in (0..self.counts.len() - 1).rev() {
            let side = SIDE >> level;
            let (below, above) = means.split_at_mut(level + 1);
            for i in 0..side * side {
                if self.counts[level][i] == 0 {
                    below[level][i] = above[0][i / side / 2 * (side / 2) + i % side / 2];
                }
            }
        }
        cells.copy_from_slice(&means[0]);
    }
}

/// A coverage as files have it.
pub fn coverage(count: u32, samples: u32) -> f16 {
    f16::from_f32(count as f32 / samples as f32).max(f16::from_bits(1))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn filled_cells_cost_nothing_and_known_ones_stay() {
        let known: Vec<bool> = (0..CELLS).map(|i| (i / SIDE) > 20 || (i % SIDE) == 3).collect();
        let mut cells: Vec<f32> = (0..CELLS).map(|i| if known[i] { (i % 17) as f32 } else { 0.0 }).collect();
        let before = cells.clone();
        Filling::new(&known).fill(&mut cells);
        assert!((0..CELLS).all(|i| !known[i] || cells[i] == before[i]));
        // One value alone fills everything.
        let mut one = vec![0.0; CELLS];
        one[77] = 5.0;
        let known: Vec<bool> = (0..CELLS).map(|i| i == 77).collect();
        Filling::new(&known).fill(&mut one);
        assert_eq!(one, vec![5.0; CELLS]);
        let mut none = vec![0.0; CELLS];
        Filling::new(&vec![false; CELLS]).fill(&mut none);
        assert_eq!(none, vec![0.0; CELLS]);
    }

    #[test]
    fn steps_keep_to_their_budget() {
        let sizes: Vec<f64> = (1..2000).map(|i| 1.0 / f64::from(i)).collect();
        let mut all = Sizes { counts: vec![0; BINS], squares: vec![0.0; BINS] };
        sizes.iter().for_each(|size| all.add(*size));
        for budget in [1e-5, 1e-3, 0.1] {
            let step = all.step_for(budget);
            let error = |step: f64| {
                let of = |size: &f64| if *size < step { size * size } else { step * step / 12.0 };
                sizes.iter().map(of).sum::<f64>()
            };
            assert!(error(step) <= 1.05 * budget && error(1.2 * step) > 0.95 * budget, "{budget}: {step}");
        }
    }
}
