//! How good a fit is: coverage, gaps, protrusion and overlap.
//!
//! Whether all is covered, and the overlap, are exact. Shares of an incomplete coverage and protrusions are
//! means over fixed points.

use super::ball::Ball;
use super::coverage::{uncovered_corners, uncovered_on_surface};
use super::solid::Solid;
use super::surface_points::{random, stratified};
use super::triangle_tree::TriangleTree;
use glam::{DVec2, DVec3, UVec3};
use rayon::prelude::*;
use relume_formats::kinds::sphere_set::{Protrusion, Quality};
use std::f64::consts::{PI, TAU};

/// Points on the surface for the share that is covered.
const SURFACE_POINTS: u32 = 65_536;
/// Points in the solid's box for the same of the volume, roughly.
const VOLUME_POINTS: f64 = 262_144.0;
/// Points on all spheres together.
const SPHERE_POINTS: f64 = 20_000.0;
/// Least number on one.
const LEAST_SPHERE_POINTS: f64 = 16.0;
/// The largest gap is known to within this part of the diagonal.
const GAP_ACCURACY: f64 = 1e-9;
/// Turn between neighbouring points of a Fibonacci lattice.
const GOLDEN_TURN: f64 = 0.381_966_011_250_105_1;

/// Measures `balls` against the solid that they are to cover; what is within `tolerance` of a ball counts as
/// covered.
///
/// Coverages are 1 exactly if nothing is uncovered. Otherwise they are shares over stratified points, below
/// 1: 65,536 on the surface, some 262,144 in the volume's box. The largest gap is exact to 10⁻⁹ of the
/// diagonal. Protrusions are taken at about 20,000 points on the spheres.
pub fn measure(solid: &Solid, balls: &[Ball], tolerance: f64) -> Quality {
    let grown = grow(balls, tolerance);
    let covers_surface = uncovered_on_surface(&solid.surface, &grown).is_empty();
    let covers_all = covers(solid, &grown);
    let coverage_surface = if covers_surface { 1.0 } else { surface_share(&solid.surface, &grown) };
    let coverage_volume = if covers_all { 1.0 } else { volume_share(solid, &grown) };
    let largest_gap = if covers_all { 0.0 } else { largest_gap(solid, balls, tolerance) };
    Quality {
        coverage_surface,
        coverage_volume,
        protrusion: protrusion(solid, balls),
        largest_gap,
        overlap: overlap(solid, balls),
    }
}

fn grow(balls: &[Ball], by: f64) -> Vec<Ball> {
    balls.iter().map(|b| Ball::new(b.centre, b.radius + by)).collect()
}

fn covers(solid: &Solid, balls: &[Ball]) -> bool {
    uncovered_corners(&solid.surface, &solid.boundary, balls).is_empty()
}

fn is_covered(balls: &[Ball], point: DVec3) -> bool {
    balls.iter().any(|b| b.contains(point))
}

/// Share of the area in the balls.
fn surface_share(surface: &TriangleTree, balls: &[Ball]) -> f64 {
    let at = |(triangle, weights): &(usize, [f64; 3])| {
        surface.corners(*triangle).into_iter().zip(weights).map(|(v, w)| v * *w).sum()
    };
    let points = stratified(surface, SURFACE_POINTS);
    let hits = points.par_iter().filter(|p| is_covered(balls, at(p))).count();
    below_one(hits as f64 / points.len().max(1) as f64, f64::from(SURFACE_POINTS))
}

/// Share of the volume in the balls: one random point in each of the cubes that fill the box; only those in
/// no ball are looked at.
fn volume_share(solid: &Solid, balls: &[Ball]) -> f64 {
    let Some(root) = solid.boundary.nodes.first() else { return 0.0 };
    let extent = root.max - root.min;
    let cube = (extent.element_product() / VOLUME_POINTS).cbrt();
    let size = (extent / cube).ceil().max(DVec3::ONE).min(DVec3::splat(65_536.0)).as_uvec3();
    let open = |i: &u32| {
        let at = UVec3::new(i % size.x, i / size.x % size.y, i / (size.x * size.y)).as_dvec3();
        let jitter = DVec3::new(random(*i, 3), random(*i, 4), random(*i, 5));
        let point = root.min + (at + jitter) / size.as_dvec3() * extent;
        !is_covered(balls, point) && solid.boundary.encloses(point)
    };
    let points = size.element_product();
    let volume_of_point = extent.element_product() / f64::from(points);
    let uncovered = (0..points).into_par_iter().filter(open).count() as f64 * volume_of_point;
    below_one((1.0 - uncovered / solid.volume).max(0.0), f64::from(points))
}

