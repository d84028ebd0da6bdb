//! Pairs of directions by half and difference angle (Rusinkiewicz 1998), on which lobes of GGX are
//! integrated.
//!
//! Nodes crowd towards the peak, so that they resolve a lobe of any width. The integral is over both
//! directions, with both cosines.

use super::Angles;
use std::f64::consts::FRAC_PI_2;

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

impl HalfDifference {
    /// All pairs of which both directions are above the surface.
    pub fn new() -> Self {
        let [halves, differences, azimuths] = QUADRATURE;
        let (mut angles, mut weight) = (Vec::new(), Vec::new());
        let middle = |i: usize, n: usize| (i as f64 + 0.5) / n as f64;
        for h in 0..halves {
            // Nodes crowd towards the peak: θ = π/2·x², dθ = π·x·dx.
            let x = middle(h, halves);
            let (sin_half, cos_half) = (FRAC_PI_2 * x * x).sin_cos();
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
        // Pairs close to the horizon are cut off cell by cell; what is lost or won there is of the order of a
        // cell's share.
        assert!((sum / PI.powi(2) - 1.0).abs() < 2e-3, "{sum}");
    }
}
