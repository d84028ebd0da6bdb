//! Lathed shapes against closed forms.

use super::tests::{mesh, shape};
use crate::scene::Mesh;
use crate::test_support::{enclosed_volume, open_edges};
use glam::{DVec3, Vec3};
use std::f64::consts::PI;

fn lathed(profile: &str, segments: u32) -> Mesh {
    mesh(&format!("shape = 'lathe'\nprofile = {profile}\nsegments = {segments}"))
}

fn area(mesh: &Mesh) -> f64 {
    let of = |t: &[u32; 3]| {
        let [a, b, c]: [DVec3; 3] = t.map(|v| Vec3::from(mesh.positions[v as usize]).as_dvec3());
        (b - a).cross(c - a).length() / 2.0
    };
    mesh.triangles.iter().map(of).sum()
}

/// Largest distance of any normal from what `expected` gives at its place; none that fits scores 2.
fn worst_normal(mesh: &Mesh, expected: impl Fn(DVec3) -> Vec<DVec3>) -> f64 {
    let off = |(p, n): (&[f32; 3], &[f32; 3])| {
        let n = Vec3::from(*n).as_dvec3();
        let choices = expected(Vec3::from(*p).as_dvec3());
        choices.iter().map(|choice| choice.distance(n)).fold(2.0, f64::min)
    };
    mesh.positions.iter().zip(&mesh.normals).map(off).fold(0.0, f64::max)
}

fn radial(p: DVec3) -> DVec3 {
    DVec3::new(p.x, 0.0, p.z).normalize_or_zero()
}

#[test]
fn a_cylinder_has_its_area_and_hard_rims() {
    let (n, radius, height) = (24, 0.5, 1.5);
    // Prism over a regular polygon: the closed form of what is drawn, not of the ideal.
    let sides = f64::from(n) * 2.0 * radius * (PI / f64::from(n)).sin() * height;
    let base = f64::from(n) / 2.0 * radius * radius * (2.0 * PI / f64::from(n)).sin();
    // Either end may come first.
    for profile in ["[[0, 0], [0.5, 0], [0.5, 1.5], [0, 1.5]]", "[[0, 1.5], [0.5, 1.5], [0.5, 0], [0, 0]]"] {
        let mesh = lathed(profile, n);
        assert_eq!(open_edges(&mesh), 0);
        assert!((area(&mesh) / (sides + 2.0 * base) - 1.0).abs() < 1e-6);
        assert!((enclosed_volume(&mesh) / (base * height) - 1.0).abs() < 1e-6);
        let off = worst_normal(&mesh, |p| match p.length() {
            _ if radial(p) == DVec3::ZERO => vec![DVec3::Y * (p.y - 0.75).signum()],
            _ => vec![radial(p), DVec3::Y * (p.y - 0.75).signum()],
        });
        assert!(off < 1e-6, "{off}");
        // Rims twice, for walls and for bases; and a middle of its own for each segment of a base.
        assert_eq!(mesh.positions.len(), 4 * (n as usize + 1) + 2 * n as usize);
    }
}

#[test]
fn a_cone_has_its_area_and_a_point() {
    let (n, radius, height) = (32, 0.6, 0.8);
    let half = PI / f64::from(n);
    let slant = (height * height + (radius * half.cos()).powi(2)).sqrt();
    let sides = f64::from(n) * radius * half.sin() * slant;
    let mesh = lathed("[[0.6, 0], [0, 0.8]]", n);
    assert!((area(&mesh) / sides - 1.0).abs() < 1e-6);
    assert_eq!((mesh.triangles.len(), mesh.positions.len()), (32, 33 + 32));
    // A 3-4-5 triangle; at the point every segment has the normal of its middle.
    let slope = |direction: DVec3| 0.8 * direction + 0.6 * DVec3::Y;
    let middles: Vec<DVec3> = (0..n)
        .map(|i| (f64::from(i) + 0.5) * 2.0 * half)
        .map(|a| DVec3::new(a.cos(), 0.0, -a.sin()))
        .collect();
    let off = worst_normal(&mesh, |p| match radial(p) {
        DVec3::ZERO => middles.iter().map(|middle| slope(*middle)).collect(),
        direction => vec![slope(direction)],
    });
    assert!(off < 1e-6, "{off}");
}

