//! Shading normals of a mesh that has deformed.
//!
//! A normal turns as the surface around its vertex does: by the smallest turn that takes the mean normal of
//! the triangles there, weighted by area, from rest to now. So normals at rest are those of the file whatever
//! their making, creases stay, and morph targets, skins and shear are all treated alike; the maps of joints
//! alone would not do, for weights that differ along a surface shear it. Triangles meet at a vertex, or at a
//! place where vertices with one position and one normal at rest lie, as along seams of texture coordinates.

use glam::{DVec3, Vec3};
use std::collections::HashMap;
use std::ops::Range;

/// What turns the normals of a mesh, prepared once.
#[derive(Debug, Clone)]
pub struct ShadingNormals {
    triangles: Vec<[u32; 3]>,
    /// Unit normals at rest.
    rest: Vec<DVec3>,
    /// For each vertex the place that it lies at, numbered from 0.
    place_of: Vec<u32>,
    /// For each place the mean normal at rest.
    rest_means: Vec<DVec3>,
}

/// What the normal of a vertex is turned by.
#[derive(Debug, Clone, PartialEq)]
pub struct Surrounded {
    /// Unit normal at rest.
    pub normal: [f32; 3],
    /// Mean normal of its triangles at rest, of unit length; 0 if these have no area.
    pub mean: [f32; 3],
    /// Its triangles in a list of those at all places.
    pub triangles: Range<u32>,
}

impl ShadingNormals {
    /// Of the mesh whose vertices rest at `positions` with unit `normals`. What triangles name beyond these
    /// is left out.
    pub fn new(positions: &[[f32; 3]], normals: &[[f32; 3]], triangles: &[[u32; 3]]) -> Self {
        let mut places = HashMap::new();
        let mut place_of_vertex = |(position, normal): (&[f32; 3], &[f32; 3])| {
            let next = places.len() as u32;
            *places.entry([position, normal].map(|v| v.map(f32::to_bits))).or_insert(next)
        };
        let place_of: Vec<u32> = positions.iter().zip(normals).map(&mut place_of_vertex).collect();
        let is_known = |triangle: &&[u32; 3]| triangle.iter().all(|v| (*v as usize) < place_of.len());
        let triangles: Vec<[u32; 3]> = triangles.iter().filter(is_known).copied().collect();
        let rest = normals.iter().map(|normal| Vec3::from(*normal).as_dvec3()).collect();
        let mut shading = Self { triangles, rest, rest_means: vec![DVec3::ZERO; places.len()], place_of };
        shading.rest_means = shading.means(positions);
        shading
    }

    /// Writes the unit normals of the mesh with its vertices at `positions` over `out`, one for each vertex.
    /// Where the triangles have no area, normals are those at rest.
    pub fn at(&self, positions: &[[f32; 3]], out: &mut Vec<[f32; 3]>) {
        let means = self.means(positions);
        out.clear();
        out.extend(self.rest.iter().zip(&self.place_of).map(|(normal, place)| {
            let mean = |means: &[DVec3]| means.get(*place as usize).copied().unwrap_or_default();
            turned(*normal, mean(&self.rest_means), mean(&means)).as_vec3().to_array()
        }));
    }

    /// What those need who sum by vertex: what turns each, and the triangles that meet at places, by their
    /// vertices, place after place and in the order in which [`ShadingNormals::at`] adds them.
    pub fn by_vertex(&self) -> (Vec<Surrounded>, Vec<[u32; 3]>) {
        let place_of = |vertex: u32| self.place_of.get(vertex as usize).copied();
        let mut meeting: Vec<(u32, [u32; 3])> = Vec::with_capacity(3 * self.triangles.len());
        for triangle in &self.triangles {
            meeting.extend(triangle.iter().filter_map(|vertex| Some((place_of(*vertex)?, *triangle))));
        }
        meeting.sort_by_key(|(place, _)| *place);
        let before = |place: u32| meeting.partition_point(|(other, _)| *other < place) as u32;
        let single = |v: DVec3| v.as_vec3().to_array();
        let surrounded = self.rest.iter().zip(&self.place_of).map(|(normal, place)| Surrounded {
            normal: single(*normal),
            mean: single(self.rest_means.get(*place as usize).copied().unwrap_or_default()),
            triangles: before(*place)..before(*place + 1),
        });
        let surrounded = surrounded.collect();
        (surrounded, meeting.into_iter().map(|(_, triangle)| triangle).collect())
    }

    /// For each place the unit vector along the sum of the area vectors of its triangles; zero where there is
    /// none.
    fn means(&self, positions: &[[f32; 3]]) -> Vec<DVec3> {
        let mut sums = vec![DVec3::ZERO; self.rest_means.len()];
        for triangle in &self.triangles {
            let corner = |k: usize| {
                positions.get(triangle[k] as usize).map_or(DVec3::ZERO, |p| Vec3::from(*p).as_dvec3())
            };
            let (a, b, c) = (corner(0), corner(1), corner(2));
            let area = (b - a).cross(c - a);
            for vertex in triangle {
                let place =
                    self.place_of.get(*vertex as usize).and_then(|place| sums.get_mut(*place as usize));
                place.into_iter().for_each(|sum| *sum += area);
            }
        }
        sums.iter().map(|sum| sum.normalize_or_zero()).collect()
    }
}

/// `v` after the smallest turn that takes the unit vector `from` to the unit vector `to` (Möller & Hughes
/// 1999), exactly `v` if they are equal. Opposite ones turn it around; zero vectors leave it.
fn turned(v: DVec3, from: DVec3, to: DVec3) -> DVec3 {
    if from == DVec3::ZERO || to == DVec3::ZERO {
        return v;
    }
    let (axis, cosine) = (from.cross(to), from.dot(to));
    if cosine < -1.0 + 1e-12 {
        return -v;
    }
    v * cosine + axis.cross(v) + axis * (axis.dot(v) / (1.0 + cosine))
}
