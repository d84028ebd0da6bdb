use super::*;
use crate::description::ObjectFile;
use crate::geometry::MeshBuilder;
use crate::scene::Mesh;
use crate::test_support::{enclosed_volume, open_edges};
use glam::{DAffine3, Vec3};
use std::f64::consts::PI;

pub(super) fn shape(text: &str) -> Result<Shape> {
    let place = Place::file("scene.toml").part("object `it`");
    let object: ObjectFile =
        relume_formats::state::parse_toml(&format!("name = 'it'\nmaterial = 'm'\n{text}"), &place)?;
    Shape::from_object(object.shape.unwrap(), &object, &place)
}

pub(super) fn mesh(text: &str) -> Mesh {
    let (place, mut warnings, mut builder) = (Place::file("scene.toml"), Vec::new(), MeshBuilder::default());
    builder.append(&shape(text).unwrap().part(), &DAffine3::IDENTITY, &place).unwrap();
    let mesh = builder.finish(&place, &mut warnings).unwrap();
    assert_eq!(warnings, [] as [&str; 0], "{text}");
    mesh
}

/// Twice the mean curvature is no concern here: a normal must agree with the faces around it to within their
/// coarseness.
fn smallest_face_agreement(mesh: &Mesh) -> f32 {
    let face = |t: &[u32; 3]| {
        let [a, b, c] = t.map(|v| Vec3::from(mesh.positions[v as usize]));
        let n = (b - a).cross(c - a).normalize();
        t.iter().map(|v| n.dot(mesh.normals[*v as usize].into())).fold(1.0, f32::min)
    };
    mesh.triangles.iter().map(face).fold(1.0, f32::min)
}

#[test]
fn closed_shapes_are_watertight_and_face_outwards() {
    // Volumes of the ideal shapes; a tessellation with n segments loses about (2π/n)²/6 per curved direction.
    let torus = 2.0 * PI * PI * 0.25 * 0.25;
    let ring = PI * (1.0 - 0.81) * 0.5;
    for (text, volume, tolerance) in [
        ("shape = 'box'", 1.0, 1e-6),
        ("shape = 'sphere'", 4.0 / 3.0 * PI, 0.01),
        ("shape = 'sphere'\nsubdivisions = 0", 2.536_150_7, 1e-5),
        ("shape = 'torus'", torus, 0.01),
        ("shape = 'ring'", ring, 0.001),
    ] {
        let mesh = mesh(text);
        assert_eq!(open_edges(&mesh), 0, "{text}");
        let relative = enclosed_volume(&mesh) / volume - 1.0;
        assert!(relative.abs() < tolerance, "{text}: {relative}");
    }
}

#[test]
fn torus_knots_are_watertight_tubes() {
    for (p, q) in [(2, 3), (3, 2), (1, 1), (3, 7)] {
        let mesh = mesh(&format!("shape = 'torus-knot'\np = {p}\nq = {q}\nsegments = 512\ntube = 0.1"));
        assert_eq!(open_edges(&mesh), 0, "({p}, {q})");
        // Pappus: a tube of radius r along a curve of length l encloses π r² l, whatever the curve.
        let volume = PI * 0.01 * curve_length(f64::from(p), f64::from(q));
        let relative = enclosed_volume(&mesh) / volume - 1.0;
        assert!((-0.02..0.0).contains(&relative), "({p}, {q}): {relative}");
        assert!(smallest_face_agreement(&mesh) > 0.95, "({p}, {q})");
    }
}

/// Length of the knot's curve at radius 1, by chords.
fn curve_length(p: f64, q: f64) -> f64 {
    let point = |t: f64| {
        let reach = 2.0 + (q * t).cos();
        glam::DVec3::new(reach * (p * t).cos(), (q * t).sin(), reach * (p * t).sin()) / 3.0
    };
    let n = 100_000;
    let at = |i: i32| point(2.0 * PI * f64::from(i) / f64::from(n));
    (0..n).map(|i| at(i).distance(at(i + 1))).sum()
}

#[test]
fn normals_are_unit_and_agree_with_the_faces() {
    for text in [
        "shape = 'quad'",
        "shape = 'box'",
        "shape = 'sphere'",
        "shape = 'torus'",
        "shape = 'torus-knot'",
        "shape = 'ring'",
        "shape = 'lathe'\nprofile = [[0, 0], [0.5, 0.1], [0.6, 0.4], [0.2, 0.5], [0.2, 1], [0, 1]]",
    ] {
        let mesh = mesh(text);
        assert!(mesh.normals.iter().all(|n| (Vec3::from(*n).length() - 1.0).abs() < 1e-6), "{text}");
        assert!(smallest_face_agreement(&mesh) > 0.95, "{text}");
    }
}

#[test]
fn the_quad_faces_up_and_has_unit_area() {
    let mesh = mesh("shape = 'quad'");
    assert_eq!(mesh.triangles.len(), 2);
    assert!(mesh.positions.iter().all(|p| p[1] == 0.0 && p[0].abs() == 0.5 && p[2].abs() == 0.5));
    assert!(mesh.normals.iter().all(|n| *n == [0.0, 1.0, 0.0]));
}

