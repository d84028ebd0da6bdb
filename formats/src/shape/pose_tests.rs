//! Poses against hand-computed positions.

use super::*;
use glam::DAffine3;

fn node(parent: Option<u32>, translation: [f32; 3]) -> Node {
    Node { parent, rest: Transform::Parts { translation, rotation: [0.0, 0.0, 0.0, 1.0], scale: [1.0; 3] } }
}

fn joint(node: u32, bound_at: [f64; 3]) -> Joint {
    Joint { node, node_from_mesh: DAffine3::from_translation(-glam::DVec3::from(bound_at)) }
}

/// Two bones along x: the shoulder at the origin, the elbow 1 m on. Vertices at the shoulder's end, on the
/// elbow and at the tip; the vertex on the elbow's outside follows both bones alike.
fn arm() -> DeformingMesh {
    let shared = Influences { joints: [0, 1, 7, 7], weights: [0.5, 0.5, 0.0, 0.0] };
    DeformingMesh {
        positions: vec![[0.5, 0.0, 0.0], [1.0, 0.2, 0.0], [2.0, 0.0, 0.0]],
        influences: vec![Influences::rigid(0), shared, Influences::rigid(1)],
        joints: vec![joint(0, [0.0; 3]), joint(1, [1.0, 0.0, 0.0])],
        nodes: vec![node(None, [0.0; 3]), node(Some(0), [1.0, 0.0, 0.0])],
        ..DeformingMesh::default()
    }
}

fn clip(tracks: Vec<Track>) -> Clip {
    Clip { name: "it".into(), duration_s: 1.0, tracks }
}

/// One key, held for ever.
fn held(property: Property, value: &[f32]) -> Track {
    Track { property, interpolation: Interpolation::Linear, times_s: vec![0.0], values: value.to_vec() }
}

const QUARTER_ABOUT_Z: [f32; 4] =
    [0.0, 0.0, std::f32::consts::FRAC_1_SQRT_2, std::f32::consts::FRAC_1_SQRT_2];

fn assert_near(positions: &[[f32; 3]], expected: &[[f32; 3]]) {
    assert_eq!(positions.len(), expected.len());
    for (p, e) in positions.iter().zip(expected) {
        assert!(p.iter().zip(e).all(|(x, y)| (x - y).abs() < 1e-6), "{positions:?} {expected:?}");
    }
}

fn posed(mesh: &DeformingMesh, tracks: Vec<Track>) -> Vec<[f32; 3]> {
    let clip = clip(tracks);
    let mesh = DeformingMesh { clips: vec![clip.clone()], ..mesh.clone() };
    mesh.validate(&crate::Place::file("t")).unwrap();
    let mut out = vec![[9.0; 3]; 7];
    mesh.positions_at(&clip, 0.3, &mut out);
    out
}

#[test]
fn at_the_bind_pose_skinning_changes_nothing() {
    let mesh = arm();
    let mut out = Vec::new();
    mesh.positions(&mesh.rest_pose(), &mut out);
    assert_eq!(out, mesh.positions);
}

#[test]
fn an_arm_bends_at_its_elbow() {
    // The forearm turns by 90° about (1, 0, 0): the tip goes up, the shared vertex to the mean of (1, 0.2, 0)
    // and (0.8, 0, 0).
    let bent = posed(&arm(), vec![held(Property::Rotation(1), &QUARTER_ABOUT_Z)]);
    assert_near(&bent, &[[0.5, 0.0, 0.0], [0.9, 0.1, 0.0], [1.0, 1.0, 0.0]]);
    // Then the whole arm about the shoulder too: everything follows.
    let both = posed(
        &arm(),
        vec![held(Property::Rotation(1), &QUARTER_ABOUT_Z), held(Property::Rotation(0), &QUARTER_ABOUT_Z)],
    );
    assert_near(&both, &[[0.0, 0.5, 0.0], [-0.1, 0.9, 0.0], [-1.0, 1.0, 0.0]]);
}

