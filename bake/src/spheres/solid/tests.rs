//! Solids of meshes that are well made and of meshes that are not.

use super::super::test_meshes::{
    cuboid, flipped_face_cube, icosphere, inside_out, joined, l_shape, mesh, open_hemisphere, thin_plate,
    torus, two_cubes,
};
use super::{CELLS, Kind, Solid, orient};
use glam::DVec3;
use relume_formats::Place;
use std::f64::consts::{PI, TAU};

type Triangles = (Vec<DVec3>, Vec<[u32; 3]>);

fn try_solid(triangles: Triangles) -> crate::error::Result<Solid> {
    Solid::of(&mesh(triangles), &Place::file("shape.obj"))
}

fn solid(triangles: Triangles) -> Solid {
    let solid = try_solid(triangles).unwrap();
    // Whatever came in, this must hold.
    assert!(orient::is_closed(&solid.boundary.triangles));
    assert!(
        (solid.boundary.nodes[0].moment / 3.0 - solid.volume).abs() <= 1e-12 * solid.volume
            && solid.volume > 0.0
    );
    solid
}

fn cube(min: f64, max: f64) -> Triangles {
    cuboid(DVec3::splat(min), DVec3::splat(max))
}

/// Closed, with the volume to the rounding of its vertices to f32, and so many notes.
fn assert_closed(triangles: Triangles, volume: f64, notes: usize) {
    let solid = solid(triangles);
    assert_eq!(solid.kind, Kind::Closed, "{:?}", solid.notes);
    assert_eq!(solid.notes.len(), notes, "{:?}", solid.notes);
    assert!((solid.volume / volume - 1.0).abs() < 1e-6, "{} {volume}", solid.volume);
}

/// By winding number, with the volume within `bound`.
fn assert_gridded(triangles: Triangles, volume: f64, bound: f64) {
    let solid = solid(triangles);
    assert_eq!(solid.kind, Kind::WindingNumber { cells: CELLS });
    assert!((solid.volume - volume).abs() < bound, "{} {volume} {bound}", solid.volume);
    assert!(solid.notes.iter().any(|n| n.contains("winding number")));
    assert!(solid.surface.vertices.len() > solid.mesh_vertex.len());
}

#[test]
fn closed_meshes_bound_their_own_solids() {
    assert_closed(cube(0.0, 1.0), 1.0, 0);
    assert_closed(l_shape(), 3.0, 0);
    assert_closed(thin_plate(), 0.08, 0);
    // A prism of n sides in place of each circle has sin(2π/n)/(2π/n) of its area.
    let prism = |n: f64| (TAU / n).sin() / (TAU / n);
    let volume = solid(torus(1.0, 0.35, 96, 48)).volume;
    let circle = 2.0 * PI * PI * 0.35 * 0.35;
    assert!(volume < circle && volume > circle * prism(96.0) * prism(48.0) * 0.999, "{volume} {circle}");
    assert_closed(two_cubes(DVec3::X * 3.0), 2.0, 0);
}

#[test]
fn triangles_and_parts_that_face_the_wrong_way_are_turned() {
    assert_closed(flipped_face_cube(), 1.0, 1);
    assert_closed(inside_out(cube(0.0, 1.0)), 1.0, 1);
    assert_closed(joined(&[cube(0.0, 1.0), inside_out(cube(2.0, 3.0))]), 2.0, 1);
    assert_closed(inside_out(two_cubes(DVec3::X * 3.0)), 2.0, 1);
}

#[test]
fn a_cavity_stays_and_what_lies_within_it_is_solid() {
    assert_closed(joined(&[cube(0.0, 4.0), inside_out(cube(1.0, 3.0))]), 56.0, 0);
    assert_closed(joined(&[inside_out(cube(1.0, 3.0)), cube(0.0, 4.0), inside_out(cube(1.5, 2.5))]), 57.0, 1);
}

