//! Where edges are hard.

use super::polygon_file_tests::Folder;
use super::*;
use glam::{DVec3, Vec3};

const CUBE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n\
                    f 1 4 3 2\nf 5 6 7 8\nf 1 2 6 5\nf 3 4 8 7\nf 2 3 7 6\nf 1 5 8 4\n";

fn load_creased(text: &str, crease_deg: Option<f64>) -> (Mesh, Vec<String>) {
    let (folder, mut warnings) = (Folder::new(), Vec::new());
    let path = folder.write("t.obj", text);
    (load_file(&path, None, &DAffine3::IDENTITY, crease_deg, &mut warnings).unwrap(), warnings)
}

/// The unit normal of a triangle.
fn face_normal(mesh: &Mesh, triangle: [u32; 3]) -> DVec3 {
    builder::area_vector(triangle.map(|v| mesh.positions[v as usize])).normalize()
}

/// Every corner has the normal of its own triangle.
fn is_flat(mesh: &Mesh) -> bool {
    let fits = |t: &[u32; 3]| {
        t.iter()
            .all(|v| face_normal(mesh, *t).distance(Vec3::from(mesh.normals[*v as usize]).as_dvec3()) < 1e-5)
    };
    mesh.triangles.iter().all(fits)
}

/// A prism of so many sides around z, without its ends.
fn prism(sides: u32) -> String {
    let vertices = (0..sides)
        .map(|i| std::f64::consts::TAU * f64::from(i) / f64::from(sides))
        .map(|a| (a.cos(), a.sin()));
    let vertices: String = vertices.map(|(x, y)| format!("v {x} {y} 0\nv {x} {y} 1\n")).collect();
    let side = |i: u32| (2 * i + 1, 2 * ((i + 1) % sides) + 1);
    vertices
        + &(0..sides).map(side).map(|(a, b)| format!("f {a} {b} {} {}\n", b + 1, a + 1)).collect::<String>()
}

#[test]
fn a_cube_is_flat_and_a_round_thing_is_smooth() {
    let (cube, warnings) = load_creased(CUBE, None);
    assert_eq!((cube.positions.len(), is_flat(&cube)), (24, true));
    assert!(
        warnings[0].ends_with("smooth where faces meet at less than 40 degrees (`crease_deg`)"),
        "{warnings:?}"
    );
    // Sides of an octagon meet at 45 degrees, of one of ten corners at 36.
    let (octagon, _) = load_creased(&prism(8), None);
    assert_eq!((octagon.positions.len(), is_flat(&octagon)), (32, true));
    let (round, _) = load_creased(&prism(10), None);
    assert_eq!(round.positions.len(), 20);
    assert!(
        round
            .positions
            .iter()
            .zip(&round.normals)
            .all(|(p, n)| Vec3::from(*n).distance(Vec3::new(p[0], p[1], 0.0)) < 1e-6)
    );
}

#[test]
fn the_scene_may_give_another_angle() {
    let (smooth, warnings) = load_creased(CUBE, Some(100.0));
    assert_eq!(smooth.positions.len(), 8);
    // Weighted by angle, three right angles meet at each corner whatever the diagonals: the normal is the
    // cube's diagonal.
    for (p, n) in smooth.positions.iter().zip(&smooth.normals) {
        assert!(Vec3::from(*n).distance((Vec3::from(*p) - 0.5).normalize()) < 1e-6, "{p:?} {n:?}");
    }
    assert!(warnings[0].contains("less than 100 degrees"), "{warnings:?}");
    let (flat, _) = load_creased(&prism(100), Some(0.0));
    assert_eq!(
        (flat.positions.len(), is_flat(&flat)),
        (400, true),
        "the two triangles of a side share their corners"
    );
    assert_eq!(load_creased(&prism(8), Some(46.0)).0.positions.len(), 16);
    let (_, warnings) = load_creased("v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 1\nf 1//1 2//1 3//1\n", Some(30.0));
    assert!(
        warnings[0].ends_with("has normals of its own everywhere, which `crease_deg` leaves as they are"),
        "{warnings:?}"
    );
}

#[test]
fn smoothing_groups_are_obeyed_unless_the_scene_gives_an_angle() {
    let grouped = |statement: &str| CUBE.replacen("f ", &format!("{statement}\nf "), 1);
    for (text, count, told) in [
        (grouped("s 1"), 8, 0),
        (grouped("s on"), 8, 0),
        (grouped("s off"), 24, 0),
        (grouped("s 0"), 24, 0),
        (grouped("s"), 24, 1),
        (prism(100).replacen("f ", "s off\nf ", 1), 400, 0),
    ] {
        let (mesh, warnings) = load_creased(&text, None);
        assert_eq!((mesh.positions.len(), warnings.len()), (count, told), "{warnings:?}");
    }
    // The bottom and the top by themselves, the four sides together: corners are shared along the sides only.
    let three = grouped("s 1").replace("f 5 6", "s 2\nf 5 6").replace("f 1 2 6", "s 3\nf 1 2 6");
    assert_eq!(load_creased(&three, None).0.positions.len(), 16);
    assert_eq!(load_creased(&grouped("s 1"), Some(40.0)).0.positions.len(), 24);
    assert_eq!(load_creased(&prism(100).replacen("f ", "s off\nf ", 1), Some(180.0)).0.positions.len(), 200);
}

#[test]
fn seams_and_sheets_and_many_faces_at_an_edge() {
    // Two triangles of one plane whose corners stand twice: the seam is no crease, and its vertices stay two.
    let seam = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 0 0\nv 1 1 0.1\nv 0 1 0\nf 1 2 3\nf 4 5 6\n";
    let (mesh, _) = load_creased(seam, None);
    assert_eq!(mesh.positions.len(), 6);
    assert_eq!((mesh.normals[1], mesh.normals[2]), (mesh.normals[3], mesh.normals[5]));
    assert!(!is_flat(&mesh));
    // Both sides of a sheet on the same vertices: each side gets vertices of its own, even where all is
    // smooth.
    for crease in [None, Some(180.0)] {
        let (mesh, _) = load_creased("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nf 3 2 1\n", crease);
        assert_eq!(mesh.normals.iter().map(|n| n[2]).collect::<Vec<_>>(), [1.0, 1.0, 1.0, -1.0, -1.0, -1.0]);
    }
    // Pages of a book around one spine, 0, 20, 40, 180 and 200 degrees: two bundles.
    let page =
        |degrees: f64| format!("v {} {} 0.5\n", degrees.to_radians().cos(), degrees.to_radians().sin());
    let book = "v 0 0 0\nv 0 0 1\n".to_owned()
        + &[0.0, 20.0, 40.0, 180.0, 200.0].map(page).concat()
        + "f 1 2 3\nf 1 2 4\nf 1 2 5\nf 1 2 6\nf 1 2 7\n";
    let (mesh, _) = load_creased(&book, Some(25.0));
    assert_eq!(mesh.positions.len(), 7 + 2, "the spine once for each bundle");
    assert_eq!(mesh.triangles.iter().map(|t| t[0]).collect::<Vec<_>>(), [0, 0, 0, 7, 7]);
}

#[test]
fn faces_that_meet_in_a_point_only_have_normals_of_their_own() {
    let (mesh, _) =
        load_creased("v 0 0 0\nv 1 0 0\nv 1 1 0\nv -1 0 0.2\nv -1 -1 0\nf 1 2 3\nf 1 4 5\n", None);
    assert_eq!((mesh.positions.len(), is_flat(&mesh)), (6, true));
}
