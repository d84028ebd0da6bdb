//! Normals of deformed meshes against closed forms.

use super::*;
use glam::{DMat3, DVec3, Vec3};

/// A grid of (n + 1)² vertices over the square from -1 to 1, at `place`(u, v), its front towards u × v.
fn grid(n: usize, place: impl Fn(f64, f64) -> DVec3) -> (Vec<[f32; 3]>, Vec<[u32; 3]>) {
    let at = |k: usize| 2.0 * k as f64 / n as f64 - 1.0;
    let positions = (0..=n)
        .flat_map(|j| (0..=n).map(move |i| (i, j)))
        .map(|(i, j)| place(at(i), at(j)).as_vec3().to_array())
        .collect();
    let triangles = (0..n * (n + 1)).filter(|k| k % (n + 1) < n).flat_map(|k| {
        let [a, b, c, d] = [k, k + 1, k + n + 1, k + n + 2].map(|v| v as u32);
        [[a, b, d], [a, d, c]]
    });
    (positions, triangles.collect())
}

fn angle(a: [f32; 3], b: DVec3) -> f64 {
    Vec3::from(a).as_dvec3().angle_between(b)
}

#[test]
fn at_rest_they_are_those_given_bit_by_bit() {
    let (positions, triangles) = grid(8, |u, v| DVec3::new(u, v, 0.3 * (3.0 * u).sin() * v));
    // Nothing that the triangles would give.
    let normals: Vec<[f32; 3]> =
        (0..positions.len()).map(|k| Vec3::new((k as f32).sin(), 0.3, 1.0).normalize().to_array()).collect();
    let mut out = vec![[f32::NAN; 3]; 3];
    ShadingNormals::new(&positions, &normals, &triangles).at(&positions, &mut out);
    assert_eq!(out, normals);
}

#[test]
fn a_plane_under_an_affine_map_takes_its_cofactors() {
    let (rest, triangles) = grid(4, |u, v| DVec3::new(u, v, 0.0));
    let shading = ShadingNormals::new(&rest, &vec![[0.0, 0.0, 1.0]; rest.len()], &triangles);
    let maps = [
        DMat3::from_axis_angle(DVec3::new(1.0, 2.0, -2.0) / 3.0, 2.5),
        DMat3::from_cols(DVec3::new(1.0, 0.0, 0.7), DVec3::new(0.2, 3.0, -0.4), DVec3::new(0.0, 0.5, 0.1)),
    ];
    for map in maps {
        let moved: Vec<[f32; 3]> =
            rest.iter().map(|p| (map * Vec3::from(*p).as_dvec3()).as_vec3().to_array()).collect();
        let expected = (map * DVec3::X).cross(map * DVec3::Y).normalize();
        let mut out = Vec::new();
        shading.at(&moved, &mut out);
        // Positions are rounded to f32, 6e-8 of at most 3, over sides of 0.5.
        out.iter().for_each(|n| assert!(angle(*n, expected) < 1e-6, "{n:?} {expected}"));
    }
}

#[test]
fn what_shears_turns_the_normals_although_no_joint_turns() {
    // z = x² − y², as morph targets or weights would make of a plane; n = (−2x, 2y, 1).
    let (rest, triangles) = grid(64, |u, v| DVec3::new(u, v, 0.0));
    let (saddle, _) = grid(64, |u, v| DVec3::new(u, v, u * u - v * v));
    let mut out = Vec::new();
    ShadingNormals::new(&rest, &vec![[0.0, 0.0, 1.0]; rest.len()], &triangles).at(&saddle, &mut out);
    for (normal, [x, y, _]) in out.iter().zip(&saddle).filter(|(_, p)| p[0].abs() < 1.0 && p[1].abs() < 1.0) {
        // Second differences are exact on quadrics: only the weights by area tilt the mean, by the square of
        // the side.
        let expected = DVec3::new(-2.0 * f64::from(*x), 2.0 * f64::from(*y), 1.0);
        assert!(angle(*normal, expected) < (1.0f64 / 32.0).powi(2) * 4.0, "{normal:?} {expected}");
    }
}

