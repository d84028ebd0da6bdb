//! OBJ, PLY and OFF as other programs write them.

use crate::support::{expect_exit, run};
use glam::Vec3;
use relume_scenes::Mesh;
use std::path::{Path, PathBuf};

fn input(case: &str, file: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("cases/inputs").join(case).join(file)
}

/// The model of a case's scene as `bake export` writes it, and what was said on the way.
fn exported(scene: &Path) -> (Mesh, String) {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let stderr = expect_exit("bake", &["export", scene.to_str().unwrap(), "-o", out.to_str().unwrap()], 0);
    let mesh = relume_scenes::load_mesh(&out.join("object_001_model.ply"), &mut Vec::new()).unwrap();
    (mesh, stderr)
}

fn area(mesh: &Mesh) -> f32 {
    let corners = |t: &[u32; 3]| t.map(|v| Vec3::from(mesh.positions[v as usize]));
    mesh.triangles.iter().map(corners).map(|[a, b, c]| (b - a).cross(c - a).length() / 2.0).sum()
}

#[test]
fn marks_comments_continued_lines_and_empty_names_leave_one_triangle() {
    for case in ["obj-bom-shifts-vertices", "obj-line-continuation-and-comments", "obj-usemtl-without-name"] {
        let (mesh, _) = exported(&input(case, "scene.toml"));
        assert_eq!(mesh.positions, [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], "{case}");
        assert_eq!(mesh.triangles, [[0, 1, 2]], "{case}");
    }
}

#[test]
fn a_polyline_is_ignored_with_a_note_by_every_command() {
    let (mesh, stderr) = exported(&input("obj-polyline-becomes-faces", "scene.toml"));
    assert_eq!((mesh.triangles.len(), area(&mesh)), (1, 0.5));
    assert!(stderr.contains("polyline.obj: ignored 1 line, without a surface"), "{stderr}");
    let file = input("obj-polyline-becomes-faces", "polyline.obj");
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("x.relume");
    let stderr =
        expect_exit("bake", &["spheres", file.to_str().unwrap(), "-n", "1", "-o", out.to_str().unwrap()], 2);
    assert!(stderr.contains("polyline.obj: ignored 1 line, without a surface"), "{stderr}");
}

#[test]
fn a_bare_corner_takes_nothing_from_others() {
    let (mesh, stderr) = exported(&input("obj-mixed-corners-lose-uv", "scene.toml"));
    assert_eq!((mesh.positions.len(), mesh.normals.as_slice()), (6, [[0.0, 0.0, 1.0]; 6].as_slice()));
    let loaded =
        relume_scenes::load_mesh(&input("obj-mixed-corners-lose-uv", "mixed.obj"), &mut Vec::new()).unwrap();
    assert_eq!(loaded.uvs[..3], [[0.0, 1.0], [1.0, 1.0], [0.0, 0.0]]);
    assert!(
        stderr.contains("mixed.obj: gave the texture coordinates (0, 0) to 3 of 6 vertices, which had none"),
        "{stderr}"
    );
    assert!(
        stderr.contains("mixed.obj: made normals for 3 of 6 vertices, as none or zero were there"),
        "{stderr}"
    );
}

#[test]
fn a_cube_without_normals_has_hard_edges() {
    let (mesh, _) = exported(&input("obj-no-normals-all-smooth", "scene.toml"));
    assert_eq!(mesh.positions.len(), 24);
    let mut sides: Vec<[i32; 3]> =
        mesh.normals.iter().map(|n| n.map(|x| (x * 1000.0).round() as i32)).collect();
    sides.sort_unstable();
    sides.dedup();
    assert_eq!(
        sides,
        [[-1000, 0, 0], [0, -1000, 0], [0, 0, -1000], [0, 0, 1000], [0, 1000, 0], [1000, 0, 0]]
    );
}

#[test]
fn concave_polygons_keep_their_area_in_every_format() {
    let text = std::fs::read_to_string(input("polygon-concave-fan", "scene.toml")).unwrap();
    for file in ["ell.obj", "ell.ply", "ell.off"] {
        let folder = tempfile::tempdir().unwrap();
        std::fs::copy(input("polygon-concave-fan", file), folder.path().join(file)).unwrap();
        let scene = crate::support::write_scene(folder.path(), &text.replace("ell.obj", file));
        assert_eq!(area(&exported(&scene).0), 3.0, "{file}");
    }
}

#[test]
fn a_negative_vertex_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let (scene, out) = (input("ply-negative-index-message", "scene.toml"), folder.path().join("out"));
    let stderr = expect_exit("bake", &["export", scene.to_str().unwrap(), "-o", out.to_str().unwrap()], 2);
    assert!(
        stderr.contains(
            "neg.ply: face 0 names vertex -1 of 3, which count from 0; mend or export the file again"
        ),
        "{stderr}"
    );
}

#[test]
fn a_seam_of_rounding_is_closed_before_spheres_are_fitted() {
    let folder = tempfile::tempdir().unwrap();
    let fitted = |mesh: &Path| {
        let out = folder.path().join("spheres.relume");
        let output = run(
            "bake",
            &["spheres", mesh.to_str().unwrap(), "-n", "8", "--iterations", "5", "-o", out.to_str().unwrap()],
        );
        assert!(output.status.success());
        let (text, said) =
            (String::from_utf8(output.stdout).unwrap(), String::from_utf8(output.stderr).unwrap());
        let share = text
            .split("E/V(T) ")
            .nth(1)
            .and_then(|rest| rest.split_whitespace().next())
            .unwrap()
            .parse::<f64>()
            .unwrap();
        (share, said)
    };
    let (seam, said) = fitted(&input("spheres-seam-by-one-ulp", "seam.obj"));
    assert!(
        said.contains("vertices to others at less than a millionth of the diagonal, which closes the mesh"),
        "{said}"
    );
    assert!(!said.contains("winding number"), "{said}");
    let exact = std::fs::read_to_string(input("spheres-seam-by-one-ulp", "seam.obj"))
        .unwrap()
        .replace(".0000001", "")
        .replace("1e-07", "0");
    std::fs::write(folder.path().join("cube.obj"), exact).unwrap();
    let (cube, said) = fitted(&folder.path().join("cube.obj"));
    assert!(!said.contains("welded"), "{said}");
    assert!((seam / cube - 1.0).abs() < 0.01, "{seam} {cube}");
}
