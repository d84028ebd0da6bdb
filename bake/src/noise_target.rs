//! How many samples each tile gets so that a bake has no more noise than asked for.
//!
//! Noise is that of the random states that the filter looks at, and never of the default alone. Paths of a seed of
//! their own tell how noisy tiles are, so that the estimates of the bake stay unbiased. With v the variance of a
//! tile's samples, n samples a pixel leave v/n; of all ways to spread a number of samples the least is left by n ∝ √v.
//! What the filter leaves of that is tried on a few small windows, at twice the samples each time.

use crate::filter::seen::{LAYERS, STATES, Seen, half_of};
use crate::filter::{self, Film, Fragment, Watcher};
use crate::interrupted::Interrupted;
use crate::job::{Job, Progress, ProgressMode};
use crate::trace::gather::{Gather, GatherPath};
use crate::trace::sampler::PixelSampler;
use crate::trace::tile_counts::TileCounts;
use rayon::prelude::*;
use relume_scenes::Scene;
use std::collections::BTreeMap;
use std::ops::Range;

/// Side of the tiles.
const TILE: u32 = filter::TILE as u32;
/// The seed of the paths that tell.
const SEED: u64 = 0x6e6f_6973_65;
/// One pixel of each square of this side is looked at, by so many paths.
const SPACING: u32 = 4;
const PATHS: u32 = 32;
/// How far counts may be from even ones, in parts of these: what few paths say of a tile is noisy itself.
const LEAST: f64 = 0.25;
const MOST: f64 = 8.0;
/// What a tile counts at least, in parts of the mean variance: where few paths found nothing more may.
const FLOOR: f64 = 0.02;
/// Fewest samples that a film has in the mean, and a pixel: halves of fewer tell nothing.
pub const FEWEST: u32 = 16;
const FEWEST_OF_PIXEL: f64 = 4.0;
/// For so many tiles there is a window, and the most windows; their side, tiles.
const TILES_PER_WINDOW: usize = 128;
const WINDOWS: usize = 8;
const WINDOW: u32 = 4;

/// What is asked for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NoiseTarget {
    /// Relative L2 error over random states.
    pub noise: f64,
    /// Whether what is left by the filter is meant.
    pub filter: bool,
}

/// Counts for a film of `size`, of `most` in the mean at most, that leave about the noise of `target` to the paths
/// of `gather`; even ones in the dark.
///
/// # Errors
/// If the job is interrupted.
pub fn counts(
    scene: &Scene,
    gather: &Gather<'_>,
    size: [u32; 2],
    most: u32,
    target: NoiseTarget,
    job: &Job,
) -> Result<TileCounts, Interrupted> {
    let pilot = Pilot { scene, gather: gather.seeded(SEED), watcher: Watcher::new(scene), size };
    let shares = Shares::new(&pilot.tiles(job)?, size);
    let samples = if target.filter {
        pilot.samples_with_filter(&shares, most, target.noise, job)?
    } else {
        (shares.left / target.noise.powi(2)).clamp(f64::from(FEWEST.min(most)), f64::from(most))
    };
    Ok(TileCounts::new(size, TILE, shares.counts(samples)))
}

/// What a tile shows, by state.
#[derive(Debug, Clone, Copy, Default)]
struct TileNoise {
    pixels: f64,
    /// Variance of one sample of each pixel, summed over them.
    variance: [f64; STATES],
    /// What that seems to be by the difference of two halves: samples are stratified, so their mean is known better
    /// than its samples tell.
    of_halves: [f64; STATES],
    /// Squares of what pixels show, summed over them.
    light: [f64; STATES],
}

/// Paths that tell.
struct Pilot<'a> {
    scene: &'a Scene,
    gather: Gather<'a>,
    watcher: Watcher,
    size: [u32; 2],
}

