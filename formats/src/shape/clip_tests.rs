//! Tracks against closed forms.

use super::*;
use std::f64::consts::FRAC_PI_2;

fn track(property: Property, interpolation: Interpolation, times_s: &[f32], values: &[f32]) -> Track {
    Track { property, interpolation, times_s: times_s.to_vec(), values: values.to_vec() }
}

/// Turned by `degrees` about the unit vector `axis`.
fn about(axis: [f64; 3], degrees: f64) -> [f64; 4] {
    let (sin, cos) = (degrees.to_radians() / 2.0).sin_cos();
    [axis[0] * sin, axis[1] * sin, axis[2] * sin, cos]
}

fn turns(interpolation: Interpolation, keys: &[[f64; 4]]) -> Track {
    let times_s: Vec<f32> = (0..keys.len()).map(|k| k as f32).collect();
    let values: Vec<f32> = keys.as_flattened().iter().map(|x| *x as f32).collect();
    track(Property::Rotation(0), interpolation, &times_s, &values)
}

fn distance(a: [f64; 4], b: [f64; 4]) -> f64 {
    a.iter().zip(&b).map(|(x, y)| (x - y).powi(2)).sum::<f64>().sqrt()
}

#[test]
fn step_holds_and_linear_is_straight_and_both_hold_at_the_ends() {
    let values = [1.0, 10.0, -1.0, 3.0, 20.0, -2.0, 4.0, 0.0, 0.0];
    let at = |interpolation, time_s| {
        track(Property::Translation(0), interpolation, &[0.5, 1.5, 2.0], &values).sample(time_s)[..3].to_vec()
    };
    for interpolation in [Interpolation::Step, Interpolation::Linear] {
        for (time_s, value) in [
            (-3.0, [1.0, 10.0, -1.0]),
            (0.5, [1.0, 10.0, -1.0]),
            (1.5, [3.0, 20.0, -2.0]),
            (2.0, [4.0, 0.0, 0.0]),
            (9.0, [4.0, 0.0, 0.0]),
        ] {
            assert_eq!(at(interpolation, time_s), value, "{interpolation:?} at {time_s} s");
        }
    }
    assert_eq!(at(Interpolation::Step, 1.25), [1.0, 10.0, -1.0]);
    assert_eq!(at(Interpolation::Linear, 0.75), [1.5, 12.5, -1.25]);
    assert_eq!(at(Interpolation::Linear, 1.75), [3.5, 10.0, -1.0]);
    assert_eq!(at(Interpolation::Linear, f32::NAN), [1.0, 10.0, -1.0], "no time is before the first key");
}

#[test]
fn rotations_turn_evenly_along_the_shorter_way() {
    let axis = [2.0 / 3.0, -1.0 / 3.0, 2.0 / 3.0];
    // A tiny turn, a right angle, nearly half a turn, and one more than half, whose shorter way is back.
    for (degrees, way) in [(0.01, 0.01), (90.0, 90.0), (179.0, 179.0), (250.0, -110.0)] {
        let track = turns(Interpolation::Linear, &[about(axis, 0.0), about(axis, degrees)]);
        for share in [0.0f32, 0.25, 0.5, 0.9, 1.0] {
            let expected = about(axis, way * f64::from(share));
            let value = track.sample(share);
            // Keys are rounded to f32: 6e-8 in each of four components.
            assert!(
                distance(value, expected).min(distance(value, expected.map(|x| -x))) < 2e-7,
                "{degrees}° at {share}: {value:?} {expected:?}"
            );
        }
    }
    let twice = turns(
        Interpolation::Linear,
        &[about(axis, 0.0).map(|x| 2.0 * x), about(axis, 90.0).map(|x| 5.0 * x)],
    );
    assert!(
        distance(twice.sample(0.5), about(axis, 45.0)) < 2e-7,
        "the length of a quaternion means nothing"
    );
}