/// A share that is known to be less than 1, although no point may have shown it.
fn below_one(share: f64, points: f64) -> f64 {
    share.min(1.0 - 0.5 / points)
}

/// The least growth of all radii that covers the solid, which `tolerance` does not: doubled until it does,
/// then halved.
fn largest_gap(solid: &Solid, balls: &[Ball], tolerance: f64) -> f64 {
    if balls.is_empty() {
        return f64::INFINITY;
    }
    let (mut low, mut high) = (tolerance, (2.0 * tolerance).max(1e-5 * solid.diagonal));
    while !covers(solid, &grow(balls, high)) && high.is_finite() {
        (low, high) = (high, 2.0 * high);
    }
    while high - low > GAP_ACCURACY * solid.diagonal {
        let middle = low.midpoint(high);
        if middle <= low || middle >= high {
            break;
        }
        if covers(solid, &grow(balls, middle)) { high = middle } else { low = middle }
    }
    high
}

fn protrusion(solid: &Solid, balls: &[Ball]) -> Protrusion {
    let area = |b: &Ball| 4.0 * PI * b.radius * b.radius;
    let total: f64 = balls.iter().map(area).sum();
    let of_ball = |i: usize| {
        let area = area(&balls[i]);
        let points = (SPHERE_POINTS * area / total).max(LEAST_SPHERE_POINTS).ceil();
        exposed(solid, balls, i, points as u32)
            .into_iter()
            .map(|p| (solid.surface.distance(p), area / points))
            .collect::<Vec<_>>()
    };
    let mut distances: Vec<(f64, f64)> = (0..balls.len()).into_par_iter().flat_map_iter(of_ball).collect();
    distances.sort_by(|a, b| a.0.total_cmp(&b.0));
    weighted(&distances)
}

/// Those of a number of points on a sphere that lie outside all other balls and the solid.
fn exposed(solid: &Solid, balls: &[Ball], index: usize, points: u32) -> Vec<DVec3> {
    let ball = balls[index];
    // Of balls that are the same the first shows.
    let hides = |(j, other): &(usize, &Ball)| *j != index && (**other != ball || *j < index);
    let meets = |other: &Ball| other.centre.distance(ball.centre) <= other.radius + ball.radius;
    let near: Vec<Ball> = balls.iter().enumerate().filter(hides).map(|(_, b)| *b).filter(meets).collect();
    let on_sphere = |i| ball.centre + ball.radius * fibonacci(i, points);
    (0..points).map(on_sphere).filter(|p| !is_covered(&near, *p) && !solid.boundary.encloses(*p)).collect()
}

/// Point `i` of a Fibonacci lattice on the unit sphere.
fn fibonacci(i: u32, points: u32) -> DVec3 {
    let height = 1.0 - (2.0 * f64::from(i) + 1.0) / f64::from(points);
    let around = DVec2::from_angle(TAU * (f64::from(i) * GOLDEN_TURN).fract());
    (around * (1.0 - height * height).sqrt()).extend(height)
}

/// Mean, 95th percentile and greatest of ascending values with weights; 0 where there are none.
fn weighted(distances: &[(f64, f64)]) -> Protrusion {
    let max = distances.last().map_or(0.0, |(d, _)| *d);
    let total: f64 = distances.iter().map(|(_, w)| w).sum();
    if total <= 0.0 {
        return Protrusion { mean: 0.0, p95: 0.0, max: 0.0 };
    }
    let mean = distances.iter().map(|(d, w)| d * w).sum::<f64>() / total;
    let mut sum = 0.0;
    let reaches = |(_, w): &&(f64, f64)| {
        sum += w;
        sum >= 0.95 * total
    };
    let p95 = distances.iter().find(reaches).map_or(max, |(d, _)| *d);
    Protrusion { mean: mean.min(max), p95, max }
}

/// Σ V(S ∩ T)/V(T) − 1.
fn overlap(solid: &Solid, balls: &[Ball]) -> f64 {
    let inside: Vec<f64> = balls.par_iter().map(|b| b.volume() - b.outside(&solid.boundary).volume).collect();
    (inside.iter().sum::<f64>() / solid.volume - 1.0).max(-1.0)
}
