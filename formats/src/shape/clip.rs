//! Clips: keyframes of nodes and of morph weights (glTF 2.0, section 3.11 and appendix C).

use super::node::normalized;
use glam::DQuat;
use serde::{Deserialize, Serialize};

/// A named movement.
#[derive(Debug, Clone, PartialEq)]
pub struct Clip {
    /// Name, as a state's `clip` has it.
    pub name: String,
    /// Time of the last key, seconds; 0 for a clip of one pose.
    pub duration_s: f32,
    /// At most one for each property of a node and each morph target. What has none rests.
    pub tracks: Vec<Track>,
}

impl Clip {
    /// `time_s` within 0..duration, as a clip that repeats has it; 0 for a clip of one pose.
    pub fn looped(&self, time_s: f32) -> f32 {
        let within = f64::from(time_s).rem_euclid(f64::from(self.duration_s)) as f32;
        if within.is_finite() { within } else { 0.0 }
    }
}

/// The keys of one property. Before the first key and after the last its value is held.
#[derive(Debug, Clone, PartialEq)]
pub struct Track {
    /// What the track sets.
    pub property: Property,
    /// How it gets from key to key.
    pub interpolation: Interpolation,
    /// Key times, seconds, at least one, increasing.
    pub times_s: Vec<f32>,
    /// [`Property::components`] numbers per key; with [`Interpolation::CubicSpline`] three times as many: the
    /// tangent on arrival, per second, the value, the tangent on departure.
    pub values: Vec<f32>,
}

/// What a track sets.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum Property {
    /// Of the node of this index.
    Translation(u32),
    /// Of the node of this index, a quaternion x, y, z, w.
    Rotation(u32),
    /// Of the node of this index.
    Scale(u32),
    /// Of the morph target of this index.
    MorphWeight(u32),
}

impl Property {
    /// How many numbers it has.
    pub fn components(self) -> usize {
        match self {
            Self::Translation(_) | Self::Scale(_) => 3,
            Self::Rotation(_) => 4,
            Self::MorphWeight(_) => 1,
        }
    }
}

/// How a track gets from key to key.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Interpolation {
    /// Holds each key until the next.
    Step,
    /// Straight; rotations along the shorter great circle.
    Linear,
    /// Cubic Hermite splines.
    CubicSpline,
}

impl Interpolation {
    /// How many values of the property stand with each key.
    pub fn values_per_key(self) -> usize {
        if self == Self::CubicSpline { 3 } else { 1 }
    }
}

/// Two neighbouring keys and a time between them.
struct Between {
    before: usize,
    after: usize,
    /// How far from one to the other, 0..1.
    share: f64,
    /// From one to the other, seconds.
    span_s: f64,
}

impl Track {
    /// The property at `time_s` as numbers, [`Property::components`] of them; what lies beyond is 0.
    pub(super) fn sample(&self, time_s: f32) -> [f64; 4] {
        let between = self.between(time_s);
        let rotation = matches!(self.property, Property::Rotation(_));
        match self.interpolation {
            Interpolation::Step => self.key(between.before),
            Interpolation::Linear if rotation => {
                let [from, to] =
                    [between.before, between.after].map(|key| normalized(DQuat::from_array(self.key(key))));
                slerp(from, to, between.share).to_array()
            }
            Interpolation::Linear => {
                let (from, to) = (self.key(between.before), self.key(between.after));
                std::array::from_fn(|k| from[k] + (to[k] - from[k]) * between.share)
            }
            Interpolation::CubicSpline => self.spline(&between),
        }
    }

    /// The value of a key.
    fn key(&self, key: usize) -> [f64; 4] {
        match self.interpolation {
            Interpolation::CubicSpline => self.entry(3 * key + 1),
            _ => self.entry(key),
        }
    }

    /// Cubic Hermite: glTF 2.0, appendix C.5. A spline of quaternions has no unit length, its user sees to
    /// that.
    fn spline(&self, between: &Between) -> [f64; 4] {
        let s = between.share;
        let (departure, arrival) = (self.entry(3 * between.before + 2), self.entry(3 * between.after));
        let (from, to) = (self.key(between.before), self.key(between.after));
        std::array::from_fn(|k| {
            (1.0 + 2.0 * s) * (1.0 - s).powi(2) * from[k]
                + between.span_s * s * (1.0 - s).powi(2) * departure[k]
                + s.powi(2) * (3.0 - 2.0 * s) * to[k]
                + between.span_s * s.powi(2) * (s - 1.0) * arrival[k]
        })
    }

    fn entry(&self, entry: usize) -> [f64; 4] {
        let components = self.property.components();
        let numbers = self.values.get(components * entry..components * (entry + 1)).unwrap_or_default();
        std::array::from_fn(|k| numbers.get(k).map_or(0.0, |x| f64::from(*x)))
    }

    fn between(&self, time_s: f32) -> Between {
        let after = self.times_s.partition_point(|t| *t <= time_s);
        let before = after.saturating_sub(1);
        match (self.times_s.get(before), self.times_s.get(after)) {
            (Some(from), Some(to)) if before < after => {
                let span_s = f64::from(*to) - f64::from(*from);
                Between { before, after, share: (f64::from(time_s) - f64::from(*from)) / span_s, span_s }
            }
            _ => Between { before, after: before, share: 0.0, span_s: 0.0 },
        }
    }
}

/// Along the shorter great circle at even speed. glam's own takes a polynomial for the arc cosine, which
/// double precision need not put up with.
fn slerp(from: DQuat, to: DQuat, share: f64) -> DQuat {
    let to = if from.dot(to) < 0.0 { -to } else { to };
    let angle = 2.0 * (to - from).length().atan2((to + from).length());
    if angle < 1e-9 {
        return normalized(from * (1.0 - share) + to * share);
    }
    normalized(from * (angle * (1.0 - share)).sin() + to * (angle * share).sin())
}
