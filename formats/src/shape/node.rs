//! Nodes: a hierarchy of frames.

use glam::{DAffine3, DQuat, DVec3, Quat, Vec3};

/// A frame within that of its parent.
#[derive(Debug, Clone, PartialEq)]
pub struct Node {
    /// Index of the parent, smaller than the node's own; none if the parent is the world.
    pub parent: Option<u32>,
    /// Where the node is unless a clip moves it.
    pub rest: Transform,
}

/// A map from a node to its parent.
#[derive(Debug, Clone, PartialEq)]
pub enum Transform {
    /// Scaled first, then turned, then moved. Clips set these one by one.
    Parts {
        /// Metres, if nothing above scales.
        translation: [f32; 3],
        /// A quaternion x, y, z, w of any length but 0.
        rotation: [f32; 4],
        /// Factors along the node's axes.
        scale: [f32; 3],
    },
    /// Any affine map, which no clip can move.
    Fixed(DAffine3),
}

impl Transform {
    /// The map from the node to its parent. A rotation of length 0 is none.
    pub fn parent_from_node(&self) -> DAffine3 {
        match self {
            Self::Parts { translation, rotation, scale } => {
                Parts::new(*translation, *rotation, *scale).parent_from_node()
            }
            Self::Fixed(parent_from_node) => *parent_from_node,
        }
    }
}

/// The unit quaternion along `quaternion`, or the identity if it has no direction.
pub(super) fn normalized(quaternion: DQuat) -> DQuat {
    let length = quaternion.length();
    if length > 0.0 && length.is_finite() { quaternion / length } else { DQuat::IDENTITY }
}

/// The map from each node to the world; `parent_from_node` is one per node.
pub(super) fn world_from_nodes(
    nodes: &[Node],
    parent_from_node: impl Iterator<Item = DAffine3>,
) -> Vec<DAffine3> {
    let mut world_from_node: Vec<DAffine3> = Vec::with_capacity(nodes.len());
    for (node, parent_from_node) in nodes.iter().zip(parent_from_node) {
        let parent = node.parent.and_then(|parent| world_from_node.get(parent as usize));
        world_from_node
            .push(parent.map_or(parent_from_node, |world_from_parent| *world_from_parent * parent_from_node));
    }
    world_from_node
}

/// A node's frame in parts, while a clip moves them; double precision, as every factor of a long chain of
/// nodes counts.
#[derive(Clone, Copy)]
pub(super) struct Parts {
    pub translation: DVec3,
    pub rotation: DQuat,
    pub scale: DVec3,
}

impl Parts {
    /// Files round quaternions to f32 and not quite to unit length.
    pub fn new(translation: [f32; 3], rotation: [f32; 4], scale: [f32; 3]) -> Self {
        let [translation, scale] = [translation, scale].map(|v| Vec3::from(v).as_dvec3());
        Self { translation, rotation: normalized(Quat::from_array(rotation).as_dquat()), scale }
    }

    pub fn parent_from_node(&self) -> DAffine3 {
        DAffine3::from_scale_rotation_translation(self.scale, self.rotation, self.translation)
    }
}
