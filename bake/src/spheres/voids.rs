//! Voids: parts of the solid that no sphere covers although its surface is covered.

use super::ball::Ball;
use super::cluster::Problem;
use super::coverage::uncovered_within;
use super::sphere::Sphere;
use glam::DVec3;

/// Growths in a row until no void is left; the second finds none, rounding aside.
const ATTEMPTS: usize = 8;
/// Voids that vanish when radii grow by this share are none.
const TOLERANCE: f64 = 1e-9;
/// How near to a sphere a corner lies on it, in parts of the radius.
const ON: f64 = 1e-6;

/// Closes all voids: each becomes a piece of its own and goes to the sphere that covers it most cheaply.
/// Returns the spheres that have grown.
pub fn fill(problem: &mut Problem<'_>, spheres: &mut Vec<Sphere>) -> Vec<usize> {
    let mut grown = Vec::new();
    for _ in 0..ATTEMPTS {
        let balls: Vec<Ball> = spheres
            .iter()
            .map(|s| Ball::new(s.ball.centre, (s.ball.radius + problem.slack) * (1.0 + TOLERANCE)))
            .collect();
        let corners = uncovered_within(problem.solid, &balls);
        if corners.is_empty() {
            break;
        }
        let voids: Vec<u32> =
            connected(&corners, &balls).iter().map(|void| problem.pieces.add_inside(void)).collect();
        let dealt = problem.deal(spheres, &voids);
        grown.extend((0..dealt.len()).filter(|i| dealt[*i].ball != spheres[*i].ball));
        *spheres = dealt;
    }
    grown
}

/// Corners of the same void: those that are joined by arcs, along which two spheres cross. Spheres bulge into
/// a void, so it lies between its corners.
fn connected(corners: &[DVec3], balls: &[Ball]) -> Vec<Vec<DVec3>> {
    let on = |corner: &DVec3| -> Vec<usize> {
        let touches = |b: &Ball| (b.centre.distance(*corner) - b.radius).abs() <= ON * b.radius;
        (0..balls.len()).filter(|i| touches(&balls[*i])).collect()
    };
    let spheres: Vec<Vec<usize>> = corners.iter().map(on).collect();
    let joined = |a: usize, b: usize| spheres[a].iter().filter(|s| spheres[b].contains(s)).count() >= 2;
    let mut voids = Vec::new();
    let mut left: Vec<usize> = (0..corners.len()).collect();
    while let Some(first) = left.pop() {
        let mut void = vec![first];
        let mut next = 0;
        while next < void.len() {
            let (near, far) = left.iter().partition(|c| joined(void[next], **c));
            void.extend::<Vec<usize>>(near);
            left = far;
            next += 1;
        }
        voids.push(void.into_iter().map(|c| corners[c]).collect());
    }
    voids
}