#[test]
fn split_vertices_are_welded_and_map_both_ways() {
    let (vertices, triangles) = cube(-1.0, 1.0);
    let corners = triangles.iter().flatten().map(|v| vertices[*v as usize]).collect::<Vec<_>>();
    let split = (0..triangles.len() as u32).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect();
    let solid = solid((corners.clone(), split));
    assert_eq!((solid.kind, solid.volume, solid.surface.vertices.len()), (Kind::Closed, 8.0, 8));
    for (vertex, position) in corners.iter().enumerate() {
        let welded = solid.welded[vertex] as usize;
        assert_eq!(solid.surface.vertices[welded], *position);
        assert_eq!(corners[solid.mesh_vertex[welded] as usize], *position);
        assert!(solid.mesh_vertex[welded] as usize <= vertex);
    }
}

/// With corners of their own for every triangle, each moved by `move_by` of its number.
fn split((vertices, triangles): Triangles, move_by: impl Fn(usize) -> DVec3) -> Triangles {
    let corners = triangles
        .iter()
        .flatten()
        .map(|v| vertices[*v as usize])
        .enumerate()
        .map(|(i, v)| v + move_by(i))
        .collect();
    (corners, (0..triangles.len() as u32).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect())
}

#[test]
fn seams_that_rounding_opens_are_welded() {
    // The diagonal is 3.46: up to 1.7e-7 of it each way, and whatever the order of the copies.
    let moved = |i: usize| {
        6e-7 * DVec3::new((i % 3) as f64 - 1.0, (i % 5) as f64 / 2.0 - 1.0, (i % 7) as f64 / 3.0 - 1.0)
    };
    let (exact, near) = (solid(cube(-1.0, 1.0)), solid(split(cube(-1.0, 1.0), moved)));
    assert_eq!(
        (near.kind, near.surface.vertices.len(), near.surface.triangles.len()),
        (Kind::Closed, 8, 12),
        "{:?}",
        near.notes
    );
    assert!((near.volume - exact.volume).abs() < 1.5e-5, "{}", near.volume);
    let welded = split(cube(-1.0, 1.0), moved)
        .0
        .iter()
        .map(|v| v.as_vec3().to_array().map(f32::to_bits))
        .collect::<std::collections::HashSet<_>>()
        .len()
        - 8;
    assert_eq!(
        near.notes,
        [format!(
            "welded {welded} vertices to others at less than a millionth of the diagonal, which closes the mesh"
        )]
    );
    // A gap of 3e-5 of the diagonal is one.
    let apart = super::weld(&mesh(split(cube(-1.0, 1.0), |i| moved(i) * 100.0))).0;
    assert!(!orient::is_closed(&apart.triangles) && apart.vertices.len() > 8);
}

#[test]
fn the_poles_of_a_computed_sphere_are_one_vertex_each() {
    let (around, up) = (24, 12);
    let point = |i: u32, j: u32| {
        let (longitude, latitude) =
            (std::f32::consts::TAU * i as f32 / around as f32, std::f32::consts::PI * j as f32 / up as f32);
        [latitude.sin() * longitude.cos(), latitude.cos(), -latitude.sin() * longitude.sin()].map(f64::from)
    };
    // Every longitude has its own pole, and the first one is there again at the end.
    let vertices = (0..=up).flat_map(|j| (0..=around).map(move |i| DVec3::from(point(i, j)))).collect();
    let at = |i: u32, j: u32| j * (around + 1) + i;
    let quad = |i: u32, j: u32| {
        [[at(i, j), at(i, j + 1), at(i + 1, j + 1)], [at(i, j), at(i + 1, j + 1), at(i + 1, j)]]
    };
    let triangles = (0..up).flat_map(|j| (0..around).flat_map(move |i| quad(i, j))).collect();
    let solid = solid((vertices, triangles));
    assert_eq!((solid.kind, solid.surface.vertices.len()), (Kind::Closed, 2 + 11 * 24), "{:?}", solid.notes);
    assert_eq!(solid.surface.triangles.len(), 2 * 24 * 11);
}

#[test]
fn far_from_the_origin_the_last_place_is_near() {
    // Single precision is in steps of 1/128 there.
    let far = |v: DVec3| v + 1e5;
    let (vertices, triangles) = cube(0.0, 1.0);
    let step = |i: usize| DVec3::splat(if i.is_multiple_of(2) { 0.0 } else { 1.0 / 128.0 });
    let (welded, notes) =
        super::weld(&mesh(split((vertices.into_iter().map(far).collect(), triangles), step)));
    assert_eq!(
        (welded.vertices.len(), welded.triangles.len(), orient::is_closed(&welded.triangles)),
        (8, 12, true),
        "{notes:?}"
    );
}

