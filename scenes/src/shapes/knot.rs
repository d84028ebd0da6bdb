//! Torus knots.

use super::grid::closed_grid;
use crate::geometry::Part;
use glam::DVec3;

/// A tube along the curve that winds `p` times around +Y and `q` times around a torus with radii ⅔ and ⅓ of `radius`.
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
    /// The triangles. The normals are exact: a tube of constant radius has its normals in the plane across the curve.
    pub fn part(&self) -> Part {
        let (p, q) = (f64::from(self.p), f64::from(self.q));
        closed_grid(self.segments, self.sides, |t, turn| {
            let outward = DVec3::new((p * t).cos(), 0.0, -(p * t).sin());
            let forward = DVec3::new(-(p * t).sin(), 0.0, -(p * t).cos());
            let reach = 2.0 + (q * t).cos();
            let centre = outward * reach + DVec3::Y * (q * t).sin();
            let tangent = forward * (p * reach) + (DVec3::Y * (q * t).cos() - outward * (q * t).sin()) * q;
            // The normal of the torus that the curve lies on: across the curve everywhere, and closing after one round,
            // which a frame carried along the curve would not.
            let across = outward * (q * t).cos() + DVec3::Y * (q * t).sin();
            let normal = across * turn.cos() + across.cross(tangent.normalize()) * turn.sin();
            (centre * (self.radius / 3.0) + normal * self.tube, normal)
        })
    }
}
