//! Solids for tests.

use super::triangle_tree::TriangleTree;
use glam::DVec3;

/// A box from `min` to `max`.
pub fn cuboid(min: DVec3, max: DVec3) -> (Vec<DVec3>, Vec<[u32; 3]>) {
    let corner = |i: u32| DVec3::new([min.x, max.x][(i & 1) as usize], [min.y, max.y][(i >> 1 & 1) as usize], [min.z, max.z][(i >> 2) as usize]);
    let quads = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    let triangles = quads.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]).collect();
    ((0..8).map(corner).collect(), triangles)
}

/// A torus about y.
pub fn torus(major: f64, minor: f64, around: u32, along: u32) -> (Vec<DVec3>, Vec<[u32; 3]>) {
    let mut vertices = Vec::new();
    for i in 0..around {
        for j in 0..along {
            let (a, b) = (std::f64::consts::TAU * f64::from(i) / f64::from(around), std::f64::consts::TAU * f64::from(j) / f64::from(along));
            let r = major + minor * b.cos();
            vertices.push(DVec3::new(r * a.cos(), minor * b.sin(), -r * a.sin()));
        }
    }
    let at = |i: u32, j: u32| i % around * along + j % along;
    let quad = |i: u32, j: u32| [[at(i, j), at(i + 1, j), at(i + 1, j + 1)], [at(i, j), at(i + 1, j + 1), at(i, j + 1)]];
    let triangles = (0..around).flat_map(|i| (0..along).flat_map(move |j| quad(i, j))).collect();
    (vertices, triangles)
}

pub fn tree((vertices, triangles): (Vec<DVec3>, Vec<[u32; 3]>)) -> TriangleTree {
    TriangleTree::new(vertices, triangles)
}