#[test]
fn a_quad_in_segments_is_the_same_square() {
    let mesh = mesh("shape = 'quad'\nsegments = 7");
    assert_eq!((mesh.positions.len(), mesh.triangles.len()), (8 * 8, 2 * 7 * 7));
    let area = |t: &[u32; 3]| {
        let [a, b, c] = t.map(|i| Vec3::from(mesh.positions[i as usize]));
        (b - a).cross(c - a).y / 2.0
    };
    // Every triangle faces up and is as large as the next.
    assert!(mesh.triangles.iter().all(|t| (area(t) - 0.5 / 49.0).abs() < 1e-6));
    let corners = [[-0.5, 0.0, -0.5], [0.5, 0.0, 0.5]];
    assert!(corners.iter().all(|corner| mesh.positions.contains(corner)));
}

#[test]
fn wrong_parameters_are_refused() {
    for (text, part) in [
        (
            "shape = 'box'\ntube = 0.1",
            "scene.toml: object `it`: `tube` is no parameter of this shape; it has none",
        ),
        ("shape = 'ring'\nradius = 1.0", "it has inner_radius, outer_radius, height, segments"),
        ("shape = 'torus-not'", "did you mean `torus-knot`?"),
        ("shape = 'sphere'\nsubdivisions = 10", "subdivisions 10 is outside 0..9"),
        ("shape = 'torus'\nsides = 2", "sides 2 is outside 3..512"),
        ("shape = 'ring'\nheight = -1", "height -1 must be a number above 0"),
        ("shape = 'ring'\nheight = nan", "height NaN must be a number above 0"),
        ("shape = 'ring'\ninner_radius = 2", "inner_radius must be smaller"),
        ("shape = 'torus'\nminor_radius = 1", "minor_radius must be smaller"),
        ("shape = 'torus-knot'\np = 2\nq = 4", "no common divisor"),
        ("shape = 'torus-knot'\ntube = 0.5", "thinner than a third"),
    ] {
        let message = shape(text).unwrap_err().to_string();
        assert!(message.contains(part), "{text}: {message}");
    }
}

/// Direction in which a texture coordinate grows on a triangle, in the triangle's plane.
fn gradient(mesh: &Mesh, triangle: &[u32; 3], axis: usize) -> Vec3 {
    let [a, b, c] = triangle.map(|v| Vec3::from(mesh.positions[v as usize]));
    let [s, t, r] = triangle.map(|v| mesh.uvs[v as usize][axis]);
    let normal = (b - a).cross(c - a);
    ((t - s) * (c - a) - (r - s) * (b - a)).cross(normal) / normal.length_squared()
}

#[test]
fn textures_stand_upright_on_every_shape() {
    for text in [
        "shape = 'quad'",
        "shape = 'box'",
        "shape = 'sphere'",
        "shape = 'torus'",
        "shape = 'torus-knot'",
        "shape = 'ring'",
        "shape = 'lathe'\nprofile = [[0, 0], [0.5, 0.1], [0.6, 0.4], [0.2, 0.5], [0.2, 1], [0, 1]]",
    ] {
        let mesh = mesh(text);
        assert_eq!(mesh.uvs.len(), mesh.positions.len(), "{text}");
        for triangle in &mesh.triangles {
            let [a, b, c] = triangle.map(|v| Vec3::from(mesh.positions[v as usize]));
            let normal = (b - a).cross(c - a);
            // Seen from the front u grows to the right and v down: never mirrored, and no triangle runs
            // backwards across a seam.
            let (u, v) = (gradient(&mesh, triangle, 0), gradient(&mesh, triangle, 1));
            assert!(v.cross(u).dot(normal) > 0.0, "{text}: {triangle:?}");
        }
    }
}

#[test]
fn gradients_of_flat_shapes_follow_the_axes() {
    let quad = mesh("shape = 'quad'");
    for triangle in &quad.triangles {
        assert_eq!((gradient(&quad, triangle, 0), gradient(&quad, triangle, 1)), (Vec3::X, Vec3::Z));
    }
    let cube = mesh("shape = 'box'");
    assert!(cube.uvs.iter().flatten().all(|x| *x == 0.0 || *x == 1.0));
    for triangle in cube.triangles.iter().filter(|t| cube.normals[t[0] as usize][1] == 0.0) {
        assert_eq!(gradient(&cube, triangle, 1), Vec3::NEG_Y, "upright on the sides");
    }
}

#[test]
fn a_sphere_wears_a_world_map() {
    let sphere = mesh("shape = 'sphere'\nsubdivisions = 3");
    for (p, uv) in sphere.positions.iter().zip(&sphere.uvs) {
        assert!((f64::from(p[1]).acos() / PI - f64::from(uv[1])).abs() < 1e-6);
        let longitude = 2.0 * PI * (f64::from(uv[0]) - 0.5);
        let radius = f64::from(p[0]).hypot(f64::from(p[2]));
        // At the poles any longitude will do.
        assert!(
            (f64::from(p[0]) - radius * longitude.sin()).abs() < 1e-6
                && (f64::from(p[2]) - radius * longitude.cos()).abs() < 1e-6
        );
    }
    // No triangle spans more than a tenth of the way round, except at the poles.
    let span = |t: &[u32; 3]| {
        let us = t.map(|v| sphere.uvs[v as usize][0]);
        us.iter().fold(f32::MIN, |m, u| m.max(*u)) - us.iter().fold(f32::MAX, |m, u| m.min(*u))
    };
    assert!(sphere.triangles.iter().map(span).fold(0.0, f32::max) <= 0.21);
}
