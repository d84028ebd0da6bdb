//! Spheres that follow a deforming mesh: rigid motion and scaling exactly, everything else so that all points
//! stay covered.

use crate::support::samples::Random;
use crate::support::spheres::sphere_set;
use glam::{DQuat, DVec3, Vec3};
use proptest::prelude::*;
use relume_formats::evaluate::sphere_set::Follower;
use relume_formats::kinds::SphereSet;

fn rest(set: &SphereSet) -> Vec<[f32; 3]> {
    set.points[..set.meta.vertices as usize].to_vec()
}

fn moved(set: &SphereSet, motion: impl Fn(DVec3) -> DVec3) -> Vec<[f32; 3]> {
    rest(set).iter().map(|p| motion(Vec3::from(*p).as_dvec3()).as_vec3().to_array()).collect()
}

fn spheres(set: &SphereSet, positions: &[[f32; 3]]) -> Vec<[f32; 4]> {
    let mut spheres = Vec::new();
    Follower::new(set).follow(positions, &mut spheres).unwrap();
    spheres
}

fn split([x, y, z, radius]: [f32; 4]) -> (Vec3, f32) {
    (Vec3::new(x, y, z), radius)
}

/// Every point of every cluster, computed from `positions` in f32 as a naive reader would, lies in its own
/// sphere.
fn assert_covered(set: &SphereSet, positions: &[[f32; 3]], now: &[[f32; 4]]) {
    for (at, cluster) in set.clusters.iter().enumerate() {
        let (centre, radius) = split(now[*cluster as usize]);
        let point: Vec3 = (0..3)
            .map(|k| Vec3::from(positions[set.point_vertices[at][k] as usize]) * set.point_weights[at][k])
            .sum();
        assert!(
            point.distance(centre) <= radius,
            "point {at}: {} from a centre with radius {radius}",
            point.distance(centre)
        );
    }
}

/// A set of one sphere around vertices alone.
fn one_sphere(points: &[[f32; 3]], sphere: [f32; 4]) -> SphereSet {
    let mut set = sphere_set(2, points.len(), points.len(), 1, 0.0);
    set.points = points.to_vec();
    set.spheres = vec![sphere];
    set
}

#[test]
fn at_rest_the_spheres_are_those_of_the_file() {
    for seed in 0..50 {
        for slack in [0.0, 0.01, 0.5] {
            let set =
                sphere_set(seed, 1 + seed as usize, 3 * seed as usize + 2, 1 + seed as usize % 7, slack);
            let now = spheres(&set, &rest(&set));
            for (file, now) in set.spheres.iter().zip(&now) {
                assert_eq!(file[..3], now[..3]);
                // The margin is 8 / 2²⁴ of coordinates and distance, each at most 4, where the slack does not
                // hold it already.
                let most = if slack > 0.0 { 0.0 } else { 4e-6 };
                assert!((0.0..=most).contains(&(now[3] - file[3])), "seed {seed}: {file:?} {now:?}");
            }
            assert_covered(&set, &rest(&set), &now);
        }
    }
}

/// Turns about any axis by any angle, half turns about the axes among them, where quaternions and iterations
/// have their seams.
#[test]
fn rigid_motion_moves_spheres_rigidly() {
    let axes = [
        DVec3::X,
        DVec3::Y,
        DVec3::Z,
        DVec3::new(1.0, -2.0, 0.5).normalize(),
        DVec3::new(1e-9, 1.0, 1e-9).normalize(),
    ];
    for seed in 0..8 {
        let set = sphere_set(seed, 60, 150, 5, 0.05);
        for axis in axes {
            for angle_deg in [0.0, 1e-4, 30.0, 90.0, 179.999, 180.0, 270.0, 359.0f64] {
                let turn = DQuat::from_axis_angle(axis, angle_deg.to_radians());
                let motion = |p: DVec3| turn * p + DVec3::new(1.0, -2.0, 0.5);
                let positions = moved(&set, motion);
                let now = spheres(&set, &positions);
                for (file, now) in set.spheres.iter().zip(&now) {
                    let ((place, radius), (now, now_radius)) = (split(*file), split(*now));
                    let expected = motion(place.as_dvec3());
                    // Positions are rounded to 2⁻²⁴ of at most 4; the centre adds its own rounding.
                    assert!(
                        now.as_dvec3().distance(expected) < 1e-6,
                        "{now} is not {expected} after {angle_deg}° about {axis}"
                    );
                    assert!((now_radius - radius).abs() < 1e-6 * 3.5, "{now_radius} is not {radius}");
                }
                assert_covered(&set, &positions, &now);
            }
        }
    }
}

