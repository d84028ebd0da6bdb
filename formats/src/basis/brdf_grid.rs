//! The angle grid (θi, θo, φ) on which BRDFs are tabulated for the PCA and for exports (thesis eq. 4-17).
//!
//! 30 × 30 × 60 nodes spaced evenly over [0, π/2] × [0, π/2] × [0, π], both ends included; φ is the angle
//! between the projections of the two directions on the surface. Look-ups in images never use this grid: at
//! high exponents it is too coarse for that.

use super::Angles;
use std::f64::consts::{FRAC_PI_2, PI};

/// Nodes along θi and along θo.
pub const THETA_NODES: usize = 30;
/// Nodes along φ.
pub const PHI_NODES: usize = 60;
/// Nodes in all, row-major over (θi, θo, φ).
pub const NODES: usize = THETA_NODES * THETA_NODES * PHI_NODES;

/// The polar angle of node `index`, radians.
pub fn theta(index: usize) -> f64 {
    FRAC_PI_2 * index as f64 / (THETA_NODES - 1) as f64
}

/// The azimuth difference of node `index`, radians.
pub fn phi(index: usize) -> f64 {
    PI * index as f64 / (PHI_NODES - 1) as f64
}

/// cos δ between the half vector and the normal at node (`i`, `o`, `p`), in 0..=1.
pub fn cos_half_angle(i: usize, o: usize, p: usize) -> f64 {
    let (theta_i, theta_o, phi) = (theta(i), theta(o), phi(p));
    let z = theta_i.cos() + theta_o.cos();
    // |ωi + ωo|² = 2 + 2 ωi·ωo; it vanishes only for opposite directions in the surface plane, where the normal component vanishes too.
    let length_squared =
        2.0 + 2.0 * (theta_i.sin() * theta_o.sin() * phi.cos() + theta_i.cos() * theta_o.cos());
    if length_squared <= 1e-18 { 0.0 } else { (z / length_squared.sqrt()).clamp(0.0, 1.0) }
}

/// The angles of node (`i`, `o`, `p`).
pub fn angles(i: usize, o: usize, p: usize) -> Angles {
    let (theta_i, theta_o) = (theta(i), theta(o));
    let cosine = theta_i.sin() * theta_o.sin() * phi(p).cos() + theta_i.cos() * theta_o.cos();
    // The half vector halves the angle between the directions.
    let cos_difference = (0.5 * (1.0 + cosine)).clamp(0.0, 1.0).sqrt();
    // cos(π/2) is a rounding error above 0.
    let cos_node = |index: usize| if index == THETA_NODES - 1 { 0.0 } else { theta(index).cos() };
    let [cos_half, cos_difference, cos_in, cos_out] =
        [cos_half_angle(i, o, p), cos_difference, cos_node(i), cos_node(o)].map(|c| c as f32);
    Angles { cos_half, cos_difference, cos_in, cos_out }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn half_angle_matches_vectors() {
        for (i, o, p) in [(0, 0, 0), (3, 20, 7), (29, 1, 59), (12, 12, 59), (29, 29, 30)] {
            let direction = |t: f64, f: f64| [t.sin() * f.cos(), t.sin() * f.sin(), t.cos()];
            let (a, b) = (direction(theta(i), 0.0), direction(theta(o), phi(p)));
            let h: Vec<f64> = a.iter().zip(b).map(|(x, y)| x + y).collect();
            let expected = h[2] / h.iter().map(|x| x * x).sum::<f64>().sqrt();
            assert!((cos_half_angle(i, o, p) - expected).abs() < 1e-12);
            let angles = angles(i, o, p);
            let cos_difference = h.iter().zip(a).map(|(h, a)| h * a).sum::<f64>()
                / h.iter().map(|x| x * x).sum::<f64>().sqrt();
            for (ours, truth) in [
                (angles.cos_half, expected),
                (angles.cos_difference, cos_difference),
                (angles.cos_in, a[2]),
                (angles.cos_out, b[2]),
            ] {
                assert!((f64::from(ours) - truth).abs() < 1e-7);
            }
        }
        assert_eq!(cos_half_angle(29, 29, 59), 0.0, "opposite grazing directions have no half vector");
    }
}
