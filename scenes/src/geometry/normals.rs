//! Smooth normals where a mesh has none.

use super::builder::{area_vector, unit_or_zero};
use crate::scene::Mesh;
use glam::{DVec3, Vec3};
use std::collections::HashMap;

/// Gives every vertex with a zero normal the mean of the normals of all triangles at its position, weighted by their angle there.
/// Positions and not indices decide, so that a seam of texture coordinates leaves no crease. Returns how many vertices there were.
pub(super) fn fill_missing(mesh: &mut Mesh) -> usize {
    let missing = mesh.normals.iter().filter(|n| is_zero(n)).count();
    if missing == 0 {
        return 0;
    }
    let mut sums: HashMap<[u32; 3], DVec3> = HashMap::new();
    // The two sides of a thin sheet cancel out; then any face of the vertex itself is better than nothing.
    let mut face_normals = vec![[0.0; 3]; mesh.positions.len()];
    for triangle in &mesh.triangles {
        let corners = triangle.map(|v| mesh.positions[v as usize]);
        let normal = area_vector(corners).normalize_or_zero();
        for (corner, vertex) in triangle.iter().enumerate() {
            let weight = corner_angle(corners, corner);
            *sums.entry(position_key(corners[corner])).or_default() += normal * weight;
            face_normals[*vertex as usize] = unit_or_zero(normal);
        }
    }
    for (vertex, normal) in mesh.normals.iter_mut().enumerate().filter(|(_, n)| is_zero(n)) {
        let sum = sums.get(&position_key(mesh.positions[vertex])).copied().unwrap_or_default();
        *normal = if sum.length() > 1e-6 { unit_or_zero(sum) } else { face_normals[vertex] };
    }
    missing
}

fn is_zero(normal: &[f32; 3]) -> bool {
    *normal == [0.0; 3]
}

/// Equal for equal positions.
fn position_key(position: [f32; 3]) -> [u32; 3] {
    position.map(|x| (x + 0.0).to_bits())
}

/// The angle of a triangle at one of its corners, radians.
fn corner_angle(corners: [[f32; 3]; 3], corner: usize) -> f64 {
    let at = |k: usize| Vec3::from(corners[(corner + k) % 3]).as_dvec3();
    (at(1) - at(0)).angle_between(at(2) - at(0))
}
