//! Whole fits: what they promise of any mesh.

use super::ball::Ball;
use super::coverage::uncovered_corners;
use super::fit::{Fit, Settings, fit, relative_outside};
use super::solid::Solid;
use super::test_meshes::{
    cuboid, flipped_face_cube, icosphere, l_shape, mesh, open_hemisphere, thin_plate, torus, two_cubes,
};
use crate::job::{Job, ProgressMode};
use glam::{DVec3, Vec3};
use relume_formats::Place;
use relume_formats::kinds::SphereSet;
use relume_scenes::Mesh;

const QUICK: Settings = Settings { spheres: 8, seed: 3, iterations: 24, tight: 0.0 };

fn fitted(mesh: &Mesh, settings: Settings) -> Fit {
    fit(mesh, &[], "test", &Place::file("test.obj"), &settings, &Job::new(ProgressMode::None)).unwrap()
}

fn balls(set: &SphereSet) -> Vec<Ball> {
    set.spheres
        .iter()
        .map(|[x, y, z, r]| Ball::new(Vec3::new(*x, *y, *z).as_dvec3(), f64::from(*r)))
        .collect()
}

/// Coverage by the exact check, radii, the history, and the stored volume against one computed anew.
fn assert_whole(mesh: &Mesh, settings: Settings, what: &str) -> Fit {
    let found = fitted(mesh, settings);
    let SphereSet { meta, history, spheres, .. } = &found.set;
    assert_eq!(spheres.len(), settings.spheres, "{what}");
    assert!(spheres.iter().all(|s| s[3] > 0.0), "{what}: {spheres:?}");
    assert!(history.windows(2).all(|w| w[1] <= w[0]), "{what}: {history:?}");
    let solid = Solid::of(mesh, &Place::file("test.obj")).unwrap();
    let grown: Vec<Ball> = balls(&found.set)
        .iter()
        .map(|b| Ball::new(b.centre, b.radius + (settings.tight + 1e-6) * solid.diagonal))
        .collect();
    assert_eq!(uncovered_corners(&solid.surface, &solid.boundary, &grown), [], "{what}");
    if settings.tight == 0.0 {
        assert_eq!(
            (meta.quality.coverage_surface, meta.quality.coverage_volume, meta.quality.largest_gap),
            (1.0, 1.0, 0.0),
            "{what}"
        );
    }
    let again = relative_outside(mesh, spheres, &Place::file("test.obj")).unwrap();
    assert!(
        (again - meta.relative_outside_volume()).abs() < 1e-9 * (1.0 + again),
        "{what}: {again} {meta:?}"
    );
    found
}

#[test]
fn every_kind_of_mesh_is_covered_whole_and_never_gets_worse() {
    let meshes = [
        ("thin plate", mesh(thin_plate())),
        ("L", mesh(l_shape())),
        ("two cubes", mesh(two_cubes(DVec3::new(3.0, 0.5, 0.0)))),
        ("torus", mesh(torus(1.0, 0.35, 24, 12))),
        ("open hemisphere", mesh(open_hemisphere(24, 8))),
        ("flipped face", mesh(flipped_face_cube())),
    ];
    for (name, mesh) in &meshes {
        assert_whole(mesh, QUICK, name);
    }
}

#[test]
fn one_sphere_is_the_smallest_that_encloses_all() {
    // Of a box it is the one through its corners.
    let found = assert_whole(
        &mesh(cuboid(DVec3::new(-1.0, 0.0, 2.0), DVec3::new(2.0, 2.0, 3.0))),
        Settings { spheres: 1, ..QUICK },
        "box",
    );
    let [x, y, z, r] = found.set.spheres[0].map(f64::from);
    assert!(DVec3::new(x, y, z).distance(DVec3::new(0.5, 1.0, 2.5)) < 1e-4, "{:?}", found.set.spheres);
    assert!((r / (14.0_f64.sqrt() / 2.0) - 1.0).abs() < 1e-5);
    // A ball is found, up to the volume that its facets lack: V(T) is 0.9907 of the ball's.
    let found = assert_whole(&mesh(icosphere(3)), Settings { spheres: 1, ..QUICK }, "icosphere");
    assert_eq!(found.set.meta.triangles, 1280);
    assert!(found.set.meta.relative_outside_volume() < 0.02, "{}", found.set.meta.relative_outside_volume());
}

#[test]
fn more_spheres_than_needed_all_have_a_size() {
    assert_whole(&mesh(icosphere(1)), Settings { spheres: 200, iterations: 8, ..QUICK }, "icosphere");
}

#[test]
fn more_spheres_and_more_iterations_leave_less_outside() {
    let torus = mesh(torus(1.0, 0.35, 24, 12));
    let outside = |spheres, iterations| {
        fitted(&torus, Settings { spheres, iterations, ..QUICK }).set.meta.relative_outside_volume()
    };
    let (few, more, longer) = (outside(4, 16), outside(16, 16), outside(16, 64));
    // Sixteen in a ring stand out by less than a quarter of what four do; see the module of this test's
    // subject for the algebra of a chain.
    assert!(more < 0.5 * few && longer <= more, "{few} {more} {longer}");
}

#[test]
fn a_tight_fit_leaves_what_it_may_and_is_smaller() {
    let torus = mesh(torus(1.0, 0.35, 24, 12));
    let whole = assert_whole(&torus, QUICK, "whole");
    let tight = assert_whole(&torus, Settings { tight: 0.01, ..QUICK }, "tight");
    let quality = tight.set.meta.quality;
    let limit = (0.01 + 2e-5) * f64::from(tight.set.meta.diagonal);
    assert!(quality.largest_gap > 0.0 && quality.largest_gap <= limit, "{quality:?}");
    assert!(tight.set.meta.relative_outside_volume() < 0.9 * whole.set.meta.relative_outside_volume());
}

#[test]
fn one_seed_gives_one_set_at_any_number_of_threads() {
    let l = mesh(l_shape());
    let pool = |threads| rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
    let one = pool(1).install(|| fitted(&l, QUICK));
    assert_eq!(one, pool(3).install(|| fitted(&l, QUICK)));
    assert_ne!(one.set.spheres, fitted(&l, Settings { seed: 4, ..QUICK }).set.spheres);
}

#[test]
fn what_encloses_nothing_or_too_much_is_asked_for_is_refused() {
    let sheet = mesh((vec![DVec3::ZERO, DVec3::X, DVec3::Y], vec![[0, 1, 2]]));
    let refused = |mesh: &Mesh, settings| {
        fit(mesh, &[], "m", &Place::file("m.obj"), &settings, &Job::new(ProgressMode::None))
            .unwrap_err()
            .to_string()
    };
    assert!(refused(&sheet, QUICK).contains("volume"), "{}", refused(&sheet, QUICK));
    for spheres in [0, 5000] {
        assert!(refused(&mesh(l_shape()), Settings { spheres, ..QUICK }).contains("1 to 4096"));
    }
}
