//! Scenes whose objects deform.

use super::{File, arm};
use crate::Scene;
use crate::test_support::Scratch;
use glam::{DAffine3, DQuat, DVec3, Vec3};
use relume_formats::Place;
use relume_formats::state::{State, parse_toml};

const TEXT: &str = r#"
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
name = "arm"
file = "t.gltf"
material = "clay"
transform = { translation = [1, 2, 3], rotation_deg = [0, 0, 90], scale = 2 }
[[object]]
name = "plane"
shape = "quad"
material = "clay"
"#;

/// The arm with a clip that takes its elbow, and one that takes its root, up along x.
fn moving() -> File {
    let mut file = arm();
    file.animate("Stretch", 2, "translation", "LINEAR", &[0.0, 2.0], &[[1.0, 0.0, 0.0], [3.0, 0.0, 0.0]]);
    file.animate("Slide", 0, "translation", "LINEAR", &[0.0, 2.0], &[[0.0, 10.0, 0.0], [4.0, 10.0, 0.0]]);
    file
}

fn scene_of(file: &File, text: &str) -> Scene {
    let folder = tempfile::tempdir().unwrap();
    let scratch = Scratch::scene(text);
    scratch.write("t.gltf", std::fs::read(file.write(&folder)).unwrap());
    scratch.load().unwrap()
}

fn at(scene: &Scene, state: &str) -> Result<Scene, String> {
    let place = Place::file("s.toml");
    let state: State = parse_toml(state, &place).unwrap();
    scene.with_state(&state, &place).map_err(|e| e.to_string())
}

fn world_from_file() -> DAffine3 {
    DAffine3::from_scale_rotation_translation(
        DVec3::splat(2.0),
        DQuat::from_rotation_z(std::f64::consts::FRAC_PI_2),
        DVec3::new(1.0, 2.0, 3.0),
    )
}

#[test]
fn an_object_keeps_what_moves_it_where_it_stands() {
    let scene = scene_of(&moving(), TEXT);
    let (object, mut out) = (&scene.objects[0], Vec::new());
    let shape = object.shape.as_deref().unwrap();
    shape.positions(&shape.rest_pose(), &mut out);
    assert_eq!(out, object.mesh.positions);
    assert!(scene.objects[1].shape.is_none(), "a shape without clips never moves");
    let fixed = scene_of(&moving(), &TEXT.replace("shape = true", "shape = false"));
    assert_eq!((fixed.objects[0].shape.is_none(), &fixed.objects[0].mesh), (true, &object.mesh));
    assert!(scene_of(&arm(), TEXT).objects[0].shape.is_none(), "a skin alone moves nothing");
}

#[test]
fn a_state_poses_an_object_and_leaves_the_others() {
    let scene = scene_of(&moving(), TEXT);
    let rest = &scene.objects[0].mesh;
    // Half of a slide moves all by 2 along the file's x, and turns no normal; -1.5 s is 0.5 s of 2 s, a
    // quarter.
    for (state, moved) in [
        ("shapes.arm = { clip = \"Slide\", time_s = 1.0 }", 2.0),
        ("shapes.arm = { clip = \"Slide\", time_s = -1.5 }", 1.0),
    ] {
        let posed = at(&scene, state).unwrap();
        let way = world_from_file().transform_vector3(DVec3::X * moved);
        for (now, before) in posed.objects[0].mesh.positions.iter().zip(&rest.positions) {
            // Coordinates of up to 30 in f32.
            assert!(
                (Vec3::from(*now).as_dvec3() - Vec3::from(*before).as_dvec3()).distance(way) < 1e-5,
                "{now:?} {before:?}"
            );
        }
        for (now, before) in posed.objects[0].mesh.normals.iter().zip(&rest.normals) {
            assert!(Vec3::from(*now).distance(Vec3::from(*before)) < 1e-5);
        }
        assert!(std::sync::Arc::ptr_eq(&posed.objects[1].mesh, &scene.objects[1].mesh));
    }
    for same in ["shapes.arm.clip = \"Stretch\"", "shapes.arm = {}"] {
        assert_eq!(&at(&scene, same).unwrap().objects[0].mesh.positions, &rest.positions, "{same}");
    }
}

#[test]
fn states_that_no_object_can_take_are_refused() {
    let scene = scene_of(&moving(), TEXT);
    for (state, part) in [
        ("shapes.arn.time_s = 1", "s.toml: no object that deforms `arn`; did you mean `arm`?"),
        ("shapes.plane.time_s = 1", "no object that deforms `plane`"),
        ("shapes.arm.time_s = 1", "shape `arm`: time_s needs a clip; add `clip`, one of `Stretch`, `Slide`"),
        ("shapes.arm.clip = \"Walk\"", "shape `arm`: no clip `Walk`; it has `Stretch`, `Slide`"),
        ("shapes.arm = { clip = \"Slide\", time_s = inf }", "shape `arm`: time_s must be a finite number"),
    ] {
        let message = at(&scene, state).unwrap_err();
        assert!(message.contains(part), "{message}");
    }
}

#[test]
fn who_brings_its_own_materials_is_told_that_it_stands_still() {
    let scene = scene_of(&moving(), &TEXT.replacen("material = \"clay\"\n", "", 1));
    assert!(scene.objects.iter().all(|object| object.shape.is_none()));
    assert!(
        scene
            .warnings
            .iter()
            .any(|w| w.contains("object `arm`: brings its materials, so that it does not deform")),
        "{:?}",
        scene.warnings
    );
}
