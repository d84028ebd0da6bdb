//! What spheres come to when their mesh moves.
//!
//! A sphere that keeps a piece of a leg and one of the belly fits well at rest and swells when the leg
//! swings. So where a mesh moves, the search looks at some of its poses too: what it lowers is the mean
//! volume outside over rest and poses, each sphere as small in a pose as covers its pieces there.

use super::ball::Ball;
use super::pieces::{Anchor, Pieces};
use super::solid::Solid;
use super::sphere::Sphere;
use super::triangle_tree::TriangleTree;
use glam::{DVec3, Vec3};
use relume_formats::evaluate::sphere_set::pulled_centre;
use relume_formats::kinds::sphere_set::Solid as SolidKind;
use relume_formats::shape::{Clip, DeformingMesh};

/// Poses of each clip that are looked at, and of all clips together at most.
const POSES: (u32, usize) = (5, 20);

/// Where the vertices of a mesh are in poses spread over its clips; none if nothing moves it.
pub fn poses(shape: &DeformingMesh) -> Vec<Vec<[f32; 3]>> {
    let times = |clip: &'_ Clip| {
        (0..POSES.0).map(|k| clip.duration_s * k as f32 / POSES.0 as f32).collect::<Vec<f32>>()
    };
    let all: Vec<(&Clip, f32)> =
        shape.clips.iter().flat_map(|clip| times(clip).into_iter().map(move |time| (clip, time))).collect();
    let pose = |(clip, time_s): &(&Clip, f32)| {
        let mut positions = Vec::new();
        shape.positions_at(clip, *time_s, &mut positions);
        positions
    };
    all.iter().step_by(all.len().div_ceil(POSES.1).max(1)).map(pose).collect()
}

/// The solid in some poses.
#[derive(Debug, Default)]
pub struct Motion {
    /// Its boundary, one for each pose; vertices as in the boundary at rest.
    poses: Vec<TriangleTree>,
}

impl Motion {
    /// `poses` are the places of the mesh's vertices. A solid that is not bounded by the mesh itself cannot
    /// be moved with it: then there are none.
    pub fn new(solid: &Solid, poses: &[Vec<[f32; 3]>]) -> Self {
        let boundary = &solid.boundary;
        let moved = |pose: &Vec<[f32; 3]>| {
            let place = |v: &u32| pose.get(*v as usize).map(|p| Vec3::from(*p).as_dvec3());
            let vertices: Option<Vec<DVec3>> = solid.mesh_vertex.iter().map(place).collect();
            vertices
                .filter(|v| v.len() == boundary.vertices.len())
                .map(|v| TriangleTree::new(v, boundary.triangles.clone()))
        };
        let own = solid.kind == SolidKind::Closed;
        Self { poses: poses.iter().filter(|_| own).filter_map(moved).collect() }
    }

    /// Number of poses besides rest.
    pub fn poses(&self) -> usize {
        self.poses.len()
    }

    /// The mean volume outside of `sphere` over rest and all poses.
    pub fn mean_outside(&self, sphere: &Sphere, pieces: &Pieces<'_>) -> f64 {
        let mut corners: Vec<u32> = sphere.cluster.iter().flat_map(|p| pieces.corners(*p)).copied().collect();
        corners.sort_unstable();
        corners.dedup();
        let anchors: Vec<Anchor> = corners.into_iter().filter_map(|c| pieces.anchor(c)).collect();
        let in_poses: f64 = self.poses.iter().map(|pose| outside(pose, &anchors)).sum();
        (sphere.outside.volume + in_poses) / (1 + self.poses.len()) as f64
    }
}

/// What the smallest ball around some points of a solid has outside it.
fn outside(solid: &TriangleTree, points: &[Anchor]) -> f64 {
    let place =
        |a: &Anchor| a.vertices.iter().zip(a.weights).map(|(v, w)| solid.vertices[*v as usize] * w).sum();
    let points: Vec<DVec3> = points.iter().map(place).collect();
    let Some(first) = points.first() else { return 0.0 };
    let centre = pulled_centre(&points, DVec3::ZERO, 1.0, *first);
    let radius = points.iter().map(|p| p.distance_squared(centre)).fold(0.0, f64::max).sqrt();
    Ball::new(centre, radius).outside(solid).volume
}