impl Pilot<'_> {
    fn tiles(&self, job: &Job) -> Result<Vec<TileNoise>, Interrupted> {
        let [columns, rows] = self.size.map(|side| side.div_ceil(TILE));
        let progress = job.progress("looking for noise", u64::from(columns * rows));
        let tile = |number: u32| {
            progress.check()?;
            let noise = self.tile([number % columns * TILE, number / columns * TILE]);
            progress.advance(1);
            Ok(noise)
        };
        (0..columns * rows).into_par_iter().map(tile).collect()
    }

    fn tile(&self, [x0, y0]: [u32; 2]) -> TileNoise {
        let [width, height] = self.size;
        let [x1, y1] = [(x0 + TILE).min(width), (y0 + TILE).min(height)];
        let mut sums = TileNoise { pixels: f64::from((x1 - x0) * (y1 - y0)), ..TileNoise::default() };
        let mut looked_at = 0.0;
        for y in (y0..y1).step_by(SPACING as usize) {
            for x in (x0..x1).step_by(SPACING as usize) {
                let within = PixelSampler::new(SEED, y * width + x).sample(0).pair(0);
                let [dx, dy] = within.map(|u| (u * SPACING as f32) as u32);
                self.add_pixel((y + dy).min(y1 - 1) * width + (x + dx).min(x1 - 1), &mut sums);
                looked_at += 1.0;
            }
        }
        let scale = sums.pixels / looked_at;
        let all = [&mut sums.variance, &mut sums.of_halves, &mut sums.light];
        all.into_iter().flatten().for_each(|sum| *sum *= scale);
        sums
    }

    /// Adds what a pixel shows, each class by itself as the filter looks at them.
    fn add_pixel(&self, pixel: u32, sums: &mut TileNoise) {
        let mut classes: BTreeMap<usize, Moments> = BTreeMap::new();
        let mut number = 0;
        self.gather.pixel(pixel, PATHS, |path| {
            if let GatherPath::Surface(eye) = path {
                let moments = classes.entry(self.class(eye.material)).or_default();
                moments.add(half_of(number, PATHS), &self.watcher.lights(eye));
            }
            number += 1;
        });
        for moments in classes.values() {
            let samples = moments.samples.iter().sum::<f64>();
            let coverage = samples / f64::from(PATHS);
            for state in 0..STATES {
                let (mean, variance) = moments.of(state);
                sums.variance[state] += coverage * variance;
                sums.of_halves[state] += coverage * moments.of_halves(state).unwrap_or(variance);
                let square = mean * mean - variance / samples;
                sums.light[state] += coverage * coverage * square;
            }
        }
    }

    fn class(&self, material: u32) -> usize {
        let varying = &self.scene.vary.materials;
        varying.iter().position(|m| *m == material as usize).unwrap_or(varying.len())
    }

    /// Samples that leave `noise` behind the filter, at most `most`.
    fn samples_with_filter(
        &self,
        shares: &Shares,
        most: u32,
        noise: f64,
        job: &Job,
    ) -> Result<f64, Interrupted> {
        let mut windows = self.windows(shares);
        // Halves of the samples are alike if each step doubles them.
        let mut samples = f64::from(most);
        while samples >= 2.0 * f64::from(FEWEST) {
            samples *= 0.5;
        }
        let mut before: Option<(f64, f64)> = None;
        loop {
            let counts = TileCounts::new(self.size, TILE, shares.counts(samples));
            let progress = job.progress("trying the filter", windows.len() as u64);
            let mut parts = Vec::new();
            for window in &mut windows {
                window.trace(self, &counts, &progress)?;
                parts.extend(window.left(self.size[0], &counts)?);
                progress.advance(1);
            }
            let weights: f64 = parts.iter().map(|(weight, _)| weight).sum();
            let part = parts.iter().map(|(weight, part)| weight * part).sum::<f64>() / weights;
            // Without light in any window nothing is known of the filter.
            let left = (shares.left / samples * if weights > 0.0 { part } else { 1.0 }).sqrt();
            if left <= noise || samples >= f64::from(most) {
                return Ok(between(before, (samples, left), noise));
            }
            before = Some((samples, left));
            samples *= 2.0;
        }
    }

    /// Windows where noise is, found with a chance as high as it is.
    fn windows(&self, shares: &Shares) -> Vec<Window> {
        let [columns, rows] = self.size.map(|side| side.div_ceil(TILE));
        let count = (shares.noise.len() / TILES_PER_WINDOW).clamp(1, WINDOWS);
        let all: f64 = shares.noise.iter().sum();
        let mut windows: BTreeMap<[u32; 2], f64> = BTreeMap::new();
        let (mut sum, mut next) = (0.0, 0);
        for (tile, noise) in (0..).zip(&shares.noise) {
            sum += noise;
            while next < count && sum * count as f64 > all * (next as f64 + 0.5) {
                let corner =
                    |at: u32, tiles: u32| at.saturating_sub(WINDOW / 2).min(tiles.saturating_sub(WINDOW));
                let place = [corner(tile % columns, columns), corner(tile / columns, rows)];
                *windows.entry(place).or_default() += 1.0;
                next += 1;
            }
        }
        windows.into_iter().map(|(place, weight)| Window::new(place, weight, self.size)).collect()
    }
}

