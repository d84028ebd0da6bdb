//! Poses: where joints and morph weights are at rest or at a time of a clip, and where that leaves the
//! vertices.

use super::node::{Parts, normalized, world_from_nodes};
use super::{Clip, DeformingMesh, Node, Property, Transform};
use crate::state::Posed;
use glam::{DAffine3, DQuat, DVec3, Vec3};

/// What decides where all vertices are.
#[derive(Debug, Clone, PartialEq)]
pub struct Pose {
    /// For each joint the map from [`DeformingMesh::positions`], morphed, to the world.
    pub world_from_mesh: Vec<DAffine3>,
    /// One per morph target.
    pub morph_weights: Vec<f32>,
}

impl DeformingMesh {
    /// Every node and weight as it is without a clip.
    pub fn rest_pose(&self) -> Pose {
        self.pose(self.nodes.iter().map(|node| node.rest.parent_from_node()), self.rest_weights())
    }

    /// The pose of `clip` at `time_s`. Before its start and after its end it holds; repeating it is up to the
    /// caller.
    pub fn pose_at(&self, clip: &Clip, time_s: f32) -> Pose {
        let mut parts: Vec<Option<Parts>> = self.nodes.iter().map(parts_of).collect();
        let mut weights = self.rest_weights();
        for track in &clip.tracks {
            let value = track.sample(time_s);
            match track.property {
                Property::MorphWeight(target) => {
                    weights.get_mut(target as usize).into_iter().for_each(|w| *w = value[0] as f32)
                }
                Property::Translation(node) | Property::Rotation(node) | Property::Scale(node) => {
                    if let Some(Some(parts)) = parts.get_mut(node as usize) {
                        set(parts, track.property, value);
                    }
                }
            }
        }
        let locals = self.nodes.iter().zip(&parts);
        self.pose(
            locals.map(|(node, parts)| {
                parts.map_or_else(|| node.rest.parent_from_node(), |p| p.parent_from_node())
            }),
            weights,
        )
    }

    /// The pose that a state asks for, its clip repeated; at rest if it asks for none, or for a clip that is
    /// not there.
    pub fn pose_of(&self, posed: Option<&Posed>) -> Pose {
        let clip = posed
            .and_then(|posed| Some((self.clips.iter().find(|clip| clip.name == posed.clip)?, posed.time_s)));
        clip.map_or_else(|| self.rest_pose(), |(clip, time_s)| self.pose_at(clip, clip.looped(time_s)))
    }

    /// Writes the position of every vertex in `pose`, in world space, over `out`.
    pub fn positions(&self, pose: &Pose, out: &mut Vec<[f32; 3]>) {
        out.clear();
        out.extend_from_slice(&self.positions);
        for (target, weight) in self.morph_targets.iter().zip(&pose.morph_weights) {
            target.add_to(out, *weight);
        }
        for (position, influences) in out.iter_mut().zip(&self.influences) {
            *position = place(&influences.blend(&pose.world_from_mesh), *position);
        }
    }

    /// [`DeformingMesh::positions`] in the pose of `clip` at `time_s`.
    pub fn positions_at(&self, clip: &Clip, time_s: f32, out: &mut Vec<[f32; 3]>) {
        self.positions(&self.pose_at(clip, time_s), out);
    }

    fn pose(&self, parent_from_node: impl Iterator<Item = DAffine3>, morph_weights: Vec<f32>) -> Pose {
        let world_from_node = world_from_nodes(&self.nodes, parent_from_node);
        let world_from = |node: u32| world_from_node.get(node as usize).copied().unwrap_or_default();
        let world_from_mesh =
            self.joints.iter().map(|joint| world_from(joint.node) * joint.node_from_mesh).collect();
        Pose { world_from_mesh, morph_weights }
    }

    fn rest_weights(&self) -> Vec<f32> {
        self.morph_targets.iter().map(|target| target.rest_weight).collect()
    }
}

/// None for a node that no clip can move.
fn parts_of(node: &Node) -> Option<Parts> {
    match &node.rest {
        Transform::Parts { translation, rotation, scale } => {
            Some(Parts::new(*translation, *rotation, *scale))
        }
        Transform::Fixed(_) => None,
    }
}

/// Sets one of `parts`; a morph weight is none of them.
fn set(parts: &mut Parts, property: Property, value: [f64; 4]) {
    let vector = DVec3::new(value[0], value[1], value[2]);
    match property {
        Property::Translation(_) => parts.translation = vector,
        Property::Rotation(_) => parts.rotation = normalized(DQuat::from_array(value)),
        Property::Scale(_) => parts.scale = vector,
        Property::MorphWeight(_) => {}
    }
}

/// Rounds once, after all that is done in double precision. Adding 0 turns −0 into +0, so that equal
/// positions have equal bits.
fn place(world_from_mesh: &DAffine3, position: [f32; 3]) -> [f32; 3] {
    (world_from_mesh.transform_point3(Vec3::from(position).as_dvec3()).as_vec3() + 0.0).to_array()
}
