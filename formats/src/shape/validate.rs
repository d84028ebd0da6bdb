//! What a deforming mesh must hold before it is used.

use super::{
    Clip, DeformingMesh, Interpolation, Joint, MAX_CLIP_KEYS, MAX_CLIPS, MAX_JOINTS, MAX_MORPHED,
    MAX_VERTICES, MorphTarget, Node, Property, Track, Transform,
};
use crate::error::{Error, Place, Result};
use crate::kinds::names::fault_of_names;
use std::collections::HashSet;

/// How far the weights of a vertex may be from the sum 1, for rounding.
const WEIGHT_TOLERANCE: f32 = 1e-3;

impl DeformingMesh {
    /// Checks counts, indices and numbers; `place` is where the mesh comes from.
    pub fn validate(&self, place: &Place) -> Result<()> {
        match self.fault() {
            None => Ok(()),
            Some(fault) => Err(Error::invalid(place, format!("{fault}; mend the model or export it again"))),
        }
    }

    /// What is wrong with it, if anything is.
    pub(crate) fn fault(&self) -> Option<String> {
        let check = || -> std::result::Result<(), String> {
            self.expect_counts()?;
            self.expect_vertices()?;
            named("node", &self.nodes, |index, node| node.check(index))?;
            named("joint", &self.joints, |_, joint| joint.check(self.nodes.len()))?;
            named("morph target", &self.morph_targets, |_, target| target.check(self.positions.len()))?;
            self.expect_clips()?;
            self.expect_reach()
        };
        check().err()
    }

    fn expect_counts(&self) -> std::result::Result<(), String> {
        let morphed = self.morph_targets.iter().map(|target| target.vertices.len()).sum();
        let keys = self.clips.iter().flat_map(|clip| &clip.tracks).map(|track| track.times_s.len()).sum();
        let counts = [
            (self.positions.len(), MAX_VERTICES, "vertices"),
            (self.nodes.len(), MAX_JOINTS, "nodes"),
            (self.joints.len(), MAX_JOINTS, "joints"),
            (self.morph_targets.len(), MAX_JOINTS, "morph targets"),
            (morphed, MAX_MORPHED, "positions in morph targets"),
            (self.clips.len(), MAX_CLIPS, "clips"),
            (keys, MAX_CLIP_KEYS, "keys"),
        ];
        match counts.into_iter().find(|(count, most, _)| count > most) {
            Some((count, most, what)) => Err(format!("{count} {what}, at most {most} are allowed")),
            None => Ok(()),
        }
    }

    fn expect_vertices(&self) -> std::result::Result<(), String> {
        if self.influences.len() != self.positions.len() {
            return Err(format!(
                "{} vertices but joints and weights for {}",
                self.positions.len(),
                self.influences.len()
            ));
        }
        if let Some(vertex) = self.positions.iter().position(|p| !is_finite(p)) {
            return Err(format!("vertex {vertex} is not a finite position"));
        }
        named("vertex", &self.influences, |_, influences| {
            if !influences.weights.iter().all(|w| *w >= 0.0) {
                return Err(format!("weights {:?} must be at least 0", influences.weights));
            }
            let sum: f32 = influences.weights.iter().sum();
            let is_whole = (sum - 1.0).abs() <= WEIGHT_TOLERANCE;
            if !is_whole {
                return Err(format!("weights {:?} must have the sum 1", influences.weights));
            }
            expect_index("joint", influences.active().map(|(joint, _)| joint), self.joints.len())
        })
    }

    fn expect_clips(&self) -> std::result::Result<(), String> {
        if let Some(fault) = fault_of_names("clips", self.clips.iter().map(|clip| clip.name.as_str())) {
            return Err(fault);
        }
        for clip in &self.clips {
            clip.check(self).map_err(|reason| format!("clip `{}`: {reason}", clip.name))?;
        }
        Ok(())
    }
}

impl Node {
    fn check(&self, index: usize) -> std::result::Result<(), String> {
        if let Some(parent) = self.parent.filter(|parent| *parent as usize >= index) {
            return Err(format!("its parent {parent} does not come before it"));
        }
        match &self.rest {
            Transform::Parts { translation, rotation, scale }
                if is_finite(translation) && is_finite(scale) =>
            {
                expect_direction(rotation)
            }
            Transform::Fixed(map) if map.is_finite() => Ok(()),
            _ => Err("its transform is not finite".to_owned()),
        }
    }
}

impl Joint {
    fn check(&self, nodes: usize) -> std::result::Result<(), String> {
        if !self.node_from_mesh.is_finite() {
            return Err("its inverse bind matrix is not finite".to_owned());
        }
        expect_index("node", std::iter::once(self.node), nodes)
    }
}

