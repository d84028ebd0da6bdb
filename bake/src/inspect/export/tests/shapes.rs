//! An exported shape, and what `info` and `verify` say of it.

use super::super::super::{info, verify};
use super::*;
use relume_formats::shape::{
    Clip, DeformingMesh, Influences, Interpolation, Joint, Node, Property, Track, Transform,
};

/// Two vertices a metre above their node, which a clip moves.
fn lifted() -> DeformingMesh {
    let rest =
        Transform::Parts { translation: [0.0, 1.0, 0.0], rotation: [0.0, 0.0, 0.0, 1.0], scale: [1.0; 3] };
    let interpolation = Interpolation::Linear;
    let track = Track {
        property: Property::Translation(0),
        interpolation,
        times_s: vec![0.0, 1.5],
        values: vec![0.0, 1.0, 0.0, 0.0, 3.0, 0.0],
    };
    DeformingMesh {
        positions: vec![[0.5, 0.0, 0.0], [0.0, 0.0, 0.25]],
        influences: vec![Influences::rigid(0); 2],
        joints: vec![Joint { node: 0, node_from_mesh: glam::DAffine3::IDENTITY }],
        nodes: vec![Node { parent: None, rest }],
        clips: vec![Clip { name: "Lift".to_owned(), duration_s: 1.5, tracks: vec![track] }],
        ..DeformingMesh::default()
    }
}

#[test]
fn a_shape_is_told_and_exported_as_it_rests() {
    let folder = tempfile::tempdir().unwrap();
    let (path, out) = (folder.path().join("lift.relume"), folder.path().join("out"));
    lifted().write_file(&path).unwrap();
    let files = export_file(&path, &out).unwrap();
    assert_eq!(
        names(&files, &out),
        ["positions.npy", "joint_indices.npy", "joint_weights.npy", "shape.json"]
    );
    assert_eq!(Npy::f32s(&files[0]), (vec![2, 3], vec![0.5, 1.0, 0.0, 0.0, 1.0, 0.25]));
    assert_eq!(Npy::f32s(&files[2]), (vec![2, 4], [1.0, 0.0, 0.0, 0.0].repeat(2)));
    let clips = serde_json::json!([{ "name": "Lift", "duration_s": 1.5, "tracks": 1, "keys": 2 }]);
    assert_eq!(
        json(&out.join("shape.json")),
        serde_json::json!({ "vertices": 2, "joints": 1, "morph_targets": 0, "clips": clips })
    );
    let told: Value = serde_json::from_str(&info(&path, true).unwrap()).unwrap();
    assert_eq!(told["details"]["clips"], clips);
    let text = info(&path, false).unwrap();
    assert!(text.contains("  vertices    2, moved by 1 joint of 1 node and 0 morph targets\n"), "{text}");
    assert!(text.contains("  clips       Lift (1.5 s, 1 track, 2 keys)\n"), "{text}");
    assert!(verify(&path).unwrap().ends_with("shape, 12 sections, every checksum and value checked\n"));
}