/// Where `noise` is met between two numbers of samples with what each leaves; the latter if it is not.
fn between(before: Option<(f64, f64)>, (samples, left): (f64, f64), noise: f64) -> f64 {
    let Some((fewer, more_left)) = before.filter(|_| left < noise) else { return samples };
    let part = (more_left / noise).ln() / (more_left / left).ln();
    fewer * (samples / fewer).powf(part.clamp(0.0, 1.0))
}

/// Sums over the samples of each half, and over the squares of all, by layer and state.
#[derive(Default)]
struct Moments {
    samples: [f64; 2],
    sums: [[[f64; STATES]; LAYERS]; 2],
    squares: [[f64; STATES]; LAYERS],
}

impl Moments {
    fn add(&mut self, half: usize, lights: &[[f32; STATES]; LAYERS]) {
        self.samples[half] += 1.0;
        let all = self.sums[half].as_flattened_mut().iter_mut().zip(self.squares.as_flattened_mut());
        for ((sum, square), light) in all.zip(lights.as_flattened()) {
            let light = f64::from(*light);
            *sum += light;
            *square += light * light;
        }
    }

    /// Mean of all light of a state, and the variance of a sample's layers. One sample says nothing of its spread,
    /// which is about as large as it.
    fn of(&self, state: usize) -> (f64, f64) {
        let (mut mean, mut variance) = (0.0, 0.0);
        let samples = self.samples[0] + self.samples[1];
        for (layer, squares) in self.squares.iter().enumerate() {
            let of_layer = (self.sums[0][layer][state] + self.sums[1][layer][state]) / samples;
            let square = of_layer * of_layer;
            let spread = (squares[state] / samples - square).max(0.0);
            variance += if samples > 1.0 { spread * samples / (samples - 1.0) } else { square };
            mean += of_layer;
        }
        (mean, variance)
    }

    /// The variance of a sample's layers by what the means of the halves differ by; nothing if one has no samples.
    fn of_halves(&self, state: usize) -> Option<f64> {
        let [a, b] = self.samples;
        let difference = |layer: usize| self.sums[0][layer][state] / a - self.sums[1][layer][state] / b;
        let squares = (0..LAYERS).map(|layer| difference(layer).powi(2)).sum::<f64>();
        (a > 0.0 && b > 0.0).then(|| squares / (1.0 / a + 1.0 / b))
    }
}

/// How samples are spread.
struct Shares {
    /// Of each tile, in parts of the mean.
    of_tiles: Vec<f64>,
    /// What each leaves of noise at one sample in the mean, squared, in parts of all light.
    noise: Vec<f64>,
    /// What all leave.
    left: f64,
}

impl Shares {
    fn new(tiles: &[TileNoise], size: [u32; 2]) -> Self {
        let light: [f64; STATES] = std::array::from_fn(|k| tiles.iter().map(|tile| tile.light[k]).sum());
        let lit = light.iter().filter(|light| **light > 0.0).count().max(1) as f64;
        let relative = |variance: &[f64; STATES]| {
            let states = variance.iter().zip(light).filter(|(_, light)| *light > 0.0);
            states.map(|(variance, light)| variance / light).sum::<f64>() / lit
        };
        let by_samples: Vec<f64> = tiles.iter().map(|tile| relative(&tile.variance)).collect();
        let by_halves: f64 = tiles.iter().map(|tile| relative(&tile.of_halves)).sum();
        let variances = smooth(&by_samples, size[0].div_ceil(TILE));
        let stratified = (by_halves / by_samples.iter().sum::<f64>().max(f64::MIN_POSITIVE)).min(1.0);
        let pixels: Vec<f64> = tiles.iter().map(|tile| tile.pixels).collect();
        let of_tiles = shares(&variances, &pixels);
        let noise: Vec<f64> = variances.iter().zip(&of_tiles).map(|(v, share)| v / share).collect();
        Self { of_tiles, left: stratified * noise.iter().sum::<f64>(), noise }
    }

