//! The distance of a point from a mesh.

use super::triangle_tree::TriangleTree;
use glam::DVec3;

impl TriangleTree {
    /// Distance of `point` from the nearest triangle; infinite if there is none.
    pub fn distance(&self, point: DVec3) -> f64 {
        self.nearest(point).map_or(f64::INFINITY, |(distance, _)| distance)
    }

    /// The distance of `point` from the nearest triangle, and which that is, the first of equally near ones.
    pub fn nearest(&self, point: DVec3) -> Option<(f64, usize)> {
        let mut best = (f64::INFINITY, 0);
        self.walk_nearest(0, point, &mut best);
        best.0.is_finite().then(|| (best.0.sqrt(), best.1))
    }

    fn walk_nearest(&self, index: u32, point: DVec3, best: &mut (f64, usize)) {
        let Some(node) = self.nodes.get(index as usize) else { return };
        if node.second == 0 {
            for t in node.range.0..node.range.1 {
                let squared = distance_squared(point, self.corners(t as usize));
                if squared < best.0 {
                    *best = (squared, t as usize);
                }
            }
            return;
        }
        let mut children =
            [index + 1, node.second].map(|child| (self.nodes[child as usize].nearest_squared(point), child));
        if children[1].0 < children[0].0 {
            children.swap(0, 1);
        }
        for (lower_bound, child) in children {
            if lower_bound < best.0 {
                self.walk_nearest(child, point, best);
            }
        }
    }
}

/// Squared distance of a point from a triangle: from its plane where the foot lies within, else from its
/// edges.
fn distance_squared(point: DVec3, corners: [DVec3; 3]) -> f64 {
    let [a, b, c] = corners;
    let normal = (b - a).cross(c - a);
    let within =
        (0..3).all(|i| (corners[(i + 1) % 3] - corners[i]).cross(point - corners[i]).dot(normal) >= 0.0);
    if within && normal != DVec3::ZERO {
        return (point - a).dot(normal).powi(2) / normal.length_squared();
    }
    let to_edge = |i: usize| {
        let (start, edge) = (corners[i], corners[(i + 1) % 3] - corners[i]);
        let t = ((point - start).dot(edge) / edge.length_squared().max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
        point.distance_squared(start + t * edge)
    };
    (0..3).map(to_edge).fold(f64::INFINITY, f64::min)
}