/// The rule for normals is exact on a circle, however its points are spaced.
#[test]
fn a_turned_circle_is_a_sphere() {
    let angles = [0.0, 0.2, 0.5, 0.9, 1.1, 1.5, 2.0, 2.4, 2.8, 3.0].map(|a: f64| a - PI / 2.0);
    let points: Vec<String> =
        angles.iter().map(|a| format!("[{}, {}]", a.cos(), a.sin())).chain(["[0, 1]".to_owned()]).collect();
    let profile = format!("[{}]", points.join(", ")).replacen(&points[0], "[0, -1]", 1);
    let mesh = lathed(&profile, 48);
    assert_eq!(open_edges(&mesh), 0);
    assert!(worst_normal(&mesh, |p| vec![p.normalize()]) < 2e-6);
    // Chords of 0.5 lose 0.5²/12 of the area about the axis, 48 segments 0.3 %.
    let ideal = 4.0 / 3.0 * PI;
    assert!((0.95..1.0).contains(&(enclosed_volume(&mesh) / ideal)));
}

/// A profile that ends where it begins is a ring with a section of that form, without a seam in its normals.
#[test]
fn a_closed_profile_is_a_torus() {
    let points: Vec<String> = (0..=24)
        .map(|i| 2.0 * PI * f64::from(i % 24) / 24.0)
        .map(|a| format!("[{}, {}]", 1.0 + 0.25 * a.cos(), 0.25 * a.sin()))
        .collect();
    let mesh = lathed(&format!("[{}]", points.join(", ")), 64);
    assert_eq!(open_edges(&mesh), 0);
    assert!(worst_normal(&mesh, |p| vec![(p - radial(p)).normalize()]) < 1e-5);
    let relative = enclosed_volume(&mesh) / (2.0 * PI * PI * 0.25 * 0.25);
    assert!((0.98..1.0).contains(&relative), "{relative}");
}

#[test]
fn a_flat_profile_is_a_disc_that_faces_up() {
    for profile in ["[[0, 0], [1, 0]]", "[[1, 0], [0, 0]]"] {
        let mesh = lathed(profile, 16);
        assert!(worst_normal(&mesh, |_| vec![DVec3::Y]) < 1e-6);
        assert!((area(&mesh) - 8.0 * (PI / 8.0).sin()).abs() < 1e-6);
    }
}

#[test]
fn counts_are_those_of_the_mesh() {
    for profile in
        ["[[0, 0], [1, 0.1], [0.5, 1], [0, 1.1]]", "[[0.5, 0], [1, 1]]", "[[1, 0], [2, 0], [1, 1], [1, 0]]"]
    {
        let text = format!("shape = 'lathe'\nprofile = {profile}\nsegments = 7");
        let (counted, part) = (shape(&text).unwrap(), shape(&text).unwrap().part());
        let given = (part.positions.len() as u64, part.triangles.len() as u64);
        assert_eq!((counted.vertices(), counted.triangles()), given, "{profile}");
    }
}

#[test]
fn bad_profiles_are_refused() {
    for (profile, part) in [
        ("[]", "the profile has 0 of 2 to 4096 points; add or remove some"),
        ("[[1, 0]]", "the profile has 1 of 2 to 4096 points"),
        ("[[-1, 0], [1, 1]]", "the radius -1 of point 1 of the profile must be a number of 0 to 1e9 m"),
        ("[[1, 0], [nan, 1]]", "the radius NaN of point 2"),
        ("[[1, 0], [inf, 1]]", "the radius inf of point 2"),
        ("[[1, 0], [1, -inf]]", "the height -inf of point 2"),
        ("[[1, 0], [0, 1], [1, 2]]", "point 2 of the profile lies on the axis, where only its ends may"),
        ("[[0, 0], [1, 0], [1, 0], [0, 1]]", "points 2 and 3 of the profile are the same; remove one"),
        ("[[0, 0], [0, 1]]", "the whole profile lies on the axis; give a point a radius above 0"),
        ("[[0, 0, 1], [0, 1]]", "3 numbers where 2 are expected"),
    ] {
        let message = shape(&format!("shape = 'lathe'\nprofile = {profile}")).unwrap_err().to_string();
        assert!(message.contains(part) && !message.contains('\n'), "{profile}: {message}");
    }
    let many = vec!["[1, 0], [1, 1]"; 2049].join(", ");
    for (text, part) in [
        ("shape = 'lathe'".to_owned(), "needs a `profile`; add one, such as [[0, 0], [0.5, 0], [0, 1]]"),
        ("shape = 'box'\nprofile = [[0, 0], [1, 1]]".to_owned(), "`profile` is no parameter of this shape"),
        (format!("shape = 'lathe'\nprofile = [{many}]"), "the profile has 4098 of 2 to 4096 points"),
        (
            "shape = 'lathe'\nprofile = [[1, 0], [1, 1]]\nsegments = 2".to_owned(),
            "segments 2 is outside 3..8192",
        ),
    ] {
        let message = shape(&text).unwrap_err().to_string();
        assert!(message.contains(part), "{message}");
    }
}
