//! Which of six ways a surface faces.

use glam::Vec3A;

/// Along each axis, both ways.
pub const ORIENTATIONS: usize = 6;

/// The axis that a normal is closest to, and its sign.
pub fn orientation_of(normal: Vec3A) -> usize {
    let axis = normal.abs().max_position();
    2 * axis + usize::from(normal[axis] < 0.0)
}
