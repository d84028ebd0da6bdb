//! Fitted spheres on meshes that deform: they keep every vertex covered, and do not swell.

use crate::support::job;
use glam::{DAffine3, DVec3, Quat, Vec3};
use relume_bake::spheres::fit::{DEFAULT_ITERATIONS, Settings, fit};
use relume_bake::spheres::motion::poses;
use relume_bake::spheres::relative_outside;
use relume_formats::Place;
use relume_formats::evaluate::sphere_set::Follower;
use relume_formats::kinds::SphereSet;
use relume_formats::shape::{
    Clip, DeformingMesh, Influences, Interpolation, Joint, Node, Property, Track, Transform,
};
use relume_scenes::{Deforming, Mesh};
use std::path::Path;

/// Poses looked at in each clip.
const FRAMES: u32 = 12;

/// Fits `n` spheres at rest and follows every clip. Every vertex stays in its own sphere, so in the union,
/// and E/V(T) of each pose, against the mesh of that pose, stays below twice that at rest.
fn expect_covered(shape: &Deforming, n: usize) {
    let place = Place::file("a mesh that deforms");
    let settings = Settings { spheres: n, seed: 0, iterations: DEFAULT_ITERATIONS, tight: 0.0 };
    let set = fit(&shape.rest, &poses(&shape.shape), "mesh", &place, &settings, &job()).unwrap().set;
    let at_rest = relative_outside(&shape.rest, &set.spheres, &place).unwrap();
    let stated = set.meta.relative_outside_volume();
    // The fit's own figure, computed from the same spheres rounded to f32.
    assert!((at_rest - stated).abs() < 1e-3 * (1.0 + stated), "{at_rest} at rest, the file says {stated}");
    let follower = Follower::new(&set);
    let (mut positions, mut spheres) = (Vec::new(), Vec::new());
    assert!(!shape.shape.clips.is_empty());
    let mut worst = (at_rest, "rest".to_owned());
    for clip in &shape.shape.clips {
        for frame in 0..FRAMES {
            let time_s = clip.duration_s * frame as f32 / (FRAMES - 1) as f32;
            shape.shape.positions_at(clip, time_s, &mut positions);
            follower.follow(&positions, &mut spheres).unwrap();
            let at = format!("{} at {time_s} s", clip.name);
            expect_vertices_inside(&set, &positions, &spheres, &at);
            let mesh = Mesh { positions: positions.clone(), ..shape.rest.clone() };
            let now = relative_outside(&mesh, &spheres, &place).unwrap();
            if now > worst.0 {
                worst = (now, at);
            }
        }
    }
    println!("E/V(T) {at_rest} at rest, {} at {}", worst.0, worst.1);
    assert!(worst.0 < 2.0 * at_rest, "{}: E/V(T) {}, at rest {at_rest}", worst.1, worst.0);
}

fn expect_vertices_inside(set: &SphereSet, positions: &[[f32; 3]], spheres: &[[f32; 4]], at: &str) {
    for (vertex, (position, cluster)) in positions.iter().zip(&set.clusters).enumerate() {
        let [x, y, z, radius] = spheres[*cluster as usize];
        let distance = Vec3::from(*position).as_dvec3().distance(Vec3::new(x, y, z).as_dvec3());
        assert!(
            distance <= f64::from(radius),
            "{at}: vertex {vertex} is {distance} from its sphere, whose radius is {radius}"
        );
    }
}

/// Rings along the bar, and its length over its width.
const RINGS: u32 = 25;
const LENGTH: f32 = 6.0;

/// A square bar along Y whose upper half follows a second joint, which bends by 60° and twists by as much;
/// between the joints weights blend.
fn bar() -> Deforming {
    let corners = [[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]];
    let height = |ring: u32| LENGTH * ring as f32 / (RINGS - 1) as f32;
    let positions: Vec<[f32; 3]> =
        (0..RINGS).flat_map(|ring| corners.map(|[x, z]| [x, height(ring), z])).collect();
    let mut triangles = vec![[0, 1, 2], [0, 2, 3]];
    for ring in 0..RINGS - 1 {
        for side in 0..4 {
            let (a, b) = (4 * ring + side, 4 * ring + (side + 1) % 4);
            triangles.extend([[a, a + 4, b], [b, a + 4, b + 4]]);
        }
    }
    let top = 4 * (RINGS - 1);
    triangles.extend([[top, top + 2, top + 1], [top, top + 3, top + 2]]);
    let normals = positions.iter().map(|[x, _, z]| Vec3::new(*x, 0.0, *z).normalize().to_array()).collect();
    let rest = Mesh { positions: positions.clone(), normals, uvs: Vec::new(), triangles };

    let middle = Vec3::new(0.0, LENGTH / 2.0, 0.0);
    let still = Transform::Parts { translation: [0.0; 3], rotation: [0.0, 0.0, 0.0, 1.0], scale: [1.0; 3] };
    let bent =
        Transform::Parts { translation: middle.to_array(), rotation: [0.0, 0.0, 0.0, 1.0], scale: [1.0; 3] };
    let influences = |[_, y, _]: &[f32; 3]| {
        let upper = ((y - 0.35 * LENGTH) / (0.3 * LENGTH)).clamp(0.0, 1.0);
        Influences { joints: [0, 1, 0, 0], weights: [1.0 - upper, upper, 0.0, 0.0] }
    };
    let turn = |name: &str, axis: Vec3| {
        let keys = [0.0, 60f32.to_radians()].map(|angle| Quat::from_axis_angle(axis, angle).to_array());
        let (property, interpolation) = (Property::Rotation(1), Interpolation::Linear);
        let track = Track { property, interpolation, times_s: vec![0.0, 1.0], values: keys.concat() };
        Clip { name: name.to_owned(), duration_s: 1.0, tracks: vec![track] }
    };
    let shape = DeformingMesh {
        influences: positions.iter().map(influences).collect(),
        positions,
        joints: vec![
            Joint { node: 0, node_from_mesh: DAffine3::IDENTITY },
            Joint { node: 1, node_from_mesh: DAffine3::from_translation(-DVec3::from(middle)) },
        ],
        nodes: vec![Node { parent: None, rest: still }, Node { parent: Some(0), rest: bent }],
        morph_targets: Vec::new(),
        clips: vec![turn("bend", Vec3::X), turn("twist", Vec3::Y)],
    };
    shape.validate(&Place::file("bar")).unwrap();
    Deforming { rest, shape }
}

#[test]
fn a_bar_that_bends_and_twists_stays_covered() {
    expect_covered(&bar(), 16);
}

#[test]
#[ignore = "needs `make assets`"]
fn the_fox_stays_covered_in_all_its_clips() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../assets/fox.glb");
    expect_covered(&relume_scenes::load_deforming(&path, &mut Vec::new()).unwrap(), 64);
}
