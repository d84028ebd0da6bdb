//! Which points of a mesh each sphere covers, so that spheres can follow the mesh when it deforms.
//!
//! A sphere that holds the corners of a piece of a triangle holds the piece, wherever the triangle goes. So
//! every sphere keeps the corners of all its pieces, and what covers a mesh at rest covers it in every pose.
//! A corner where spheres meet belongs to several.

use super::ball::Ball;
use super::pieces::Pieces;
use super::solid::Solid;
use super::sphere::Sphere;
use relume_scenes::Mesh;
use std::collections::HashMap;

/// Points with what they are made of and the sphere that each belongs to; the mesh's vertices first, in their
/// order.
#[derive(Debug, Default)]
pub struct Members {
    /// At rest.
    pub points: Vec<[f32; 3]>,
    /// Vertices of the mesh.
    pub vertices: Vec<[u32; 3]>,
    /// Their weights.
    pub weights: Vec<[f32; 3]>,
    /// Indices of spheres.
    pub spheres: Vec<u32>,
}

/// The members of `spheres`, which stand as `balls`.
pub fn members(
    mesh: &Mesh,
    solid: &Solid,
    pieces: &Pieces<'_>,
    spheres: &[Sphere],
    balls: &[Ball],
) -> Members {
    // For each vertex of the welded mesh, the sphere in which it lies deepest.
    let mut owners: HashMap<u32, (f64, u32)> = HashMap::new();
    let mut held = Vec::new();
    for (index, (sphere, ball)) in (0_u32..).zip(spheres.iter().zip(balls)) {
        let mut corners: Vec<u32> = sphere.cluster.iter().flat_map(|p| pieces.corners(*p)).copied().collect();
        corners.sort_unstable();
        corners.dedup();
        for corner in corners {
            held.push((corner, index));
            let depth = pieces.point(corner).distance(ball.centre) / ball.radius;
            let owner = owners.entry(corner).or_insert((depth, index));
            if depth < owner.0 {
                *owner = (depth, index);
            }
        }
    }
    let mut members = Members::default();
    for (vertex, welded) in (0_u32..).zip(&solid.welded) {
        let sphere = owners.get(welded).map_or(0, |owner| owner.1);
        members.push(mesh, [vertex; 3], [1.0, 0.0, 0.0], sphere);
    }
    for (corner, sphere) in held {
        let Some(anchor) = pieces.anchor(corner) else { continue };
        let is_vertex = anchor.vertices[0] == anchor.vertices[1];
        let listed = is_vertex && owners.get(&corner).is_some_and(|owner| owner.1 == sphere);
        let vertices = anchor.vertices.map(|v| solid.mesh_vertex.get(v as usize).copied());
        if let ([Some(a), Some(b), Some(c)], false) = (vertices, listed) {
            members.push(mesh, [a, b, c], anchor.weights, sphere);
        }
    }
    members
}

impl Members {
    fn push(&mut self, mesh: &Mesh, vertices: [u32; 3], weights: [f64; 3], sphere: u32) {
        let position = |axis: usize| {
            let parts =
                vertices.iter().zip(weights).map(|(v, w)| w * f64::from(mesh.positions[*v as usize][axis]));
            parts.sum::<f64>() as f32
        };
        self.points.push([0, 1, 2].map(position));
        self.vertices.push(vertices);
        self.weights.push(weights.map(|w| w as f32));
        self.spheres.push(sphere);
    }
}
