//! How many samples each tile gets so that a bake has no more noise than asked for.
//!
//! Noise is that of the random states that the filter looks at, and never of the default alone. Paths of a
//! seed of their own tell how noisy tiles are, so that the estimates of the bake stay unbiased. With v the
//! variance of a tile's samples, n samples a pixel leave v/n; of all ways to spread a number of samples the
//! least is left by n ∝ √v. What the filter leaves of that is tried on a few small windows, at twice the
//! samples each time.

mod shares;
mod window;

use crate::filter::seen::{LAYERS, STATES, StateLight, half_of};
use crate::filter::{self, Watcher};
use crate::interrupted::Interrupted;
use crate::job::Job;
use crate::trace::gather::{Gather, GatherPath};
use crate::trace::sampler::PixelSampler;
use crate::trace::tile_counts::TileCounts;
use rayon::prelude::*;
use relume_scenes::Scene;
use shares::Shares;
use std::collections::BTreeMap;
use window::Window;

/// Side of the tiles.
const TILE: u32 = filter::TILE as u32;
/// The seed of the paths that tell.
const SEED: u64 = 0x006e_6f69_7365;
/// One pixel of each square of this side is looked at, by so many paths.
const SPACING: u32 = 4;
const PATHS: u32 = 32;
/// Fewest samples that a film has in the mean, if it may have as many; trials of the filter begin with less than
/// twice that.
pub const FEWEST: u32 = 16;
/// For so many tiles there is a window, and the most windows; their side, tiles.
const TILES_PER_WINDOW: usize = 32;
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

/// Counts for a film of `size`, of `most` in the mean at most, that leave about the noise of `target` to the
/// paths of `gather`; `most` everywhere if nothing is lit that is looked at.
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
    let samples = if shares.left <= 0.0 {
        f64::from(most)
    } else if target.filter {
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
    /// What that seems to be by the difference of two halves: samples are stratified, so their mean is known
    /// better than they tell.
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
                let moments = classes.entry(self.class(eye.spot.material)).or_default();
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
                // Where noise is as large as the light there is no telling them apart, and no less than half
                // is light.
                let square = (mean * mean - variance / samples).max(0.5 * mean * mean);
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
        // Samples, with what part of the noise the filter leaves, and with what is left of all light.
        let mut tried: Option<(f64, f64)> = None;
        let mut known: Option<(f64, f64)> = None;
        loop {
            let counts = TileCounts::new(self.size, TILE, shares.counts(samples));
            let part = self.part_left(&mut windows, &counts, job)?;
            if let Some((fewer, part_of_fewer)) = tried {
                // Where light is found by chance windows disagree with themselves: two trials know more.
                let left = (shares.left / fewer * 0.5 * (part_of_fewer + part)).sqrt();
                if left <= noise {
                    return Ok(between(known, (fewer, left), noise));
                }
                known = Some((fewer, left));
            }
            if samples >= f64::from(most) {
                return Ok(between(known, (samples, (shares.left / samples * part).sqrt()), noise));
            }
            tried = Some((samples, part));
            samples *= 2.0;
        }
    }

    /// What part of their noise, squared, the filter leaves in `windows` at these `counts`.
    fn part_left(&self, windows: &mut [Window], counts: &TileCounts, job: &Job) -> Result<f64, Interrupted> {
        let progress = job.progress("trying the filter", windows.len() as u64);
        let mut parts = Vec::new();
        for window in windows {
            window.trace(self, counts, &progress)?;
            parts.extend(window.left(self.size[0], counts)?);
            progress.advance(1);
        }
        let weights: f64 = parts.iter().map(|(weight, _)| weight).sum();
        // Without light in any window nothing is known of the filter.
        let sum = parts.iter().map(|(weight, part)| weight * part).sum::<f64>();
        Ok(if weights > 0.0 { sum / weights } else { 1.0 })
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
    fn add(&mut self, half: usize, lights: &[StateLight; LAYERS]) {
        self.samples[half] += 1.0;
        let layers = self.sums[half].iter_mut().zip(&mut self.squares).zip(lights);
        for ((sums, squares), lights) in layers {
            // Of the random states alone.
            for ((sum, square), light) in sums.iter_mut().zip(squares).zip(lights) {
                let light = f64::from(*light);
                *sum += light;
                *square += light * light;
            }
        }
    }

    /// Mean of all light of a state, and the variance of a sample's layers. One sample says nothing of its
    /// spread, which is about as large as it.
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

    /// The variance of a sample's layers by what the means of the halves differ by; nothing if one has none.
    fn of_halves(&self, state: usize) -> Option<f64> {
        let [a, b] = self.samples;
        let difference = |layer: usize| self.sums[0][layer][state] / a - self.sums[1][layer][state] / b;
        let squares = (0..LAYERS).map(|layer| difference(layer).powi(2)).sum::<f64>();
        (a > 0.0 && b > 0.0).then(|| squares / (1.0 / a + 1.0 / b))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