#[test]
fn ancestors_scale_turn_and_move_in_this_order() {
    let mut mesh = arm();
    // The placement: twice as large, then turned by 90° about z, then 10 up; above it nothing, below it the
    // arm.
    let placement =
        Transform::Parts { translation: [0.0, 0.0, 10.0], rotation: QUARTER_ABOUT_Z, scale: [2.0; 3] };
    mesh.nodes =
        vec![Node { parent: None, rest: placement }, node(Some(0), [0.0; 3]), node(Some(1), [1.0, 0.0, 0.0])];
    mesh.joints.iter_mut().for_each(|joint| joint.node += 1);
    assert_near(&posed(&mesh, Vec::new()), &[[0.0, 1.0, 10.0], [-0.4, 2.0, 10.0], [0.0, 4.0, 10.0]]);
    // The elbow slides by 1 along the arm's x, which is the world's y at twice the size; the shared vertex
    // goes half the way.
    let slid = posed(&mesh, vec![held(Property::Translation(2), &[2.0, 0.0, 0.0])]);
    assert_near(&slid, &[[0.0, 1.0, 10.0], [-0.4, 3.0, 10.0], [0.0, 6.0, 10.0]]);
    let stretched = posed(&mesh, vec![held(Property::Scale(2), &[3.0, 1.0, 1.0])]);
    assert_near(&stretched[2..], &[[0.0, 8.0, 10.0]]);
}

#[test]
fn a_fixed_matrix_places_like_its_parts() {
    let parts =
        Transform::Parts { translation: [1.0, 2.0, 3.0], rotation: QUARTER_ABOUT_Z, scale: [2.0, 3.0, 4.0] };
    let fixed = Transform::Fixed(parts.parent_from_node());
    let mut mesh = arm();
    mesh.nodes[0].rest = parts;
    let with_parts = posed(&mesh, Vec::new());
    // (2, 0, 0) scaled to (4, 0, 0), turned to (0, 4, 0), moved.
    assert_near(&with_parts[2..], &[[1.0, 6.0, 3.0]]);
    mesh.nodes[0].rest = fixed;
    assert_eq!(posed(&mesh, Vec::new()), with_parts);
}

#[test]
fn morphs_add_up_before_joints_move() {
    let mut mesh = arm();
    mesh.morph_targets = vec![
        MorphTarget {
            rest_weight: 0.25,
            vertices: vec![0, 2],
            deltas: vec![[0.0, 4.0, 0.0], [0.0, 0.0, 8.0]],
        },
        MorphTarget { rest_weight: 0.0, vertices: vec![2], deltas: vec![[1.0, 0.0, 0.0]] },
    ];
    assert_near(&posed(&mesh, Vec::new()), &[[0.5, 1.0, 0.0], [1.0, 0.2, 0.0], [2.0, 0.0, 2.0]]);
    let weights = [held(Property::MorphWeight(0), &[-0.5]), held(Property::MorphWeight(1), &[3.0])];
    assert_near(&posed(&mesh, weights.to_vec()), &[[0.5, -2.0, 0.0], [1.0, 0.2, 0.0], [5.0, 0.0, -4.0]]);
    let [first, second] = weights;
    // (5, 0, −4) turns about the elbow at (1, 0, 0) to (1, 4, −4).
    let bent = posed(&mesh, vec![first, second, held(Property::Rotation(1), &QUARTER_ABOUT_Z)]);
    assert_near(&bent[2..], &[[1.0, 4.0, -4.0]]);
}

#[test]
fn a_clip_holds_before_its_start_and_after_its_end() {
    let mesh = arm();
    let slide = Track {
        property: Property::Translation(0),
        interpolation: Interpolation::Linear,
        times_s: vec![1.0, 3.0],
        values: vec![0.0, 0.0, 0.0, 0.0, 6.0, 0.0],
    };
    let clip = Clip { name: "slide".into(), duration_s: 3.0, tracks: vec![slide] };
    for (time_s, y) in [(-1.0, 0.0), (0.0, 0.0), (1.0, 0.0), (2.0, 3.0), (3.0, 6.0), (1e9, 6.0)] {
        let mut out = Vec::new();
        mesh.positions_at(&clip, time_s, &mut out);
        assert_eq!(out[0], [0.5, y, 0.0], "{time_s} s");
    }
}

#[test]
fn a_clip_of_another_mesh_does_no_harm() {
    let stray =
        [Property::Translation(99), Property::Rotation(99), Property::Scale(99), Property::MorphWeight(99)];
    let clip = clip(stray.map(|property| held(property, &[1.0; 4])).to_vec());
    let mut out = Vec::new();
    arm().positions_at(&clip, 0.0, &mut out);
    assert_eq!(out, arm().positions);
}