#[test]
fn scaling_scales() {
    let set = sphere_set(3, 60, 150, 5, 0.05);
    for scale in [0.1, 0.5, 1.0, 3.0, 1e4] {
        let turn = DQuat::from_axis_angle(DVec3::new(0.6, 0.0, 0.8), 2.0);
        let now = spheres(&set, &moved(&set, |p| turn * p * scale));
        for (file, now) in set.spheres.iter().zip(&now) {
            let ((place, radius), (now, now_radius)) = (split(*file), split(*now));
            assert!(now.as_dvec3().distance(turn * place.as_dvec3() * scale) < 1e-6 * scale);
            assert!(
                (f64::from(now_radius) - f64::from(radius) * scale).abs() < 2e-6 * scale,
                "{now_radius} is not {radius} × {scale}"
            );
        }
    }
}

/// One point: no turn. Two, or collinear ones: the smallest turn that brings the line along, none about it. A
/// plane: its turn, no reflection.
#[test]
fn small_clusters_turn_as_far_as_they_say() {
    let quarter = DQuat::from_rotation_z(std::f64::consts::FRAC_PI_2);
    let line: Vec<[f32; 3]> = [-1.0, 0.25, 1.0, 0.5].map(|x| [x, 0.0, 0.0]).to_vec();
    let plane: Vec<[f32; 3]> =
        [[-1.0, 0.0, 0.0], [0.25, 0.5, 0.0], [1.0, -0.5, 0.0], [0.5, 1.0, 0.0]].to_vec();
    for (points, turn, expected) in [
        (&line[..1], quarter, DVec3::new(0.5 + 1.0, 1.0 - 1.0, 0.25)),
        (&line[1..3], quarter, DVec3::new(-1.0, 0.5, 0.25)),
        (&line[..], quarter, DVec3::new(-1.0, 0.5, 0.25)),
        (&plane[..], quarter, DVec3::new(-1.0, 0.5, 0.25)),
        // Half a turn about the line: nobody can tell, so the centre stays.
        (&line[..], DQuat::from_rotation_x(std::f64::consts::PI), DVec3::new(0.5, 1.0, 0.25)),
        // Of the plane: both the points and the side on which the centre is.
        (&plane[..], DQuat::from_rotation_x(std::f64::consts::PI), DVec3::new(0.5, -1.0, -0.25)),
    ] {
        let set = one_sphere(points, [0.5, 1.0, 0.25, 3.0]);
        let positions = moved(&set, |p| turn * p);
        let now = spheres(&set, &positions);
        let (centre, radius) = split(now[0]);
        // A lone point at (-1, 0, 0) goes to (0, -1, 0) and takes the centre along by (1, -1, 0).
        assert!(centre.as_dvec3().distance(expected) < 1e-6, "{centre} is not {expected}");
        assert!((radius - 3.0).abs() < 1e-6);
        assert_covered(&set, &positions, &now);
    }
}