impl MorphTarget {
    fn check(&self, vertices: usize) -> std::result::Result<(), String> {
        if self.vertices.len() != self.deltas.len() {
            return Err(format!("names {} vertices but moves {}", self.vertices.len(), self.deltas.len()));
        }
        if self.vertices.windows(2).any(|pair| pair[0] >= pair[1]) {
            return Err("the vertices that it moves must increase".to_owned());
        }
        if !self.rest_weight.is_finite() || !is_finite(self.deltas.as_flattened()) {
            return Err("its numbers must be finite".to_owned());
        }
        expect_index("vertex", self.vertices.iter().copied(), vertices)
    }
}

impl Clip {
    fn check(&self, mesh: &DeformingMesh) -> std::result::Result<(), String> {
        let last =
            self.tracks.iter().filter_map(|track| track.times_s.last()).fold(0.0, |a: f32, b| a.max(*b));
        if !(self.duration_s.is_finite() && self.duration_s >= last) {
            return Err(format!(
                "its duration {} s must be finite and reach its last key at {last} s",
                self.duration_s
            ));
        }
        let mut properties = HashSet::new();
        named("track", &self.tracks, |_, track| {
            if !properties.insert(track.property) {
                return Err(format!("{:?} has a track already", track.property));
            }
            track.expect_property(mesh)?;
            track.expect_keys()
        })
    }
}

impl Track {
    fn expect_property(&self, mesh: &DeformingMesh) -> std::result::Result<(), String> {
        match self.property {
            Property::MorphWeight(target) => {
                expect_index("morph target", std::iter::once(target), mesh.morph_targets.len())
            }
            Property::Translation(node) | Property::Rotation(node) | Property::Scale(node) => {
                match mesh.nodes.get(node as usize) {
                    None => expect_index("node", std::iter::once(node), mesh.nodes.len()),
                    Some(Node { rest: Transform::Fixed(_), .. }) => Err(format!(
                        "moves node {node}, which has a matrix, not translation, rotation and scale"
                    )),
                    Some(_) => Ok(()),
                }
            }
        }
    }

    fn expect_keys(&self) -> std::result::Result<(), String> {
        if self.times_s.is_empty() || !self.times_s.iter().all(|t| t.is_finite() && *t >= 0.0) {
            return Err("needs keys at finite times of at least 0".to_owned());
        }
        if self.times_s.windows(2).any(|pair| pair[0] >= pair[1]) {
            return Err("key times must increase".to_owned());
        }
        let per_key = self.property.components() * self.interpolation.values_per_key();
        if self.values.len() != per_key * self.times_s.len() {
            return Err(format!(
                "{} keys need {per_key} numbers each, there are {}",
                self.times_s.len(),
                self.values.len()
            ));
        }
        if !is_finite(&self.values) {
            return Err("values must be finite".to_owned());
        }
        match self.property {
            Property::Rotation(_) => self.rotations().try_for_each(expect_direction),
            _ => Ok(()),
        }
    }

    /// The values of the keys, without tangents, of a track of rotations.
    fn rotations(&self) -> impl Iterator<Item = &[f32; 4]> {
        let (step, first) = if self.interpolation == Interpolation::CubicSpline { (3, 1) } else { (1, 0) };
        self.values.as_chunks().0.iter().skip(first).step_by(step)
    }
}

/// Applies `check` to every item; a complaint names the item.
fn named<T>(
    what: &str,
    items: &[T],
    mut check: impl FnMut(usize, &T) -> std::result::Result<(), String>,
) -> std::result::Result<(), String> {
    let mut items = items.iter().enumerate();
    items.try_for_each(|(index, item)| {
        check(index, item).map_err(|reason| format!("{what} {index}: {reason}"))
    })
}

fn expect_index(
    what: &str,
    mut indices: impl Iterator<Item = u32>,
    count: usize,
) -> std::result::Result<(), String> {
    match indices.find(|index| *index as usize >= count) {
        Some(index) => Err(format!("names {what} {index} of {count}")),
        None => Ok(()),
    }
}

fn expect_direction(rotation: &[f32; 4]) -> std::result::Result<(), String> {
    if is_finite(rotation) && rotation.iter().any(|x| *x != 0.0) {
        return Ok(());
    }
    Err(format!("rotation {rotation:?} must be finite and not 0"))
}

fn is_finite(numbers: &[f32]) -> bool {
    numbers.iter().all(|x| x.is_finite())
}
