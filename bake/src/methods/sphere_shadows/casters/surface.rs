//! The surface of an object by fewer triangles, in all poses.
//!
//! Edges are collapsed to one of their ends (crate `meshopt`, after Garland and Heckbert 1997), so what is
//! left has corners that are vertices of the mesh and follows its skin, its morphs and its clips. What an
//! edge costs counts in the poses too: where vertices are in each of some poses goes with them as attributes,
//! whose change over the surface a collapse must keep as it must keep the surface itself.
//!
//! Corners on the surface leave the triangles within what is round, and their shadow thinner than it should
//! be. So corners are moved along their normals until the surface is, on the whole, as far outside the
//! triangles as it is inside.

use super::solids::{are_outside, are_solids};
use crate::spheres::motion::poses;
use crate::spheres::solid::{is_closed, welded};
use crate::spheres::triangle_tree::TriangleTree;
use glam::Vec3;
use meshopt::{SimplifyOptions, VertexDataAdapter, simplify_with_attributes_and_locks};
use rayon::prelude::*;
use relume_formats::shape::ShadingNormals;
use relume_scenes::Object;

/// Poses that go with the vertices: as many as `meshopt` has room for.
const POSES: usize = 10;
/// How often corners are moved.
const ROUNDS: usize = 3;
/// How much farther than from its own a vertex that is within fewer triangles may be below those beside it:
/// of open meshes these would block its view.
const BESIDE: f32 = 2.0;
/// Error, in parts of the extent, that counts as none: a texel of visibility is 500 times as wide, seen from
/// as far.
const NONE: f32 = 1e-4;

/// An object's surface.
pub struct Surface {
    /// By the first of the mesh's vertices at each place, consistently turned, closed parts outwards.
    triangles: Vec<[u32; 3]>,
    /// Where the vertices are, at rest first.
    poses: Vec<Pose>,
    /// The vertices that triangles have, with the area around each, at rest.
    used: Vec<(u32, f64)>,
    /// Whether it is the skin of solids that stand apart.
    solid: bool,
}

/// Vertices of the object in a pose.
struct Pose {
    positions: Vec<[f32; 3]>,
    /// Of unit length.
    normals: Vec<[f32; 3]>,
}

/// Fewer triangles of it.
#[derive(Debug, Clone, PartialEq)]
pub struct Simplified {
    /// Vertices of the object.
    pub triangles: Vec<[u32; 3]>,
    /// Whether they are the skin of solids that stand apart, seen counter-clockwise from outside.
    pub closed: bool,
    /// How far the corners are before their vertices, along these' normals, metres.
    pub offsets: Vec<[f32; 3]>,
    /// For each the farthest that a vertex is, in any pose, from where it and those around it stand for the
    /// surface; twice that if they are not closed, for a vertex within is farther below some of those around
    /// it. Metres.
    pub errors: Vec<f32>,
}

impl Surface {
    /// Of `object`.
    pub fn new(object: &Object) -> Self {
        let surface = welded(&object.mesh);
        let triangles: Vec<[u32; 3]> =
            surface.triangles.iter().map(|t| t.map(|vertex| surface.first[vertex as usize])).collect();
        let moved = object.shape.as_deref().map(poses).unwrap_or_default();
        let step = moved.len().div_ceil(POSES).max(1);
        let mesh = &object.mesh;
        let shading = ShadingNormals::new(&mesh.positions, &mesh.normals, &mesh.triangles);
        let posed = |positions: Vec<[f32; 3]>| {
            let mut normals = Vec::new();
            shading.at(&positions, &mut normals);
            Pose { positions, normals }
        };
        let rest = Pose { positions: mesh.positions.clone(), normals: mesh.normals.clone() };
        let poses: Vec<Pose> =
            std::iter::once(rest).chain(moved.into_iter().step_by(step).map(posed)).collect();
        let places: Vec<&[[f32; 3]]> = poses.iter().map(|pose| &pose.positions[..]).collect();
        let used = areas(&triangles, &mesh.positions);
        let outside = |pose: &Pose| are_outside(&triangles, &used, &pose.positions, &pose.normals);
        let solid = are_solids(&triangles, &mesh.normals, &places) && poses.iter().all(outside);
        Self { used, triangles, poses, solid }
    }

