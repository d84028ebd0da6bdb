//! Whether a surface is the skin of solids, each by itself.
//!
//! Receivers on such a surface are outside of all of it, so that what of it blocks their view turns its front
//! to them: half of its triangles need not be looked at. Where parts touch, overlap or lie within each other,
//! a receiver of one may be within another, and in a room all are, whose walls face inwards. So may those of
//! a single part that runs into itself or folds over.

use crate::spheres::solid::is_closed;
use crate::spheres::triangle_tree::TriangleTree;
use glam::Vec3;
use rayon::prelude::*;

/// Parts that are looked at one against the other; more count as touching.
const MOST_PARTS: usize = 64;
/// What must be between their boxes, in parts of the extent of all.
const MARGIN: f32 = 0.01;
/// How far before a vertex it is asked whether that is outside, in parts of the extent of all: far more than
/// rounding, far less than triangles.
const BEFORE: f64 = 1e-4;

/// A box along the axes.
type Bounds = (Vec3, Vec3);

/// Whether `triangles`, turned outwards, are closed, vertices' `normals` at rest face outwards too, and the
/// boxes around parts that have no vertex in common stand apart wherever vertices are in `poses`, rest first.
pub fn are_solids(triangles: &[[u32; 3]], normals: &[[f32; 3]], poses: &[&[[f32; 3]]]) -> bool {
    let Some(rest) = poses.first() else { return false };
    if !is_closed(triangles) {
        return false;
    }
    let parts = parts(triangles, rest.len());
    let count = parts.iter().max().map_or(0, |last| *last as usize + 1);
    count <= MOST_PARTS
        && face_outwards(triangles, &parts, count, rest, normals)
        && poses.iter().all(|pose| stand_apart(triangles, &parts, count, pose))
}

/// Whether what is just before each of the `used` vertices, along its normal, is outside of all that
/// `triangles`, which are closed and face outwards, enclose with vertices at `positions`.
pub fn are_outside(
    triangles: &[[u32; 3]],
    used: &[(u32, f64)],
    positions: &[[f32; 3]],
    normals: &[[f32; 3]],
) -> bool {
    let places = positions.iter().map(|p| Vec3::from(*p).as_dvec3()).collect();
    let tree = TriangleTree::new(places, triangles.to_vec());
    let extent = tree.nodes.first().map_or(0.0, |root| (root.max - root.min).max_element());
    used.par_iter().all(|(vertex, _)| {
        let vertex = *vertex as usize;
        let (place, normal) = (Vec3::from(positions[vertex]), Vec3::from(normals[vertex]));
        !tree.encloses(place.as_dvec3() + BEFORE * extent * normal.as_dvec3())
    })
}

/// For each triangle the number of its part.
fn parts(triangles: &[[u32; 3]], vertices: usize) -> Vec<u32> {
    let mut leader: Vec<u32> = (0..vertices as u32).collect();
    let find = |leader: &mut Vec<u32>, mut vertex: u32| {
        while leader[vertex as usize] != vertex {
            leader[vertex as usize] = leader[leader[vertex as usize] as usize];
            vertex = leader[vertex as usize];
        }
        vertex
    };
    for [a, b, c] in triangles {
        for other in [b, c] {
            let [first, second] = [*a, *other].map(|vertex| find(&mut leader, vertex));
            leader[first.max(second) as usize] = first.min(second);
        }
    }
    let mut numbers = vec![u32::MAX; vertices];
    let mut next = 0;
    let of = |triangle: &[u32; 3]| {
        let number = &mut numbers[find(&mut leader, triangle[0]) as usize];
        if *number == u32::MAX {
            *number = next;
            next += 1;
        }
        *number
    };
    triangles.iter().map(of).collect()
}

fn face_outwards(
    triangles: &[[u32; 3]],
    parts: &[u32],
    count: usize,
    positions: &[[f32; 3]],
    normals: &[[f32; 3]],
) -> bool {
    let mut along = vec![0.0_f64; count];
    for (triangle, part) in triangles.iter().zip(parts) {
        let [a, b, c] = triangle.map(|v| Vec3::from(positions[v as usize]).as_dvec3());
        let shading: Vec3 = triangle.iter().map(|v| Vec3::from(normals[*v as usize])).sum();
        along[*part as usize] += (b - a).cross(c - a).dot(shading.as_dvec3());
    }
    along.iter().all(|along| *along > 0.0)
}

