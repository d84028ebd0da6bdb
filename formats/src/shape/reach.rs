//! How far the vertices of a mesh can get, whatever its clips do: a bound from the sizes of all factors. It
//! keeps products of long chains of nodes within numbers, and costs no more than reading the mesh.

use super::{Clip, DeformingMesh, Interpolation, MorphTarget, Node, Property, Track, Transform};
use crate::state::MAX_COORDINATE;
use glam::{DAffine3, DMat3, DVec3};

/// Farthest that the bound may be: squared lengths are still numbers in single precision. The bound adds up
/// what seldom points the same way, so it is far beyond [`MAX_COORDINATE`].
const MOST: f64 = MAX_COORDINATE as f64 * MAX_COORDINATE as f64;

/// How much a map can enlarge, and how far it moves the origin.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Growth {
    pub scale: f64,
    pub shift: f64,
}

impl Growth {
    fn of(map: &DAffine3) -> Self {
        Self { scale: norm(&map.matrix3), shift: map.translation.length() }
    }

    /// First `inner`, then this.
    fn after(self, inner: Self) -> Self {
        Self { scale: self.scale * inner.scale, shift: self.shift + self.scale * inner.shift }
    }

    /// Farthest that a point ends that was so far from the origin.
    fn reach(self, distance: f64) -> f64 {
        self.scale * distance + self.shift
    }
}

impl DeformingMesh {
    /// Fails if some vertex could get too far.
    pub(super) fn expect_reach(&self) -> Result<(), String> {
        let reach = self.reach();
        if reach <= MOST {
            return Ok(());
        }
        Err(format!(
            "its nodes, joints, morph targets and keys together may take vertices {reach:e} m away, {MOST:e} m are possible"
        ))
    }

    /// No vertex is farther from the origin in any pose.
    pub(super) fn reach(&self) -> f64 {
        let farthest = self.positions.iter().map(length).fold(0.0, f64::max);
        let moves = self
            .morph_targets
            .iter()
            .zip(self.largest_weights())
            .map(|(target, weight)| weight * largest_delta(target));
        let morphed = farthest + moves.sum::<f64>();
        let mut of_nodes: Vec<Growth> = Vec::with_capacity(self.nodes.len());
        let moved = self.growths();
        for (node, own) in self.nodes.iter().zip(moved) {
            let parent = node.parent.and_then(|parent| of_nodes.get(parent as usize));
            of_nodes.push(parent.map_or(own, |parent| parent.after(own)));
        }
        let of_joint =
            |node: u32| of_nodes.get(node as usize).copied().unwrap_or(Growth { scale: 1.0, shift: 0.0 });
        self.joints
            .iter()
            .map(|joint| of_joint(joint.node).after(Growth::of(&joint.node_from_mesh)).reach(morphed))
            .fold(0.0, f64::max)
    }

    fn tracks(&self) -> impl Iterator<Item = &Track> {
        self.clips.iter().flat_map(|clip: &Clip| &clip.tracks)
    }

    /// Of each node to its parent, at rest and in all clips.
    fn growths(&self) -> Vec<Growth> {
        let mut growths: Vec<Growth> = self.nodes.iter().map(of_rest).collect();
        for track in self.tracks() {
            let (node, of) = match track.property {
                Property::Translation(node) => (node, track.largest(length)),
                Property::Scale(node) => (node, track.largest(largest::<3>)),
                Property::Rotation(_) | Property::MorphWeight(_) => continue,
            };
            let Some(growth) = growths.get_mut(node as usize) else { continue };
            match track.property {
                Property::Translation(_) => growth.shift = growth.shift.max(of),
                _ => growth.scale = growth.scale.max(of),
            }
        }
        growths
    }

    /// Of each morph target, at rest and in all clips.
    fn largest_weights(&self) -> Vec<f64> {
        let mut weights: Vec<f64> =
            self.morph_targets.iter().map(|target| f64::from(target.rest_weight.abs())).collect();
        for track in self.tracks() {
            if let Property::MorphWeight(target) = track.property
                && let Some(weight) = weights.get_mut(target as usize)
            {
                *weight = weight.max(track.largest(largest::<1>));
            }
        }
        weights
    }
}

fn largest_delta(target: &MorphTarget) -> f64 {
    target.deltas.iter().map(length).fold(0.0, f64::max)
}

fn of_rest(node: &Node) -> Growth {
    match &node.rest {
        Transform::Parts { translation, scale, .. } => {
            Growth { scale: largest(scale), shift: length(translation) }
        }
        Transform::Fixed(map) => Growth::of(map),
    }
}

impl Track {
    /// Largest `size` of the property at any time. Between keys a cubic spline adds no more than 4/27 of each
    /// tangent times the time between.
    fn largest<const N: usize>(&self, size: fn(&[f32; N]) -> f64) -> f64 {
        let entries = self.values.as_chunks::<N>().0;
        let of = |first: usize, step: usize| {
            entries.iter().skip(first).step_by(step).map(size).fold(0.0, f64::max)
        };
        if self.interpolation != Interpolation::CubicSpline {
            return of(0, 1);
        }
        let longest =
            self.times_s.windows(2).map(|pair| f64::from(pair[1]) - f64::from(pair[0])).fold(0.0, f64::max);
        of(1, 3) + longest * 4.0 / 27.0 * (of(0, 3) + of(2, 3))
    }
}

fn length(vector: &[f32; 3]) -> f64 {
    DVec3::from_array(vector.map(f64::from)).length()
}

fn largest<const N: usize>(vector: &[f32; N]) -> f64 {
    vector.iter().fold(0.0, |most, x| f64::from(x.abs()).max(most))
}

/// How much a matrix can lengthen a vector: the root of the largest eigenvalue of mᵀm, in closed form (Smith
/// 1961).
pub(super) fn norm(m: &DMat3) -> f64 {
    let size = m.to_cols_array().iter().fold(0.0, |most: f64, x| most.max(x.abs()));
    if size == 0.0 || !size.is_finite() {
        return size;
    }
    let m = *m * (1.0 / size);
    let a = m.transpose() * m;
    let middle = (a.x_axis.x + a.y_axis.y + a.z_axis.z) / 3.0;
    let off = a - DMat3::from_diagonal(DVec3::splat(middle));
    let spread = (off.to_cols_array().iter().map(|x| x * x).sum::<f64>() / 6.0).sqrt();
    if spread == 0.0 {
        return size * middle.sqrt();
    }
    let angle = ((off * (1.0 / spread)).determinant() / 2.0).clamp(-1.0, 1.0).acos() / 3.0;
    size * (middle + 2.0 * spread * angle.cos()).sqrt()
}