    /// All of it.
    pub fn whole(&self) -> Simplified {
        let (count, triangles) = (self.triangles.len(), self.triangles.clone());
        Simplified { triangles, closed: self.solid, offsets: vec![[0.0; 3]; count], errors: vec![0.0; count] }
    }

    /// As few triangles as leave the surface where it is: all, if it is so thin that none would be left.
    pub fn flat(&self) -> Simplified {
        Some(self.collapsed(0, NONE))
            .filter(|flat| !flat.triangles.is_empty())
            .unwrap_or_else(|| self.whole())
    }

    /// About `count` triangles; none, if there are fewer than it takes for anything to be left.
    pub fn simplified(&self, count: usize) -> Simplified {
        self.collapsed(count, f32::MAX)
    }

    /// About `count` triangles, or as few as leave the surface where it is, if these are not more.
    pub fn about(&self, count: usize) -> Simplified {
        Some(self.flat())
            .filter(|flat| flat.triangles.len() <= count)
            .unwrap_or_else(|| self.simplified(count))
    }

    fn collapsed(&self, count: usize, error: f32) -> Simplified {
        let [rest, moved @ ..] = &self.poses[..] else { return self.whole() };
        // Vertices beside others that no triangle has would count as seams, which may not move.
        let mut kept: Vec<u32> = self.triangles.as_flattened().to_vec();
        kept.sort_unstable();
        kept.dedup();
        let among_kept = |vertex: &u32| kept.partition_point(|other| other < vertex) as u32;
        let indices: Vec<u32> = self.triangles.as_flattened().iter().map(among_kept).collect();
        let place = |pose: &Pose, vertex: &u32| pose.positions[*vertex as usize];
        let at_rest: Vec<[f32; 3]> = kept.iter().map(|vertex| place(rest, vertex)).collect();
        let attributes: Vec<f32> =
            kept.iter().flat_map(|vertex| moved.iter().flat_map(move |pose| place(pose, vertex))).collect();
        let weights = vec![1.0 / extent(&rest.positions); 3 * moved.len()];
        let stride = size_of::<[f32; 3]>();
        let Ok(vertices) = VertexDataAdapter::new(bytemuck::cast_slice(&at_rest), stride, 0) else {
            return self.whole();
        };
        let unlocked = vec![false; kept.len()];
        let left = simplify_with_attributes_and_locks(
            &indices,
            &vertices,
            &attributes,
            &weights,
            size_of_val(&weights[..]),
            &unlocked,
            3 * count,
            error,
            SimplifyOptions::None,
            None,
        );
        let of_object = |triangle: &[u32; 3]| triangle.map(|vertex| kept[vertex as usize]);
        self.fitted(left.as_chunks::<3>().0.iter().map(of_object).collect())
    }