#[test]
fn a_held_rotation_does_not_turn() {
    let axis = [0.0, 1.0, 0.0];
    let track = turns(Interpolation::Step, &[about(axis, 10.0), about(axis, 50.0)]);
    assert!(distance(track.sample(0.99), about(axis, 10.0)) < 1e-7);
}

#[test]
fn a_spline_with_the_tangents_of_a_cubic_is_the_cubic() {
    // p(t) = 2 − t + 3t² − ½t³ and two like it: Hermite interpolation of any cubic is exact, over unequal
    // spans too.
    let cubics = [[2.0, -1.0, 3.0, -0.5], [0.0, 1.0, 0.0, 0.25], [-1.0, 0.0, -2.0, 1.0]];
    let value = |c: [f64; 4], t: f64| c[0] + t * (c[1] + t * (c[2] + t * c[3]));
    let slope = |c: [f64; 4], t: f64| c[1] + t * (2.0 * c[2] + t * 3.0 * c[3]);
    let times_s = [0.0f32, 0.5, 2.0];
    let mut values = Vec::new();
    for t in times_s.map(f64::from) {
        values.extend(cubics.map(|c| slope(c, t) as f32));
        values.extend(cubics.map(|c| value(c, t) as f32));
        values.extend(cubics.map(|c| slope(c, t) as f32));
    }
    let track = track(Property::Scale(0), Interpolation::CubicSpline, &times_s, &values);
    for step in 0..=40 {
        let t = step as f32 * 0.05;
        let sample = track.sample(t);
        for (axis, cubic) in cubics.iter().enumerate() {
            let expected = value(*cubic, f64::from(t));
            assert!((sample[axis] - expected).abs() < 1e-6, "{t} s: {} {expected}", sample[axis]);
        }
    }
    for (t, end) in [(-1.0, 0.0), (3.0, 2.0)] {
        assert_eq!(track.sample(t)[0], value(cubics[0], end), "held, without its slope");
    }
}

#[test]
fn departure_comes_after_the_value_and_arrival_before() {
    // glTF 2.0, appendix C.5, with v = 0 at both keys: halfway p = t_d/8 · (departure of the first − arrival
    // of the second).
    let values = [7.0, 0.0, 3.0, 1.0, 0.0, 9.0];
    let track = track(Property::MorphWeight(0), Interpolation::CubicSpline, &[1.0, 3.0], &values);
    assert_eq!(track.sample(2.0)[0], 2.0 / 8.0 * (3.0 - 1.0));
}

#[test]
fn a_splined_rotation_stays_a_rotation() {
    let zero = [0.0; 4];
    let keys = [zero, about([0.0, 0.0, 1.0], 0.0), zero, zero, about([0.0, 0.0, 1.0], 90.0), zero];
    let values: Vec<f32> = keys.as_flattened().iter().map(|x| *x as f32).collect();
    let clip = Clip {
        name: "turn".into(),
        duration_s: 1.0,
        tracks: vec![track(Property::Rotation(0), Interpolation::CubicSpline, &[0.0, 1.0], &values)],
    };
    let rest = Transform::Parts { translation: [0.0; 3], rotation: [0.0, 0.0, 0.0, 1.0], scale: [1.0; 3] };
    let mesh = DeformingMesh {
        positions: vec![[1.0, 0.0, 0.0]],
        influences: vec![Influences::rigid(0)],
        joints: vec![Joint { node: 0, node_from_mesh: glam::DAffine3::IDENTITY }],
        nodes: vec![Node { parent: None, rest }],
        ..DeformingMesh::default()
    };
    let mut out = Vec::new();
    mesh.positions_at(&clip, 0.5, &mut out);
    // Between equal lengths the middle of a chord lies at the middle angle: cos and sin of 45°.
    let half = (FRAC_PI_2 / 2.0).cos() as f32;
    assert!((out[0][0] - half).abs() < 1e-6 && (out[0][1] - half).abs() < 1e-6, "{out:?}");
}
