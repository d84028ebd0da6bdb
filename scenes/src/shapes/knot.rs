//! Torus knots.

use super::grid::closed_grid;
use crate::geometry::Part;
use glam::DVec3;
use std::f64::consts::TAU;

/// A tube along the curve that winds `p` times around +Y and `q` times around a torus with radii ⅔ and ⅓ of
/// `radius`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct TorusKnot {
    /// Turns around the axis; has no common divisor with `q`.
    pub p: u32,
    /// Turns around the torus' tube.
    pub q: u32,
    /// Largest distance of the curve from the axis.
    pub radius: f64,
    /// Radius of the tube.
    pub tube: f64,
    /// Rings of vertices along the curve.
    pub segments: u32,
    /// Vertices of a ring.
    pub sides: u32,
}

impl TorusKnot {
    /// The triangles. The normals are exact: a tube of constant radius has its normals in the plane across
    /// the curve. A texture repeats along the curve as often as leaves it least stretched, and goes once
    /// around the tube.
    pub fn part(&self) -> Part {
        let (p, q) = (f64::from(self.p), f64::from(self.q));
        let repeats = (self.length() / (TAU * self.tube)).round();
        closed_grid(self.segments, self.sides, repeats, |t, turn| {
            let outward = DVec3::new((p * t).cos(), 0.0, -(p * t).sin());
            let forward = DVec3::new(-(p * t).sin(), 0.0, -(p * t).cos());
            let reach = 2.0 + (q * t).cos();
            let centre = outward * reach + DVec3::Y * (q * t).sin();
            let tangent = forward * (p * reach) + (DVec3::Y * (q * t).cos() - outward * (q * t).sin()) * q;
            // The normal of the torus that the curve lies on: across the curve everywhere, and closing after
            // one round, which a frame carried along the curve would not.
            let across = outward * (q * t).cos() + DVec3::Y * (q * t).sin();
            let normal = across * turn.cos() + across.cross(tangent.normalize()) * turn.sin();
            (centre * (self.radius / 3.0) + normal * self.tube, normal)
        })
    }

    /// Length of the curve: the mean speed over the parameter times 2π. A smooth periodic function is summed
    /// to its last digits by few points.
    fn length(&self) -> f64 {
        let (p, q, points) = (f64::from(self.p), f64::from(self.q), 64 * self.q);
        let speed = |t: f64| (p * (2.0 + (q * t).cos())).hypot(q) * self.radius / 3.0;
        let sum: f64 = (0..points).map(|i| speed(TAU * f64::from(i) / f64::from(points))).sum();
        TAU * sum / f64::from(points)
    }
}