    /// Samples of each tile, of so many in the mean.
    fn counts(&self, samples: f64) -> Vec<u32> {
        let least = FEWEST_OF_PIXEL.min(samples);
        self.of_tiles.iter().map(|share| (share * samples).max(least).round() as u32).collect()
    }
}

/// Half of each and half of those around it, for few paths tell little.
fn smooth(values: &[f64], columns: u32) -> Vec<f64> {
    let rows = values.len() as i64 / i64::from(columns);
    let at = |x: i64, y: i64| {
        let inside = (0..i64::from(columns)).contains(&x) && (0..rows).contains(&y);
        inside.then(|| values[(y * i64::from(columns) + x) as usize])
    };
    let smooth = |(number, value): (i64, &f64)| {
        let [x, y] = [number % i64::from(columns), number / i64::from(columns)];
        let places = (-1..=1).flat_map(|dy| (-1..=1).map(move |dx| [x + dx, y + dy]));
        let around: Vec<f64> = places.filter_map(|[x, y]| at(x, y)).collect();
        0.5 * value + 0.5 * around.iter().sum::<f64>() / around.len() as f64
    };
    (0..).zip(values).map(smooth).collect()
}

/// √variance of each pixel's samples, of mean 1 over all `pixels` and within bounds.
fn shares(variances: &[f64], pixels: &[f64]) -> Vec<f64> {
    let all: f64 = pixels.iter().sum();
    let mean = variances.iter().sum::<f64>() / all;
    if mean <= 0.0 {
        return vec![1.0; variances.len()];
    }
    let roots: Vec<f64> = variances.iter().zip(pixels).map(|(v, n)| (v / n + FLOOR * mean).sqrt()).collect();
    let scaled = |factor: f64| roots.iter().map(move |root| (root * factor).clamp(LEAST, MOST));
    let sum = |factor: f64| scaled(factor).zip(pixels).map(|(share, n)| share * n).sum::<f64>();
    let (mut low, mut high) = (0.0, MOST / (FLOOR * mean).sqrt());
    for _ in 0..100 {
        let middle = 0.5 * (low + high);
        *(if sum(middle) > all { &mut high } else { &mut low }) = middle;
    }
    scaled(low).collect()
}

/// A few tiles on which the filter is tried.
struct Window {
    /// How often it was found.
    weight: f64,
    /// From which pixels to which all neighbours that there are in the film are in it, too.
    whole: [Range<i32>; 2],
    /// Its pixels, with what is seen of each class so far, and by how many samples.
    pixels: Vec<(u32, BTreeMap<usize, Seen>, u32)>,
}

impl Window {
    fn new(place: [u32; 2], weight: f64, size: [u32; 2]) -> Self {
        let [xs, ys] = [0, 1].map(|k| place[k] * TILE..((place[k] + WINDOW) * TILE).min(size[k]));
        let whole = [(&xs, size[0]), (&ys, size[1])].map(|(side, all)| {
            let within = |is_end: bool| if is_end { 0 } else { filter::RADIUS };
            let [from, to] = [side.start, side.end].map(|end| end as i32);
            from + within(from == 0)..to - within(side.end == all)
        });
        let pixels = ys.flat_map(|y| xs.clone().map(move |x| (y * size[0] + x, BTreeMap::new(), 0)));
        Self { weight, whole, pixels: pixels.collect() }
    }

