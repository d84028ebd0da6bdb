//! What spheres come to in poses, against closed forms.

use super::ball::Ball;
use super::cluster::Problem;
use super::fit::{Settings, fit};
use super::motion::{Motion, poses};
use super::pieces::Pieces;
use super::solid::Solid;
use super::sphere::Sphere;
use super::test_meshes::{cuboid, mesh, open_hemisphere, two_cubes};
use crate::job::{Job, ProgressMode};
use glam::{DAffine3, DVec3};
use relume_formats::Place;
use relume_formats::shape::{
    Clip, DeformingMesh, Influences, Interpolation, Joint, Node, Property, Track, Transform,
};
use std::f64::consts::PI;
use std::sync::Arc;

fn moved(rest: &relume_scenes::Mesh, place: impl Fn([f32; 3]) -> [f32; 3]) -> Vec<[f32; 3]> {
    rest.positions.iter().map(|p| place(*p)).collect()
}

#[test]
fn the_mean_is_over_rest_and_poses_with_the_smallest_ball_in_each() {
    let rest = mesh(cuboid(DVec3::ZERO, DVec3::ONE));
    let solid = Solid::of(&rest, &Place::file("cube")).unwrap();
    let larger = moved(&rest, |p| p.map(|x| 2.0 * x + 5.0));
    let longer = moved(&rest, |[x, y, z]| [3.0 * x, y, z]);
    let pieces = Pieces::new(&solid.surface, 10.0);
    let motion = Motion::new(&solid, &[larger, longer]);
    let problem = Problem { solid: &solid.boundary, pieces, slack: 0.0, motion: &motion };
    let all: Vec<u32> = (0..problem.pieces.len() as u32).collect();
    // A centre of its own at rest: a ball about the centre that reaches farther than it must.
    let sphere = Sphere::new(&solid.boundary, Ball::new(DVec3::splat(0.5), 1.5), Arc::new(all));
    let ball = |squared_diameter: f64| PI / 6.0 * squared_diameter.powf(1.5);
    let (at_rest, twice, thrice) =
        (4.0 / 3.0 * PI * 1.5_f64.powi(3) - 1.0, ball(12.0) - 8.0, ball(11.0) - 3.0);
    let wanted = (at_rest + twice + thrice) / 3.0;
    assert!((problem.cost(&[sphere]) - wanted).abs() < 1e-9 * wanted);
}

#[test]
fn cubes_that_part_share_no_sphere() {
    let rest = mesh(two_cubes(DVec3::X * 1.05));
    let apart = moved(&rest, |[x, y, z]| if x > 1.02 { [x + 4.0, y, z] } else { [x, y, z] });
    let settings = Settings { spheres: 3, seed: 1, iterations: 40, tight: 0.0 };
    let job = Job::new(ProgressMode::None);
    let shared = |poses: &[Vec<[f32; 3]>]| {
        let set = fit(&rest, poses, "cubes", &Place::file("cubes"), &settings, &job).unwrap().set;
        assert_eq!((set.meta.poses as usize, set.meta.quality.coverage_surface), (poses.len(), 1.0));
        assert!(set.history.windows(2).all(|w| w[1] <= w[0]));
        (0..3)
            .filter(|s| [false, true].iter().all(|right| members(&set, *s).any(|p| (p[0] > 1.02) == *right)))
            .count()
    };
    // Three spheres for two cubes: at rest one of them covers some of both.
    assert_eq!((shared(&[]), shared(&[apart])), (1, 0));
}

#[test]
fn a_solid_of_the_winding_number_is_fitted_at_rest_and_says_so() {
    let rest = mesh(open_hemisphere(8, 3));
    let larger = moved(&rest, |p| p.map(|x| 2.0 * x));
    let settings = Settings { spheres: 2, seed: 0, iterations: 2, tight: 0.0 };
    let found = fit(&rest, &[larger], "bowl", &Place::file("bowl"), &settings, &Job::new(ProgressMode::None))
        .unwrap();
    assert_eq!(found.set.meta.poses, 0);
    assert!(found.notes.iter().any(|note| note.contains("without a look at its clips")), "{:?}", found.notes);
}

fn members(set: &relume_formats::kinds::SphereSet, sphere: u32) -> impl Iterator<Item = &[f32; 3]> {
    set.points.iter().zip(&set.clusters).filter(move |(_, c)| **c == sphere).map(|(p, _)| p)
}

/// A point that clips carry along X, a metre a second for five seconds.
fn carried(clips: usize) -> DeformingMesh {
    let still = Transform::Parts { translation: [0.0; 3], rotation: [0.0, 0.0, 0.0, 1.0], scale: [1.0; 3] };
    let clip = |k: usize| {
        let values = vec![0.0, 0.0, 0.0, 5.0, 0.0, 0.0];
        let track = Track {
            property: Property::Translation(0),
            interpolation: Interpolation::Linear,
            times_s: vec![0.0, 5.0],
            values,
        };
        Clip { name: k.to_string(), duration_s: 5.0, tracks: vec![track] }
    };
    DeformingMesh {
        positions: vec![[0.0; 3]],
        influences: vec![Influences::rigid(0)],
        joints: vec![Joint { node: 0, node_from_mesh: DAffine3::IDENTITY }],
        nodes: vec![Node { parent: None, rest: still }],
        morph_targets: Vec::new(),
        clips: (0..clips).map(clip).collect(),
    }
}

#[test]
fn poses_are_spread_over_the_clips() {
    let along = |clips: usize| poses(&carried(clips)).into_iter().map(|p| p[0][0]).collect::<Vec<f32>>();
    assert!(along(0).is_empty());
    assert_eq!(along(1), [0.0, 1.0, 2.0, 3.0, 4.0]);
    // Every third of fifty.
    let many = along(10);
    assert_eq!((many.len(), &many[..4]), (17, [0.0, 3.0, 1.0, 4.0].as_slice()));
}