fn stand_apart(triangles: &[[u32; 3]], parts: &[u32], count: usize, positions: &[[f32; 3]]) -> bool {
    let mut boxes: Vec<Bounds> = vec![(Vec3::INFINITY, Vec3::NEG_INFINITY); count];
    for (triangle, part) in triangles.iter().zip(parts) {
        for point in triangle.map(|v| Vec3::from(positions[v as usize])) {
            let (low, high) = boxes[*part as usize];
            boxes[*part as usize] = (low.min(point), high.max(point));
        }
    }
    let all = boxes
        .iter()
        .fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(low, high), (l, h)| (low.min(*l), high.max(*h)));
    let margin = MARGIN * (all.1 - all.0).max_element();
    let apart = |a: &Bounds, b: &Bounds| (a.1 + margin).cmplt(b.0).any() || (b.1 + margin).cmplt(a.0).any();
    boxes.iter().enumerate().all(|(k, a)| boxes[..k].iter().all(|b| apart(a, b)))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A cube of side 1 about `centre`, turned outwards.
    fn cube(centre: [f32; 3], positions: &mut Vec<[f32; 3]>, triangles: &mut Vec<[u32; 3]>) {
        let first = positions.len() as u32;
        let corner = |k: u32| [0, 1, 2].map(|axis: usize| centre[axis] + (k >> axis & 1) as f32 - 0.5);
        positions.extend((0..8).map(corner));
        let quads = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
        for [a, b, c, d] in quads {
            triangles.extend([[a, b, c], [a, c, d]].map(|t| t.map(|v: u32| first + v)));
        }
    }

    /// Positions, triangles, normals.
    type Cubes = (Vec<[f32; 3]>, Vec<[u32; 3]>, Vec<[f32; 3]>);

    fn of(centres: &[[f32; 3]]) -> Cubes {
        let (mut positions, mut triangles) = (Vec::new(), Vec::new());
        centres.iter().for_each(|centre| cube(*centre, &mut positions, &mut triangles));
        let normal = |(k, p): (usize, &[f32; 3])| {
            let centre = Vec3::from(centres[k / 8]);
            (Vec3::from(*p) - centre).normalize().to_array()
        };
        let normals = positions.iter().enumerate().map(normal).collect();
        (positions, triangles, normals)
    }

    #[test]
    fn what_touches_lies_within_or_faces_inwards_is_no_solid() {
        let alone = |centres: &[[f32; 3]]| {
            let (positions, triangles, normals) = of(centres);
            are_solids(&triangles, &normals, &[&positions])
        };
        assert!(alone(&[[0.0; 3]]));
        assert!(alone(&[[0.0; 3], [1.1, 0.0, 0.0], [0.0, -7.0, 0.5]]), "stand apart");
        assert!(!alone(&[[0.0; 3], [1.0, 0.0, 0.0]]), "touch");
        assert!(!alone(&[[0.0; 3], [0.5, 0.2, 0.0]]), "overlap");
        let (positions, triangles, normals) = of(&[[0.0; 3]]);
        let inwards: Vec<[f32; 3]> = normals.iter().map(|n| n.map(|x| -x)).collect();
        assert!(!are_solids(&triangles, &inwards, &[&positions]), "a room");
        assert!(!are_solids(&triangles[1..], &normals, &[&positions]), "open");
        let (positions, triangles, normals) = of(&[[0.0; 3], [3.0, 0.0, 0.0]]);
        let mut meeting = positions.clone();
        meeting[8..].iter_mut().for_each(|p| p[0] -= 2.5);
        assert!(!are_solids(&triangles, &normals, &[&positions, &meeting]), "meet in a pose");
    }

    /// A torus knot of this tube, and whether its vertices are outside of it.
    fn is_knot_outside(tube: f32, q: u32) -> bool {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("scene.toml");
        let text = format!(
            "[camera]\nposition = [0, 0, 3]\ntarget = [0, 0, 0]\nfov_deg = 40\n[render]\nsize = [8, 8]\n[environment]\nfile = 'white'\n\
             [materials.m]\nbrdf = 'blinn-phong'\n[[object]]\nname = 'knot'\nshape = 'torus-knot'\nradius = 0.5\n\
             tube = {tube}\np = 2\nq = {q}\nmaterial = 'm'\n"
        );
        std::fs::write(&path, text).unwrap();
        let scene = relume_scenes::load(&path).unwrap();
        let mesh = &scene.objects[0].mesh;
        let used: Vec<(u32, f64)> = (0..mesh.positions.len() as u32).map(|vertex| (vertex, 1.0)).collect();
        are_outside(&mesh.triangles, &used, &mesh.positions, &mesh.normals)
    }

    #[test]
    fn a_knot_that_runs_into_itself_is_within_itself() {
        assert!(is_knot_outside(0.1, 3));
        assert!(!is_knot_outside(0.15, 9), "nine windings of a tube of 0.15 m");
    }
}
