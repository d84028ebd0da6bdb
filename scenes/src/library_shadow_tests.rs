//! The scenes of the library in which the shape varies.

use crate::library_tests::{bounds, load, load_if_fetched, names};
use crate::scene::Scene;
use crate::test_support::open_edges;
use relume_formats::Place;
use relume_formats::shape::DeformingMesh;

/// Everything varies but materials; what asks for spheres is closed, stands on the plane, and the plane is
/// 128 × 128 vertices that face up.
fn check(scene: &Scene, deforming: &[&str]) {
    assert!(scene.vary.light && scene.vary.view && scene.vary.shape && scene.vary.materials.is_empty());
    assert_eq!((scene.reflections, scene.lights.len()), (1, 0), "{}", scene.name);
    let of_shapes = || scene.objects.iter().filter(|object| object.shape.is_some());
    assert_eq!(of_shapes().map(|object| object.name.as_str()).collect::<Vec<_>>(), deforming);
    let [solids @ .., plane] = &scene.objects[..] else { panic!("no object") };
    assert_eq!((plane.mesh.positions.len(), plane.spheres), (128 * 128, None));
    assert!(plane.mesh.normals.iter().all(|normal| *normal == [0.0, 1.0, 0.0]));
    for object in solids {
        let (low, high) = bounds(object);
        assert!((-0.002..0.002).contains(&low.y), "{} stands at {low}", object.name);
        let (edge, _) = bounds(plane);
        assert!(low.x.min(low.z).min(-high.x).min(-high.z) > edge.x, "{low} {high} on {edge}");
        assert_eq!((object.spheres, open_edges(&object.mesh)), (Some(64), 0), "{}", object.name);
    }
    for object in of_shapes() {
        let (shape, mut positions): (&DeformingMesh, _) = (object.shape.as_deref().unwrap(), Vec::new());
        shape.positions(&shape.rest_pose(), &mut positions);
        assert_eq!(positions, object.mesh.positions, "{}", object.name);
    }
    check_animations(scene);
}

/// They loop, but for cameras and angles of a whole turn and times, of which whole numbers of clips pass.
fn check_animations(scene: &Scene) {
    assert!(scene.animations.len() >= 2);
    for animation in &scene.animations {
        assert!(animation.looping, "{}", animation.name);
        let state = |time_s| {
            scene.with_state(&animation.sample(time_s).unwrap(), &Place::file(&animation.name)).unwrap()
        };
        let moved = state(animation.duration_s * 0.4);
        let poses = animation.tracks.iter().any(|track| track.leaf[0] == "shapes");
        let meshes = |scene: &Scene| {
            scene.objects.iter().map(|object| object.mesh.positions.clone()).collect::<Vec<_>>()
        };
        assert_eq!(poses, meshes(&moved) != meshes(scene), "{}", animation.name);
        assert!(moved.objects.iter().flat_map(|o| o.mesh.normals.as_flattened()).all(|x| x.is_finite()));
    }
}

#[test]
fn knot_twist_loads() {
    let scene = load("knot-twist").unwrap();
    assert_eq!((names(&scene), scene.warnings.len()), (vec!["knot", "plane"], 0), "{:?}", scene.warnings);
    check(&scene, &["knot"]);
}

#[test]
fn still_scenes_load_or_name_the_remedy() {
    for (name, asset) in [("bunny-shadow", "bunny.obj"), ("armadillo-shadow", "armadillo.off")] {
        let Some(scene) = load_if_fetched(name, asset) else { continue };
        check(&scene, &[]);
    }
}

#[test]
fn scenes_with_the_fox_load_or_name_the_remedy() {
    if let Some(scene) = load_if_fetched("fox-walk", "fox.glb") {
        check(&scene, &["fox"]);
        // Clips that are six times as long as a step end where they began.
        let walk =
            scene.objects[0].shape.as_deref().unwrap().clips.iter().find(|clip| clip.name == "Walk").unwrap();
        assert!((6.0 * walk.duration_s - 4.25).abs() < 1e-5, "{}", walk.duration_s);
    }
    if let Some(scene) = load_if_fetched("shadow-parade", "fox.glb") {
        check(&scene, &["knot", "fox"]);
    }
}