    /// `triangles` with their corners moved, and what is left of errors.
    fn fitted(&self, triangles: Vec<[u32; 3]>) -> Simplified {
        let vertices = self.poses.first().map_or(0, |pose| pose.positions.len());
        let mut offsets = vec![0.0; vertices];
        for _ in 0..ROUNDS {
            let mut sums = vec![(0.0, 0.0); vertices];
            for (distance, area, triangle) in self.distances(&triangles, &offsets) {
                for corner in triangle {
                    let (sum, weight) = &mut sums[corner as usize];
                    (*sum, *weight) = (*sum + area * distance, *weight + area);
                }
            }
            for (offset, (sum, weight)) in offsets.iter_mut().zip(sums) {
                *offset += if weight > 0.0 { sum / weight } else { 0.0 };
            }
        }
        let mut errors = vec![0.0; vertices];
        for (distance, _, triangle) in self.distances(&triangles, &offsets) {
            for corner in triangle {
                let error: &mut f64 = &mut errors[corner as usize];
                *error = error.max(distance.abs());
            }
        }
        let closed = self.solid && is_closed(&triangles);
        let times = if closed { 1.0 } else { BESIDE };
        let of = |triangle: &[u32; 3]| {
            times * triangle.iter().map(|v| errors[*v as usize] as f32).fold(0.0, f32::max)
        };
        Simplified {
            closed,
            errors: triangles.iter().map(of).collect(),
            offsets: triangles.iter().map(|t| t.map(|v| offsets[v as usize] as f32)).collect(),
            triangles,
        }
    }

    /// For each vertex in each pose how far it is before `triangles`, with the area around it and the
    /// triangle that is nearest.
    fn distances(&self, triangles: &[[u32; 3]], offsets: &[f64]) -> Vec<(f64, f64, [u32; 3])> {
        let of_pose = |pose: &Pose| {
            let place = |v: usize| Vec3::from(pose.positions[v]).as_dvec3();
            let moved = |v: usize| place(v) + offsets[v] * Vec3::from(pose.normals[v]).as_dvec3();
            let tree = TriangleTree::new((0..offsets.len()).map(moved).collect(), triangles.to_vec());
            let of = |(vertex, area): &(u32, f64)| {
                let point = place(*vertex as usize);
                let (distance, triangle) = tree.nearest(point)?;
                let side = (point - tree.corners(triangle)[0]).dot(tree.planes[triangle].0);
                Some((distance.copysign(side), *area, tree.triangles[triangle]))
            };
            self.used.par_iter().filter_map(of).collect::<Vec<_>>()
        };
        self.poses.iter().flat_map(of_pose).collect()
    }
}

/// The vertices of `triangles`, each with a third of the area of those that have it.
fn areas(triangles: &[[u32; 3]], positions: &[[f32; 3]]) -> Vec<(u32, f64)> {
    let mut areas = vec![0.0; positions.len()];
    for triangle in triangles {
        let [a, b, c] = triangle.map(|v| Vec3::from(positions[v as usize]).as_dvec3());
        triangle.iter().for_each(|v| areas[*v as usize] += (b - a).cross(c - a).length() / 6.0);
    }
    (0..).zip(areas).filter(|(_, area)| *area > 0.0).collect()
}

