//! The torus.

use super::grid::closed_grid;
use crate::geometry::Part;
use glam::DVec3;

/// A torus around +Y: `segments` along the ring, `sides` around its tube. A texture repeats along the ring as
/// often as leaves it least stretched, and goes once around the tube.
pub(super) fn torus(major_radius: f64, minor_radius: f64, segments: u32, sides: u32) -> Part {
    closed_grid(segments, sides, (major_radius / minor_radius).round(), |around, tube| {
        let outward = DVec3::new(around.cos(), 0.0, -around.sin());
        let normal = outward * tube.cos() + DVec3::Y * tube.sin();
        (outward * major_radius + normal * minor_radius, normal)
    })
}