/// Points that all but coincide must not turn a distant centre with their rounding errors.
#[test]
fn points_that_nearly_coincide_do_not_spin_the_sphere() {
    let points = [[1.0, 1.0, 1.0], [1.0 + f32::EPSILON, 1.0, 1.0], [1.0, 1.0 + f32::EPSILON, 1.0]];
    let set = one_sphere(&points, [0.0, 1.0, 1.0, 1.25]);
    for jitter in [[2, 0, 1], [1, 1, 1], [0, 3, -2], [-2, -2, 0i16]] {
        let positions: Vec<[f32; 3]> = points
            .iter()
            .zip(jitter)
            .map(|(p, j)| [p[0] - f32::EPSILON * f32::from(j), p[1], p[2] + f32::EPSILON * f32::from(j)])
            .collect();
        let now = spheres(&set, &positions);
        assert!(split(now[0]).0.distance(Vec3::new(0.0, 1.0, 1.0)) < 1e-3, "{now:?}");
        assert!((now[0][3] - 1.25).abs() < 1e-3, "{now:?}");
    }
}

/// A straight row of points, its sphere in the middle, is bent to a right angle in the middle: the smallest
/// ball of an L with arms of 1 has the radius √½. The points now reach less far than at rest, but the radius
/// need not shrink below what the scale of their spread allows.
#[test]
fn a_bent_row_needs_no_larger_sphere() {
    let points: Vec<[f32; 3]> = (-20..=20).map(|i| [i as f32 / 20.0, 0.0, 0.0]).collect();
    let set = one_sphere(&points, [0.0, 0.0, 0.0, 1.0]);
    let positions = moved(&set, |p| if p.x < 0.0 { p } else { DVec3::new(0.0, p.x, 0.0) });
    let now = spheres(&set, &positions);
    assert_covered(&set, &positions, &now);
    // The rms distance from the centroid is √(1/3 − 1/8) instead of √(1/3), so 0.79 is within what the scale
    // allows.
    let wanted = ((1.0 / 3.0 - 1.0 / 8.0) / (1.0 / 3.0f32)).sqrt();
    assert!(now[0][3] <= wanted * 1.01 && now[0][3] >= 0.5f32.sqrt(), "{now:?}, wanted {wanted}");
}

/// Points that reach out farther than any scale allows: the sphere is the smallest ball around them.
#[test]
fn spheres_grow_no_farther_than_to_the_smallest_ball() {
    // At rest a ball of 200 points, centre off by half a radius; then all but one shrink to a heap and one
    // stays: the ball between them is the smallest.
    let mut random = Random(7);
    let direction =
        |random: &mut Random| Vec3::new(random.signed(), random.signed(), random.signed()).normalize();
    let points: Vec<[f32; 3]> = (0..200).map(|_| direction(&mut random).to_array()).collect();
    let set = one_sphere(&points, [0.5, 0.0, 0.0, 1.5]);
    let mut positions = moved(&set, |p| p * 0.01);
    positions[0] = [4.0, 0.0, 0.0];
    let now = spheres(&set, &positions);
    assert_covered(&set, &positions, &now);
    // The heap has a radius of 0.01, so the ball has at most one of 2.005; its other end is the point itself.
    // The sphere stands out of its farthest point by as little as at rest, less than 0.001 of the radius.
    assert!((2.0..2.0065).contains(&now[0][3]), "{now:?}");
    assert!(split(now[0]).0.distance(Vec3::X * 2.0) < 0.01, "{now:?}");
}

/// Where points begin to reach out the centre begins to move: no jump.
#[test]
fn centres_do_not_jump() {
    let set = sphere_set(5, 40, 80, 4, 0.02);
    let bend =
        |amount: f64| moved(&set, |p| DVec3::new(p.x * (1.0 + 0.3 * amount), p.y + amount * p.x * p.x, p.z));
    for step in 0..200 {
        let amounts = [f64::from(step) * 1e-3 - 0.1, f64::from(step) * 1e-3 - 0.1 + 1e-6];
        let [before, after] = amounts.map(|amount| spheres(&set, &bend(amount)));
        for (a, b) in before.iter().zip(&after) {
            // Radii are continuous; points move by some 10⁻⁶.
            assert!((a[3] - b[3]).abs() < 1e-4, "{a:?} {b:?} at {amounts:?}");
        }
    }
    let at_rest = spheres(&set, &bend(0.0));
    let near = spheres(&set, &bend(1e-5));
    for (a, b) in at_rest.iter().zip(&near) {
        assert!(split(*a).0.distance(split(*b).0) < 1e-4, "{a:?} {b:?}");
    }
}

