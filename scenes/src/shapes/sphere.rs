//! The sphere, as an icosphere: triangles of nearly equal size, no poles.

use super::sphere_uvs::wrap_map_around;
use crate::geometry::Part;
use glam::DVec3;
use std::collections::HashMap;

/// Points on the unit sphere and triangles between them, counter-clockwise seen from outside: an icosahedron
/// whose 20 triangles are split in four `subdivisions` times.
pub fn icosphere(subdivisions: u32) -> (Vec<DVec3>, Vec<[u32; 3]>) {
    let (mut points, mut triangles) = icosahedron();
    for _ in 0..subdivisions {
        triangles = split(&mut points, &triangles);
    }
    (points, triangles)
}

/// The unit sphere as a shape, with texture coordinates.
pub(super) fn part(subdivisions: u32) -> Part {
    let (points, triangles) = icosphere(subdivisions);
    let positions: Vec<[f32; 3]> = points.iter().map(|p| p.as_vec3().to_array()).collect();
    let mut part = Part { normals: positions.clone(), positions, triangles, ..Part::default() };
    wrap_map_around(&mut part);
    part
}

fn split(points: &mut Vec<DVec3>, triangles: &[[u32; 3]]) -> Vec<[u32; 3]> {
    let mut middles: HashMap<[u32; 2], u32> = HashMap::new();
    let mut middle = |a: u32, b: u32| {
        *middles.entry([a.min(b), a.max(b)]).or_insert_with(|| {
            points.push((points[a as usize] + points[b as usize]).normalize());
            points.len() as u32 - 1
        })
    };
    let mut smaller = Vec::with_capacity(4 * triangles.len());
    for [a, b, c] in triangles {
        let (ab, bc, ca) = (middle(*a, *b), middle(*b, *c), middle(*c, *a));
        smaller.extend([[*a, ab, ca], [*b, bc, ab], [*c, ca, bc], [ab, bc, ca]]);
    }
    smaller
}

/// The poles, and two staggered rings of five at latitudes ± atan ½.
fn icosahedron() -> (Vec<DVec3>, Vec<[u32; 3]>) {
    let (y, radius) = (1.0 / 5f64.sqrt(), 2.0 / 5f64.sqrt());
    let on_ring = |tenths: u32, y: f64| {
        let angle = std::f64::consts::TAU * f64::from(tenths) / 10.0;
        DVec3::new(radius * angle.cos(), y, -radius * angle.sin())
    };
    let mut points = vec![DVec3::Y, DVec3::NEG_Y];
    points.extend((0..5).map(|k| on_ring(2 * k, y)));
    points.extend((0..5).map(|k| on_ring(2 * k + 1, -y)));
    let upper = |k: u32| 2 + k % 5;
    let lower = |k: u32| 7 + k % 5;
    let around = |k: u32| {
        [
            [0, upper(k), upper(k + 1)],
            [upper(k), lower(k), upper(k + 1)],
            [lower(k), lower(k + 1), upper(k + 1)],
            [1, lower(k + 1), lower(k)],
        ]
    };
    (points, (0..5).flat_map(around).collect())
}
