//! The surfaces of a scene as obstacles: how far a hand may move the camera before it would go through one.

use glam::Vec3;

/// Largest number of steps of one way. A way that goes along a surface, just farther from it than is to be
/// kept, may end before its time.
const STEPS: usize = 256;
/// Whether a way leads towards surfaces is looked up after this share of the distance to them; it does if it
/// makes for them by more than this slope.
const PROBE: f32 = 0.01;
/// Steps end where no more than this share of the distance to keep is left to go.
const TOLERANCE: f32 = 1e-3;

/// Triangles in world space, metres.
#[derive(Debug, Clone, Default)]
pub struct Surfaces {
    positions: Vec<[f32; 3]>,
    triangles: Vec<[u32; 3]>,
}

impl Surfaces {
    /// The surfaces of a mesh; triangles without all three corners are none.
    pub fn new(positions: Vec<[f32; 3]>, triangles: Vec<[u32; 3]>) -> Self {
        Self { positions, triangles }
    }

    /// Moves the corners.
    pub fn set_positions(&mut self, positions: Vec<[f32; 3]>) {
        self.positions = positions;
    }

    /// The last point on the straight way between two points from which every surface is at least `keep`
    /// away. A point that is closer already may come out again, and along, but not nearer.
    pub fn way(&self, from: Vec3, to: Vec3, keep: f32) -> Vec3 {
        let length = from.distance(to);
        let near = self.near(from, to, keep);
        let distance =
            |point: Vec3| near.iter().map(|triangle| distance(triangle, point)).fold(f32::INFINITY, f32::min);
        let here = distance(from);
        let probe = (PROBE * here).min(length);
        let approaches = distance(from + probe / length * (to - from)) < here - PROBE * probe;
        let keep = if approaches { keep } else { keep.min(0.5 * here) };
        let mut gone = 0.0;
        for _ in 0..STEPS {
            let room = distance(from + gone / length * (to - from)) - keep;
            gone += room.max(0.0);
            if gone >= length || room.is_nan() {
                return to;
            }
            if room <= TOLERANCE * keep {
                break;
            }
        }
        from + gone / length * (to - from)
    }

    /// The triangles of which anything may be within `reach` of the way.
    fn near(&self, from: Vec3, to: Vec3, reach: f32) -> Vec<[Vec3; 3]> {
        let (low, high) = (from.min(to) - reach, from.max(to) + reach);
        let corner = |index: u32| self.positions.get(index as usize).copied().map(Vec3::from);
        let corners = |[a, b, c]: [u32; 3]| Some([corner(a)?, corner(b)?, corner(c)?]);
        let touches =
            |[a, b, c]: &[Vec3; 3]| a.max(*b).max(*c).cmpge(low).all() && a.min(*b).min(*c).cmple(high).all();
        self.triangles.iter().filter_map(|triangle| corners(*triangle)).filter(touches).collect()
    }
}

/// How far `point` is from a triangle: from its plane if it stands above the triangle, else from the nearest
/// edge.
fn distance([a, b, c]: &[Vec3; 3], point: Vec3) -> f32 {
    let normal = (b - a).cross(c - a);
    let edges = [(*a, *b), (*b, *c), (*c, *a)];
    let above = edges.iter().all(|(from, to)| (to - from).cross(point - from).dot(normal) >= 0.0);
    if above && normal.length_squared() > 0.0 {
        return (point - a).dot(normal.normalize()).abs();
    }
    edges.iter().map(|(from, to)| distance_to_edge(*from, *to, point)).fold(f32::INFINITY, f32::min)
}

fn distance_to_edge(from: Vec3, to: Vec3, point: Vec3) -> f32 {
    let way = to - from;
    let share = (point - from).dot(way) / way.length_squared().max(f32::MIN_POSITIVE);
    point.distance(from + share.clamp(0.0, 1.0) * way)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A square of side 2 in the plane z = 0, around the origin.
    fn square() -> Surfaces {
        let positions = vec![[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0]];
        Surfaces::new(positions, vec![[0, 1, 2], [0, 2, 3], [0, 1, 9]])
    }

    fn ends(from: [f32; 3], to: [f32; 3]) -> Vec3 {
        square().way(from.into(), to.into(), 0.1)
    }

    #[test]
    fn a_way_ends_before_a_surface_from_either_side() {
        for side in [1.0, -1.0] {
            let end = ends([0.3, 0.2, 5.0 * side], [0.3, 0.2, -5.0 * side]);
            assert!(end.distance(Vec3::new(0.3, 0.2, 0.1 * side)) < 1e-3, "{end}");
            // At a slant, the distance counts that is square to the surface.
            let end = ends([-2.0, 0.0, 2.0 * side], [2.0, 0.0, -2.0 * side]);
            assert!(end.distance(Vec3::new(-0.1, 0.0, 0.1 * side)) < 1e-3, "{end}");
        }
    }

    #[test]
    fn where_nothing_is_in_the_way_it_is_gone_whole() {
        for (from, to) in [
            ([1.2, 0.0, 5.0], [1.2, 0.0, -5.0]),
            ([0.0, 0.0, 5.0], [0.0, 0.0, 0.2]),
            ([0.0, 0.0, 0.2], [0.0, 0.0, 900.0]),
        ] {
            assert_eq!(ends(from, to), Vec3::from(to));
        }
        let there = Vec3::new(0.0, 0.0, 3.0);
        assert_eq!(Surfaces::default().way(there, there, 0.1), there);
        assert_eq!(Surfaces::default().way(there, -there, 0.1), -there);
        // Past the edge, as near as may be and a little nearer.
        assert_eq!(ends([1.101, 0.0, 1.0], [1.101, 0.0, -1.0]), Vec3::new(1.101, 0.0, -1.0));
        assert!(ends([1.05, 0.0, 1.0], [1.05, 0.0, -1.0]).z > 0.08);
    }

    #[test]
    fn what_is_too_close_comes_out_again_but_not_through() {
        assert_eq!(ends([0.0, 0.0, 0.02], [0.0, 0.0, 4.0]), Vec3::new(0.0, 0.0, 4.0));
        assert_eq!(ends([-0.5, 0.0, 0.02], [0.5, 0.0, 0.02]), Vec3::new(0.5, 0.0, 0.02));
        assert_eq!(ends([0.0, 0.0, 0.02], [0.0, 0.0, -4.0]), Vec3::new(0.0, 0.0, 0.02));
    }

    #[test]
    fn distances_are_those_of_the_nearest_point() {
        let triangle = [[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 3.0, 0.0]].map(Vec3::from);
        for (point, expected) in [
            ([1.0, 1.0, -2.0], 2.0),
            ([2.0, -3.0, 4.0], 5.0),
            ([-3.0, -4.0, 0.0], 5.0),
            ([4.0 + 3.0, 4.0, 0.0], 5.0),
            ([7.0, 0.0, 4.0], 5.0),
        ] {
            assert!((distance(&triangle, point.into()) - expected).abs() < 1e-5, "{point:?}");
        }
        let line = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0]].map(Vec3::from);
        assert_eq!(distance(&line, Vec3::new(1.5, 2.0, 0.0)), 2.0);
    }
}
