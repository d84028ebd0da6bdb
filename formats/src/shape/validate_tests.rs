//! Every rule refuses what breaks it.

use super::*;
use crate::error::Place;
use glam::DAffine3;

/// What breaks a sound thing, and part of the refusal.
type Case<T> = (fn(&mut T), &'static str);

fn sound() -> DeformingMesh {
    let parts =
        || Transform::Parts { translation: [0.0; 3], rotation: [0.0, 0.0, 0.0, 1.0], scale: [1.0; 3] };
    let track = |property, values: &[f32]| Track {
        property,
        interpolation: Interpolation::Linear,
        times_s: vec![0.0, 1.0],
        values: values.to_vec(),
    };
    DeformingMesh {
        positions: vec![[0.0; 3]; 3],
        influences: vec![Influences::rigid(1); 3],
        joints: vec![Joint { node: 0, node_from_mesh: DAffine3::IDENTITY }; 2],
        nodes: vec![
            Node { parent: None, rest: parts() },
            Node { parent: Some(0), rest: parts() },
            Node { parent: Some(0), rest: Transform::Fixed(DAffine3::IDENTITY) },
        ],
        morph_targets: vec![MorphTarget {
            rest_weight: 0.0,
            vertices: vec![0, 2],
            deltas: vec![[1.0; 3]; 2],
        }],
        clips: vec![Clip {
            name: "walk".into(),
            duration_s: 1.0,
            tracks: vec![
                track(Property::Rotation(1), &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]),
                track(Property::Translation(1), &[0.0; 6]),
                track(Property::MorphWeight(0), &[0.0; 2]),
            ],
        }],
    }
}

fn refusal(change: impl FnOnce(&mut DeformingMesh)) -> String {
    let mut mesh = sound();
    change(&mut mesh);
    let error = mesh.validate(&Place::file("fox.glb")).unwrap_err();
    assert!(error.is_bad_input());
    error.to_string()
}

#[test]
fn a_sound_mesh_passes() {
    sound().validate(&Place::file("fox.glb")).unwrap();
    DeformingMesh::default().validate(&Place::file("fox.glb")).unwrap();
}

#[test]
fn broken_meshes_are_refused_with_their_place() {
    let cases: [Case<DeformingMesh>; 16] = [
        (|m| m.influences.truncate(2), "3 vertices but joints and weights for 2"),
        (|m| m.positions[1][2] = f32::NAN, "vertex 1 is not a finite position"),
        (|m| m.influences[2].joints[0] = 2, "vertex 2: names joint 2 of 2"),
        (|m| m.influences[0].weights[0] = -1.0, "vertex 0: weights [-1.0, 0.0, 0.0, 0.0] must be at least 0"),
        (|m| m.influences[0].weights[3] = f32::NAN, "must be at least 0"),
        (|m| m.influences[0].weights[0] = 0.0, "vertex 0: weights [0.0, 0.0, 0.0, 0.0] must have the sum 1"),
        (|m| m.joints[1].node = 3, "joint 1: names node 3 of 3"),
        (
            |m| m.joints[0].node_from_mesh.translation.x = f64::INFINITY,
            "joint 0: its inverse bind matrix is not finite",
        ),
        (|m| m.nodes[0].parent = Some(0), "node 0: its parent 0 does not come before it"),
        (|m| m.nodes[1].parent = Some(2), "node 1: its parent 2 does not come before it"),
        (
            |m| m.nodes[2].rest = Transform::Fixed(DAffine3::from_scale(glam::DVec3::NAN)),
            "node 2: its transform is not finite",
        ),
        (
            |m| {
                m.nodes[1].rest =
                    Transform::Parts { translation: [0.0; 3], rotation: [0.0; 4], scale: [1.0; 3] }
            },
            "node 1: rotation [0.0, 0.0, 0.0, 0.0] must be finite and not 0",
        ),
        (|m| m.morph_targets[0].vertices[1] = 3, "morph target 0: names vertex 3 of 3"),
        (|m| m.morph_targets[0].vertices[1] = 0, "morph target 0: the vertices that it moves must increase"),
        (|m| m.morph_targets[0].deltas.truncate(1), "morph target 0: names 2 vertices but moves 1"),
        (|m| m.morph_targets[0].rest_weight = f32::INFINITY, "morph target 0: its numbers must be finite"),
    ];
    for (change, part) in cases {
        let message = refusal(change);
        assert!(
            message.starts_with("fox.glb: ")
                && message.contains(part)
                && message.ends_with("; mend the model or export it again"),
            "{message}"
        );
    }
}

