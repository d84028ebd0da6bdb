//! Exact coverage against dense points.

use super::ball::Ball;
use super::coverage::{uncovered_corners, uncovered_on_surface, uncovered_within};
use super::surface_points::stratified;
use super::test_meshes::{cuboid, l_shape, random, torus, tree};
use super::triangle_tree::TriangleTree;
use glam::DVec3;

fn covered(balls: &[Ball], point: DVec3, slack: f64) -> bool {
    balls.iter().any(|b| Ball::new(b.centre, b.radius + slack).contains(point))
}

#[test]
fn one_ball_covers_a_cube_until_a_bit_is_taken_away() {
    let cube = tree(cuboid(-DVec3::ONE, DVec3::ONE));
    // What the square of the root of three rounds to is of no interest here.
    let radius = 3.0_f64.sqrt() * (1.0 + 1e-15);
    assert!(uncovered_corners(&cube, &cube, &[Ball::new(DVec3::ZERO, radius)]).is_empty());
    let less = uncovered_corners(&cube, &cube, &[Ball::new(DVec3::ZERO, radius - 1e-9)]);
    for corner in &cube.vertices {
        assert!(less.contains(corner), "{corner}");
    }
    let nothing = uncovered_on_surface(&cube, &[]);
    assert!(cube.vertices.iter().all(|v| nothing.contains(v)));
}

#[test]
fn two_balls_that_just_meet_on_a_face_cover_it() {
    // A box 2 × 1 × 1 by a ball for each half, through all corners of its half.
    let mesh = tree(cuboid(DVec3::ZERO, DVec3::new(2.0, 1.0, 1.0)));
    let pair = |radius: f64| [0.5, 1.5].map(|x| Ball::new(DVec3::new(x, 0.5, 0.5), radius));
    let radius = 0.75_f64.sqrt();
    assert!(uncovered_corners(&mesh, &mesh, &pair(radius + 1e-12)).is_empty());
    assert!(!uncovered_corners(&mesh, &mesh, &pair(radius - 1e-9)).is_empty());
}

#[test]
fn a_hole_in_the_middle_is_found() {
    let mesh = tree(cuboid(-DVec3::ONE, DVec3::ONE));
    // Balls of 0.6 at a grid of centres on the surface, half a unit apart, none within.
    let steps = [-1.0, -0.5, 0.0, 0.5, 1.0];
    let grid =
        steps.iter().flat_map(|x| steps.iter().flat_map(|y| steps.iter().map(|z| DVec3::new(*x, *y, *z))));
    let mut balls: Vec<Ball> =
        grid.filter(|c| c.abs().max_element() == 1.0).map(|c| Ball::new(c, 0.6)).collect();
    assert!(uncovered_on_surface(&mesh, &balls).is_empty());
    let hole = uncovered_within(&mesh, &balls);
    assert!(!hole.is_empty() && hole.iter().all(|p| p.abs().max_element() < 0.6), "{hole:?}");
    // A ball through the hole's farthest corners fills it.
    let reach = hole.iter().map(|p| p.length()).fold(0.0, f64::max);
    balls.push(Ball::new(DVec3::ZERO, reach + 1e-9));
    assert!(uncovered_corners(&mesh, &mesh, &balls).is_empty());
    balls.pop();
    balls.push(Ball::new(DVec3::ZERO, reach - 1e-6));
    assert!(!uncovered_corners(&mesh, &mesh, &balls).is_empty());
}

/// Points of a solid, its surface included.
fn dense(mesh: &TriangleTree, random: &mut impl FnMut() -> f64) -> (Vec<DVec3>, Vec<DVec3>) {
    let place =
        |(t, weights): (usize, [f64; 3])| mesh.corners(t).into_iter().zip(weights).map(|(v, w)| v * w).sum();
    let surface = stratified(mesh, 20_000).into_iter().map(place).collect();
    let (min, max) = (mesh.nodes[0].min, mesh.nodes[0].max);
    let points = (0..20_000).map(|_| min + DVec3::new(random(), random(), random()) * (max - min));
    (surface, points.filter(|p| mesh.encloses(*p)).collect())
}

#[test]
fn random_balls_cover_just_when_points_say_so() {
    let mut random = random(8);
    let (mut complete, mut incomplete) = (0, 0);
    for mesh in [tree(torus(1.0, 0.35, 24, 12)), tree(l_shape())] {
        let (surface, volume) = dense(&mesh, &mut random);
        for case in 0..40 {
            let count = 6 + case % 10;
            let centres: Vec<DVec3> =
                (0..count).map(|_| volume[(random() * volume.len() as f64) as usize]).collect();
            // As large as the points need in all, and a bit more or less than that.
            let need = |points: &[DVec3]| {
                let nearest =
                    |p: &DVec3| centres.iter().map(|c| c.distance(*p)).fold(f64::INFINITY, f64::min);
                points.iter().map(nearest).fold(0.0, f64::max)
            };
            let all = need(&surface).max(need(&volume));
            let radius = all * (0.9 + 0.03 * f64::from(case % 7));
            let balls: Vec<Ball> = centres.iter().map(|c| Ball::new(*c, radius)).collect();
            let corners = uncovered_corners(&mesh, &mesh, &balls);
            // Points that are seen to be open must be reported.
            let seen = surface.iter().chain(&volume).any(|p| !covered(&balls, *p, 0.0));
            assert!(!seen || !corners.is_empty(), "{balls:?}");
            // What is reported must be open on the surface or in the solid.
            for corner in &corners {
                assert!(!covered(&balls, *corner, -1e-9), "{corner} {balls:?}");
                assert!(mesh.distance(*corner) < 1e-9 || mesh.encloses(*corner));
            }
            // Points lie this dense on the surface and within: more than that beyond their need nothing can
            // be open.
            assert!(radius < all * 1.07 || corners.is_empty(), "{radius} {all} {corners:?}");
            *(if corners.is_empty() { &mut complete } else { &mut incomplete }) += 1;
        }
    }
    assert!(complete > 10 && incomplete > 10, "{complete} {incomplete}");
}

#[test]
fn the_growth_that_just_covers_is_the_distance_of_the_farthest_point() {
    let mut random = random(9);
    let mesh = tree(torus(1.0, 0.35, 16, 8));
    let (surface, volume) = dense(&mesh, &mut random);
    for _ in 0..6 {
        let balls: Vec<Ball> = (0..12)
            .map(|_| Ball::new(volume[(random() * volume.len() as f64) as usize], 0.1 + 0.2 * random()))
            .collect();
        let grown = |t: f64| balls.iter().map(|b| Ball::new(b.centre, b.radius + t)).collect::<Vec<_>>();
        let (mut low, mut high) = (0.0, 4.0);
        for _ in 0..40 {
            let middle = (low + high) / 2.0;
            if uncovered_corners(&mesh, &mesh, &grown(middle)).is_empty() {
                high = middle
            } else {
                low = middle
            }
        }
        let gap =
            |p: &DVec3| balls.iter().map(|b| b.centre.distance(*p) - b.radius).fold(f64::INFINITY, f64::min);
        let most = surface.iter().chain(&volume).chain(&mesh.vertices).map(gap).fold(0.0, f64::max);
        // Points are about 0.03 apart.
        assert!(high >= most - 1e-9 && high < most + 0.05, "{high} {most}");
    }
}
