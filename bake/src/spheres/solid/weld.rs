//! One vertex for each position: meshes split their vertices where texture coordinates or normals jump.

use glam::DVec3;
use relume_scenes::Mesh;
use std::collections::{HashMap, HashSet};

/// A mesh with one vertex for each position.
pub struct Welded {
    /// Positions, in the order of the mesh's vertices.
    pub vertices: Vec<DVec3>,
    /// Indices of them; each set of three once.
    pub triangles: Vec<[u32; 3]>,
    /// For each vertex of the mesh, its index in `vertices`.
    pub index: Vec<u32>,
    /// For each of `vertices`, the first vertex of the mesh there.
    pub first: Vec<u32>,
}

impl Welded {
    /// Welds vertices whose positions are equal to the bit, and keeps one of triangles that are there again, be it from behind.
    pub fn of(mesh: &Mesh, notes: &mut Vec<String>) -> Self {
        let mut known = HashMap::new();
        let (mut vertices, mut first) = (Vec::new(), Vec::new());
        let mut weld = |(at, position): (u32, &[f32; 3])| {
            // The sum turns -0 into 0.
            let key = position.map(|x| (x + 0.0).to_bits());
            *known.entry(key).or_insert_with(|| {
                vertices.push(DVec3::from_array(position.map(f64::from)));
                first.push(at);
                first.len() as u32 - 1
            })
        };
        let index: Vec<u32> = (0..).zip(&mesh.positions).map(&mut weld).collect();
        let mut seen = HashSet::new();
        let is_new = |t: &[u32; 3]| {
            let mut key = *t;
            key.sort_unstable();
            key[0] != key[1] && key[1] != key[2] && seen.insert(key)
        };
        let triangles: Vec<[u32; 3]> = mesh.triangles.iter().map(|t| t.map(|v| index[v as usize])).filter(is_new).collect();
        match mesh.triangles.len() - triangles.len() {
            0 => {}
            again => notes.push(format!("{again} triangles are there again or have no extent; they were left out")),
        }
        Self { vertices, triangles, index, first }
    }
}