#[test]
fn broken_clips_are_refused_with_their_name_and_track() {
    let cases: [Case<Clip>; 14] = [
        (
            |c| c.duration_s = 0.5,
            "clip `walk`: its duration 0.5 s must be finite and reach its last key at 1 s",
        ),
        (|c| c.duration_s = f32::NAN, "its duration NaN s"),
        (|c| c.tracks[0].times_s[1] = 0.0, "clip `walk`: track 0: key times must increase"),
        (|c| c.tracks[0].times_s[0] = -0.1, "needs keys at finite times of at least 0"),
        (|c| c.tracks[0].times_s[0] = f32::NAN, "needs keys at finite times of at least 0"),
        (|c| c.tracks[0].times_s.clear(), "needs keys at finite times of at least 0"),
        (|c| c.tracks[1].values[4] = f32::NAN, "track 1: values must be finite"),
        (|c| c.tracks[1].values.truncate(5), "track 1: 2 keys need 3 numbers each, there are 5"),
        (
            |c| c.tracks[0].interpolation = Interpolation::CubicSpline,
            "track 0: 2 keys need 12 numbers each, there are 8",
        ),
        (|c| c.tracks[0].values[7] = 0.0, "track 0: rotation [0.0, 0.0, 0.0, 0.0] must be finite and not 0"),
        (|c| c.tracks[1].property = Property::Scale(3), "track 1: names node 3 of 3"),
        (|c| c.tracks[1].property = Property::Scale(2), "track 1: moves node 2, which has a matrix"),
        (|c| c.tracks[2].property = Property::MorphWeight(1), "track 2: names morph target 1 of 1"),
        (
            |c| {
                let again = c.tracks[1].clone();
                c.tracks.push(again);
            },
            "track 3: Translation(1) has a track already",
        ),
    ];
    for (change, part) in cases {
        let message = refusal(|mesh| change(&mut mesh.clips[0]));
        assert!(message.contains(part), "{message}");
    }
    let message = refusal(|mesh| mesh.clips.push(mesh.clips[0].clone()));
    assert!(message.contains("two clips are called `walk`"), "{message}");
}

#[test]
fn a_spline_of_rotations_may_have_tangents_of_length_0_but_no_such_value() {
    let mut mesh = sound();
    let track = &mut mesh.clips[0].tracks[0];
    track.interpolation = Interpolation::CubicSpline;
    track.values = [[0.0; 4], [0.0, 0.0, 0.0, 1.0], [0.0; 4]].repeat(2).concat();
    mesh.validate(&Place::file("t")).unwrap();
    mesh.clips[0].tracks[0].values[19] = 0.0;
    assert!(
        mesh.validate(&Place::file("t")).unwrap_err().to_string().contains("rotation [0.0, 0.0, 0.0, 0.0]")
    );
}

#[test]
fn too_much_of_anything_is_refused() {
    assert!(
        refusal(|m| m.joints = vec![m.joints[0].clone(); MAX_JOINTS + 1])
            .contains("65537 joints, at most 65536 are allowed")
    );
    assert!(
        refusal(|m| m.nodes = vec![m.nodes[0].clone(); MAX_JOINTS + 1])
            .contains("65537 nodes, at most 65536")
    );
    assert!(
        refusal(|m| m.clips = vec![m.clips[0].clone(); MAX_CLIPS + 1]).contains("4097 clips, at most 4096")
    );
    assert!(
        refusal(|m| m.clips[0].tracks[2].times_s = vec![0.0; MAX_CLIP_KEYS])
            .contains("4194308 keys, at most 4194304")
    );
}
