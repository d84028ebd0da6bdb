//! Small sphere sets, made from a seed.

use super::samples::Random;
use relume_formats::kinds::SphereSet;
use relume_formats::kinds::sphere_set::{Meta, Protrusion, Quality, Solid};

fn meta(vertices: usize, seed: u64) -> Meta {
    Meta {
        mesh: "päper bunny.obj".to_owned(),
        vertices: vertices as u32,
        triangles: 2 + vertices as u32,
        seed,
        iterations: 40,
        tight: 0.0,
        poses: 0,
        solid: if seed.is_multiple_of(2) { Solid::Closed } else { Solid::WindingNumber { cells: 64 } },
        diagonal: 3.5,
        volume: 2.0,
        outside_volume: 0.5,
        quality: Quality {
            coverage_surface: 1.0,
            coverage_volume: 0.75,
            protrusion: Protrusion { mean: 0.01, p95: 0.02, max: 0.03 },
            largest_gap: 0.125,
            overlap: 0.5,
        },
    }
}

/// Points in -1..1, the first ones vertices, all others within triangles of vertices that need not be near
/// each other. Every sphere covers its points, and `slack` more.
pub fn sphere_set(seed: u64, vertices: usize, points: usize, spheres: usize, slack: f32) -> SphereSet {
    let random = &mut Random(seed);
    let mut set = SphereSet {
        meta: meta(vertices, seed),
        spheres: Vec::new(),
        points: (0..vertices).map(|_| [random.signed(), random.signed(), random.signed()]).collect(),
        point_vertices: (0..vertices as u32).map(|v| [v; 3]).collect(),
        point_weights: vec![[1.0, 0.0, 0.0]; vertices],
        clusters: (0..points).map(|_| random.below(spheres) as u32).collect(),
        history: vec![1.5, 0.75, 0.75, 0.25],
    };
    for _ in vertices..points {
        let corners = [(); 3].map(|()| random.below(vertices) as u32);
        let (a, b) = (random.unit(), random.unit());
        let weights = [1.0 - a, a * (1.0 - b), a * b];
        let place = |axis: usize| {
            (0..3)
                .map(|k| f64::from(set.points[corners[k] as usize][axis]) * f64::from(weights[k]))
                .sum::<f64>() as f32
        };
        let place = [place(0), place(1), place(2)];
        set.points.push(place);
        set.point_vertices.push(corners);
        set.point_weights.push(weights);
    }
    for sphere in 0..spheres as u32 {
        let own: Vec<_> = set
            .points
            .iter()
            .zip(&set.clusters)
            .filter(|(_, cluster)| **cluster == sphere)
            .map(|(p, _)| *p)
            .collect();
        let centre = own.first().map_or([0.25; 3], |p| p.map(|x| x + 0.25 * random.signed()));
        let distance = |p: &[f32; 3]| (0..3).map(|k| (p[k] - centre[k]).powi(2)).sum::<f32>().sqrt();
        let radius = own.iter().map(distance).fold(0.0, f32::max) * (1.0 + 1e-6) + 1e-6 + slack;
        set.spheres.push([centre[0], centre[1], centre[2], radius]);
    }
    set.meta.diagonal = diagonal(&set);
    set
}

/// Of the box around the vertices.
pub fn diagonal(set: &SphereSet) -> f32 {
    let vertices = &set.points[..set.meta.vertices as usize];
    let along = |axis: usize| vertices.iter().map(move |v| f64::from(v[axis]));
    let side = |axis: usize| {
        along(axis).fold(f64::NEG_INFINITY, f64::max) - along(axis).fold(f64::INFINITY, f64::min)
    };
    (0..3).map(|axis| side(axis).powi(2)).sum::<f64>().sqrt() as f32
}
