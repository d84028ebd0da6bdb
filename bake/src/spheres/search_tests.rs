//! The parts of the search: pieces, dealing, refitting, tightening, voids.

use super::ball::Ball;
use super::cluster::Problem;
use super::coverage::uncovered_within;
use super::growth::Growth;
use super::motion::Motion;
use super::pieces::Pieces;
use super::sphere::{Sphere, total_outside};
use super::start::start;
use super::test_meshes::{cuboid, l_shape, random, torus, tree};
use super::triangle_tree::TriangleTree;
use super::voids;
use glam::DVec3;
use std::sync::Arc;

fn problem(solid: &TriangleTree, size: f64) -> Problem<'_> {
    Problem {
        solid,
        pieces: Pieces::new(solid, size),
        slack: 0.0,
        motion: Box::leak(Box::<Motion>::default()),
    }
}

fn all(problem: &Problem<'_>) -> Vec<u32> {
    (0..problem.pieces.len() as u32).collect()
}

/// Every piece belongs to one sphere and lies in it.
fn assert_dealt(problem: &Problem<'_>, spheres: &[Sphere], pieces: &[u32]) {
    let mut owned: Vec<u32> = spheres.iter().flat_map(|s| s.cluster.iter()).copied().collect();
    owned.sort_unstable();
    assert_eq!(owned, pieces);
    for sphere in spheres {
        let reach = |p: &u32| problem.pieces.farthest_squared(*p, sphere.ball.centre).sqrt();
        assert!(
            sphere.cluster.iter().all(|p| reach(p) <= sphere.ball.radius * (1.0 + 1e-12)),
            "{:?}",
            sphere.ball
        );
    }
}

#[test]
fn pieces_make_up_the_surface_and_their_parts_make_up_them() {
    let solid = tree(torus(1.0, 0.35, 24, 12));
    let mut pieces = Pieces::new(&solid, 0.2);
    let area = |pieces: &Pieces<'_>, p: u32| {
        // Branches that are small enough hold several triangles; here none is, since triangles are larger.
        let [a, b, c] = pieces.places(p) else { panic!("not a triangle") };
        (*b - *a).cross(*c - *a).length() / 2.0
    };
    let whole: Vec<u32> = (0..pieces.len() as u32).collect();
    let total: f64 = whole.iter().map(|p| area(&pieces, *p)).sum();
    let surface: f64 = solid.planes.iter().map(|(_, area)| area).sum();
    assert!((total / surface - 1.0).abs() < 1e-12, "{total} {surface}");
    assert!(whole.iter().all(|p| pieces.extent(*p) <= 0.2));
    // Twice in halves, and together again.
    let mut parts: Vec<u32> = whole.iter().flat_map(|p| pieces.split(*p)).collect();
    parts = parts.into_iter().flat_map(|p| pieces.split(p)).collect();
    parts.sort_unstable();
    assert_eq!(parts.len(), 4 * whole.len());
    let total: f64 = parts.iter().map(|p| area(&pieces, *p)).sum();
    assert!((total / surface - 1.0).abs() < 1e-12);
    let made = pieces.len();
    assert_eq!(pieces.split(whole[0]).len(), 2);
    assert_eq!(pieces.len(), made, "a piece is split once");
    assert_eq!(pieces.merged(&parts, |_, _| true), whole);
    assert_eq!(pieces.merged(&parts, |_, _| false), parts);
    assert_eq!(
        pieces.merged(&parts[1..], |_, _| true).len(),
        whole.len() + 1,
        "what lacks a part stays in parts"
    );
    // Points hang on the surface by their weights.
    for corner in parts.iter().flat_map(|p| pieces.corners(*p)) {
        let anchor = pieces.anchor(*corner).unwrap();
        let place: DVec3 =
            anchor.vertices.iter().zip(anchor.weights).map(|(v, w)| w * solid.vertices[*v as usize]).sum();
        assert!(place.distance(pieces.point(*corner)) < 1e-12);
    }
}

