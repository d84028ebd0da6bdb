//! Shapes that deform: a mesh, what moves its vertices, and clips that say how. After glTF 2.0 (sections
//! 3.7.2.2, 3.7.3 and 3.11), which has the same nodes, skins, morph targets and animations.
//!
//! Every vertex follows up to four [`Joint`]s. A mesh without a skin follows its own node alone, so that
//! there is one rule for all: morph first, then blend the joints' maps (linear blend skinning), then apply
//! the blend.

mod clip;
mod node;
mod normals;
mod pose;
mod reach;
mod rims;
mod skin;
mod validate;

pub use clip::{Clip, Interpolation, Property, Track};
pub use node::{Node, Transform};
pub use normals::{ShadingNormals, Surrounded};
pub use pose::Pose;
pub use rims::Rims;
pub use skin::{Influences, Joint, MorphTarget, morphed};

/// A mesh that deforms. [`DeformingMesh::validate`] says what the fields must hold; nothing here panics on
/// what it has accepted.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct DeformingMesh {
    /// Vertices before they are morphed and skinned, each in the space that its joints map from.
    pub positions: Vec<[f32; 3]>,
    /// What moves each vertex, one per vertex.
    pub influences: Vec<Influences>,
    /// What vertices follow.
    pub joints: Vec<Joint>,
    /// A forest, parents before their children.
    pub nodes: Vec<Node>,
    /// What may be added to the positions.
    pub morph_targets: Vec<MorphTarget>,
    /// Movements, each with a name of its own.
    pub clips: Vec<Clip>,
}

/// Largest number of vertices.
pub const MAX_VERTICES: usize = 1 << 26;
/// Largest number of positions in all morph targets together.
pub const MAX_MORPHED: usize = 1 << 24;
/// Largest number of nodes, of joints, and of morph targets.
pub const MAX_JOINTS: usize = 1 << 16;
/// Largest number of clips.
pub const MAX_CLIPS: usize = 1 << 12;
/// Largest number of keys in all tracks of all clips together.
pub const MAX_CLIP_KEYS: usize = 1 << 22;

#[cfg(test)]
mod clip_tests;

#[cfg(test)]
mod normals_tests;

#[cfg(test)]
mod pose_tests;

#[cfg(test)]
mod reach_tests;

#[cfg(test)]
mod validate_tests;
