//! A shape that deforms: where it rests, and what its clips are.

use super::super::info::facts::ClipInfo;
use super::out::Out;
use relume_formats::Result;
use relume_formats::shape::DeformingMesh;
use serde_json::json;

/// `positions.npy` [vertices, 3]: at rest in world space, metres; `joint_indices.npy` and `joint_weights.npy` [vertices, 4]; `shape.json`: how many
/// joints and morph targets there are, and the clips.
pub(super) fn export(shape: &DeformingMesh, out: &mut Out) -> Result<()> {
    let mut positions = Vec::new();
    shape.positions(&shape.rest_pose(), &mut positions);
    let vertices = positions.len();
    out.npy("positions.npy", &[vertices, 3], positions.into_iter().flatten())?;
    out.npy("joint_indices.npy", &[vertices, 4], shape.influences.iter().flat_map(|i| i.joints))?;
    out.npy("joint_weights.npy", &[vertices, 4], shape.influences.iter().flat_map(|i| i.weights))?;
    out.json(
        "shape.json",
        &json!({
            "vertices": vertices,
            "joints": shape.joints.len(),
            "morph_targets": shape.morph_targets.len(),
            "clips": shape.clips.iter().map(ClipInfo::of).collect::<Vec<_>>(),
        }),
    )
}
