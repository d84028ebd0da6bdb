//! Smallest balls against all that few points span, and against random centres.

use super::enclosing::pulled_centre;
use glam::{DMat3, DVec3};

/// Random numbers in [0, 1) that are the same each time.
fn random(seed: u64) -> impl FnMut() -> f64 {
    let mut state = seed;
    move || {
        state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (state >> 11) as f64 / (1_u64 << 53) as f64
    }
}

/// 1,000 points of the unit sphere in opposite pairs, along a spiral.
fn on_unit_sphere(k: u32) -> DVec3 {
    let y = 1.0 - f64::from(k / 2 * 2) / 1000.0;
    let (sin, cos) = (2.4 * f64::from(k / 2)).sin_cos();
    let r = (1.0 - y * y).sqrt();
    DVec3::new(r * cos, y, r * sin) * sign(k)
}

/// 1 for an even number, else -1.
fn sign(k: u32) -> f64 {
    1.0 - 2.0 * f64::from(k % 2)
}

/// The point equally far from all of up to four points in their affine hull, by the normal equations.
fn circumcentre(points: &[DVec3]) -> DVec3 {
    let edges: Vec<DVec3> = points[1..].iter().map(|p| *p - points[0]).collect();
    let axis = |i: usize| edges.get(i).copied();
    let (a, b, c) = (axis(0), axis(1), axis(2));
    let offset = match (a, b, c) {
        (None, ..) => DVec3::ZERO,
        (Some(a), None, _) => a / 2.0,
        (Some(a), Some(b), None) => {
            let n = a.cross(b);
            (a.length_squared() * b.cross(n) + b.length_squared() * n.cross(a)) / (2.0 * n.length_squared())
        }
        (Some(a), Some(b), Some(c)) => {
            DMat3::from_cols(a, b, c).transpose().inverse()
                * DVec3::new(a.length_squared(), b.length_squared(), c.length_squared())
                / 2.0
        }
    };
    points[0] + offset
}

fn reach(centre: DVec3, points: &[DVec3]) -> f64 {
    points.iter().map(|p| p.distance(centre)).fold(0.0, f64::max)
}

/// The least reach over the circumcentres of all sets of up to four points.
fn brute_force(points: &[DVec3]) -> f64 {
    let sets = (1_u32..1 << points.len()).filter(|set| set.count_ones() <= 4);
    let chosen = |set: u32| {
        points.iter().enumerate().filter(|(i, _)| set >> i & 1 == 1).map(|(_, p)| *p).collect::<Vec<_>>()
    };
    sets.map(|set| circumcentre(&chosen(set)))
        .filter(|c| c.is_finite())
        .map(|c| reach(c, points))
        .fold(f64::INFINITY, f64::min)
}

#[test]
fn without_a_pull_it_is_the_smallest_enclosing_ball() {
    let mut random = random(5);
    for case in 0..300 {
        let count = 1 + case % 12;
        let mut point = || DVec3::new(random(), random(), random()) * 2.0 - 1.0;
        // Some sets are flat or far from the origin.
        let place = |p: DVec3| match case % 3 {
            0 => p,
            1 => p.with_z(0.0),
            _ => p + DVec3::splat(50.0),
        };
        let points: Vec<DVec3> = (0..count).map(|_| place(point())).collect();
        let start = place(point());
        let got = reach(pulled_centre(&points, DVec3::ZERO, 1.0 + f64::from(case % 7), start), &points);
        let best = brute_force(&points);
        assert!((got - best).abs() < 1e-8, "{case}: {got} {best} {points:?}");
    }
}

#[test]
fn points_of_a_sphere_and_points_that_coincide_are_no_trouble() {
    let sphere: Vec<DVec3> = (0..1000).map(on_unit_sphere).collect();
    assert!(pulled_centre(&sphere, DVec3::ZERO, 1.0, DVec3::splat(0.3)).length() < 1e-6);
    let cube: Vec<DVec3> = (0..8).map(|k| DVec3::new(sign(k), sign(k / 2), sign(k / 4))).collect();
    assert!(pulled_centre(&cube, DVec3::ZERO, 1.0, DVec3::X).length() < 1e-9);
    let line: Vec<DVec3> = (0..20).map(|i| DVec3::X * f64::from(i / 2)).collect();
    assert!(pulled_centre(&line, DVec3::ZERO, 1.0, DVec3::Y).distance(DVec3::X * 4.5) < 1e-9);
    assert_eq!(pulled_centre(&[], DVec3::X, 1.0, DVec3::Y), DVec3::Y);
}

#[test]
fn with_a_pull_no_centre_nearby_or_far_does_better() {
    let mut random = random(11);
    for case in 0..200 {
        let mut vector = || DVec3::new(random(), random(), random()) * 2.0 - 1.0;
        let points: Vec<DVec3> = (0..3 + case % 40).map(|_| vector()).collect();
        let (pull, scale) = (vector() * 10.0_f64.powi(case % 5 - 2), 0.1 + f64::from(case % 4));
        let cost = |c: DVec3| pull.dot(c) + scale * reach(c, &points).powi(2);
        let centre = pulled_centre(&points, pull, scale, vector());
        let (best, slack) = (cost(centre), 1e-9 * (1.0 + cost(centre).abs()));
        for step in [1e-4, 1e-2, 0.3, 3.0] {
            for _ in 0..50 {
                let other = cost(centre + vector() * step);
                assert!(other >= best - slack, "{case}: {step} {other} {best}");
            }
        }
    }
}