#[test]
fn seams_stay_closed_and_creases_open() {
    // A roof of two squares: the ridge is there twice. With one normal it is a seam, with two it is a crease.
    let positions = [
        [0.0, 0.0, 0.0],
        [0.0, 1.0, 0.0],
        [1.0, 0.0, 0.0],
        [1.0, 1.0, 0.0],
        [0.0, 0.0, 0.0],
        [0.0, 1.0, 0.0],
        [-1.0, 0.0, 0.0],
        [-1.0, 1.0, 0.0],
    ];
    let triangles = [[0, 2, 3], [0, 3, 1], [4, 7, 6], [4, 5, 7]];
    let mut folded = positions;
    (folded[2], folded[3], folded[6], folded[7]) =
        ([0.8, 0.0, -0.6], [0.8, 1.0, -0.6], [-0.8, 0.0, -0.6], [-0.8, 1.0, -0.6]);
    let flat = [[0.0, 0.0, 1.0]; 8];
    let mut out = Vec::new();
    ShadingNormals::new(&positions, &flat, &triangles).at(&folded, &mut out);
    for vertex in [0, 4, 1, 5] {
        assert!(angle(out[vertex], DVec3::Z) < 0.4, "{:?}", out[vertex]);
        assert_eq!(out[vertex], out[(vertex + 4) % 8], "one normal along the seam");
    }
    let mut creased = flat;
    creased[4..].iter_mut().for_each(|n| *n = [0.0, 0.1f32.sin(), 0.1f32.cos()]);
    ShadingNormals::new(&positions, &creased, &triangles).at(&folded, &mut out);
    assert!(angle(out[0], DVec3::new(0.6, 0.0, 0.8)) < 1e-6, "{:?}", out[0]);
    assert!(out[4][0] < -0.5, "{:?}", out[4]);
}

#[test]
fn sums_by_vertex_are_the_means() {
    let (rest, mut triangles) = grid(5, |u, v| DVec3::new(u, v, 0.2 * u * v));
    // A seam along a row of vertices that are there twice, one that nothing touches, and a triangle that meets
    // the place of two of its corners.
    let (mut rest, count) = (rest, 36);
    rest.extend_from_within(12..18);
    rest.push([5.0, 5.0, 5.0]);
    let doubled = |v: u32| if (12..18).contains(&v) { v - 12 + count } else { v };
    triangles.iter_mut().skip(20).for_each(|t| *t = t.map(doubled));
    triangles.push([13, 37, 20]);
    let normals = vec![[0.0, 0.0, 1.0]; rest.len()];
    let shading = ShadingNormals::new(&rest, &normals, &triangles);
    let (surrounded, meeting) = shading.by_vertex();
    assert_eq!((surrounded.len(), meeting.len()), (rest.len(), 3 * triangles.len()));
    assert_eq!(surrounded[12], surrounded[36], "one place");
    assert!(surrounded[42].triangles.is_empty());
    let at = |v: u32| Vec3::from(rest[v as usize]).as_dvec3();
    for vertex in &surrounded {
        let own = &meeting[vertex.triangles.start as usize..vertex.triangles.end as usize];
        let areas = own.iter().map(|[a, b, c]| (at(*b) - at(*a)).cross(at(*c) - at(*a)));
        let mean = areas.fold(DVec3::ZERO, |sum, area| sum + area).normalize_or_zero();
        assert_eq!((vertex.mean, vertex.normal), (mean.as_vec3().to_array(), [0.0, 0.0, 1.0]), "bit by bit");
    }
    let places = |triangle: &[u32; 3]| triangle.map(|v| surrounded[v as usize].triangles.clone());
    let twice = meeting.iter().filter(|t| **t == [13, 37, 20]).count();
    assert!(twice == 3 && places(&[13, 37, 20])[0] == places(&[13, 37, 20])[1]);
}

#[test]
fn collapsed_and_strange_meshes_keep_the_rest() {
    let (rest, mut triangles) = grid(2, |u, v| DVec3::new(u, v, 0.0));
    triangles.push([0, 1, 99]);
    let normals = vec![[0.0, 0.0, 1.0]; rest.len()];
    let shading = ShadingNormals::new(&rest, &normals, &triangles);
    let mut out = Vec::new();
    shading.at(&vec![[0.5; 3]; rest.len()], &mut out);
    assert_eq!(out, normals);
    shading.at(&rest[..4], &mut out);
    assert!(out.len() == rest.len() && out.as_flattened().iter().all(|x| x.is_finite()));
    let mirrored: Vec<[f32; 3]> = rest.iter().map(|[x, y, z]| [-x, *y, *z]).collect();
    shading.at(&mirrored, &mut out);
    assert_eq!(out, vec![[-0.0, -0.0, -1.0]; rest.len()], "what is seen from behind has turned around");
}