    /// Traces as many more samples as are missing. What there was becomes the first half.
    fn trace(
        &mut self,
        pilot: &Pilot<'_>,
        counts: &TileCounts,
        progress: &Progress,
    ) -> Result<(), Interrupted> {
        self.pixels.par_iter_mut().try_for_each(|(pixel, classes, traced)| {
            progress.check()?;
            let wanted = counts.of(*pixel);
            let known = *traced;
            classes.values_mut().for_each(Seen::join_halves);
            let mut number = 0;
            pilot.gather.some_of_pixel(*pixel, known..wanted, |path| {
                if let GatherPath::Surface(eye) = path {
                    let seen = classes.entry(pilot.class(eye.material)).or_default();
                    let half = if known > 0 { 1 } else { half_of(number, wanted) };
                    pilot.watcher.add(path, half, seen);
                }
                number += 1;
            });
            *traced = wanted;
            Ok(())
        })
    }

    /// Its weight, and what part of its noise, squared, the filter leaves; `None` in the dark.
    fn left(&self, width: u32, counts: &TileCounts) -> Result<Option<(f64, f64)>, Interrupted> {
        let seen = self.pixels.iter().flat_map(|(pixel, classes, _)| {
            classes.iter().map(|(class, seen)| (*pixel, *class as u16, *seen))
        });
        let film = Film::new(width, |pixel| counts.of(pixel), seen);
        let is_whole = |fragment: &Fragment| {
            let pixel = film.pixel(fragment);
            self.whole.iter().zip(pixel).all(|(range, at)| range.contains(&at))
        };
        let noise = filter::noise_of(&film, is_whole, &Job::new(ProgressMode::None))?;
        let part = noise.filter(|noise| noise.before > 0.0).map(|noise| (noise.after / noise.before).powi(2));
        Ok(part.map(|part| (self.weight, part)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn left(variances: &[f64], shares: &[f64]) -> f64 {
        variances.iter().zip(shares).map(|(v, share)| v / share).sum()
    }

    /// By Cauchy and Schwarz the least is (Σ√v)² over the number of tiles.
    #[test]
    fn shares_are_those_that_leave_the_least() {
        let variances = [100.0, 400.0, 900.0, 1600.0];
        let found = shares(&variances, &[256.0; 4]);
        assert!((found.iter().sum::<f64>() - 4.0).abs() < 1e-6, "{found:?}");
        let least = (10.0f64 + 20.0 + 30.0 + 40.0).powi(2) / 4.0;
        let found = left(&variances, &found);
        assert!(found >= least - 1e-9 && found < 1.01 * least, "{found} {least}");
        assert!(left(&variances, &[1.0; 4]) > 1.15 * least);
    }

    /// Dark tiles keep some, a caustic does not take all, and without any noise all have as many.
    #[test]
    fn shares_are_bounded_and_add_up() {
        let mut variances = vec![1.0; 400];
        variances[7] = 1e12;
        variances[9] = 0.0;
        let pixels: Vec<f64> = (0..400).map(|tile| if tile % 20 == 19 { 64.0 } else { 256.0 }).collect();
        let found = shares(&variances, &pixels);
        let sum: f64 = found.iter().zip(&pixels).map(|(share, n)| share * n).sum();
        assert!((sum / pixels.iter().sum::<f64>() - 1.0).abs() < 1e-9);
        assert!(found.iter().all(|share| (LEAST..=MOST).contains(share)));
        assert_eq!((found[7], found[9] < found[7]), (MOST, true));
        assert_eq!(shares(&[0.0; 3], &[1.0; 3]), [1.0; 3]);
    }

    #[test]
    fn smooth_leaves_what_is_even_and_halves_what_stands_alone() {
        assert_eq!(smooth(&[2.0; 12], 4), [2.0; 12]);
        let mut alone = [0.0; 9];
        alone[4] = 9.0;
        let found = smooth(&alone, 3);
        assert_eq!((found[4], found[1]), (5.0, 0.75));
        assert_eq!(smooth(&[3.0], 1), [3.0]);
    }

    /// Noise that falls by the square root of samples is met where it is.
    #[test]
    fn samples_between_two_trials_follow_a_power() {
        let noise = |samples: f64| (4.0 / samples).sqrt();
        let found = between(Some((64.0, noise(64.0))), (128.0, noise(128.0)), noise(100.0));
        assert!((found - 100.0).abs() < 1e-9, "{found}");
        assert_eq!(between(Some((64.0, 0.2)), (128.0, 0.19), 0.1), 128.0);
        assert_eq!(between(None, (16.0, 0.01), 0.1), 16.0);
    }
}
