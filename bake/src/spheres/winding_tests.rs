//! Winding numbers, solid angles and distances against closed forms and brute force.

use super::test_meshes::{cuboid, icosphere, inside_out, joined, open_hemisphere, random, torus, tree};
use super::winding::solid_angle;
use glam::DVec3;
use std::f64::consts::{PI, TAU};

#[test]
fn a_solid_angle_has_its_closed_forms() {
    // An octant, whichever way it is stretched.
    assert!((solid_angle([DVec3::X, DVec3::Y * 3.0, DVec3::Z * 0.2]) - PI / 2.0).abs() < 1e-14);
    assert!((solid_angle([DVec3::Y, DVec3::X, DVec3::Z]) + PI / 2.0).abs() < 1e-14);
    // A right-angled triangle at distance d over its corner of angle 45°: half a rectangle's eighth. A
    // rectangle of sides 2a, 2b at distance d has 4 asin(ab/√((a²+d²)(b²+d²))), and a square is eight such
    // triangles.
    let (a, d) = (0.7_f64, 0.4);
    let square = 4.0 * (a * a / (a * a + d * d)).asin();
    let got = solid_angle([DVec3::new(0.0, 0.0, d), DVec3::new(a, 0.0, d), DVec3::new(a, a, d)]);
    assert!((got - square / 8.0).abs() < 1e-14, "{got} {}", square / 8.0);
}

#[test]
fn a_closed_mesh_winds_once_around_what_it_encloses() {
    let mut random = random(2);
    // Of the cube every triangle is near; of the ball distant branches are dipoles.
    for (mesh, bound) in [(tree(cuboid(-DVec3::ONE, DVec3::ONE)), 1e-12), (tree(icosphere(4)), 0.05)] {
        for _ in 0..2000 {
            let point = DVec3::new(random(), random(), random()) * 4.0 - 2.0;
            let size = if bound < 1e-3 { point.abs().max_element() } else { point.length() };
            if (size - 1.0).abs() < 0.01 {
                continue;
            }
            let got = mesh.winding_number(point);
            let expected = f64::from(u8::from(size < 1.0));
            // Beyond three radii the cube too is a dipole, of no moment.
            assert!((got - expected).abs() < bound, "{point} {got}");
            assert_eq!(mesh.encloses(point), size < 1.0);
        }
    }
}

#[test]
fn dipoles_are_near_the_sum_over_all_triangles() {
    let mut random = random(3);
    for (vertices, triangles) in [open_hemisphere(48, 16), torus(1.0, 0.35, 48, 24)] {
        let corners: Vec<[DVec3; 3]> = triangles.iter().map(|t| t.map(|v| vertices[v as usize])).collect();
        let mesh = tree((vertices, triangles));
        for _ in 0..500 {
            let point = DVec3::new(random(), random(), random()) * 4.0 - 2.0;
            let all: f64 =
                corners.iter().map(|t| solid_angle(t.map(|v| v - point))).sum::<f64>() / (2.0 * TAU);
            assert!(
                (mesh.winding_number(point) - all).abs() < 0.05,
                "{point} {} {all}",
                mesh.winding_number(point)
            );
        }
    }
}

#[test]
fn an_open_mesh_winds_by_the_solid_angle_that_it_fills() {
    let (vertices, triangles) = cuboid(-DVec3::ONE, DVec3::ONE);
    // Without one face five sixths of all directions meet the cube, seen from its middle; at the open face's
    // middle half of them do.
    let open = tree((vertices, triangles[2..].to_vec()));
    assert!((open.winding_number(DVec3::ZERO) - 5.0 / 6.0).abs() < 1e-12);
    assert!((open.winding_number(-DVec3::X) - 0.5).abs() < 1e-12);
    let dome = tree(open_hemisphere(48, 16));
    // Its branches are seen as dipoles.
    assert!((dome.winding_number(DVec3::ZERO) - 0.5).abs() < 0.01);
}

#[test]
fn parts_add_and_cavities_take_away() {
    let nested =
        tree(joined(&[cuboid(-DVec3::ONE * 2.0, DVec3::ONE * 2.0), cuboid(-DVec3::ONE, DVec3::ONE)]));
    assert!((nested.winding_number(DVec3::ZERO) - 2.0).abs() < 1e-12);
    let hollow = tree(joined(&[
        cuboid(-DVec3::ONE * 2.0, DVec3::ONE * 2.0),
        inside_out(cuboid(-DVec3::ONE, DVec3::ONE)),
    ]));
    assert!(hollow.winding_number(DVec3::ZERO).abs() < 1e-12);
    assert!((hollow.winding_number(DVec3::X * 1.5) - 1.0).abs() < 1e-12);
}

/// Nearest point of a triangle by the region its projection falls in (Ericson 2005, §5.1.5).
fn nearest_point(p: DVec3, [a, b, c]: [DVec3; 3]) -> DVec3 {
    let (ab, ac) = (b - a, c - a);
    let (d1, d2) = (ab.dot(p - a), ac.dot(p - a));
    let (d3, d4) = (ab.dot(p - b), ac.dot(p - b));
    let (d5, d6) = (ab.dot(p - c), ac.dot(p - c));
    let (va, vb, vc) = (d3 * d6 - d5 * d4, d5 * d2 - d1 * d6, d1 * d4 - d3 * d2);
    if d1 <= 0.0 && d2 <= 0.0 {
        a
    } else if d3 >= 0.0 && d4 <= d3 {
        b
    } else if d6 >= 0.0 && d5 <= d6 {
        c
    } else if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        a + ab * (d1 / (d1 - d3))
    } else if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        a + ac * (d2 / (d2 - d6))
    } else if va <= 0.0 && d4 >= d3 && d5 >= d6 {
        b + (c - b) * ((d4 - d3) / (d4 - d3 + d5 - d6))
    } else {
        a + ab * (vb / (va + vb + vc)) + ac * (vc / (va + vb + vc))
    }
}

#[test]
fn distances_are_those_of_brute_force() {
    let mut random = random(4);
    for triangles in [cuboid(-DVec3::ONE, DVec3::ONE), torus(1.0, 0.35, 24, 12), open_hemisphere(16, 5)] {
        let mesh = tree(triangles);
        for _ in 0..1000 {
            let point = DVec3::new(random(), random(), random()) * 4.0 - 2.0;
            let each =
                (0..mesh.triangles.len()).map(|t| nearest_point(point, mesh.corners(t)).distance(point));
            let brute = each.fold(f64::INFINITY, f64::min);
            assert!((mesh.distance(point) - brute).abs() < 1e-12, "{point} {brute}");
        }
        assert!(mesh.vertices.iter().all(|v| mesh.distance(*v) < 1e-12));
    }
    assert_eq!(tree((Vec::new(), Vec::new())).distance(DVec3::ZERO), f64::INFINITY);
}

#[test]
fn a_triangle_without_area_is_its_longest_edge() {
    let mesh = tree((vec![DVec3::ZERO, DVec3::X, DVec3::X * 3.0], vec![[0, 1, 2]]));
    assert!((mesh.distance(DVec3::new(2.0, 1.0, 0.0)) - 1.0).abs() < 1e-15);
    assert!((mesh.distance(DVec3::new(5.0, 0.0, 0.0)) - 2.0).abs() < 1e-15);
}
