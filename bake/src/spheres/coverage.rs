//! Whether balls cover a solid, surface included: exactly, not by samples.
//!
//! What balls leave uncovered of a solid is bounded by flat triangles and by spheres that bulge into it. The
//! extreme points of such a region are therefore corners: a vertex of the mesh, a point where a sphere
//! crosses an edge, where two spheres cross on a triangle, or where three spheres cross within the solid. So
//! if every such corner lies within another ball, nothing is uncovered.

use super::ball::Ball;
use super::triangle_tree::TriangleTree;
use glam::DVec3;
use rayon::prelude::*;

/// How far within a ball a point must lie, in radii: more than rounding, less than any tolerance.
const WITHIN: f64 = 1e-13;

/// The corners of what `balls` leave uncovered of the triangles of `surface`, and of the solid within
/// `solid`, which only matters where the surface is covered. None if all is covered.
pub fn uncovered_corners(surface: &TriangleTree, solid: &TriangleTree, balls: &[Ball]) -> Vec<DVec3> {
    let mut corners = uncovered_on_surface(surface, balls);
    corners.extend(uncovered_within(solid, balls));
    corners
}

/// The corners of what is uncovered of the triangles.
pub fn uncovered_on_surface(surface: &TriangleTree, balls: &[Ball]) -> Vec<DVec3> {
    let all: Vec<u32> = (0..balls.len() as u32).collect();
    // Branches with the balls that may reach them; a few thousand of them keep all threads busy.
    let mut branches = vec![(0_u32, all)];
    let mut leaves = Vec::new();
    if surface.nodes.is_empty() {
        return Vec::new();
    }
    while let Some((index, candidates)) = branches.pop() {
        let node = &surface.nodes[index as usize];
        let ball = |i: &u32| balls[*i as usize];
        if candidates.iter().any(|i| node.farthest_squared(ball(i).centre) <= ball(i).radius.powi(2)) {
            continue;
        }
        let near: Vec<u32> = candidates
            .into_iter()
            .filter(|i| node.nearest_squared(ball(i).centre) <= ball(i).radius.powi(2))
            .collect();
        if node.second == 0 {
            leaves.push((node.range, near));
        } else {
            branches.push((node.second, near.clone()));
            branches.push((index + 1, near));
        }
    }
    let of_leaf = |((first, last), near): &((u32, u32), Vec<u32>)| {
        let near: Vec<Ball> = near.iter().map(|i| balls[*i as usize]).collect();
        let mut found = Vec::new();
        (*first..*last).for_each(|t| uncovered_of_triangle(surface.corners(t as usize), &near, &mut found));
        found
    };
    leaves.par_iter().flat_map_iter(of_leaf).collect()
}

fn uncovered_of_triangle(triangle: [DVec3; 3], balls: &[Ball], found: &mut Vec<DVec3>) {
    // Balls are convex.
    if balls.iter().any(|b| triangle.iter().all(|v| b.contains(*v))) {
        return;
    }
    let open = |point: DVec3, of: &[usize]| {
        !balls.iter().enumerate().any(|(i, b)| !of.contains(&i) && holds(b, point))
    };
    found.extend(triangle.iter().filter(|v| open(**v, &[])));
    for (i, ball) in balls.iter().enumerate() {
        for edge in 0..3 {
            let ends = [triangle[edge], triangle[(edge + 1) % 3]];
            found.extend(crossings_of_edge(ball, ends).into_iter().flatten().filter(|p| open(*p, &[i])));
        }
        for (j, other) in balls.iter().enumerate().skip(i + 1) {
            found.extend(
                crossings_on_triangle(ball, other, triangle)
                    .into_iter()
                    .flatten()
                    .filter(|p| open(*p, &[i, j])),
            );
        }
    }
}

/// Whether a point lies within a ball, not just on it: where four spheres meet in one point, as they do
/// around symmetric solids, none of them closes the void that may begin there. Whoever asks grows the balls
/// by a tolerance, so that points which the balls themselves cover lie well within.
fn holds(ball: &Ball, point: DVec3) -> bool {
    let limit = ball.radius * (1.0 - WITHIN);
    point.distance_squared(ball.centre) < limit * limit
}

