//! Pairs of directions by half and difference angle (Rusinkiewicz 1998), on which lobes of GGX are
//! integrated.
//!
//! Nodes crowd towards the peak, so that they resolve a lobe of any width. The integral is over both
//! directions, with both cosines.

use super::Angles;
use std::f64::consts::FRAC_PI_2;
use std::ops::Range;

/// Nodes over half angle, difference angle and azimuth.
pub const QUADRATURE: [usize; 3] = [48, 24, 12];

/// The pairs, with the square roots of their weights.
#[derive(Debug, Clone)]
pub struct HalfDifference {
    /// Of each pair.
    pub angles: Vec<Angles>,
    /// Square root of the weight of each, up to one factor for all.
    pub weight: Vec<f64>,
}

/// Half angles of [`half_angles`].
const HALF_ANGLES: usize = 256;

/// Cosines of half angles with what they weigh for lobes that depend on nothing else: the same integral, finer.
pub fn half_angles() -> Vec<(f64, f64)> {
    let [_, differences, azimuths] = QUADRATURE;
    let of_half = |half: usize| {
        let pairs = HalfDifference::of_quadrature([HALF_ANGLES, differences, azimuths], half..half + 1);
        let cosine = half_angle(middle(half, HALF_ANGLES)).cos();
        (cosine, pairs.weight.iter().map(|weight| weight * weight).sum())
    };
    (0..HALF_ANGLES).map(of_half).collect()
}

fn middle(index: usize, count: usize) -> f64 {
    (index as f64 + 0.5) / count as f64
}

/// Nodes crowd towards the peak: θ = π/2·x², dθ = π·x·dx.
fn half_angle(x: f64) -> f64 {
    FRAC_PI_2 * x * x
}

impl HalfDifference {
    /// All pairs of which both directions are above the surface.
    pub fn new() -> Self {
        Self::of_quadrature(QUADRATURE, 0..QUADRATURE[0])
    }

    /// Those of the half angles of some numbers.
    fn of_quadrature([halves, differences, azimuths]: [usize; 3], of: Range<usize>) -> Self {
        let (mut angles, mut weight) = (Vec::new(), Vec::new());
        for h in of {
            let x = middle(h, halves);
            let (sin_half, cos_half) = half_angle(x).sin_cos();
            for d in 0..differences {
                let (sin_difference, cos_difference) = (FRAC_PI_2 * middle(d, differences)).sin_cos();
                // dω_i dω_o = 4 cos θ_d dω_h dω_d (Rusinkiewicz 1998).
                let measure = 4.0 * cos_difference * sin_half * sin_difference * x;
                for a in 0..azimuths {
                    // Lobes are symmetric in both directions, so a quarter of the circle tells all.
                    let across = sin_half * sin_difference * (FRAC_PI_2 * middle(a, azimuths)).cos();
                    let [cos_in, cos_out] =
                        [cos_half * cos_difference - across, cos_half * cos_difference + across];
                    if cos_in > 0.0 {
                        let [cos_half, cos_difference, c_in, c_out] =
                            [cos_half, cos_difference, cos_in, cos_out].map(|c| c as f32);
                        angles.push(Angles { cos_half, cos_difference, cos_in: c_in, cos_out: c_out });
                        weight.push((measure * cos_in * cos_out).sqrt());
                    }
                }
            }
        }
        Self { angles, weight }
    }
}

impl Default for HalfDifference {
    fn default() -> Self {
        Self::new()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::{PI, TAU};

    #[test]
    fn the_quadrature_integrates_over_both_directions() {
        // ∫∫ cos θi cos θo dωi dωo = π². The grid covers a quarter of the azimuth and leaves out constant
        // factors: π/2·π·4/2 per unit of x and angles, over the numbers of nodes, times 2π for turning both
        // directions together.
        let grid = HalfDifference::new();
        let [h, d, a] = QUADRATURE.map(|n| n as f64);
        let steps = (PI / h) * (FRAC_PI_2 / d) * (4.0 * FRAC_PI_2 / a) * TAU;
        let sum: f64 = grid.weight.iter().map(|w| w * w).sum::<f64>() * steps;
        let fine = half_angles();
        let sum_of_halves: f64 =
            fine.iter().map(|(_, weight)| weight).sum::<f64>() * steps * h / fine.len() as f64;
        // Pairs close to the horizon are cut off cell by cell; what is lost or won there is of the order of a
        // cell's share.
        for sum in [sum, sum_of_halves] {
            assert!((sum / PI.powi(2) - 1.0).abs() < 2e-3, "{sum}");
        }
    }
}
