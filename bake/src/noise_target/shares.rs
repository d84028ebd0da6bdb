//! How samples are spread over tiles.

use super::{STATES, TILE, TileNoise};

/// How far counts may be from even ones, in parts of these: what few paths say of a tile is noisy itself.
const LEAST: f64 = 0.25;
const MOST: f64 = 8.0;
/// What a tile counts at least, in parts of the mean variance: where few paths found nothing more may.
const FLOOR: f64 = 0.02;
/// Fewest and most samples of a pixel: halves of fewer tell nothing, and of more single precision loses some.
const OF_PIXEL: [f64; 2] = [4.0, 1e6];

/// How samples are spread.
pub struct Shares {
    /// Of each tile, in parts of the mean.
    of_tiles: Vec<f64>,
    /// What each leaves of noise at one sample in the mean, squared, in parts of all light.
    pub noise: Vec<f64>,
    /// What all leave; 0 if no light was seen.
    pub left: f64,
}

impl Shares {
    /// Of the tiles of a film of `size`, row by row.
    pub fn new(tiles: &[TileNoise], size: [u32; 2]) -> Self {
        let light: [f64; STATES] = std::array::from_fn(|k| tiles.iter().map(|tile| tile.light[k]).sum());
        let lit = light.iter().filter(|light| **light > 0.0).count().max(1) as f64;
        let relative = |variance: &[f64; STATES]| {
            let states = variance.iter().zip(light).filter(|(_, light)| *light > 0.0);
            states.map(|(variance, light)| variance / light).sum::<f64>() / lit
        };
        let by_samples: Vec<f64> = tiles.iter().map(|tile| relative(&tile.variance)).collect();
        let by_halves: f64 = tiles.iter().map(|tile| relative(&tile.of_halves)).sum();
        let stratified = (by_halves / by_samples.iter().sum::<f64>().max(f64::MIN_POSITIVE)).min(1.0);
        let pixels: Vec<f64> = tiles.iter().map(|tile| tile.pixels).collect();
        let variances = smooth(&by_samples, &pixels, size[0].div_ceil(TILE));
        let of_tiles = shares(&variances, &pixels);
        let noise: Vec<f64> = variances.iter().zip(&of_tiles).map(|(v, share)| v / share).collect();
        Self { of_tiles, left: stratified * noise.iter().sum::<f64>(), noise }
    }

    /// Samples of each tile, of so many in the mean at most.
    pub fn counts(&self, samples: f64) -> Vec<u32> {
        let [least, most] = OF_PIXEL;
        if samples * LEAST < least {
            // Where some would have too few, all have as many.
            return vec![samples as u32; self.of_tiles.len()];
        }
        let of = |share: &f64| (share * samples).clamp(least, most) as u32;
        self.of_tiles.iter().map(of).collect()
    }
}

/// Half of each and half of those around it, a pixel alike, for few paths tell little.
fn smooth(values: &[f64], pixels: &[f64], columns: u32) -> Vec<f64> {
    let columns = i64::from(columns);
    let rows = values.len() as i64 / columns;
    let at = |x: i64, y: i64| {
        let inside = (0..columns).contains(&x) && (0..rows).contains(&y);
        inside.then_some((y * columns + x) as usize)
    };
    let smooth = |number: i64| {
        let [x, y] = [number % columns, number / columns];
        let places = (-1..=1).flat_map(|dy| (-1..=1).map(move |dx| [x + dx, y + dy]));
        let around: Vec<usize> = places.filter_map(|[x, y]| at(x, y)).collect();
        let sum = |of: &[f64]| around.iter().map(|tile| of[*tile]).sum::<f64>();
        let own = number as usize;
        0.5 * values[own] + 0.5 * pixels[own] * sum(values) / sum(pixels)
    };
    (0..values.len() as i64).map(smooth).collect()
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
        // Even noise a pixel, the last column of fewer pixels.
        let pixels = [256.0, 256.0, 16.0].repeat(4);
        let even: Vec<f64> = pixels.iter().map(|n| 2.0 * n).collect();
        assert_eq!(smooth(&even, &pixels, 3), even);
        let mut alone = [0.0; 9];
        alone[4] = 9.0;
        let found = smooth(&alone, &[256.0; 9], 3);
        assert_eq!((found[4], found[1]), (5.0, 0.75));
        assert_eq!(smooth(&[3.0], &[7.0], 1), [3.0]);
    }

    /// No more in the mean than asked for, though every tile has whole samples.
    #[test]
    fn counts_are_no_more_than_asked_for() {
        let shares = Shares { of_tiles: vec![0.97, 0.97, 1.06], noise: Vec::new(), left: 1.0 };
        assert_eq!(shares.counts(16.0), [15, 15, 16]);
        assert_eq!(shares.counts(1.0), [1, 1, 1]);
        // No tile has less than halves take, and the mean is no more for it.
        let uneven = Shares { of_tiles: vec![0.25, 1.75], noise: Vec::new(), left: 1.0 };
        assert_eq!((uneven.counts(15.0), uneven.counts(16.0)), (vec![15, 15], vec![4, 28]));
        assert_eq!(shares.counts(1e9), [1_000_000; 3]);
    }
}
