//! Skins, morph targets and clips of glTF files, against positions computed by hand.

mod asset_tests;
mod file;
mod refusal_tests;
mod scene_tests;

use super::gltf_deforming::load_placed;
use super::*;
use crate::test_support::enclosed_volume;
use file::{File, NOT_TURNED, TURNED, arm, morphing};
use glam::{DVec3, Vec3};
use relume_formats::shape::{Interpolation, Property};
use serde_json::json;

fn assert_near(found: &[[f32; 3]], expected: &[[f32; 3]]) {
    assert_eq!(found.len(), expected.len());
    for (f, e) in found.iter().zip(expected) {
        assert!(Vec3::from(*f).distance(Vec3::from(*e)) < 2e-6, "{found:?} {expected:?}");
    }
}

/// The position of every vertex at a time of the first clip.
fn at(deforming: &Deforming, time_s: f32) -> Vec<[f32; 3]> {
    let mut out = Vec::new();
    deforming.shape.positions_at(&deforming.shape.clips[0], time_s, &mut out);
    out
}

fn at_rest(deforming: &Deforming) -> Vec<[f32; 3]> {
    let mut out = Vec::new();
    deforming.shape.positions(&deforming.shape.rest_pose(), &mut out);
    out
}

#[test]
fn a_mesh_rests_where_its_skin_puts_it() {
    let folder = tempfile::tempdir().unwrap();
    let mesh = load_mesh(&arm().write(&folder), &mut Vec::new()).unwrap();
    // The elbow turns (x, y, z) to (1 − y, x − 1, z), the root lifts by 10; the third vertex is ¾ (0, 11, 0)
    // + ¼ (0, 9, 0).
    assert_near(&mesh.positions, &[[0.0, 10.0, 0.0], [1.0, 10.0, 0.0], [0.0, 10.5, 0.0], [1.0, 9.0, 1.0]]);
    // What turns by a share of the right angle has the blend of the axes as its normal.
    let between = Vec3::new(0.75, 0.25, 0.0).normalize().to_array();
    assert_near(&mesh.normals, &[[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], between, [0.0, 1.0, 0.0]]);
    assert_eq!(mesh.triangles.len(), 4);
}

#[test]
fn the_deforming_mesh_is_the_mesh_vertex_by_vertex() {
    let mut flat = arm();
    flat.remove("/meshes/0/primitives/0/attributes", "NORMAL");
    let mut rigid = arm();
    rigid.remove("/nodes/3", "skin");
    let mut both = arm();
    both.set("/nodes/0/mesh", json!(0));
    let mirror = DAffine3::from_scale_rotation_translation(
        DVec3::new(-2.0, 1.0, 0.5),
        glam::DQuat::from_rotation_x(0.7),
        DVec3::ONE,
    );
    let folder = tempfile::tempdir().unwrap();
    for (name, file, vertices) in
        [("arm", arm(), 4), ("flat", flat, 12), ("rigid", rigid, 4), ("both", both, 8)]
    {
        for world_from_file in [DAffine3::IDENTITY, mirror] {
            let path = file.write(&folder);
            let (mut warnings, mut of_mesh) = (Vec::new(), Vec::new());
            let deforming = load_placed(&path, None, &world_from_file, None, &mut warnings).unwrap();
            let mesh = load_file(&path, None, &world_from_file, None, &mut of_mesh).unwrap();
            assert_eq!((&deforming.rest, &warnings), (&mesh, &of_mesh), "{name}");
            assert_eq!(at_rest(&deforming), mesh.positions, "{name}: to the last bit");
            assert_eq!(mesh.positions.len(), vertices, "{name}");
            // Whatever mirrors, fronts stay outside.
            assert!(enclosed_volume(&mesh) > 0.0, "{name}: {}", enclosed_volume(&mesh));
        }
    }
}

#[test]
fn what_a_skin_mirrors_keeps_its_front() {
    let folder = tempfile::tempdir().unwrap();
    let mut volumes = Vec::new();
    for scale in [1.0, -1.0] {
        let mut file = arm();
        file.set("/nodes/2/rotation", json!(NOT_TURNED));
        file.set("/nodes/0/scale", json!([scale, 2.0, 1.0]));
        for normals in [true, false] {
            if !normals {
                file.remove("/meshes/0/primitives/0/attributes", "NORMAL");
            }
            let mesh = load_mesh(&file.write(&folder), &mut Vec::new()).unwrap();
            volumes.push(enclosed_volume(&mesh));
            if !normals {
                let [a, b, c] = mesh.triangles[0].map(|v| Vec3::from(mesh.positions[v as usize]));
                assert!(
                    (b - a).cross(c - a).dot(Vec3::from(mesh.normals[mesh.triangles[0][0] as usize])) > 0.0
                );
            }
        }
    }
    // A tetrahedron of 1/6, twice as high.
    assert!(volumes.iter().all(|volume| (volume - 1.0 / 3.0).abs() < 1e-6), "{volumes:?}");
}