/// Where a sphere crosses an edge.
fn crossings_of_edge(ball: &Ball, [p, q]: [DVec3; 2]) -> [Option<DVec3>; 2] {
    let (edge, start) = (q - p, p - ball.centre);
    let (a, half_b, c) =
        (edge.length_squared(), edge.dot(start), start.length_squared() - ball.radius.powi(2));
    let square = half_b * half_b - a * c;
    if square <= 0.0 || a == 0.0 {
        return [None; 2];
    }
    [-square.sqrt(), square.sqrt()].map(|root| {
        let t = (root - half_b) / a;
        (0.0..=1.0).contains(&t).then(|| p + t * edge)
    })
}

/// Where two spheres cross on a triangle.
fn crossings_on_triangle(a: &Ball, b: &Ball, triangle: [DVec3; 3]) -> [Option<DVec3>; 2] {
    let normal = (triangle[1] - triangle[0]).cross(triangle[2] - triangle[0]);
    let within = |p: DVec3| {
        (0..3).all(|i| (triangle[(i + 1) % 3] - triangle[i]).cross(p - triangle[i]).dot(normal) >= 0.0)
    };
    on_plane_and_spheres(a, b, (normal, normal.dot(triangle[0]))).map(|p| p.filter(|p| within(*p)))
}

/// The points of two spheres and the plane normal · x = offset.
fn on_plane_and_spheres(a: &Ball, b: &Ball, (normal, offset): (DVec3, f64)) -> [Option<DVec3>; 2] {
    let Some((radical, radical_offset)) = radical_plane(a, b) else { return [None; 2] };
    let along = normal.cross(radical);
    let size = along.length_squared();
    // Parallel planes share no line.
    if size <= 1e-24 * normal.length_squared() * radical.length_squared() {
        return [None; 2];
    }
    let base = (offset * radical.cross(along) + radical_offset * along.cross(normal)) / size;
    let start = base - a.centre;
    let (half_b, c) = (along.dot(start), start.length_squared() - a.radius.powi(2));
    let square = half_b * half_b - size * c;
    if square <= 0.0 {
        return [None; 2];
    }
    [-square.sqrt(), square.sqrt()].map(|root| Some(base + (root - half_b) / size * along))
}

/// The plane in which two spheres cross; `None` if they do not.
fn radical_plane(a: &Ball, b: &Ball) -> Option<(DVec3, f64)> {
    let axis = b.centre - a.centre;
    let distance = axis.length();
    let cross = distance < a.radius + b.radius && distance > (a.radius - b.radius).abs();
    // From a's centre, for precision where coordinates are large.
    let offset = (distance * distance + a.radius.powi(2) - b.radius.powi(2)) / 2.0;
    cross.then(|| (axis, offset + axis.dot(a.centre)))
}

/// Corners of three spheres that lie in the solid and in no other ball.
pub fn uncovered_within(solid: &TriangleTree, balls: &[Ball]) -> Vec<DVec3> {
    let crossing = |i: usize, j: usize| radical_plane(&balls[i], &balls[j]).is_some();
    let touches =
        |i: usize, j: usize| balls[i].centre.distance(balls[j].centre) < balls[i].radius + balls[j].radius;
    let of_ball = |i: usize| {
        let near: Vec<usize> = (0..balls.len()).filter(|j| *j != i && touches(i, *j)).collect();
        let later: Vec<usize> = near.iter().copied().filter(|j| *j > i && crossing(i, *j)).collect();
        let mut found = Vec::new();
        for (k, j) in later.iter().enumerate() {
            for l in later[k + 1..].iter().filter(|l| crossing(*j, **l)) {
                let Some(plane) = radical_plane(&balls[i], &balls[*l]) else { continue };
                for point in on_plane_and_spheres(&balls[i], &balls[*j], plane).into_iter().flatten() {
                    let covered = near.iter().any(|m| m != j && m != l && holds(&balls[*m], point));
                    if !covered && solid.encloses(point) {
                        found.push(point);
                    }
                }
            }
        }
        found
    };
    (0..balls.len()).into_par_iter().flat_map_iter(of_ball).collect()
}
