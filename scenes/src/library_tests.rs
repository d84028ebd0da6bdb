//! The scenes of the library: they load, stand where they should, and their animations loop.

use crate::library::resolve;
use crate::scene::{Emitter, Object, Scene};
use crate::test_support::{enclosed_volume, open_edges};
use glam::Vec3;
use relume_formats::state::TrackValues;
use std::path::Path;

fn load(name: &str) -> relume_formats::Result<Scene> {
    crate::load(&resolve(name).unwrap())
}

/// Smallest and largest corner of an object.
fn bounds(object: &Object) -> (Vec3, Vec3) {
    let points = || object.mesh.positions.iter().copied().map(Vec3::from);
    (points().reduce(Vec3::min).unwrap(), points().reduce(Vec3::max).unwrap())
}

/// The room [−1, 1] × [0, 2] × [−1, 1] faces inwards, lit from just below the ceiling, and fills the frame.
fn check_room(scene: &Scene) {
    assert_eq!(scene.warnings.iter().filter(|w| !w.contains("smooth normals")).count(), 0, "{:?}", scene.warnings);
    let centre = Vec3::new(0.0, 1.0, 0.0);
    let walls: Vec<&Object> = scene.objects.iter().filter(|o| o.mesh.triangles.len() == 2).collect();
    assert_eq!(walls.len(), 5);
    for wall in walls {
        let (low, high) = bounds(wall);
        assert_eq!(((low + high) / 2.0).distance(centre), 1.0, "{}", wall.name);
        let [a, b, c] = wall.mesh.triangles[0].map(|v| Vec3::from(wall.mesh.positions[v as usize]));
        assert!((b - a).cross(c - a).dot(centre - a) > 0.0, "{} faces inwards", wall.name);
    }
    let Emitter::Area { corner, edge_u, edge_v, .. } = scene.lights[0].emitter else { panic!() };
    let down = Vec3::from(edge_u).cross(edge_v.into());
    assert!(down.y < -0.4 && down.x == 0.0 && down.z == 0.0 && (1.99..2.0).contains(&corner[1]));
    // The corners of the frame meet the room's open side within its walls, but not far from them.
    let film = scene.camera.film(scene.size[0], scene.size[1]);
    let eye = Vec3::from(film.eye_in_world);
    let direction = Vec3::from(film.direction(0.0, 0.0));
    let at_opening = eye + direction * ((1.0 - eye.z) / direction.z);
    assert!((-1.0..-0.95).contains(&at_opening.x) && (1.95..2.0).contains(&at_opening.y), "{at_opening}");
}

/// `object` stands on the floor, inside the room, and is a closed solid.
fn check_solid(object: &Object, height: std::ops::Range<f32>) {
    let (low, high) = bounds(object);
    assert!((-0.002..0.002).contains(&low.y), "{} stands on the floor: {low}", object.name);
    assert!(height.contains(&high.y), "{high}");
    assert!(low.x > -0.8 && high.x < 0.8 && low.z > -0.8 && high.z < 0.8, "{low} {high}");
    assert!(((low.x + high.x) / 2.0).abs() < 0.05, "in the middle: {low} {high}");
    assert_eq!(open_edges(&object.mesh), 0);
    assert!(enclosed_volume(&object.mesh) > 0.0);
}

fn check_animations(scene: &Scene) {
    assert_eq!(scene.animations.iter().map(|a| a.name.as_str()).collect::<Vec<_>>(), ["polish", "repaint"]);
    for animation in &scene.animations {
        assert!(animation.looping && animation.duration_s == 4.0, "{}", animation.name);
        for track in animation.tracks.iter().filter(|t| t.times_s.len() > 1) {
            assert_eq!((track.times_s[0], *track.times_s.last().unwrap()), (0.0, 4.0));
            match &track.values {
                TrackValues::Scalar(v) => assert_eq!(v.first(), v.last(), "{}: {:?}", animation.name, track.leaf),
                TrackValues::Vector(v) => assert_eq!(v.first(), v.last(), "{}: {:?}", animation.name, track.leaf),
                TrackValues::Name(v) => assert_eq!(v.first(), v.last(), "{}: {:?}", animation.name, track.leaf),
            }
        }
        // They may name nothing but what the bundle will vary.
        let state = animation.sample(0.0).unwrap();
        assert!(state.materials.keys().all(|name| scene.varying_names().contains(&name.as_str())));
    }
}

#[test]
fn cornell_knot_loads() {
    let scene = load("cornell-knot").unwrap();
    assert_eq!((scene.name.as_str(), scene.size, scene.reflections), ("cornell-knot", [256, 256], 2));
    assert_eq!(scene.varying_names(), ["knot", "walls"]);
    check_room(&scene);
    check_solid(&scene.objects[0], 1.2..1.5);
    check_animations(&scene);
}

#[test]
fn bunny_room_loads_or_names_the_remedy() {
    let bunny = Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap().join("assets/bunny.obj");
    if !bunny.is_file() {
        let error = load("bunny-room").unwrap_err();
        assert!(error.is_bad_input() && error.to_string().contains("bunny.obj: no such file"), "{error}");
        assert!(error.to_string().contains("run `make assets`"), "{error}");
        return;
    }
    let scene = load("bunny-room").unwrap();
    assert_eq!((scene.name.as_str(), scene.size), ("bunny-room", [512, 512]));
    assert_eq!(scene.varying_names(), ["bunny", "walls"]);
    assert_eq!((scene.objects[0].mesh.positions.len(), scene.objects[0].mesh.triangles.len()), (1839, 3674));
    check_room(&scene);
    check_solid(&scene.objects[0], 1.1..1.3);
    check_animations(&scene);
}
