//! One vertex for each position: meshes split their vertices where texture coordinates or normals jump, and
//! programs that compute the two sides of a seam by themselves leave them apart by a rounding error.

use glam::{DVec3, IVec3};
use relume_scenes::Mesh;
use std::collections::{HashMap, HashSet};

/// Vertices nearer than this, in parts of the diagonal, may be one whose copies differ by rounding.
const NEAR: f64 = 1e-6;
/// Far from the origin single precision itself is coarser: an error of a unit in the last place along each
/// axis.
const ROUNDING: f64 = 1.75 * f32::EPSILON as f64;

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
    /// Triangles left out, because they are there again, be it from behind, or have no extent.
    pub left_out: usize,
}

impl Welded {
    /// Welds vertices whose positions are equal to the bit.
    pub fn exactly(mesh: &Mesh) -> Self {
        let mut known = HashMap::new();
        let mut first = Vec::new();
        let mut weld = |(at, position): (u32, &[f32; 3])| {
            // The sum turns -0 into 0.
            let key = position.map(|x| (x + 0.0).to_bits());
            *known.entry(key).or_insert_with(|| {
                first.push(at);
                first.len() as u32 - 1
            })
        };
        let index = (0..).zip(&mesh.positions).map(&mut weld).collect();
        Self::new(mesh, index, first)
    }

    /// Welds vertices that only rounding keeps apart. Each joins the first one before it that stays and is
    /// near; those that stay are not near each other, so that chains of near vertices do not run together and
    /// no cell of the search's grid holds many.
    pub fn nearly(mesh: &Mesh) -> Self {
        let positions: Vec<DVec3> =
            mesh.positions.iter().map(|p| DVec3::from_array(p.map(f64::from))).collect();
        let reach = reach(&positions);
        let cell_of = |p: DVec3| (p / reach).floor();
        let low = positions.iter().fold(DVec3::INFINITY, |low, p| low.min(*p));
        let mut cells: HashMap<IVec3, Vec<u32>> = HashMap::new();
        let mut first = Vec::new();
        let mut weld = |(at, position): (u32, &DVec3)| {
            let cell = cell_of(*position - low).as_ivec3();
            let around = (0..27).map(|i| cell + IVec3::new(i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1));
            let is_near = |kept: &u32| {
                positions[first[*kept as usize] as usize].distance_squared(*position) <= reach * reach
            };
            let near = around.filter_map(|cell| cells.get(&cell)).flatten().copied().filter(is_near).min();
            near.unwrap_or_else(|| {
                let kept = first.len() as u32;
                first.push(at);
                cells.entry(cell).or_default().push(kept);
                kept
            })
        };
        let index = (0..).zip(&positions).map(&mut weld).collect();
        Self::new(mesh, index, first)
    }

    fn new(mesh: &Mesh, index: Vec<u32>, first: Vec<u32>) -> Self {
        let mut seen = HashSet::new();
        let is_new = |t: &[u32; 3]| {
            let mut key = *t;
            key.sort_unstable();
            key[0] != key[1] && key[1] != key[2] && seen.insert(key)
        };
        let triangles: Vec<[u32; 3]> =
            mesh.triangles.iter().map(|t| t.map(|v| index[v as usize])).filter(is_new).collect();
        let vertices =
            first.iter().map(|at| DVec3::from_array(mesh.positions[*at as usize].map(f64::from))).collect();
        let left_out = mesh.triangles.len() - triangles.len();
        Self { vertices, triangles, index, first, left_out }
    }
}

/// How near is near.
fn reach(positions: &[DVec3]) -> f64 {
    let (low, high) = positions
        .iter()
        .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), p| (low.min(*p), high.max(*p)));
    let farthest = low.abs().max(high.abs()).max_element();
    (NEAR * (high - low).length()).max(ROUNDING * farthest).max(f64::MIN_POSITIVE)
}
