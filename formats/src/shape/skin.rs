//! What moves vertices: morph targets, then joints.

use glam::{DAffine3, DMat3, DVec3};

/// A node that vertices follow, and where the mesh was when it was bound to it.
#[derive(Debug, Clone, PartialEq)]
pub struct Joint {
    /// Index of the node.
    pub node: u32,
    /// The inverse bind matrix: maps [`DeformingMesh::positions`](super::DeformingMesh::positions) into the
    /// node's space. The identity for a mesh that lies in the node itself.
    pub node_from_mesh: DAffine3,
}

/// The joints that a vertex follows.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Influences {
    /// Indices of joints; only those with a weight count.
    pub joints: [u32; 4],
    /// Shares of the joints: at least 0, with the sum 1.
    pub weights: [f32; 4],
}

impl Influences {
    /// All of one joint.
    pub fn rigid(joint: u32) -> Self {
        Self { joints: [joint, 0, 0, 0], weights: [1.0, 0.0, 0.0, 0.0] }
    }

    /// The joints with a weight, each with it.
    pub fn active(&self) -> impl Iterator<Item = (u32, f32)> {
        self.joints.into_iter().zip(self.weights).filter(|(_, weight)| *weight != 0.0)
    }

    /// The mean of the joints' maps, `world_from_mesh`, by weight. Joints beyond its end count as nothing.
    pub fn blend(&self, world_from_mesh: &[DAffine3]) -> DAffine3 {
        let nothing = DAffine3 { matrix3: DMat3::ZERO, translation: DVec3::ZERO };
        let maps = self
            .active()
            .filter_map(|(joint, weight)| Some((world_from_mesh.get(joint as usize)?, f64::from(weight))));
        maps.fold(nothing, |sum, (map, weight)| DAffine3 {
            matrix3: sum.matrix3 + map.matrix3 * weight,
            translation: sum.translation + map.translation * weight,
        })
    }
}

/// What is added to the positions of some vertices, times a weight.
#[derive(Debug, Clone, PartialEq)]
pub struct MorphTarget {
    /// The weight unless a clip sets it; any number.
    pub rest_weight: f32,
    /// Indices of the vertices that it moves, increasing.
    pub vertices: Vec<u32>,
    /// How far it moves each of them, one per vertex in `vertices`.
    pub deltas: Vec<[f32; 3]>,
}

impl MorphTarget {
    /// Adds `weight` times the target to `positions`.
    pub fn add_to(&self, positions: &mut [[f32; 3]], weight: f32) {
        if weight == 0.0 {
            return;
        }
        for (vertex, delta) in self.vertices.iter().zip(&self.deltas) {
            if let Some(position) = positions.get_mut(*vertex as usize) {
                *position = morphed(*position, *delta, weight);
            }
        }
    }
}

/// A position moved by `weight` times `delta`, or any other vector.
pub fn morphed(position: [f32; 3], delta: [f32; 3], weight: f32) -> [f32; 3] {
    std::array::from_fn(|axis| position[axis] + weight * delta[axis])
}
