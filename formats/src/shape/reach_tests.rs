//! The bound on how far vertices get, against vertices that go there.

use super::reach::norm;
use super::{
    Clip, DeformingMesh, Influences, Interpolation, Joint, MorphTarget, Node, Property, Track, Transform,
};
use crate::Place;
use glam::{DAffine3, DMat3, DQuat, DVec3};

#[test]
fn the_norm_of_a_matrix_is_its_largest_stretch() {
    let turn = DMat3::from_quat(DQuat::from_axis_angle(DVec3::new(0.48, 0.6, 0.64), 1.1));
    for (stretch, most) in [
        (DVec3::ONE, 1.0),
        (DVec3::new(2.0, -3.0, 0.5), 3.0),
        (DVec3::new(0.0, 0.0, 7e200), 7e200),
        (DVec3::ZERO, 0.0),
    ] {
        let found = norm(&(turn * DMat3::from_diagonal(stretch) * turn.transpose()));
        assert!((found - most).abs() <= 1e-12 * most, "{stretch}: {found}");
    }
    assert_eq!(norm(&DMat3::from_cols_array(&[0.0, 0.0, 0.0, 5.0, 0.0, 0.0, 0.0, 0.0, 0.0])), 5.0, "a shear");
}

/// A chain of `nodes` nodes, each scaled by `scale` and moved by 1 m, a clip that moves the last of them, and
/// a morph target.
fn chain(nodes: u32, scale: f32, track: Track) -> DeformingMesh {
    let rest =
        Transform::Parts { translation: [1.0, 0.0, 0.0], rotation: [0.0, 0.0, 0.0, 1.0], scale: [scale; 3] };
    DeformingMesh {
        positions: vec![[2.0, 0.0, 0.0]],
        influences: vec![Influences::rigid(0)],
        joints: vec![Joint { node: nodes - 1, node_from_mesh: DAffine3::from_scale(DVec3::splat(2.0)) }],
        nodes: (0..nodes).map(|node| Node { parent: node.checked_sub(1), rest: rest.clone() }).collect(),
        morph_targets: vec![MorphTarget {
            rest_weight: 0.5,
            vertices: vec![0],
            deltas: vec![[0.0, 4.0, 0.0]],
        }],
        clips: vec![Clip { name: "Go".to_owned(), duration_s: 2.0, tracks: vec![track] }],
    }
}

fn track(property: Property, interpolation: Interpolation, values: &[f32]) -> Track {
    Track { property, interpolation, times_s: vec![0.0, 2.0], values: values.to_vec() }
}

#[test]
fn the_bound_holds_and_is_met_where_all_points_one_way() {
    let still = track(Property::MorphWeight(0), Interpolation::Linear, &[0.5, 0.0]);
    // (2 + 0.5·4)·2 = 8, then three times doubled and moved by 1.
    assert_eq!(chain(3, 2.0, still.clone()).reach(), ((8.0 * 2.0 + 1.0) * 2.0 + 1.0) * 2.0 + 1.0);
    // The same with a weight of 3 at most: (2 + 3·4)·2 = 28.
    assert_eq!(
        chain(3, 2.0, Track { values: vec![-3.0, 0.0], ..still }).reach(),
        ((28.0 * 2.0 + 1.0) * 2.0 + 1.0) * 2.0 + 1.0
    );
    let mesh = chain(
        1,
        1.0,
        track(
            Property::Translation(0),
            Interpolation::CubicSpline,
            &[
                0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 27.0, 0.0, 0.0, //
                -27.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0,
            ],
        ),
    );
    let (mut now, mut farthest) = (Vec::new(), 0.0f32);
    for step in 0..=200 {
        mesh.positions_at(&mesh.clips[0], step as f32 / 100.0, &mut now);
        farthest = farthest.max(now[0][0]);
    }
    let (bound, reached) = (mesh.reach(), f64::from(farthest));
    assert!(reached <= bound && reached > 0.5 * bound, "{reached} of {bound}");
}

#[test]
fn chains_that_overflow_are_refused_and_long_ones_are_not() {
    let still = || track(Property::Scale(0), Interpolation::Linear, &[1.0; 6]);
    let verdict = |mesh: DeformingMesh| mesh.validate(&Place::file("a.glb")).map_err(|e| e.to_string());
    assert_eq!(verdict(chain(5000, 1.0, still())), Ok(()));
    let message = verdict(chain(40, 10.0, still())).unwrap_err();
    assert!(message.contains("may take vertices") && message.contains("1e18 m are possible"), "{message}");
    let message = verdict(chain(1, 1.0, track(Property::Translation(0), Interpolation::Linear, &[1e30; 6])))
        .unwrap_err();
    assert!(message.contains("may take vertices"), "{message}");
}
