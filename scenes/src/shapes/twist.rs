//! The twist: a procedural shape turned about its axis, more the higher, there and back within the clip
//! `Twist`.
//!
//! A point at height h turns about +Y by angle·(h − middle)/height·(1 − cos 2πt/T)/2. [`JOINTS`] joints stand
//! along the axis, evenly from the lowest vertex to the highest, and each vertex follows its two neighbours
//! by linear weights. Two neighbours never differ by more than Δ = angle/32, so blending misses the true
//! place of a point at distance ρ from the axis by at most ρΔ²/8, and pulls it in by at most as much: 0.05 %
//! of ρ at 120°, 0.5 % at 360°. Keys are [`STEPS`] to a clip, linear between them, which turns the ends by at
//! most angle/2·2π²/(8·STEPS²) too little or too much: 0.04° at 120°.

use glam::{DAffine3, DQuat};
use relume_formats::shape::{
    Clip, DeformingMesh, Influences, Interpolation, Joint, Node, Property, Track, Transform,
};
use relume_formats::{Error, Place, Result};
use std::f64::consts::TAU;

/// Along the axis.
const JOINTS: u32 = 33;
/// From one key to the next, over the whole clip.
const STEPS: u32 = 64;
/// Largest angle from bottom to top, degrees.
const MAX_TWIST_DEG: f64 = 360.0;
/// Shortest clip, seconds: nobody sees a shorter one, and its keys must differ in single precision.
const MIN_TWIST_S: f64 = 1e-3;
/// Longest clip, seconds: a day.
const MAX_TWIST_S: f64 = 86_400.0;
/// Weights are multiples of this, so that two that sum to 1 do so exactly.
const WEIGHT_STEP: f64 = 1.0 / (1 << 20) as f64;

/// How far and how fast.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Twist {
    /// From the lowest vertex to the highest at the height of the clip, radians; counter-clockwise seen from
    /// +Y.
    angle: f64,
    /// Seconds there and back.
    duration_s: f64,
}

impl Twist {
    /// What an object's `twist_deg` and `twist_s` ask for; none if neither is given.
    pub fn from_keys(twist_deg: Option<f64>, twist_s: Option<f64>, place: &Place) -> Result<Option<Self>> {
        match (twist_deg, twist_s) {
            (None, None) => Ok(None),
            (Some(degrees), _) if degrees == 0.0 || !(-MAX_TWIST_DEG..=MAX_TWIST_DEG).contains(&degrees) => {
                Err(Error::invalid(
                    place,
                    format!("twist_deg {degrees} must be within {MAX_TWIST_DEG} either way, and not 0"),
                ))
            }
            (_, Some(seconds)) if !(MIN_TWIST_S..=MAX_TWIST_S).contains(&seconds) => Err(Error::invalid(
                place,
                format!("twist_s {seconds:e} must be at least {MIN_TWIST_S} s and at most a day"),
            )),
            (Some(degrees), Some(duration_s)) => Ok(Some(Self { angle: degrees.to_radians(), duration_s })),
            _ => Err(Error::invalid(place, "give both `twist_deg` and `twist_s`, or neither")),
        }
    }