#[test]
fn clips_move_joints_and_what_follows_them() {
    let mut file = arm();
    file.animate("Bend", 2, "rotation", "LINEAR", &[0.5, 1.5], &[NOT_TURNED, TURNED]);
    file.animate("Slide", 0, "translation", "STEP", &[0.0, 2.0], &[[0.0; 3], [0.0, 0.0, 5.0]]);
    let deforming = file.load();
    let clips: Vec<_> =
        deforming.shape.clips.iter().map(|clip| (clip.name.as_str(), clip.duration_s)).collect();
    assert_eq!(clips, [("Bend", 1.5), ("Slide", 2.0)]);
    // Straight until half a second, at the bind pose but for the root.
    for time_s in [-1.0, 0.0, 0.5] {
        assert_near(
            &at(&deforming, time_s),
            &[[0.0, 10.0, 0.0], [1.0, 10.0, 0.0], [0.0, 11.0, 0.0], [0.0, 10.0, 1.0]],
        );
    }
    // By 45° at one second: (−1, 0, 1) from the elbow goes to (−√½, −√½, 1).
    let half = std::f32::consts::FRAC_1_SQRT_2;
    assert_near(&at(&deforming, 1.0)[3..], &[[1.0 - half, 10.0 - half, 1.0]]);
    assert_eq!(at(&deforming, 1.5), at_rest(&deforming));
    assert_eq!(at(&deforming, 9.0), at_rest(&deforming));
    let mut out = Vec::new();
    deforming.shape.positions_at(&deforming.shape.clips[1], 1.9, &mut out);
    assert_near(&out[..2], &[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]]);
    deforming.shape.positions_at(&deforming.shape.clips[1], 2.0, &mut out);
    assert_near(&out[..2], &[[0.0, 0.0, 5.0], [1.0, 0.0, 5.0]]);
}

#[test]
fn every_skin_has_joints_of_its_own() {
    let mut file = arm();
    // A second body, whose skin names the same joints the other way round and has no matrices; then a third,
    // which wears the first skin again.
    file.document["skins"].as_array_mut().unwrap().push(json!({"joints": [2, 1]}));
    let nodes = file.document["nodes"].as_array_mut().unwrap();
    nodes.extend([
        json!({"name": "second", "mesh": 0, "skin": 1}),
        json!({"name": "third", "mesh": 0, "skin": 0}),
    ]);
    file.set("/scenes/0/nodes", json!([0, 3, 4, 5]));
    file.set("/nodes/2/rotation", json!(NOT_TURNED));
    let deforming = file.load();
    assert_eq!(deforming.shape.joints.len(), 4);
    // Without matrices a vertex lies in its joint: the elbow adds (1, 10, 0), the shoulder (0, 10, 0).
    let straight = [[0.0, 10.0, 0.0], [1.0, 10.0, 0.0], [0.0, 11.0, 0.0], [0.0, 10.0, 1.0]];
    let second = [[1.0, 10.0, 0.0], [1.0, 10.0, 0.0], [0.75, 11.0, 0.0], [0.0, 10.0, 1.0]];
    let rest = at_rest(&deforming);
    assert_near(&rest[..4], &straight);
    assert_near(&rest[rest.len() - 4..], &straight);
    // Two of its corners meet, so that two of its triangles are gone, but no vertex.
    assert_near(&rest[4..8], &second);
    let folder = tempfile::tempdir().unwrap();
    let only = load_placed(&file.write(&folder), Some("second"), &DAffine3::IDENTITY, None, &mut Vec::new())
        .unwrap();
    assert_near(&at_rest(&only), &second);
}

#[test]
fn morph_targets_add_up_and_their_weights_move() {
    let mut file = morphing();
    file.animate("Breathe", 3, "weights", "LINEAR", &[0.0, 1.0], &[[0.0], [1.0], [2.0], [3.0]]);
    let deforming = file.load();
    let rest = [[100.0, 0.0, 0.0], [101.0, 0.0, 0.0], [100.0, 1.0, 0.0], [100.0, 1.0, 1.0]];
    assert_eq!(deforming.rest.positions, rest, "half of the first target");
    assert_eq!(at_rest(&deforming), rest);
    // Key by key the weights of both targets: (0, 1), (2, 3); halfway (1, 2).
    assert_eq!(
        at(&deforming, 0.5),
        [[100.0, 0.0, 0.0], [101.0, 0.0, -2.0], [100.0, 1.0, -2.0], [100.0, 2.0, 1.0]]
    );
    // Flat shading takes triangles apart, and morph targets with them.
    file.remove("/meshes/0/primitives/0/attributes", "NORMAL");
    let flat = file.load();
    assert_eq!(flat.rest.positions.len(), 12);
    let (tip, moved) = ([100.0, 1.0, 1.0], [100.0, 2.0, 1.0]);
    let places = |positions: &[[f32; 3]], wanted| {
        positions.iter().enumerate().filter(|(_, p)| **p == wanted).map(|(v, _)| v).collect::<Vec<_>>()
    };
    assert_eq!(places(&at(&flat, 0.5), moved), places(&flat.rest.positions, tip));
    // A node's own weights come before the mesh's.
    file.set("/nodes/3/weights", json!([0.0, 1.0]));
    assert!(places(&file.load().rest.positions, [101.0, 0.0, -1.0]).len() == 3);
}

