//! The small parts of a shape as records: nodes, joints, and clips without their keys.

use crate::error::{Error, Place, Result};
use crate::shape::{Clip, Interpolation, Joint, Node, Property, Track, Transform};
use glam::DAffine3;
use serde::{Deserialize, Serialize};

/// The columns of an affine map, the translation last.
type Map = [f64; 12];

#[derive(Serialize, Deserialize)]
pub(super) struct NodeRecord {
    parent: Option<u32>,
    rest: RestRecord,
}

#[derive(Serialize, Deserialize)]
enum RestRecord {
    Parts { translation: [f32; 3], rotation: [f32; 4], scale: [f32; 3] },
    Fixed(Map),
}

#[derive(Serialize, Deserialize)]
pub(super) struct JointRecord {
    node: u32,
    node_from_mesh: Map,
}

#[derive(Serialize, Deserialize)]
pub(super) struct ClipRecord {
    name: String,
    duration_s: f32,
    tracks: Vec<TrackRecord>,
}

#[derive(Serialize, Deserialize)]
struct TrackRecord {
    property: Property,
    interpolation: Interpolation,
    keys: u32,
}

impl NodeRecord {
    pub fn of(node: &Node) -> Self {
        let rest = match &node.rest {
            Transform::Parts { translation, rotation, scale } => {
                RestRecord::Parts { translation: *translation, rotation: *rotation, scale: *scale }
            }
            Transform::Fixed(map) => RestRecord::Fixed(map.to_cols_array()),
        };
        Self { parent: node.parent, rest }
    }

    pub fn node(self) -> Node {
        let rest = match self.rest {
            RestRecord::Parts { translation, rotation, scale } => {
                Transform::Parts { translation, rotation, scale }
            }
            RestRecord::Fixed(map) => Transform::Fixed(DAffine3::from_cols_array(&map)),
        };
        Node { parent: self.parent, rest }
    }
}

impl JointRecord {
    pub fn of(joint: &Joint) -> Self {
        Self { node: joint.node, node_from_mesh: joint.node_from_mesh.to_cols_array() }
    }

    pub fn joint(self) -> Joint {
        Joint { node: self.node, node_from_mesh: DAffine3::from_cols_array(&self.node_from_mesh) }
    }
}

impl ClipRecord {
    pub fn of(clip: &Clip) -> Self {
        let track = |track: &Track| TrackRecord {
            property: track.property,
            interpolation: track.interpolation,
            keys: track.times_s.len() as u32,
        };
        Self {
            name: clip.name.clone(),
            duration_s: clip.duration_s,
            tracks: clip.tracks.iter().map(track).collect(),
        }
    }
}

/// The clips, with the keys that stand together in `times_s` and `values`.
///
/// # Errors
/// `Invalid` if the tracks do not use all keys, or more.
pub(super) fn clips(
    records: Vec<ClipRecord>,
    times_s: &[f32],
    values: &[f32],
    place: &Place,
) -> Result<Vec<Clip>> {
    let mut keys = Keys { times_s, values };
    let clips: Option<Vec<Clip>> = records.into_iter().map(|record| keys.clip(record)).collect();
    clips.filter(|_| keys.times_s.is_empty() && keys.values.is_empty()).ok_or_else(|| {
        Error::invalid(
            &place.part("section `clips`"),
            "does not fit the keys; the file is damaged, bake it again",
        )
    })
}

/// What no track has taken yet.
struct Keys<'a> {
    times_s: &'a [f32],
    values: &'a [f32],
}

impl Keys<'_> {
    fn clip(&mut self, record: ClipRecord) -> Option<Clip> {
        let tracks = record.tracks.into_iter().map(|track| self.track(&track)).collect::<Option<_>>()?;
        Some(Clip { name: record.name, duration_s: record.duration_s, tracks })
    }

    fn track(&mut self, record: &TrackRecord) -> Option<Track> {
        let (keys, per_key) =
            (record.keys as usize, record.interpolation.values_per_key() * record.property.components());
        let times_s = self.times_s.split_off(..keys)?.to_vec();
        let values = self.values.split_off(..keys.checked_mul(per_key)?)?.to_vec();
        Some(Track { property: record.property, interpolation: record.interpolation, times_s, values })
    }
}
