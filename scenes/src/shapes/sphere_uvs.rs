//! Texture coordinates of the sphere: longitude and latitude, as a world map has them.

use crate::geometry::Part;
use std::collections::HashMap;
use std::f64::consts::{FRAC_1_PI, TAU};

/// Gives a sphere around the origin texture coordinates u = ½ + atan2(x, z)/2π and v = acos(y)/π. Vertices of
/// the seam at the back and of the poles are doubled as needed, at the same positions.
pub(super) fn wrap_map_around(part: &mut Part) {
    part.uvs = part.positions.iter().map(|p| map_coordinates(*p)).collect();
    let mut doubles = HashMap::new();
    for index in 0..part.triangles.len() {
        let triangle = part.triangles[index];
        let us = unwrapped(
            triangle.map(|v| part.uvs[v as usize][0]),
            triangle.map(|v| is_pole(part.positions[v as usize])),
        );
        for (corner, u) in us.into_iter().enumerate() {
            let vertex = triangle[corner];
            if u != part.uvs[vertex as usize][0] {
                part.triangles[index][corner] =
                    *doubles.entry((vertex, u.to_bits())).or_insert_with(|| double(part, vertex, u));
            }
        }
    }
}

fn map_coordinates([x, y, z]: [f32; 3]) -> [f32; 2] {
    let turn = 0.5 + f64::from(x).atan2(f64::from(z)) / TAU;
    [turn as f32, (f64::from(y).clamp(-1.0, 1.0).acos() * FRAC_1_PI) as f32]
}

fn is_pole([x, _, z]: [f32; 3]) -> bool {
    x == 0.0 && z == 0.0
}

/// The longitudes of a triangle's corners without a jump between them; a pole has no longitude and takes the
/// others' mean.
fn unwrapped(us: [f32; 3], pole: [bool; 3]) -> [f32; 3] {
    let others = || (0..3).filter(|k| !pole[*k]).map(|k| us[k]);
    let largest = others().fold(f32::MIN, f32::max);
    let turned = |u: f32| if largest - u > 0.5 { u + 1.0 } else { u };
    let mean = others().map(turned).sum::<f32>() / others().count() as f32;
    std::array::from_fn(|k| if pole[k] { mean } else { turned(us[k]) })
}

fn double(part: &mut Part, vertex: u32, u: f32) -> u32 {
    let vertex = vertex as usize;
    part.positions.push(part.positions[vertex]);
    part.normals.push(part.normals[vertex]);
    part.uvs.push([u, part.uvs[vertex][1]]);
    part.positions.len() as u32 - 1
}
