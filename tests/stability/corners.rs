//! Where surfaces meet: what lies in the plane of another surface sees it edge-on, and is lit as what is beside it.

use crate::shadows::{BALL, Bundle};
use crate::support::relit::{self, wanted};
use crate::support::{mean_radiance, scene};
use glam::Vec3A;
use relume_scenes::Scene;

/// The floor and two walls of a room that is open to the sky and to two sides, and a ball outside.
fn room(text: &str) -> String {
    let mut text = text.replace("translation = [0.0, 1.0, 0.0]", "translation = [6.0, 1.0, 6.0]");
    let material = if text.contains("materials.white") { "white" } else { "plane" };
    for (name, place, turn) in
        [("west", "[-2.0, 2.0, 0.0]", "[0, 0, -90]"), ("north", "[0.0, 2.0, -2.0]", "[90, 0, 0]")]
    {
        let wall = format!(
            "[[object]]\n name = '{name}'\n shape = 'quad'\n segments = 4\n material = '{material}'\n \
             transform = {{ translation = {place}, rotation_deg = {turn}, scale = 4.0 }}\n"
        );
        text = text.replace("[environment]", &format!("{wall}[environment]"));
    }
    text
}

/// The vertices of floor and walls, each with what the path tracer sees of a white surface a little within them.
fn truths(scene: &Scene) -> Vec<(usize, Vec3A, f64)> {
    let middle = Vec3A::new(0.0, 2.0, 0.0);
    let vertices = scene.objects.iter().flat_map(|object| {
        let placed = object.mesh.positions.iter().zip(&object.mesh.normals);
        placed.map(|(position, normal)| (&object.name, Vec3A::from(*position), Vec3A::from(*normal)))
    });
    let of_room =
        vertices.enumerate().filter(|(_, (name, ..))| ["plane", "west", "north"].contains(&name.as_str()));
    let truth = |(vertex, (_, position, normal)): (usize, (_, Vec3A, Vec3A))| {
        let beside = position + 1e-3 * (middle - position).reject_from(normal);
        let (mean, _) = mean_radiance(scene, 1, 1 << 12, |_| (beside + normal * 1e-3, -normal));
        (vertex, position, mean)
    };
    of_room.step_by(3).map(truth).collect()
}

/// What is in the very corner sees a quarter of the light; all else is as bright as rays say.
#[track_caller]
fn expect_room(scene: &Scene, shown: &[f64], bound: f64) {
    let corner = Vec3A::new(-2.0, 0.0, -2.0);
    let mut in_corner = 0;
    let (mut worst, mut place) = (0.0f64, Vec3A::ZERO);
    let positions = scene.objects.iter().flat_map(|object| &object.mesh.positions);
    for (position, shown) in positions.zip(shown).filter(|(p, _)| Vec3A::from(**p).distance(corner) < 1e-5) {
        assert!((shown - 0.25).abs() < bound, "{position:?}: {shown}");
        in_corner += 1;
    }
    assert_eq!(in_corner, 3, "floor and walls");
    for (vertex, position, truth) in truths(scene) {
        if (shown[vertex] - truth).abs() > worst {
            (worst, place) = ((shown[vertex] - truth).abs(), position);
        }
    }
    println!("off by {worst:.4} at {place}");
    assert!(worst < bound, "{worst} at {place}");
}

#[test]
fn a_room_by_sphere_shadows() {
    let text = room(BALL);
    let bundle = Bundle::bake(&text);
    let shown: Vec<f64> = bundle.shown(0.0, None).iter().map(|rgb| f64::from(rgb[1])).collect();
    expect_room(&scene(&text), &shown, 0.03);
}

#[test]
fn a_room_by_sparse_transfer() {
    let colour = "kd = [0.2, 0.5, 0.8]";
    assert!(relit::BALL.contains(colour));
    let scene = scene(&room(&relit::BALL.replace(colour, "kd = [1.0, 1.0, 1.0]")));
    let baked = relit::bake(&scene, wanted(4, 256));
    let shown: Vec<f64> = baked.under_texels(&vec![1.0; 6 * 64 * 64]).into_iter().map(f64::from).collect();
    expect_room(&scene, &shown, 0.03);
}