#[test]
fn growth_is_exact_at_its_ends_and_close_between() {
    let solid = tree(l_shape());
    let mut random = random(5);
    for _ in 0..50 {
        let centre = solid.nodes[0].min
            + DVec3::new(random(), random(), random()) * (solid.nodes[0].max - solid.nodes[0].min);
        let radius = 0.2 + random();
        let growth = Growth::new(&solid, centre, radius);
        let exact = |r: f64| Ball::new(centre, r).outside(&solid).volume;
        for share in [0.3, 1.5] {
            assert!((growth.volume(share * radius) - exact(share * radius)).abs() < 1e-9);
        }
        let mut last = 0.0;
        for step in 0..60 {
            let r = radius * 0.03 * f64::from(step);
            let got = growth.volume(r);
            assert!(got >= last - 1e-12, "it never falls");
            // The volume's second derivative by the radius is at most 8πr, and between knots h apart a cubic
            // with exact ends and slopes strays by less than h²/8 of it.
            let step = 1.2 * radius / 7.0;
            let bound = step * step / 8.0 * 8.0 * std::f64::consts::PI * 1.5 * radius;
            if r > 0.3 * radius && r < 1.5 * radius {
                assert!((got - exact(r)).abs() < bound, "{got} {} {bound}", exact(r));
            }
            last = got;
        }
    }
}

#[test]
fn a_refitted_sphere_cannot_be_moved_to_advantage() {
    for solid in [tree(l_shape()), tree(torus(1.0, 0.35, 24, 12))] {
        let problem = problem(&solid, 0.25);
        let mut random = random(9);
        for sphere in start(&problem, 7, 1) {
            let positions = problem.pieces.positions(&sphere.cluster);
            let refitted = problem.refit(&sphere, 100);
            assert!(refitted.outside.volume <= sphere.outside.volume);
            let mut best = refitted.clone();
            let mut width = 0.1 * refitted.ball.radius;
            for round in 1..=1500 {
                let step = DVec3::new(random() - 0.5, random() - 0.5, random() - 0.5) * 2.0 * width;
                let tried = problem.sphere(best.ball.centre + step, Arc::clone(&best.cluster), &positions);
                if tried.outside.volume < best.outside.volume {
                    best = tried;
                }
                if round % 150 == 0 {
                    width *= 0.5;
                }
            }
            // Refitting ends when a step gains less than a thousandth.
            assert!(
                best.outside.volume > 0.995 * refitted.outside.volume,
                "{} {}",
                best.outside.volume,
                refitted.outside.volume
            );
        }
    }
}

#[test]
fn dealing_and_tightening_keep_all_covered_and_tightening_never_adds() {
    let solid = tree(torus(1.0, 0.35, 24, 12));
    let problem = problem(&solid, 0.25);
    let pieces = all(&problem);
    let bare: Vec<Sphere> = start(&problem, 9, 2).iter().map(|s| s.with_cluster(Vec::new())).collect();
    let dealt = problem.deal(&bare, &pieces);
    assert_dealt(&problem, &dealt, &pieces);
    let tight = problem.tighten(dealt.clone(), &[0, 1, 2, 3, 4, 5, 6, 7, 8], 6);
    assert_dealt(&problem, &tight, &pieces);
    assert!(total_outside(&tight) < total_outside(&dealt));
    // Whatever is left alone stays as it is.
    let one = problem.tighten(dealt.clone(), &[4], 6);
    assert!((0..9).filter(|i| *i != 4).all(|i| one[i].ball == dealt[i].ball));
}

#[test]
fn voids_are_filled() {
    // A ball at each corner of a cube reaches as far as the cube's edges' middles, which covers its faces,
    // but not its middle.
    let solid = tree(cuboid(DVec3::splat(-1.0), DVec3::splat(1.0)));
    let mut problem = problem(&solid, 3.0);
    let corner = |i: u32| DVec3::new(f64::from(i & 1), f64::from(i >> 1 & 1), f64::from(i >> 2)) * 1.2 - 0.6;
    let sphere = |i| Sphere::new(&solid, Ball::new(corner(i), 0.94), Arc::new(vec![i]));
    let mut spheres: Vec<Sphere> = (0..8).map(sphere).collect();
    // Four balls meet in each of the void's corners.
    let balls = |spheres: &[Sphere]| -> Vec<Ball> {
        spheres.iter().map(|s| Ball::new(s.ball.centre, s.ball.radius + 1e-8)).collect()
    };
    assert!(!uncovered_within(&solid, &balls(&spheres)).is_empty());
    let grown = voids::fill(&mut problem, &mut spheres);
    assert_eq!(uncovered_within(&solid, &balls(&spheres)), []);
    assert_eq!(grown.len(), 1, "one void goes to one sphere");
    assert!(spheres.iter().any(|s| s.ball.contains(DVec3::ZERO)));
    assert!(voids::fill(&mut problem, &mut spheres).is_empty());
}
