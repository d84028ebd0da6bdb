//! Directions of a hemisphere by where they fall on the disc below it (thesis §5.3.3.1, after Wang et al.
//! 2004): cells of as many rings of the same width, each cut into as many azimuths.
//!
//! Projected so, area is solid angle times cosine: what a surface receives through a cell is its radiance
//! times [`weight`]. Rings, and not a square grid, so that what is the same in all azimuths stays so: a lobe
//! turned with the direction that it is seen from moves from cell to cell.
//!
//! Cell (ring, azimuth) has index ring·[`AZIMUTHS`] + azimuth. Its node is at radius (ring + ½)/[`RINGS`] and
//! angle 2π·azimuth/[`AZIMUTHS`] from +X towards +Y, the normal being +Z. Between nodes values are bilinear
//! in radius and angle, across the middle from node to opposite node, and beyond the last ring those of that
//! ring.

use glam::DVec3;
use std::f64::consts::{PI, TAU};

/// Rings of the disc.
pub const RINGS: usize = 12;
/// Cells of a ring.
pub const AZIMUTHS: usize = 48;
/// Cells of the disc.
pub const CELLS: usize = RINGS * AZIMUTHS;

/// Radius of the nodes of a ring, the sine of their angle from the normal.
pub fn radius(ring: usize) -> f64 {
    (ring as f64 + 0.5) / RINGS as f64
}

/// Angle of an azimuth around the normal, radians.
pub fn angle(azimuth: usize) -> f64 {
    TAU * azimuth as f64 / AZIMUTHS as f64
}

/// The unit vector at the node of `cell`.
pub fn direction(cell: usize) -> DVec3 {
    let (r, angle) = (radius(cell / AZIMUTHS), angle(cell % AZIMUTHS));
    DVec3::new(r * angle.cos(), r * angle.sin(), (1.0 - r * r).sqrt())
}

/// Area of a cell of `ring`: ∫ cos θ dω over it. All cells have π.
pub fn weight(ring: usize) -> f64 {
    let [inner, outer] = [ring, ring + 1].map(|edge| edge as f64 / RINGS as f64);
    PI * (outer * outer - inner * inner) / AZIMUTHS as f64
}

/// The nodes around the unit vector `direction`, whose z is not below 0, and how much each counts; together
/// 1.
pub fn locate(direction: DVec3) -> [(usize, f32); 4] {
    let r = direction.truncate().length().min(1.0);
    let turns = direction.y.atan2(direction.x) / TAU * AZIMUTHS as f64;
    let turns = turns.rem_euclid(AZIMUTHS as f64);
    let (before, around) = (turns.floor(), turns.fract());
    let azimuth = |shift: usize| (before as usize + shift) % AZIMUTHS;
    let at = (r * RINGS as f64 - 0.5).min((RINGS - 1) as f64);
    // Within the first ring on the line to the opposite node, at −½.
    let (inner, outer, out, opposite) = if at < 0.0 {
        (0, 0, at + 1.0, AZIMUTHS / 2)
    } else {
        let ring = (at as usize).min(RINGS - 2);
        (ring, ring + 1, at - ring as f64, 0)
    };
    let node = |ring: usize, azimuth: usize, share: f64| (ring * AZIMUTHS + azimuth, share as f32);
    [
        node(inner, azimuth(opposite), (1.0 - out) * (1.0 - around)),
        node(inner, azimuth(opposite + 1), (1.0 - out) * around),
        node(outer, azimuth(0), out * (1.0 - around)),
        node(outer, azimuth(1), out * around),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_cover_the_disc() {
        let whole: f64 = (0..CELLS).map(|cell| weight(cell / AZIMUTHS)).sum();
        assert!((whole - PI).abs() < 1e-12);
        // ∫ cos²θ dω over the rings from `first` on: 2π/3 (1 − r²)^{3/2} of the inner radius, which is 2π/3
        // of all. A node is the midpoint rule, which errs by at most h³/3 of the largest second derivative
        // over a ring of half width h, and this one, 2π r(3 − 2r²)(1 − r²)^{-3/2}, grows outwards. The last
        // ring's has no largest: its node's sum is compared with the closed form of itself.
        let ring = |ring: usize| {
            let sum = AZIMUTHS as f64 * direction(ring * AZIMUTHS).z * weight(ring);
            let [inner, outer] = [ring, ring + 1].map(|edge| edge as f64 / RINGS as f64);
            let beyond = |r: f64| TAU / 3.0 * (1.0 - r * r).max(0.0).powf(1.5);
            (sum, beyond(inner) - beyond(outer), outer)
        };
        let half_width: f64 = 0.5 / RINGS as f64;
        for (sum, exact, outer) in (0..RINGS - 1).map(ring) {
            let bend = TAU * outer * (3.0 - 2.0 * outer * outer) * (1.0 - outer * outer).powf(-1.5);
            assert!(
                (sum - exact).abs() < bend * half_width.powi(3) / 3.0,
                "ring to {outer}: {sum} for {exact}"
            );
        }
        // With d = 1/RINGS: 2πd(1 − d/2)·√(d − d²/4) for 2π/3·(2d − d²)^{3/2}.
        let (sum, exact, _) = ring(RINGS - 1);
        let d = 1.0 / RINGS as f64;
        assert!((exact - TAU / 3.0 * (2.0 * d - d * d).powf(1.5)).abs() < 1e-12);
        assert!((sum - TAU * d * (1.0 - 0.5 * d) * (d - 0.25 * d * d).sqrt()).abs() < 1e-12);
        for cell in 0..CELLS {
            let nearest = locate(direction(cell)).into_iter().max_by(|a, b| a.1.total_cmp(&b.1));
            assert!(nearest.is_some_and(|(node, share)| node == cell && share > 0.9999), "cell {cell}");
        }
    }

    /// x and y are linear along a ray from the middle, and off by at most 1 − cos(π/48) across azimuths: the
    /// chord of two neighbours, at all radii.
    #[test]
    fn between_nodes_values_are_linear() {
        let middle = locate(DVec3::Z);
        assert!((middle.iter().map(|(_, share)| share).sum::<f32>() - 1.0).abs() < 1e-6);
        for step in 0..2000 {
            let [u, v] = [0.618_034, 0.414_214].map(|g: f64| (f64::from(step) * g).fract());
            let (r, angle) = (u * radius(RINGS - 1), TAU * v);
            let d = DVec3::new(r * angle.cos(), r * angle.sin(), (1.0 - r * r).sqrt());
            let located = locate(d);
            let sum = |f: &dyn Fn(DVec3) -> f64| {
                located.iter().map(|(cell, share)| f64::from(*share) * f(direction(*cell))).sum::<f64>()
            };
            assert!((sum(&|_| 1.0) - 1.0).abs() < 1e-6);
            let bound = (1.0 - (PI / AZIMUTHS as f64).cos()) * r.max(radius(0)) + 1e-6;
            assert!((sum(&|n| n.x) - d.x).hypot(sum(&|n| n.y) - d.y) < bound, "{d}: {located:?}");
        }
    }
}
