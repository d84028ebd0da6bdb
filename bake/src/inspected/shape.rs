//! Shapes that deform: where they rest, and what their clips are.

use super::out::Out;
use super::words::{grouped, list, many};
use super::{Described, Facts, Inspected};
use relume_formats::Result;
use relume_formats::container::{Kind, Stored};
use relume_formats::shape::{Clip, DeformingMesh};
use serde::Serialize;
use serde_json::json;
use std::path::Path;

/// See there.
pub(super) const INSPECTED: Inspected = Inspected { kind: Kind::Shape, describe, export };

#[derive(Serialize)]
struct Details {
    vertices: usize,
    nodes: usize,
    joints: usize,
    morph_targets: usize,
    clips: Vec<ClipInfo>,
}

/// A clip of a shape.
#[derive(Serialize)]
struct ClipInfo {
    name: String,
    duration_s: f32,
    tracks: usize,
    keys: usize,
}

impl ClipInfo {
    fn of(clip: &Clip) -> Self {
        let keys = clip.tracks.iter().map(|track| track.times_s.len()).sum();
        Self { name: clip.name.clone(), duration_s: clip.duration_s, tracks: clip.tracks.len(), keys }
    }

    fn words(&self) -> String {
        format!(
            "{} ({} s, {}, {})",
            self.name,
            self.duration_s,
            many(self.tracks, "track", "tracks"),
            many(self.keys, "key", "keys")
        )
    }
}

fn describe(path: &Path) -> Result<Described> {
    let shape = DeformingMesh::read_file(path)?;
    let details = Details {
        vertices: shape.positions.len(),
        nodes: shape.nodes.len(),
        joints: shape.joints.len(),
        morph_targets: shape.morph_targets.len(),
        clips: shape.clips.iter().map(ClipInfo::of).collect(),
    };
    Ok(Described { facts: facts(&details), details: Box::new(details) })
}

fn facts(details: &Details) -> Facts {
    let moved_by = format!(
        "{}, moved by {} of {} and {}",
        grouped(details.vertices as u64),
        many(details.joints, "joint", "joints"),
        many(details.nodes, "node", "nodes"),
        many(details.morph_targets, "morph target", "morph targets")
    );
    vec![("vertices", moved_by), ("clips", list(details.clips.iter().map(ClipInfo::words)))]
}

/// `positions.npy` [vertices, 3]: at rest in world space, metres; `joint_indices.npy` and `joint_weights.npy`
/// [vertices, 4]; `shape.json`: how many joints and morph targets there are, and the clips.
fn export(path: &Path, out: &mut Out) -> Result<()> {
    let shape = DeformingMesh::read_file(path)?;
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