    /// The shape with vertices at `positions`, in its own space, that twists so.
    ///
    /// # Errors
    /// `Invalid` if it has no height.
    pub fn apply(
        &self,
        positions: Vec<[f32; 3]>,
        world_from_local: &DAffine3,
        place: &Place,
    ) -> Result<DeformingMesh> {
        let heights = || positions.iter().map(|p| f64::from(p[1]));
        let (low, high) =
            heights().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), y| (low.min(y), high.max(y)));
        let is_flat = high <= low;
        if is_flat {
            return Err(Error::invalid(
                place,
                "has no height to twist along; remove twist_deg and twist_s, or take another shape",
            ));
        }
        let joint = |node| Joint { node, node_from_mesh: DAffine3::IDENTITY };
        let rest =
            || Transform::Parts { translation: [0.0; 3], rotation: [0.0, 0.0, 0.0, 1.0], scale: [1.0; 3] };
        let root = Node { parent: None, rest: Transform::Fixed(*world_from_local) };
        Ok(DeformingMesh {
            influences: heights().map(|y| influences((y - low) / (high - low))).collect(),
            joints: (1..=JOINTS).map(joint).collect(),
            nodes: std::iter::once(root)
                .chain((0..JOINTS).map(|_| Node { parent: Some(0), rest: rest() }))
                .collect(),
            morph_targets: Vec::new(),
            clips: vec![self.clip()],
            positions,
        })
    }

    fn clip(&self) -> Clip {
        let duration_s = self.duration_s as f32;
        let track = |joint: u32| {
            let share = f64::from(joint) / f64::from(JOINTS - 1) - 0.5;
            let rotation =
                |step| DQuat::from_rotation_y(self.angle * share * wave(f64::from(step) / f64::from(STEPS)));
            Track {
                property: Property::Rotation(joint + 1),
                interpolation: Interpolation::Linear,
                times_s: (0..=STEPS)
                    .map(|step| (self.duration_s * f64::from(step) / f64::from(STEPS)) as f32)
                    .collect(),
                values: (0..=STEPS).flat_map(|step| rotation(step).as_quat().to_array()).collect(),
            }
        };
        Clip { name: "Twist".to_owned(), duration_s, tracks: (0..JOINTS).map(track).collect() }
    }
}

/// The two joints beside a vertex, `share` of the height up.
fn influences(share: f64) -> Influences {
    let place = share * f64::from(JOINTS - 1);
    let below = place.floor().min(f64::from(JOINTS - 2));
    let upper = ((place - below) / WEIGHT_STEP).round() * WEIGHT_STEP;
    let below = below as u32;
    Influences { joints: [below, below + 1, 0, 0], weights: [(1.0 - upper) as f32, upper as f32, 0.0, 0.0] }
}

