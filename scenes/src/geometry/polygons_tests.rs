//! Triangulated areas against the shoelace formula, in any plane.

use super::*;
use glam::DQuat;
use proptest::prelude::*;
use std::f64::consts::TAU;

/// One polygon over all `points`.
fn triangulated(points: &[[f32; 3]]) -> Triangulation {
    let mut polygons = Polygons::default();
    polygons.add(0..points.len() as u32, Smoothing::ByAngle, &Place::file("t.obj")).unwrap();
    polygons.triangulate(points)
}

/// Twice the signed area in the plane z = 0.
fn shoelace(outline: &[[f64; 2]]) -> f64 {
    outline.iter().zip(outline.iter().cycle().skip(1)).map(|([ax, ay], [bx, by])| ax * by - bx * ay).sum()
}

/// In the plane z = 0.
fn flat(outline: &[[f64; 2]]) -> Vec<[f32; 3]> {
    outline.iter().map(|[x, y]| [*x as f32, *y as f32, 0.0]).collect()
}

/// Twice the signed area of all triangles seen along −z, none of which faces away.
fn area(points: &[[f32; 3]], triangles: &[[u32; 3]]) -> f64 {
    let areas = triangles.iter().map(|t| area_vector(t.map(|v| points[v as usize])).z);
    areas.inspect(|area| assert!(*area >= 0.0)).sum()
}

/// As single precision has it.
fn rounded(outline: &[[f64; 2]]) -> Vec<[f64; 2]> {
    outline.iter().map(|p| p.map(|x| f64::from(x as f32))).collect()
}

/// Checks what holds for every simple outline: the area, the number of triangles, no sliver, and that every
/// edge of the outline is one of theirs.
fn check(outline: &[[f64; 2]]) {
    let points = flat(outline);
    let done = triangulated(&points);
    assert_eq!(done.notes(), [] as [&str; 0], "{outline:?}");
    let expected = shoelace(&rounded(outline));
    assert!(
        (area(&points, &done.triangles) - expected).abs() < 1e-9 * expected,
        "{outline:?} {:?}",
        done.triangles
    );
    assert_eq!(done.triangles.len(), outline.len() - 2);
    assert!(
        done.triangles.iter().all(|t| !is_sliver(t.map(|v| points[v as usize]))),
        "{outline:?} {:?}",
        done.triangles
    );
    let count = outline.len() as u32;
    for edge in (0..count).map(|i| [i, (i + 1) % count]) {
        assert!(done.triangles.iter().any(|t| (0..3).any(|k| [t[k], t[(k + 1) % 3]] == edge)), "{edge:?}");
    }
}

#[test]
fn convex_polygons_are_fans() {
    for count in [4, 5, 17, 1000] {
        let angle = |i: u32| TAU * f64::from(i) / f64::from(count);
        let points: Vec<[f32; 3]> =
            (0..count).map(|i| [0.0, angle(i).cos() as f32, angle(i).sin() as f32]).collect();
        assert_eq!(
            triangulated(&points).triangles,
            (1..count - 1).map(|i| [0, i, i + 1]).collect::<Vec<_>>(),
            "{count}"
        );
    }
}

