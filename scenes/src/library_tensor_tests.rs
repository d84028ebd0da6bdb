//! The scenes of the library in which light, view and materials vary together.

use crate::library_tests::{bounds, load, load_if_fetched, names};
use crate::scene::Scene;
use crate::test_support::open_edges;
use relume_formats::Place;
use relume_formats::state::Model;

/// Most vertices: so that a draft is baked in minutes.
const MAX_VERTICES: usize = 14_500;

/// Light, view and `materials` of one model vary, and nothing is left out without a word. Objects that a
/// solid is expected of by `is_solid` are closed and above the lowest of all others.
fn check(scene: &Scene, materials: &[&str], model: Model, is_solid: impl Fn(&str) -> bool) {
    assert_eq!(scene.varying_names(), materials);
    assert!(scene.vary.light && scene.vary.view && !scene.vary.shape);
    assert_eq!((scene.size, scene.reflections, scene.lights.len()), ([512, 512], 3, 0));
    assert!(scene.warnings.iter().all(|w| w.contains("made normals")), "{:?}", scene.warnings);
    assert!(scene.materials.iter().all(|material| material.brdf.model() == model));
    let vertices: usize = scene.objects.iter().map(|object| object.mesh.positions.len()).sum();
    assert!(vertices <= MAX_VERTICES, "{vertices}");
    let lowest = |solid: bool| {
        let some = scene.objects.iter().filter(|object| is_solid(&object.name) == solid);
        some.map(|object| bounds(object).0.y).fold(f32::INFINITY, f32::min)
    };
    assert!(lowest(true) >= lowest(false) - 0.002, "{} under {}", lowest(true), lowest(false));
    check_animations(scene);
}

/// They begin where they end, but for skies that have turned once, and every moment is legal.
fn check_animations(scene: &Scene) {
    assert_eq!(scene.animations.len(), 2, "{}", scene.name);
    for animation in &scene.animations {
        assert!(animation.looping, "{}", animation.name);
        let state = |time_s| {
            let mut state = animation.sample(time_s).unwrap();
            if let Some(environment) = &mut state.environment {
                environment.rotation_deg = environment.rotation_deg.map(|degrees| degrees.rem_euclid(360.0));
            }
            state
        };
        assert_eq!(state(0.0), state(animation.duration_s), "{}", animation.name);
        for moment in 0..=16u8 {
            let time_s = animation.duration_s * f32::from(moment) / 16.0;
            let place = Place::file(&animation.name);
            scene.with_state(&animation.sample(time_s).unwrap(), &place).unwrap();
        }
    }
}

fn closed(scene: &Scene, is_solid: impl Fn(&str) -> bool) {
    for object in scene.objects.iter().filter(|object| is_solid(&object.name)) {
        assert_eq!(open_edges(&object.mesh), 0, "{}", object.name);
    }
}

#[test]
fn knot_studio_loads() {
    let scene = load("knot-studio").unwrap();
    assert_eq!(scene.varying_names(), ["knot", "floor"]);
    assert_eq!(open_edges(&scene.objects[0].mesh), 0);
}

#[test]
fn chess_loads() {
    let scene = load("chess").unwrap();
    let is_man = |name: &str| name.starts_with("white-") || name.starts_with("black-");
    check(&scene, &["white", "black"], Model::CookTorrance, is_man);
    closed(&scene, is_man);
    // All stand in the middles of squares, none beside the board, no two on one square.
    let mut squares: Vec<[i32; 2]> = Vec::new();
    for man in scene.objects.iter().filter(|man| is_man(&man.name) && bounds(man).0.y < 0.001) {
        let (low, high) = bounds(man);
        let at = [(low.x + high.x) / 2.0, (low.z + high.z) / 2.0].map(|x| x / 0.055 + 3.5);
        assert!(at.iter().all(|x| (x - x.round()).abs() < 0.02 && (0.0..7.1).contains(x)), "{at:?}");
        squares.push(at.map(|x| x.round() as i32));
    }
    squares.sort_unstable();
    squares.dedup();
    assert_eq!(squares.len(), 8);
    assert_eq!(scene.materials.iter().filter(|material| material.texture.is_some()).count(), 1);
}

#[test]
fn glossy_ring_loads() {
    let scene = load("glossy-ring").unwrap();
    assert_eq!(names(&scene), ["hoop", "plane"]);
    check(&scene, &["hoop", "plane"], Model::BlinnPhong, |name| name == "hoop");
    closed(&scene, |name| name == "hoop");
}

#[test]
fn room_loads() {
    let scene = load("room").unwrap();
    check(&scene, &["sofa", "floor"], Model::CookTorrance, |_| false);
    assert_eq!(scene.materials.len(), 12);
    assert_eq!(scene.materials.iter().filter(|material| material.texture.is_some()).count(), 4);
    closed(&scene, |name| ["cushion-left", "table-top", "vase", "lamp-shade"].contains(&name));
}

#[test]
fn watch_loads() {
    let scene = load("watch").unwrap();
    check(&scene, &["metal"], Model::CookTorrance, |name| name != "table");
    closed(&scene, |name| name.starts_with("link-") || name.starts_with("lug-"));
}

#[test]
fn bunny_studio_loads_or_names_the_remedy() {
    let Some(scene) = load_if_fetched("bunny-studio", "bunny.obj") else { return };
    check(&scene, &["bunny"], Model::CookTorrance, |name| name == "bunny");
    closed(&scene, |name| name == "bunny");
}
