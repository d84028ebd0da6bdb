//! Measures of fits against closed forms.

use super::ball::Ball;
use super::measure::measure;
use super::solid::Solid;
use super::test_meshes::{cuboid, icosphere, mesh};
use glam::DVec3;
use relume_formats::Place;
use std::f64::consts::PI;

fn cube() -> Solid {
    Solid::of(&mesh(cuboid(DVec3::splat(-1.0), DVec3::ONE)), &Place::file("cube.obj")).unwrap()
}

#[test]
fn one_ball_around_a_cube_has_the_closed_forms() {
    let solid = cube();
    let radius = 3.0_f64.sqrt();
    let quality = measure(&solid, &[Ball::new(DVec3::ZERO, radius)], 1e-9);
    assert_eq!((quality.coverage_surface, quality.coverage_volume, quality.largest_gap), (1.0, 1.0, 0.0));
    assert!(quality.overlap.abs() < 1e-12);
    // The farthest point is above a face's centre; of 20,000 points one is within 0.02 of it, which lowers it
    // by 0.02²/2R.
    let protrusion = quality.protrusion;
    assert!((radius - 1.0 - protrusion.max).abs() < 2e-4 && protrusion.max <= radius - 1.0, "{protrusion:?}");
    // On the sphere the part above a face is x > |y|, |z|, and the distance is x − 1 where |y|, |z| <= 1:
    // everywhere. The mean of x over the part is R ∫ cos over a cube's face / (4π/6).
    let steps = 1000;
    let middle = |i: i32| (f64::from(i) + 0.5) / f64::from(steps) * 2.0 - 1.0;
    let (mut flux, mut angle, mut area) = (0.0, 0.0, (2.0 / f64::from(steps)).powi(2));
    for (u, v) in (0..steps).flat_map(|i| (0..steps).map(move |j| (middle(i), middle(j)))) {
        let squared = 1.0 + u * u + v * v;
        angle += area / squared.powf(1.5);
        // Where |y| or |z| passes 1 the nearest point is on an edge or corner.
        let at = DVec3::new(1.0, u, v) * (radius / squared.sqrt());
        flux += area / squared.powf(1.5) * at.distance(at.clamp(DVec3::splat(-1.0), DVec3::ONE));
    }
    area = 4.0 * PI / 6.0;
    assert!((angle - area).abs() < 1e-5);
    assert!((protrusion.mean - flux / angle).abs() < 1e-3, "{protrusion:?} {}", flux / angle);
    assert!(protrusion.mean < protrusion.p95 && protrusion.p95 < protrusion.max);
}

#[test]
fn a_ball_that_is_too_small_leaves_a_known_gap_and_share() {
    let solid = cube();
    // The inscribed ball, less a tolerance that gives it back.
    let quality = measure(&solid, &[Ball::new(DVec3::ZERO, 0.9)], 0.1);
    assert!((quality.largest_gap - (3.0_f64.sqrt() - 0.9)).abs() <= 2e-9 * solid.diagonal, "{quality:?}");
    // Stratified points err by less than random ones: four sigma of those.
    let share = PI / 6.0;
    let bound = |points: f64| 4.0 * (share * (1.0 - share) / points).sqrt();
    assert!((quality.coverage_volume - share).abs() < bound(262_144.0), "{quality:?} {share}");
    assert!((quality.overlap - (share * 0.9_f64.powi(3) - 1.0)).abs() < 1e-12);
    assert_eq!(quality.protrusion.max, 0.0);
    // Touches the faces only.
    assert!(quality.coverage_surface < 1e-4);
    // A disc of radius 1/2 on each face.
    let quality = measure(&solid, &[Ball::new(DVec3::ZERO, 1.25_f64.sqrt())], 0.0);
    let share = PI / 16.0;
    assert!(
        (quality.coverage_surface - share).abs() < 4.0 * (share * (1.0 - share) / 65_536.0).sqrt(),
        "{quality:?}"
    );
}

#[test]
fn a_hair_uncovered_is_less_than_all() {
    let solid = cube();
    let quality = measure(&solid, &[Ball::new(DVec3::ZERO, 3.0_f64.sqrt() - 1e-6)], 0.0);
    assert!(quality.coverage_surface < 1.0 && quality.coverage_volume < 1.0, "{quality:?}");
    assert!((quality.largest_gap - 1e-6).abs() <= 2e-9 * solid.diagonal);
}

#[test]
fn a_ball_that_is_there_twice_overlaps_whole_and_protrudes_once() {
    let solid = cube();
    let ball = Ball::new(DVec3::ZERO, 2.0);
    let [once, twice] = [vec![ball], vec![ball, ball]].map(|balls| measure(&solid, &balls, 0.0));
    assert!(once.overlap.abs() < 1e-12 && (twice.overlap - 1.0).abs() < 1e-12);
    // Half as many points on each.
    assert!((once.protrusion.mean - twice.protrusion.mean).abs() < 2e-3 && twice.protrusion.max > 0.99);
}

#[test]
fn two_half_overlapping_balls_in_a_cube_share_a_lens() {
    let solid = cube();
    let (r, d) = (0.5, 0.5);
    let balls = [Ball::new(DVec3::X * -0.25, r), Ball::new(DVec3::X * 0.25, r)];
    let quality = measure(&solid, &balls, 0.0);
    let ball = 4.0 / 3.0 * PI * r * r * r;
    assert!((quality.overlap - (2.0 * ball / 8.0 - 1.0)).abs() < 1e-12);
    let lens = PI * (4.0 * r + d) * (2.0 * r - d).powi(2) / 12.0;
    let share = (2.0 * ball - lens) / 8.0;
    assert!(
        (quality.coverage_volume - share).abs() < 4.0 * (share * (1.0 - share) / 262_144.0).sqrt(),
        "{quality:?} {share}"
    );
    assert_eq!(quality.coverage_surface, 0.0);
    // From the corner (1, 1, 1) to the nearer centre.
    assert!((quality.largest_gap - (DVec3::new(0.75, 1.0, 1.0).length() - r)).abs() <= 2e-9 * solid.diagonal);
}

#[test]
fn two_half_overlapping_balls_around_an_icosphere_protrude_where_they_show() {
    let solid = Solid::of(&mesh(icosphere(4)), &Place::file("ball.obj")).unwrap();
    let balls = [Ball::new(DVec3::X * -0.5, 1.5), Ball::new(DVec3::X * 0.5, 1.5)];
    let quality = measure(&solid, &balls, 1e-6);
    assert_eq!((quality.coverage_surface, quality.coverage_volume), (1.0, 1.0));
    assert!((quality.overlap - 1.0).abs() < 1e-9);
    // A point of the right sphere with x >= 0 is at |(0.5 + 1.5 z, …)| − 1 from the unit sphere: height z =
    // cos is uniform, from −1/3 to 1. Its mean of √(2.5 + 1.5 z) is 2/3 (4^1.5 − 2^1.5)/1.5 / (4/3). The
    // facets lie within 0.002 of the sphere.
    let mean = 2.0 / 3.0 * (8.0 - 2.0_f64.powf(1.5)) / 1.5 / (4.0 / 3.0) - 1.0;
    assert!((quality.protrusion.mean - mean).abs() < 4e-3, "{quality:?} {mean}");
    assert!((quality.protrusion.max - 1.0).abs() < 4e-3);
    let p95 = (2.5_f64 + 1.5 * (1.0 - 0.05 * 4.0 / 3.0)).sqrt() - 1.0;
    assert!((quality.protrusion.p95 - p95).abs() < 4e-3, "{quality:?} {p95}");
}