#[test]
fn welding_does_not_run_along_chains_nor_flatten_what_is_closed() {
    // A closed plate thinner than the reach stays what it is.
    let plate = super::weld(&mesh(cuboid(DVec3::splat(-1.0), DVec3::new(1.0, 1.0, -1.0 + 1e-6)))).0;
    assert_eq!((plate.vertices.len(), plate.triangles.len()), (8, 12));
    // Vertices every 0.6 of the reach along a line: every second stays, none moves by more than the reach.
    let line = (0..400_000_u32).map(|i| DVec3::X * f64::from(i) * 0.6e-6).chain([DVec3::new(0.0, 0.97, 0.0)]);
    let mesh = mesh((line.collect(), Vec::new()));
    let welded = super::weld::Welded::nearly(&mesh);
    let moved = |(p, i): (&[f32; 3], &u32)| {
        DVec3::from_array(p.map(f64::from)).distance(welded.vertices[*i as usize])
    };
    assert!(mesh.positions.iter().zip(&welded.index).map(moved).fold(0.0, f64::max) <= 1e-6);
    assert!((199_000..202_000).contains(&welded.vertices.len()), "{}", welded.vertices.len());
}

#[test]
fn parts_that_meet_are_united_on_the_grid() {
    // The grid cuts convex edges off and fills concave ones by at most half a cell squared along their
    // length.
    let overlapping = two_cubes(DVec3::splat(0.5));
    let bound = |length: f64, longest: f64| length * (longest / f64::from(CELLS)).powi(2) / 2.0;
    assert_gridded(overlapping, 2.0 - 0.125, bound(24.0, 1.5));
    assert_gridded(joined(&[cube(0.0, 4.0), cube(1.0, 3.0)]), 64.0, bound(48.0, 4.0));
    // One that faces inwards, before the two are united.
    assert_gridded(joined(&[cube(0.0, 1.0), inside_out(cube(0.5, 1.5))]), 2.0 - 0.125, bound(24.0, 1.5));
}

#[test]
fn an_open_hemisphere_is_nearly_half_a_ball() {
    // The winding number of the open half sphere is 1/2 on its missing base: outside adds what inside lacks.
    let half = 2.0 / 3.0 * PI;
    let cell = 2.0 / f64::from(CELLS);
    for triangles in [open_hemisphere(96, 24), inside_out(open_hemisphere(96, 24))] {
        assert_gridded(triangles, half, cell * PI);
    }
}

#[test]
fn the_grid_surface_of_a_ball_with_a_hole_is_near_the_ball() {
    let (vertices, mut triangles) = icosphere(4);
    triangles.pop();
    let solid = solid((vertices, triangles));
    let worst = solid.boundary.vertices.iter().map(|v| (v.length() - 1.0).abs()).fold(0.0, f64::max);
    assert!(worst < 2.0 / f64::from(CELLS), "{worst}");
    assert!((solid.volume / (4.0 / 3.0 * PI) - 1.0).abs() < 0.01, "{}", solid.volume);
}

#[test]
fn the_same_mesh_gives_the_same_solid() {
    let [a, b] = [(), ()].map(|()| solid(open_hemisphere(24, 6)));
    assert_eq!((a.boundary.vertices, a.boundary.triangles), (b.boundary.vertices, b.boundary.triangles));
}

#[test]
fn sheets_are_no_solids() {
    let square = vec![DVec3::ZERO, DVec3::X, DVec3::new(1.0, 1.0, 0.0), DVec3::Y];
    let front = vec![[0, 1, 2], [0, 2, 3]];
    let both = vec![[0, 1, 2], [0, 2, 3], [0, 2, 1], [0, 3, 2]];
    for triangles in [front, both] {
        let error = try_solid((square.clone(), triangles)).unwrap_err();
        assert_eq!(error.exit_code(), 2);
        let message = error.to_string();
        assert!(
            message.contains("shape.obj")
                && message.contains("encloses no volume")
                && message.contains("thickness"),
            "{message}"
        );
    }
}