/// The longest side of the box around `points`.
fn extent(points: &[[f32; 3]]) -> f32 {
    let of = |axis: usize| {
        let along = points.iter().map(|p| p[axis]);
        let (low, high) = along.fold((f32::MAX, f32::MIN), |(low, high), x| (low.min(x), high.max(x)));
        high - low
    };
    (0..3).map(of).fold(f32::MIN_POSITIVE, f32::max)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DAffine3;
    use relume_formats::shape::{
        Clip, DeformingMesh, Influences, Interpolation, Joint, MorphTarget, Node, Property, Track, Transform,
    };
    use relume_scenes::Mesh;
    use std::sync::Arc;

    fn knot() -> Object {
        relume_scenes::load(&relume_scenes::resolve("knot-twist").unwrap()).unwrap().objects[0].clone()
    }

    /// Signed volume in a pose.
    fn volume(surface: &Simplified, pose: &Pose) -> f64 {
        let of = |(t, offsets): (&[u32; 3], &[f32; 3])| {
            let corner = |k: usize| {
                let v = t[k] as usize;
                (Vec3::from(pose.positions[v]) + offsets[k] * Vec3::from(pose.normals[v])).as_dvec3()
            };
            corner(0).dot(corner(1).cross(corner(2))) / 6.0
        };
        surface.triangles.iter().zip(&surface.offsets).map(of).sum()
    }

    #[test]
    fn a_knot_stays_closed_and_near_itself_in_all_poses() {
        let surface = Surface::new(&knot());
        let whole = surface.whole();
        assert!(surface.poses.len() == 6 && whole.closed && whole.triangles.len() == 6144);
        let mut last = f32::MAX;
        for count in [512, 1024, 2048] {
            let few = surface.simplified(count);
            assert!(few.closed && few.triangles.len().abs_diff(count) <= 8, "{}", few.triangles.len());
            for pose in &surface.poses {
                let share = volume(&few, pose) / volume(&whole, pose);
                assert!((share - 1.0).abs() < 0.15, "{count}: {share} of the volume");
            }
            let worst = few.errors.iter().copied().fold(0.0, f32::max);
            assert!(worst < last, "{count} triangles are off by {worst}, fewer by {last}");
            last = worst;
        }
        assert!(last < 0.03, "a tube of 0.11 m within {last}");
    }

    /// A strip of 32 quads that lies flat, and in its clip bends to an arch.
    fn strip() -> Object {
        let twisted = knot();
        let place = |v: usize| [(v / 2) as f32 / 16.0 - 1.0, 0.0, (v % 2) as f32 * 0.5];
        let positions: Vec<[f32; 3]> = (0..66).map(place).collect();
        let quad = |k: u32| [[2 * k, 2 * k + 1, 2 * k + 2], [2 * k + 2, 2 * k + 1, 2 * k + 3]];
        let mesh = Mesh {
            normals: vec![[0.0, 1.0, 0.0]; 66],
            triangles: (0..32).flat_map(quad).collect(),
            positions: positions.clone(),
            uvs: Vec::new(),
        };
        let bend = |p: &[f32; 3]| [0.0, 1.0 - p[0] * p[0], 0.0];
        let weight = Track {
            property: Property::MorphWeight(0),
            interpolation: Interpolation::Linear,
            times_s: vec![0.0, 1.0],
            values: vec![0.0, 1.0],
        };
        let rest = Transform::Fixed(DAffine3::IDENTITY);
        let shape = DeformingMesh {
            influences: vec![Influences::rigid(0); 66],
            joints: vec![Joint { node: 0, node_from_mesh: DAffine3::IDENTITY }],
            nodes: vec![Node { parent: None, rest }],
            morph_targets: vec![MorphTarget {
                rest_weight: 0.0,
                vertices: (0..66).collect(),
                deltas: positions.iter().map(bend).collect(),
            }],
            clips: vec![Clip { name: "Bend".to_owned(), duration_s: 1.0, tracks: vec![weight] }],
            positions,
        };
        Object { mesh: Arc::new(mesh), shape: Some(Arc::new(shape)), ..twisted }
    }

    #[test]
    fn what_is_flat_at_rest_and_bends_keeps_what_bends() {
        let bending = strip();
        let still = Object { shape: None, ..bending.clone() };
        let [bending, still] = [bending, still].map(|object| Surface::new(&object));
        assert!(still.flat().triangles.len() <= 4 && bending.flat().triangles.len() > 20);
        // In the pose that bends most, 0.8 of the way, an arch of 0.8 m in eight straight parts is within 8
        // mm.
        let few = bending.simplified(16);
        let worst = few.errors.iter().copied().fold(0.0, f32::max) / BESIDE;
        assert!(
            few.triangles.len() <= 16 && worst < 0.02,
            "{} triangles within {worst}",
            few.triangles.len()
        );
    }

    #[test]
    fn what_is_flat_needs_few() {
        let scene = relume_scenes::load(&relume_scenes::resolve("knot-twist").unwrap()).unwrap();
        let flat = Surface::new(&scene.objects[1]).flat();
        assert!(flat.triangles.len() <= 16 && !flat.closed, "{}", flat.triangles.len());
        assert!(flat.errors.iter().all(|error| *error < 1e-5), "{:?}", flat.errors);
    }
}