#[test]
fn concave_outlines_have_their_own_area() {
    let ell = [[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [1.0, 1.0], [1.0, 2.0], [0.0, 2.0]];
    for first in 0..6 {
        let mut turned = ell;
        turned.rotate_left(first);
        check(&turned);
    }
    let arrow = [[0.0, 0.0], [2.0, 0.0], [0.5, 0.5], [0.0, 2.0]];
    check(&arrow);
    let comb: Vec<[f64; 2]> = (0..40)
        .flat_map(|i| [[f64::from(i), 0.1], [f64::from(i) + 0.5, 3.0]])
        .chain([[40.0, 0.1], [40.0, 4.0], [0.0, 4.0]])
        .collect();
    check(&comb);
    let star: Vec<[f64; 2]> = (0..200)
        .map(|i| (TAU * f64::from(i) / 200.0, if i % 2 == 0 { 1.0 } else { 0.1 }))
        .map(|(a, r)| [r * a.cos(), r * a.sin()])
        .collect();
    check(&star);
    // A spiral of seven turns, one way out and the other way in.
    let arm = |i: u32, wide: f64| (0.2 * f64::from(i), 1.0 + 0.1 * f64::from(i) + wide);
    let spiral = (0..220)
        .map(|i| arm(i, 1.0))
        .chain((0..220).rev().map(|i| arm(i, 0.0)))
        .map(|(a, r)| [r * a.cos(), r * a.sin()]);
    check(&spiral.collect::<Vec<_>>());
}

#[test]
fn corners_on_a_line_stay_joined_to_their_neighbours() {
    // On the edges of a square, also at the first corner, where a fan would have triangles without a height.
    let square =
        [[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [2.0, 1.0], [2.0, 2.0], [0.5, 2.0], [0.0, 2.0], [0.0, 0.25]];
    for first in 0..8 {
        let mut turned = square;
        turned.rotate_left(first);
        check(&turned);
    }
    // As in single precision, where they lie on the line only nearly.
    let third = |i: u32| f64::from(i as f32 / 3.0 * 0.7);
    check(&[
        [0.0, 0.0],
        [third(1), third(1) * 0.1],
        [third(2), third(2) * 0.1],
        [third(3), third(3) * 0.1],
        [0.1, 1.0],
    ]);
}

#[test]
fn repeated_corners_and_cuts_to_holes_add_nothing() {
    let twice = [
        [0.0, 0.0],
        [0.0, 0.0],
        [2.0, 0.0],
        [2.0, 1.0],
        [2.0, 1.0],
        [1.0, 1.0],
        [1.0, 2.0],
        [0.0, 2.0],
        [0.0, 0.0],
    ];
    let points = flat(&twice);
    assert_eq!(area(&points, &triangulated(&points).triangles), 6.0);
    // A square of 4 with a hole of 2, as programs write it: along a cut to the hole, around it, and back.
    let cut = [
        [0.0, 0.0],
        [4.0, 0.0],
        [4.0, 4.0],
        [0.0, 4.0],
        [0.0, 0.0],
        [1.0, 1.0],
        [1.0, 3.0],
        [3.0, 3.0],
        [3.0, 1.0],
        [1.0, 1.0],
    ];
    let points = flat(&cut);
    let done = triangulated(&points);
    assert_eq!((area(&points, &done.triangles), done.notes().len()), (24.0, 0));
    // A spike that has no width, and an outline that touches itself in one corner.
    let spike = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [5.0, 5.0], [1.0, 1.0], [0.0, 1.0]];
    let points = flat(&spike);
    assert_eq!(area(&points, &triangulated(&points).triangles), 2.0);
    let eight = [[0.0, 0.0], [2.0, 0.0], [1.0, 1.0], [2.0, 2.0], [0.0, 2.0], [1.0, 1.0]];
    let points = flat(&eight);
    assert_eq!(area(&points, &triangulated(&points).triangles), 4.0);
}

#[test]
fn outlines_that_cross_themselves_are_told_and_become_fans() {
    let tie = [[0.0, 0.0], [2.0, 0.0], [0.0, 1.0], [2.0, 3.0]];
    let pentagram: Vec<[f64; 2]> =
        (0..5).map(|i| TAU * 0.4 * f64::from(i)).map(|a| [a.cos(), a.sin()]).collect();
    let twice_around: Vec<[f64; 2]> =
        (0..8).map(|i| TAU * 0.25 * f64::from(i)).map(|a| [a.cos(), a.sin()]).collect();
    for outline in [tie.to_vec(), pentagram, twice_around] {
        let done = triangulated(&flat(&outline));
        assert_eq!(done.triangles, (1..outline.len() as u32 - 1).map(|i| [0, i, i + 1]).collect::<Vec<_>>());
        assert_eq!(
            done.notes(),
            [
                "the outlines of 1 face cross themselves or have no inside; triangulated as fans, which may overlap"
            ]
        );
    }
    // Corners on one line are no face at all, which the builder counts; nothing is said of crossing.
    let line = triangulated(&flat(&[[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [1.5, 0.0]]));
    assert_eq!((line.triangles.len(), line.notes().len()), (2, 0));
    assert_eq!(
        triangulated(&flat(&[[0.0, 0.0], [1.0, 0.0]])).notes(),
        ["ignored 1 face with fewer than three corners"]
    );
}

#[test]
fn a_face_that_is_not_flat_keeps_its_corners() {
    // A bent arrow: seen along its mean normal it is simple, and so it is triangulated.
    let points = [[0.0, 0.0, 0.1], [2.0, 0.0, 0.0], [0.5, 0.5, 0.2], [0.0, 2.0, 0.0]];
    let done = triangulated(&points);
    assert_eq!((done.triangles.len(), done.notes().len()), (2, 0));
    assert!(
        done.triangles
            .iter()
            .all(|t| area_vector(t.map(|v| points[v as usize])).z > 0.0 && t.contains(&2) && t.contains(&0))
    );
}

/// Outlines around the origin with corners in order of their angle, less than half a turn apart.
fn around_the_origin() -> impl Strategy<Value = Vec<[f64; 2]>> {
    prop::collection::vec((0.3..1.0_f64, 0.1..1.0_f64), 5..60).prop_map(|corners| {
        let whole: f64 = corners.iter().map(|(step, _)| step).sum();
        let angles = corners.iter().scan(0.0, |sum, (step, _)| {
            *sum += step;
            Some(*sum * TAU / whole)
        });
        angles.zip(&corners).map(|(a, (_, r))| [r * a.cos(), r * a.sin()]).collect()
    })
}

/// Outlines between two chains that run to the right, the upper above the lower.
fn between_chains() -> impl Strategy<Value = Vec<[f64; 2]>> {
    let chain = || prop::collection::vec((0.1..1.0_f64, 0.0..1.0_f64), 2..30);
    (chain(), chain()).prop_map(|(lower, upper)| {
        // From x = 0 to 1.
        let run = |chain: &[(f64, f64)], offset: f64| {
            let width: f64 = chain.iter().skip(1).map(|(step, _)| step).sum();
            let x = |i: usize| chain[1..=i].iter().map(|(step, _)| step).sum::<f64>() / width;
            chain.iter().enumerate().map(|(i, (_, y))| [x(i), y + offset]).collect::<Vec<_>>()
        };
        let mut outline = run(&lower, 0.0);
        outline.extend(run(&upper, 1.01).into_iter().rev());
        outline
    })
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn any_simple_outline_in_any_plane_has_its_area(
        outline in prop_oneof![around_the_origin(), between_chains()],
        axis in [-1.0..1.0_f64, -1.0..1.0, 0.1..1.0], angle in 0.0..TAU, size in -3.0..3.0_f64, first in 0..60_usize,
    ) {
        let turn = DQuat::from_axis_angle(DVec3::from(axis).normalize(), angle);
        let size = 10.0_f64.powf(size);
        let mut outline = outline;
        let first = first % outline.len();
        outline.rotate_left(first);
        let place = |p: &[f64; 2]| (turn * (size * DVec3::new(p[0], p[1], 0.0) + DVec3::new(0.3, -0.2, 0.7) * size)).as_vec3().to_array();
        let points: Vec<[f32; 3]> = outline.iter().map(place).collect();
        let done = triangulated(&points);
        prop_assert_eq!(done.notes().len(), 0);
        prop_assert_eq!(done.triangles.len(), outline.len() - 2);
        let vectors: Vec<DVec3> = done.triangles.iter().map(|t| area_vector(t.map(|v| points[v as usize]))).collect();
        let normal = turn * DVec3::Z;
        // The shoelace formula in space, of the corners as they are rounded.
        let next = points.iter().cycle().skip(1);
        let expected = points.iter().zip(next).map(|(a, b)| area_vector([points[0], *a, *b])).sum::<DVec3>().length();
        prop_assert!((expected / (shoelace(&outline) * size * size) - 1.0).abs() < 1e-4);
        let sum = vectors.iter().map(|v| v.length()).sum::<f64>();
        prop_assert!((sum - expected).abs() < 1e-6 * expected, "{} {}", sum, expected);
        prop_assert!(vectors.iter().all(|v| v.dot(normal) > -1e-6 * expected));
    }

    #[test]
    fn any_corners_at_all_give_triangles_of_them(corners in prop::collection::vec([0..4_i32, 0..4, 0..2], 4..14)) {
        let points: Vec<[f32; 3]> = corners.iter().map(|c| c.map(|x| x as f32)).collect();
        let done = triangulated(&points);
        prop_assert!(!done.triangles.is_empty() && done.triangles.len() == done.smoothing.len());
        prop_assert!(done.triangles.as_flattened().iter().all(|v| (*v as usize) < points.len()));
        // Those of an outline that does not cross itself all face as it does on the mean.
        let area_of = |t: &[u32; 3]| area_vector(t.map(|v| points[v as usize]));
        let mean: DVec3 = (1..points.len() as u32 - 1).map(|i| area_of(&[0, i, i + 1])).sum();
        prop_assert!(!done.notes().is_empty() || done.triangles.iter().all(|t| area_of(t).dot(mean) > -1e-9));
        prop_assert_eq!(triangulated(&points).triangles, done.triangles);
    }
}