/// From 0 to 1 and back, smoothly, also where it begins again.
fn wave(share: f64) -> f64 {
    (1.0 - (TAU * share).cos()) / 2.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_support::Scratch;
    use glam::{DVec3, Vec3};
    use relume_formats::state::Posed;

    const KNOT: &str = r#"
[vary]
shape = true
[render]
size = [8, 8]
[camera]
position = [0, 1, 4]
target = [0, 1, 0]
fov_deg = 40
[materials.clay]
brdf = "blinn-phong"
[[object]]
name = "knot"
shape = "torus-knot"
material = "clay"
transform = { translation = [0.5, 1, -0.25], rotation_deg = [20, 30, 0], scale = [1, 1.5, 1] }
twist_deg = 120
twist_s = 4
"#;

    #[test]
    fn points_turn_by_the_closed_form() {
        for (degrees, allowed_share) in [(120.0f64, 0.0006), (-360.0, 0.005)] {
            let scratch = Scratch::scene(&KNOT.replace("twist_deg = 120", &format!("twist_deg = {degrees}")));
            let scene = scratch.load().unwrap();
            let shape = scene.objects[0].shape.as_deref().unwrap();
            let (low, high) = shape
                .positions
                .iter()
                .fold((f32::MAX, f32::MIN), |(low, high), p| (low.min(p[1]), high.max(p[1])));
            let (low, high) = (f64::from(low), f64::from(high));
            let Transform::Fixed(world_from_local) = &shape.nodes[0].rest else {
                panic!("{:?}", shape.nodes[0])
            };
            let (angle, mut out, mut worst) = (degrees.to_radians(), Vec::new(), 0.0f64);
            let joint_step = angle / f64::from(JOINTS - 1);
            let key_error = angle.abs() / 2.0 * TAU.powi(2) / 2.0 / (8.0 * f64::from(STEPS).powi(2));
            assert!(joint_step.powi(2) / 8.0 < allowed_share, "as the documentation says");
            for time_s in [0.0, 0.4, 1.03, 1.97, 2.0, 3.3, 4.0, 6.0] {
                shape.positions(&shape.pose_of(Some(&Posed { clip: "Twist".to_owned(), time_s })), &mut out);
                for (place, [x, y, z]) in out.iter().zip(&shape.positions) {
                    let share = (f64::from(*y) - (low + high) / 2.0) / (high - low);
                    let (sin, cos) =
                        (angle * share * (std::f64::consts::PI * f64::from(time_s) / 4.0).sin().powi(2))
                            .sin_cos();
                    let [x, y, z] = [x, y, z].map(|v| f64::from(*v));
                    // Counter-clockwise seen from +Y takes +Z to +X.
                    let expected = world_from_local.transform_point3(DVec3::new(
                        x * cos + z * sin,
                        y,
                        z * cos - x * sin,
                    ));
                    let missed = expected.distance(Vec3::from(*place).as_dvec3());
                    // The transform scales no distance from the axis. Quaternions, weights and positions are
                    // rounded: to 1e-6 in all.
                    let allowed = x.hypot(z) * (joint_step.powi(2) / 8.0 + key_error) + 3e-6;
                    assert!(missed <= allowed, "{time_s} s: {expected} {place:?}, {missed} of {allowed}");
                    worst = worst.max(missed / x.hypot(z));
                }
            }
            // The bound is no idle one: half of the blend's share is reached.
            assert!(worst > joint_step.powi(2) / 16.0, "{worst}");
        }
    }

    #[test]
    fn at_rest_the_shape_is_the_mesh_bit_by_bit() {
        let scene = Scratch::scene(KNOT).load().unwrap();
        let (object, mut out) = (&scene.objects[0], Vec::new());
        let shape = object.shape.as_deref().unwrap();
        shape.positions(&shape.rest_pose(), &mut out);
        assert_eq!(out, object.mesh.positions);
        shape.validate(&Place::file("knot")).unwrap();
        let still = Scratch::scene(&KNOT.replace("twist_deg = 120\ntwist_s = 4\n", "")).load().unwrap();
        assert!(still.objects[0].shape.is_none());
        assert_eq!(still.objects[0].mesh, object.mesh, "a twist leaves the mesh alone");
    }

    #[test]
    fn what_makes_no_twist_is_refused() {
        for (from, to, message) in [
            ("twist_deg = 120\n", "", "object `knot`: give both `twist_deg` and `twist_s`, or neither"),
            ("twist_s = 4\n", "", "give both `twist_deg` and `twist_s`"),
            ("twist_s = 4", "twist_s = 0", "twist_s 0e0 must be at least 0.001 s and at most a day"),
            ("twist_s = 4", "twist_s = 1e-300", "twist_s 1e-300 must be at least 0.001 s"),
            ("twist_s = 4", "twist_s = 9e4", "twist_s 9e4 must be"),
            ("twist_s = 4", "twist_s = nan", "twist_s NaN must be"),
            ("= 120", "= 361", "twist_deg 361 must be within 360 either way, and not 0"),
            ("= 120", "= 0", "twist_deg 0 must be"),
            ("= 120", "= nan", "twist_deg NaN must be"),
            ("shape = true", "shape = false", "twists, but nothing deforms; add shape = true to [vary]"),
            ("\"torus-knot\"", "\"quad\"", "has no height to twist along"),
            (
                "shape = \"torus-knot\"",
                "file = \"bunny.obj\"",
                "`twist_deg` belongs to a shape, but the object is a file",
            ),
        ] {
            let message_of = Scratch::scene(&KNOT.replacen(from, to, 1)).load().unwrap_err().to_string();
            assert!(message_of.contains(message) && message_of.contains("knot"), "{message_of}");
        }
    }
}
