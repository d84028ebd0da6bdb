//! The scenes of the library: they load, stand where they should, and their animations loop.

use crate::library::resolve;
use crate::painting::Painting;
use crate::scene::{ALL_REFLECTIONS, Emitter, Object, Scene};
use crate::test_support::{enclosed_volume, open_edges};
use glam::Vec3;
use relume_formats::Place;
use relume_formats::state::{Model, State, TrackValues};
use std::path::Path;

pub(crate) fn load(name: &str) -> relume_formats::Result<Scene> {
    crate::load(&resolve(name).unwrap())
}

/// Smallest and largest corner of an object.
pub(crate) fn bounds(object: &Object) -> (Vec3, Vec3) {
    let points = || object.mesh.positions.iter().copied().map(Vec3::from);
    (points().reduce(Vec3::min).unwrap(), points().reduce(Vec3::max).unwrap())
}

/// The room [−1, 1] × [0, 2] × [−1, 1] faces inwards, lit from just below the ceiling, and fills the frame.
fn check_room(scene: &Scene) {
    assert_eq!(
        scene.warnings.iter().filter(|w| !w.contains("made normals")).count(),
        0,
        "{:?}",
        scene.warnings
    );
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
    assert_eq!(
        scene.animations.iter().map(|a| a.name.as_str()).collect::<Vec<_>>(),
        ["polish", "repaint"],
        "{}",
        scene.name
    );
    for animation in &scene.animations {
        assert!(animation.looping && animation.duration_s == 4.0, "{}", animation.name);
        for track in animation.tracks.iter().filter(|t| t.times_s.len() > 1) {
            assert_eq!((track.times_s[0], *track.times_s.last().unwrap()), (0.0, 4.0));
            match &track.values {
                TrackValues::Scalar(v) => {
                    assert_eq!(v.first(), v.last(), "{}: {:?}", animation.name, track.leaf)
                }
                TrackValues::Vector(v) => {
                    assert_eq!(v.first(), v.last(), "{}: {:?}", animation.name, track.leaf)
                }
                TrackValues::Name(v) => {
                    assert_eq!(v.first(), v.last(), "{}: {:?}", animation.name, track.leaf)
                }
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
    assert_eq!(
        (scene.name.as_str(), scene.size, scene.reflections),
        ("cornell-knot", [256, 256], ALL_REFLECTIONS)
    );
    assert_eq!(scene.varying_names(), ["knot", "walls"]);
    check_room(&scene);
    check_solid(&scene.objects[0], 1.2..1.5);
    check_animations(&scene);
}

/// The scene if its asset is there; else the error is checked to say how to get it.
pub(crate) fn load_if_fetched(name: &str, asset: &str) -> Option<Scene> {
    let assets = Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap().join("assets");
    if assets.join(asset).is_file() {
        return Some(load(name).unwrap());
    }
    let error = load(name).unwrap_err();
    assert!(
        error.is_bad_input() && error.to_string().contains(&format!("no such file: `assets/{asset}`")),
        "{error}"
    );
    assert!(error.to_string().contains("run `make assets`"), "{error}");
    None
}

#[test]
fn imported_loads_or_names_the_remedy() {
    let text = std::fs::read_to_string(resolve("imported").unwrap()).unwrap();
    assert!(text.lines().count() <= 25, "a short scene file is enough");
    let Some(scene) = load_if_fetched("imported", "three-things.glb") else { return };
    assert_eq!(scene.varying_names(), ["material-5", "material-7"]);
    assert!(scene.objects.iter().all(|o| o.name == "floor" || o.name.starts_with("things/")));
    assert_eq!(scene.materials.iter().filter(|m| m.texture.is_some()).count(), 2);
    let Emitter::Directional { direction, irradiance } = scene.lights[0].emitter else {
        panic!("{:?}", scene.lights)
    };
    assert!(direction[1] < -0.8 && irradiance == [1.0; 3] && scene.lights.len() == 1);
    check_animations(&scene);
}

#[test]
fn bunny_room_loads_or_names_the_remedy() {
    let Some(scene) = load_if_fetched("bunny-room", "bunny.obj") else { return };
    assert_eq!((scene.name.as_str(), scene.size), ("bunny-room", [512, 512]));
    assert_eq!(scene.varying_names(), ["bunny", "walls"]);
    assert_eq!((scene.objects[0].mesh.positions.len(), scene.objects[0].mesh.triangles.len()), (1839, 3674));
    check_room(&scene);
    check_solid(&scene.objects[0], 1.1..1.3);
    check_animations(&scene);
}

pub(crate) fn names(scene: &Scene) -> Vec<&str> {
    scene.objects.iter().map(|o| o.name.as_str()).collect()
}

#[test]
fn ring_loads() {
    let scene = load("ring").unwrap();
    assert_eq!(
        (scene.size, scene.reflections, names(&scene)),
        ([512, 512], ALL_REFLECTIONS, vec!["ring", "plane"])
    );
    assert_eq!((scene.varying_names(), scene.warnings.len()), (vec!["ring", "plane"], 0));
    let (low, high) = bounds(&scene.objects[0]);
    assert!(low.y.abs() < 1e-6 && (high.y - 0.3).abs() < 1e-6, "it stands on the plane");
    assert_eq!(open_edges(&scene.objects[0].mesh), 0);
    // The light faces the middle of the ring, to within a degree.
    let Emitter::Area { corner, edge_u, edge_v, .. } = scene.lights[0].emitter else { panic!() };
    let (u, v) = (Vec3::from(edge_u), Vec3::from(edge_v));
    let centre = Vec3::from(corner) + (u + v) / 2.0;
    assert!(u.cross(v).normalize().dot(-centre.normalize()) > 0.9998);
    check_animations(&scene);
}

#[test]
fn statue_hall_loads() {
    let scene = load("statue-hall").unwrap();
    assert_eq!(
        (scene.size, scene.reflections, scene.warnings.len()),
        ([512, 512], ALL_REFLECTIONS, 0),
        "{:?}",
        scene.warnings
    );
    assert_eq!(scene.varying_names(), ["statue", "hoop"]);
    let textured = |name: &str| scene.materials.iter().find(|m| m.name == name).unwrap().texture.clone();
    assert!(textured("statue").is_some() && textured("hoop").is_none());
    assert_eq!((textured("brick").unwrap().size, textured("tiles").unwrap().size), ([384, 384], [256, 256]));
    // The statue stands on the plinth, the rest on the floor, and nothing leaves the hall.
    let [statue, plinth, hoop, ball] = [0, 1, 2, 3].map(|i| bounds(&scene.objects[i]));
    assert!((statue.0.y - plinth.1.y).abs() < 0.002 && plinth.0.y == 0.0, "{statue:?} {plinth:?}");
    assert!(hoop.0.y.abs() < 0.002 && ball.0.y.abs() < 0.002, "{hoop:?} {ball:?}");
    for (low, high) in [statue, plinth, hoop, ball] {
        assert!(low.min_element() > -1.0 && high.x < 1.0 && high.y < 2.0 && high.z < 1.0);
    }
    assert!(scene.objects[..4].iter().all(|o| open_edges(&o.mesh) == 0));
    for wall in ["back-wall", "left-wall", "right-wall"] {
        let mesh = &scene.objects.iter().find(|o| o.name == wall).unwrap().mesh;
        for (p, uv) in mesh.positions.iter().zip(&mesh.uvs) {
            assert!((uv[1] - (1.0 - p[1] / 2.0)).abs() < 1e-6, "bricks lie level on the {wall}");
        }
    }
    check_animations(&scene);
}

#[test]
fn showroom_loads() {
    let scene = load("showroom").unwrap();
    assert_eq!(
        (scene.size, scene.reflections, scene.warnings.len()),
        ([512, 512], ALL_REFLECTIONS, 0),
        "{:?}",
        scene.warnings
    );
    assert_eq!(scene.varying_names(), ["paint", "floor"]);
    assert!(scene.materials.iter().all(|m| m.brdf.model() == Model::Ggx) && scene.environment.is_some());
    for object in &scene.objects[..5] {
        assert_eq!(open_edges(&object.mesh), 0, "{}", object.name);
    }
    let low = |i: usize| bounds(&scene.objects[i]).0.y;
    assert!(
        (low(0) - 0.08).abs() < 0.002 && [1, 2, 3, 4].iter().all(|i| low(*i).abs() < 0.002),
        "the knot stands on its stand"
    );
    check_animations(&scene);
}

/// Every state beside a scene is one that it may be in, textures and all.
fn check_states(scene: &Scene) {
    let folder = scene.file.parent().unwrap().join("states");
    let mut count = 0;
    for file in std::fs::read_dir(&folder).unwrap().map(|entry| entry.unwrap().path()) {
        let state = State::read_file(&file).unwrap();
        let scene = scene.with_state(&state, &Place::file(&file)).unwrap();
        let painted = scene.vary.painted.iter().map(|index| &scene.materials[*index]);
        assert!(painted.clone().all(|material| material.paint.is_some()), "{}", file.display());
        count += painted.count();
    }
    assert_eq!(count, 4, "{}", folder.display());
}

#[test]
fn painted_scenes_load_with_their_textures() {
    for (name, painted) in [("cubes", "walls"), ("tube", "tube")] {
        let scene = load(name).unwrap();
        let [material] = scene.vary.painted[..] else { panic!("{name}") };
        assert_eq!(scene.materials[material].name, painted);
        assert!(!Painting::of_meshes(&scene, material).unwrap().is_empty(), "its coordinates serve");
        check_states(&scene);
    }
    let Some(scene) = load_if_fetched("bunny-painted", "bunny.obj") else { return };
    check_states(&scene);
}

/// The bunny's textures are made for the atlas that its scene gets.
#[test]
fn the_atlas_of_the_painted_bunny_is_the_one_that_its_textures_are_for() {
    let Some(scene) = load_if_fetched("bunny-painted", "bunny.obj") else { return };
    let painting = Painting::of_atlas(&scene, scene.vary.painted[0], |_| true).unwrap().unwrap();
    let text =
        std::fs::read_to_string(resolve("bunny-painted").unwrap().with_file_name("atlas.txt")).unwrap();
    let rest = |start: &'static str| text.lines().filter_map(move |line| line.strip_prefix(start));
    let numbers = |line: &str| line.split(' ').map(|x| x.parse::<f64>().unwrap()).collect::<Vec<_>>();
    let corners: Vec<Vec<f64>> = rest("t ").map(numbers).collect();
    let bunny = scene.objects.iter().position(|object| object.material == painting.material).unwrap();
    let mut triangles = 0;
    for (triangle, line) in rest("f ").enumerate() {
        for (corner, weights) in numbers(line).into_iter().zip([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]) {
            let here = painting.at(bunny, triangle, weights).unwrap();
            let there = &corners[corner as usize - 1];
            let off = (0..2).map(|k| (f64::from(here[k]) - there[k]).abs()).fold(0.0, f64::max);
            // Of 256 texels on a side a quarter; the file has five digits.
            assert!(off < 1e-3, "triangle {triangle}: {here:?}, {there:?}");
        }
        triangles += 1;
    }
    assert_eq!(triangles, scene.objects[bunny].mesh.triangles.len());
}