#[test]
fn splines_and_normalised_integers_are_read() {
    let mut file = morphing();
    // In-tangents, values, out-tangents, each of both targets; one span of two seconds.
    let keys = [[9.0], [9.0], [0.0], [1.0], [0.5], [0.0], [0.25], [0.0], [2.0], [1.0], [9.0], [9.0]];
    file.animate("Spline", 3, "weights", "CUBICSPLINE", &[0.0, 2.0], &keys);
    let track = &file.load().shape.clips[0].tracks;
    assert_eq!(track.len(), 2);
    assert_eq!(
        (track[0].property, track[0].interpolation),
        (Property::MorphWeight(0), Interpolation::CubicSpline)
    );
    assert_eq!(track[0].values, [9.0, 0.0, 0.5, 0.25, 2.0, 9.0]);
    assert_eq!(track[1].values, [9.0, 1.0, 0.0, 0.0, 1.0, 9.0]);
    let mut file = arm();
    // Rotations as 16-bit and weights as 8-bit shares: 23170/32767 ≈ √½, and 192 : 64 = 3 : 1.
    file.animate("Bend", 2, "rotation", "LINEAR", &[0.0], &[TURNED]);
    let shares: Vec<u8> = [0i16, 0, 23170, 23170].iter().flat_map(|x| x.to_le_bytes()).collect();
    let output = file.accessor(5122, "VEC4", 1, &shares);
    file.set(&format!("/accessors/{output}/normalized"), json!(true));
    file.set("/animations/0/samplers/0/output", json!(output));
    let weights = file.accessor(
        5121,
        "VEC4",
        5,
        &[[255, 0, 0, 0], [255, 0, 0, 0], [255, 0, 0, 0], [192, 64, 0, 0], [255, 0, 0, 0]].concat(),
    );
    file.set(&format!("/accessors/{weights}/normalized"), json!(true));
    file.set("/meshes/0/primitives/0/attributes/WEIGHTS_0", json!(weights));
    let deforming = file.load();
    assert_near(&at_rest(&deforming), &arm().load().rest.positions);
    assert_near(&at(&deforming, 0.0), &at_rest(&deforming));
}

#[test]
fn nodes_move_meshes_without_a_skin() {
    let mut file = arm();
    file.set("/nodes/2", json!({"name": "elbow", "mesh": 0, "translation": [1.0, 0.0, 0.0]}));
    file.set("/scenes/0/nodes", json!([0]));
    file.animate("Turn", 1, "rotation", "LINEAR", &[0.0, 1.0], &[NOT_TURNED, TURNED]);
    let deforming = file.load();
    assert_eq!(deforming.shape.joints.len(), 1);
    assert_near(
        &at(&deforming, 0.0),
        &[[1.0, 10.0, 0.0], [2.0, 10.0, 0.0], [1.0, 11.0, 0.0], [1.0, 10.0, 1.0]],
    );
    assert_near(
        &at(&deforming, 1.0),
        &[[0.0, 11.0, 0.0], [0.0, 12.0, 0.0], [-1.0, 11.0, 0.0], [0.0, 11.0, 1.0]],
    );
}

#[test]
fn clips_that_move_nothing_of_the_scene_are_left_out() {
    let mut file = arm();
    file.document["nodes"].as_array_mut().unwrap().push(json!({"name": "elsewhere"}));
    file.animate("Elsewhere", 4, "translation", "LINEAR", &[0.0], &[[0.0; 3]]);
    file.animate("Weightless", 3, "weights", "LINEAR", &[0.0], &[[0.0]]);
    file.animate("", 1, "scale", "LINEAR", &[0.0], &[[1.0; 3]]);
    let deforming = file.load();
    let clips: Vec<_> =
        deforming.shape.clips.iter().map(|clip| (clip.name.as_str(), clip.duration_s)).collect();
    assert_eq!(clips, [("clip-2", 0.0)], "a clip of one pose, named by its number");
}

#[test]
fn matrices_stand_still_and_other_formats_have_no_clips() {
    let mut file = arm();
    file.set(
        "/nodes/0",
        json!({"children": [1], "matrix": [2, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 10, 0, 1]}),
    );
    assert_near(&file.load().rest.positions[..2], &[[0.0, 10.0, 0.0], [2.0, 10.0, 0.0]]);
    file.animate("A", 0, "scale", "LINEAR", &[0.0], &[[1.0; 3]]);
    assert!(file.refusal().contains("moves node 1, which has a matrix"), "{}", file.refusal());
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("t.obj");
    std::fs::write(&path, "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").unwrap();
    assert_eq!(load_mesh(&path, &mut Vec::new()).unwrap().triangles.len(), 1);
    assert!(
        load_deforming(&path, &mut Vec::new())
            .unwrap_err()
            .to_string()
            .contains("only .gltf and .glb files hold shapes that deform")
    );
}