#[test]
fn a_sphere_without_points_follows_the_nearest_that_has_some() {
    let mut set =
        one_sphere(&[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [9.0, 9.0, 9.0]], [0.25, 0.25, 0.0, 1.0]);
    set.spheres = vec![[9.0, 9.0, 9.0, 0.5], [0.25, 0.25, 0.5, 0.75], [0.25, 0.25, 0.0, 1.0]];
    set.clusters = vec![2, 2, 2, 0];
    // Around the first three doubled and turned a quarter about z; the fourth goes elsewhere.
    let mut positions = moved(&set, |p| 2.0 * DVec3::new(-p.y, p.x, p.z));
    positions[3] = [-9.0, 0.0, 3.0];
    let now = spheres(&set, &positions);
    assert!(
        split(now[1]).0.distance(Vec3::new(-0.5, 0.5, 1.0)) < 1e-5 && (now[1][3] - 1.5).abs() < 1e-5,
        "{now:?}"
    );
    assert!(split(now[0]).0.distance(Vec3::new(-9.0, 0.0, 3.0)) < 1e-5, "{now:?}");
}

/// A set that was fitted with tolerance keeps its spheres at rest, and the share by which points lie outside.
#[test]
fn what_may_lie_outside_keeps_its_share() {
    let mut set = one_sphere(
        &[[1.0, 0.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, -1.0, 0.0]],
        [0.0, 0.0, 0.0, 0.875],
    );
    set.meta.tight = 0.05;
    let at_rest = spheres(&set, &rest(&set));
    assert!((at_rest[0][3] - 0.875).abs() < 1e-6, "{at_rest:?}");
    let doubled = spheres(&set, &moved(&set, |p| p * 2.0));
    assert!((doubled[0][3] - 1.75).abs() < 2e-6, "{doubled:?}");
    // Without the tolerance all is covered, at rest too.
    set.meta.tight = 0.0;
    assert_covered(&set, &rest(&set), &spheres(&set, &rest(&set)));
}

#[test]
fn poses_of_other_meshes_are_refused() {
    let set = sphere_set(2, 5, 9, 3, 0.1);
    let follower = Follower::new(&set);
    let mut now = Vec::new();
    let message = follower.follow(&rest(&set)[..4], &mut now).unwrap_err().to_string();
    assert!(message.contains("4 vertices, its spheres were fitted to 5"), "{message}");
    assert!(follower.follow(&[[0.0; 3]; 6], &mut now).is_err());
    let mut broken = rest(&set);
    broken[3][1] = f32::NAN;
    let message = follower.follow(&broken, &mut now).unwrap_err().to_string();
    assert!(message.contains("vertex 3 is not at a finite place"), "{message}");
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(300) })]

    /// Any pose at all: folded, flattened, turned inside out, all points in one place.
    #[test]
    fn every_point_stays_covered(
        seed: u64, vertices in 1usize..40, more in 0usize..40, count in 1usize..12, slack in 0.0f32..0.2,
        size in prop_oneof![Just(0.0f32), Just(1e-6), 0.1f32..10.0, Just(1e6)], away in prop_oneof![Just(0.0f32), -1e3f32..1e3],
    ) {
        let set = sphere_set(seed, vertices, vertices + more, count, slack);
        let random = &mut Random(seed ^ 1);
        let positions: Vec<[f32; 3]> = rest(&set).iter().map(|_| [(); 3].map(|()| size * random.signed() + away)).collect();
        let now = spheres(&set, &positions);
        assert_covered(&set, &positions, &now);
        prop_assert!(now.iter().flatten().all(|x| x.is_finite()));
        prop_assert_eq!(&spheres(&set, &positions), &now, "the same again");
    }
}
