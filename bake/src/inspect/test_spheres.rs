//! A small sphere set whose every number is known.

use relume_formats::kinds::SphereSet;
use relume_formats::kinds::sphere_set::{Meta, Protrusion, Quality, Solid};

/// Two spheres about the ends of an octahedron that is 2 × 2 × 4 large, and a point in the middle of one of
/// its triangles.
pub(super) fn octahedron() -> SphereSet {
    let vertices = [
        [1.0, 0.0, 0.0],
        [-1.0, 0.0, 0.0],
        [0.0, 1.0, 0.0],
        [0.0, -1.0, 0.0],
        [0.0, 0.0, 2.0],
        [0.0, 0.0, -2.0f32],
    ];
    let volume = 8.0 / 3.0;
    SphereSet {
        meta: Meta {
            mesh: "octahedron.off".to_owned(),
            vertices: 6,
            triangles: 8,
            seed: 7,
            iterations: 40,
            tight: 0.0,
            poses: 0,
            solid: Solid::Closed,
            diagonal: 24f32.sqrt(),
            volume,
            outside_volume: 2.5 * volume,
            quality: Quality {
                coverage_surface: 1.0,
                coverage_volume: 0.9375,
                protrusion: Protrusion { mean: 0.25, p95: 0.5, max: 0.75 },
                largest_gap: 0.125,
                overlap: 0.375,
            },
        },
        spheres: vec![[0.0, 0.0, 1.0, 1.5], [0.0, 0.0, -1.0, 1.5]],
        points: vertices.into_iter().chain([[0.5, 0.25, 0.5]]).collect(),
        point_vertices: (0..6).map(|v| [v; 3]).chain([[0, 2, 4]]).collect(),
        point_weights: std::iter::repeat_n([1.0, 0.0, 0.0], 6).chain([[0.5, 0.25, 0.25]]).collect(),
        clusters: vec![0, 0, 1, 1, 0, 1, 0],
        history: vec![4.0, 3.0, 2.5],
    }
}
