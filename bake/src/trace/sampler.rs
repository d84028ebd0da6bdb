//! Low-discrepancy points: the Sobol (0,2)-sequence, Owen-scrambled by hashing (Burley 2020, "Practical
//! Hash-based Owen Scrambling", with N. Vegdahl's constants).
//!
//! Every pair of dimensions of every pixel gets its own scrambling and its own order, derived from (seed,
//! pixel, pair) alone, so results depend neither on threads nor on what other pixels do, and any prefix of 2ᵏ
//! samples of a pixel is stratified.

/// The sample sequence of one pixel.
#[derive(Debug, Clone, Copy)]
pub struct PixelSampler {
    pixel_hash: u32,
}

/// One sample of a pixel's sequence: hands out its pairs of dimensions by number.
#[derive(Debug, Clone, Copy)]
pub struct Sample {
    pixel_hash: u32,
    index: u32,
}

impl PixelSampler {
    /// The sequence of pixel number `pixel` under `seed`.
    pub fn new(seed: u64, pixel: u32) -> Self {
        let low = hash(seed as u32 ^ 0x9e37_79b9);
        let high = hash((seed >> 32) as u32 ^ low);
        Self { pixel_hash: hash(pixel ^ hash(high)) }
    }

    /// Sample number `index` of the pixel.
    pub fn sample(&self, index: u32) -> Sample {
        Sample { pixel_hash: self.pixel_hash, index }
    }
}

impl Sample {
    /// Number `number` of so many `parts` of it, each as good as a sample: those of all samples of a pixel are a
    /// sequence themselves.
    pub fn part(&self, number: usize, parts: usize) -> Self {
        Self { index: self.index.wrapping_mul(parts as u32).wrapping_add(number as u32), ..*self }
    }

    /// The two coordinates of dimension pair `pair`, each in [0, 1).
    pub fn pair(&self, pair: u32) -> [f32; 2] {
        let seed = hash(self.pixel_hash ^ pair.wrapping_mul(0x9e37_79b9));
        let index = owen_scramble(self.index, seed);
        let x = owen_scramble(index.reverse_bits(), hash(seed ^ 0x68bc_21eb));
        let y = owen_scramble(sobol_second(index), hash(seed ^ 0x02e5_be93));
        [unit(x), unit(y)]
    }
}

/// 24 bits of `x` as a number in [0, 1).
fn unit(x: u32) -> f32 {
    (x >> 8) as f32 * (1.0 / 16_777_216.0)
}

/// The second Sobol dimension: its direction numbers are the rows of Pascal's triangle modulo 2.
///
/// C(i, k) is odd where k has no bit that i lacks (Lucas), so bit k of the reversed value is the parity of
/// the bits i of `index` of which that is true. Such sums are taken one bit of the places at a time.
fn sobol_second(index: u32) -> u32 {
    let places =
        [(0xaaaa_aaaa, 1), (0xcccc_cccc, 2), (0xf0f0_f0f0, 4), (0xff00_ff00, 8), (0xffff_0000u32, 16)];
    places.into_iter().fold(index, |sums, (with, shift)| sums ^ ((sums & with) >> shift)).reverse_bits()
}

/// Flips each bit depending on the more significant ones only: a nested uniform scramble.
fn owen_scramble(x: u32, seed: u32) -> u32 {
    let mut x = x.reverse_bits();
    // Each step lets lower bits influence higher ones only; on reversed bits that is the direction wanted.
    x ^= x.wrapping_mul(0x3d20_adea);
    x = x.wrapping_add(seed);
    x = x.wrapping_mul((seed >> 16) | 1);
    x ^= x.wrapping_mul(0x0552_6c56);
    x ^= x.wrapping_mul(0x53a2_2864);
    x.reverse_bits()
}

/// A well-mixing integer hash (lowbias32 by C. Wellons).
fn hash(mut x: u32) -> u32 {
    x ^= x >> 16;
    x = x.wrapping_mul(0x7feb_352d);
    x ^= x >> 15;
    x = x.wrapping_mul(0x846c_a68b);
    x ^ (x >> 16)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Against Pascal's triangle itself, a direction number a bit.
    #[test]
    fn the_second_dimension_follows_pascals_triangle() {
        let by_directions = |index: u32| {
            let directions = std::iter::successors(Some(1u32 << 31), |d| Some(d ^ (d >> 1)));
            let set = directions.zip(0..32).filter(|(_, bit)| index >> bit & 1 == 1);
            set.fold(0, |value, (direction, _)| value ^ direction)
        };
        for index in (0..32).map(|bit| 1 << bit).chain((0..10_000).map(hash)) {
            assert_eq!(sobol_second(index), by_directions(index), "{index:#x}");
        }
    }

    /// A (0,2)-sequence puts exactly one of its first 2^m points into every elementary interval of area 2^-m.
    #[test]
    fn every_elementary_interval_holds_one_point() {
        for pixel in 0..20 {
            let sampler = PixelSampler::new(7, pixel);
            for pair in 0..4 {
                let points: Vec<_> = (0..256).map(|i| sampler.sample(i).pair(pair)).collect();
                for x_bits in 0..=8 {
                    let (columns, rows) = (1 << x_bits, 256 >> x_bits);
                    let mut seen = vec![0; 256];
                    for [x, y] in &points {
                        seen[(x * columns as f32) as usize * rows + (y * rows as f32) as usize] += 1;
                    }
                    assert!(seen.iter().all(|n| *n == 1), "pixel {pixel}, pair {pair}, {columns} columns");
                }
            }
        }
    }

    #[test]
    fn parts_of_samples_are_a_sequence_themselves() {
        let sampler = PixelSampler::new(7, 3);
        for (index, number) in [(0, 0), (0, 3), (5, 1), (63, 3)] {
            let part = sampler.sample(index).part(number as usize, 4);
            assert_eq!(part.pair(2), sampler.sample(4 * index + number).pair(2));
        }
        assert_eq!(sampler.sample(9).part(0, 1).pair(1), sampler.sample(9).pair(1));
    }

    /// Pixels, pairs and seeds must not be correlated: the mean of xy over independent uniform numbers is 1/4
    /// with variance 7/144.
    #[test]
    fn pixels_pairs_and_seeds_are_independent() {
        let n = 4096;
        let first = |seed, pixel, pair| PixelSampler::new(seed, pixel).sample(3).pair(pair)[0];
        type Other = fn(u32) -> (u64, u32, u32);
        let others: [Other; 3] = [|p| (7, p + 1, 0), |p| (7, p, 1), |p| (8, p, 0)];
        for other in others {
            let product = |p| {
                let (seed, pixel, pair) = other(p);
                f64::from(first(7, p, 0) * first(seed, pixel, pair))
            };
            let mean = (0..n).map(product).sum::<f64>() / f64::from(n);
            let sigma = (7.0 / 144.0 / f64::from(n)).sqrt();
            assert!((mean - 0.25).abs() < 4.0 * sigma, "mean of products {mean}");
        }
    }
}
