//! The generalised winding number (Jacobson et al. 2013): how many times a mesh encloses a point. 1 inside
//! and 0 outside a closed mesh that faces outwards; in between, smoothly, near the holes of an open one.
//! Distant branches are summed as dipoles (Barill et al. 2018).

use super::triangle_tree::TriangleTree;
use glam::DVec3;
use std::f64::consts::TAU;

/// A branch is a dipole from this many of its radii away. There the error of a whole closed mesh's number
/// stays far below the 1/2 that matters.
const FAR: f64 = 3.0;

impl TriangleTree {
    /// The winding number about `point`.
    pub fn winding_number(&self, point: DVec3) -> f64 {
        let mut sum = 0.0;
        self.walk(|node| {
            let to_node = node.centre - point;
            let distance_squared = to_node.length_squared();
            if distance_squared > (FAR * node.radius).powi(2) {
                sum += node.area_vector.dot(to_node) / (distance_squared * distance_squared.sqrt());
                return false;
            }
            if node.second == 0 {
                let (first, last) = node.range;
                sum += (first..last)
                    .map(|t| solid_angle(self.corners(t as usize).map(|v| v - point)))
                    .sum::<f64>();
            }
            true
        });
        sum / (2.0 * TAU)
    }

    /// Whether `point` lies in the solid that the mesh bounds.
    pub fn encloses(&self, point: DVec3) -> bool {
        self.winding_number(point) >= 0.5
    }
}

/// Signed solid angle of a triangle seen from the origin, positive if its front faces away (Van Oosterom and
/// Strackee 1983).
pub fn solid_angle([a, b, c]: [DVec3; 3]) -> f64 {
    let (la, lb, lc) = (a.length(), b.length(), c.length());
    let determinant = a.dot(b.cross(c));
    let denominator = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
    2.0 * determinant.atan2(denominator)
}
