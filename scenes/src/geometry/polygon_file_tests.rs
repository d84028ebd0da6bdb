//! PLY and OFF: every flavour against the same mesh as OBJ, and bad input.

use super::*;
use crate::scene::Mesh;
use std::path::PathBuf;

pub(super) struct Folder(tempfile::TempDir);

impl Folder {
    pub fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    pub fn write(&self, name: &str, content: impl AsRef<[u8]>) -> PathBuf {
        let path = self.0.path().join(name);
        std::fs::write(&path, content).unwrap();
        path
    }

    pub fn load(&self, name: &str, content: impl AsRef<[u8]>) -> (Mesh, Vec<String>) {
        let mut warnings = Vec::new();
        (
            load_file(&self.write(name, content), None, &DAffine3::IDENTITY, None, &mut warnings).unwrap(),
            warnings,
        )
    }

    pub fn refusal(&self, name: &str, content: impl AsRef<[u8]>) -> String {
        let error = load_file(&self.write(name, content), None, &DAffine3::IDENTITY, None, &mut Vec::new())
            .unwrap_err();
        let message = error.to_string();
        assert!(error.is_bad_input() && message.contains(name) && !message.contains('\n'), "{message}");
        message
    }
}

/// A pyramid on a square: one quadrilateral and four triangles.
const POINTS: [[f32; 3]; 5] =
    [[-1.0, 0.0, -1.0], [1.0, 0.0, -1.0], [1.0, 0.0, 1.0], [-1.0, 0.0, 1.0], [0.0, 1.5, 0.0]];
const NORMALS: [[f32; 3]; 5] =
    [[-0.6, 0.0, -0.8], [0.6, 0.0, -0.8], [0.6, 0.0, 0.8], [-0.6, 0.0, 0.8], [0.0, 1.0, 0.0]];
const UVS: [[f32; 2]; 5] = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0], [0.5, 0.25]];
const FACES: [&[u32]; 5] = [&[0, 1, 2, 3], &[1, 0, 4], &[2, 1, 4], &[3, 2, 4], &[0, 3, 4]];

fn obj(normals: bool, uvs: bool) -> String {
    let mut text = String::new();
    POINTS.iter().for_each(|[x, y, z]| text += &format!("v {x} {y} {z}\n"));
    UVS.iter().filter(|_| uvs).for_each(|[u, v]| text += &format!("vt {u} {v}\n"));
    NORMALS.iter().filter(|_| normals).for_each(|[x, y, z]| text += &format!("vn {x} {y} {z}\n"));
    for face in FACES {
        let corner = |i: &u32| match (normals, uvs) {
            (false, false) => format!(" {}", i + 1),
            (true, false) => format!(" {0}//{0}", i + 1),
            (false, true) => format!(" {0}/{0}", i + 1),
            (true, true) => format!(" {0}/{0}/{0}", i + 1),
        };
        text += &format!("f{}\n", face.iter().map(corner).collect::<String>());
    }
    text
}

/// Position, normal and texture coordinates.
type Corner = ([f32; 3], [f32; 3], Option<[f32; 2]>);

/// The corners of every triangle with all that belongs to them: what a mesh is, whatever the order of its
/// vertices.
fn corners(mesh: &Mesh) -> Vec<Corner> {
    let corner = |v: &u32| {
        (mesh.positions[*v as usize], mesh.normals[*v as usize], mesh.uvs.get(*v as usize).copied())
    };
    mesh.triangles.as_flattened().iter().map(corner).collect()
}

/// The header, with properties that no one needs and an element that no one knows before and between.
fn ply_header(format: &str, normals: bool, uv_names: Option<[&str; 2]>) -> String {
    let scalar = |name: &str| format!("property float {name}\n");
    let mut text = format!(
        "ply\nformat {format} 1.0\ncomment made by hand\nelement material 1\nproperty list uchar short keys\n"
    );
    text += "element vertex 5\nproperty float x\nproperty double y\nproperty uchar red\nproperty float z\n";
    ["nx", "ny", "nz"].iter().filter(|_| normals).for_each(|name| text += &scalar(name));
    uv_names.iter().flatten().for_each(|name| text += &scalar(name));
    text + "element face 5\nproperty list uchar int vertex_indices\nproperty int group\nend_header\n"
}

fn ply_ascii(normals: bool, uv_names: Option<[&str; 2]>) -> String {
    let mut text = ply_header("ascii", normals, uv_names) + "3 7 8 9\n";
    for (i, [x, y, z]) in POINTS.iter().enumerate() {
        text += &format!("{x} {y} 255 {z}");
        NORMALS[i].iter().filter(|_| normals).for_each(|n| text += &format!(" {n}"));
        UVS[i].iter().filter(|_| uv_names.is_some()).for_each(|t| text += &format!(" {t}"));
        text += "\n";
    }
    for face in FACES {
        text += &format!("{}{} 4\n", face.len(), face.iter().map(|i| format!(" {i}")).collect::<String>());
    }
    text
}

fn ply_binary(big_endian: bool, normals: bool, uv_names: Option<[&str; 2]>) -> Vec<u8> {
    let format = if big_endian { "binary_big_endian" } else { "binary_little_endian" };
    let mut bytes = ply_header(format, normals, uv_names).into_bytes();
    let mut push = |little: &[u8]| {
        if big_endian { bytes.extend(little.iter().rev()) } else { bytes.extend(little) }
    };
    push(&[3]);
    [7i16, 8, 9].iter().for_each(|k| push(&k.to_le_bytes()));
    for (i, [x, y, z]) in POINTS.iter().enumerate() {
        push(&x.to_le_bytes());
        push(&f64::from(*y).to_le_bytes());
        push(&[255]);
        push(&z.to_le_bytes());
        NORMALS[i].iter().filter(|_| normals).for_each(|n| push(&n.to_le_bytes()));
        UVS[i].iter().filter(|_| uv_names.is_some()).for_each(|t| push(&t.to_le_bytes()));
    }
    for face in FACES {
        push(&[face.len() as u8]);
        face.iter().for_each(|i| push(&i.to_le_bytes()));
        push(&4i32.to_le_bytes());
    }
    bytes
}

#[test]
fn every_ply_is_the_mesh_that_its_obj_is() {
    let folder = Folder::new();
    for (normals, uv_names) in [
        (false, None),
        (true, None),
        (true, Some(["s", "t"])),
        (false, Some(["u", "v"])),
        (true, Some(["texture_u", "texture_v"])),
    ] {
        let expected = corners(&folder.load("t.obj", obj(normals, uv_names.is_some())).0);
        assert_eq!(expected.len(), 18);
        assert_eq!(expected[0].2.is_some(), uv_names.is_some());
        let ascii = folder.load("t.ply", ply_ascii(normals, uv_names)).0;
        assert_eq!(corners(&ascii), expected, "{normals} {uv_names:?}");
        assert_eq!(
            ascii.positions.len(),
            if normals { 5 } else { 16 },
            "vertices stay shared but along hard edges"
        );
        for big_endian in [false, true] {
            assert_eq!(
                folder.load("t.ply", ply_binary(big_endian, normals, uv_names)).0,
                ascii,
                "{big_endian} {normals} {uv_names:?}"
            );
        }
    }
    // OBJ and PLY count v from the last row of an image, a mesh from the first.
    let mesh = folder.load("t.ply", ply_ascii(true, Some(["s", "t"]))).0;
    assert_eq!(mesh.uvs, UVS.map(|[u, v]| [u, 1.0 - v]));
}

#[test]
fn every_off_is_the_mesh_that_its_obj_is() {
    let folder = Folder::new();
    for (keyword, normals, colours) in [
        ("OFF", false, ""),
        ("COFF", false, " 255 0 0 255"),
        ("NOFF", true, ""),
        ("CNOFF", true, " 0.5 0.5 0.5 1"),
    ] {
        let expected = corners(&folder.load("t.obj", obj(normals, false)).0);
        for counts in [" 5 5 8\n", "\n# a comment\n\n5 5 8 # another\n"] {
            let mut text = format!("{keyword}{counts}");
            for (i, [x, y, z]) in POINTS.iter().enumerate() {
                let [nx, ny, nz] = NORMALS[i];
                let normal = if normals { format!(" {nx} {ny} {nz}") } else { String::new() };
                text += &format!("  {x} {y}\t{z}{normal}{colours}\r\n\n");
            }
            for face in FACES {
                text += &format!(
                    "{}{} 3 200 100\n",
                    face.len(),
                    face.iter().map(|i| format!(" {i}")).collect::<String>()
                );
            }
            assert_eq!(corners(&folder.load("t.off", text).0), expected, "{keyword}{counts}");
        }
    }
}

#[test]
fn faces_without_an_area_are_counted() {
    let folder = Folder::new();
    let text = ply_ascii(false, None).replace("3 1 0 4 4\n", "2 1 0 4\n");
    let (mesh, warnings) = folder.load("t.ply", text);
    assert_eq!(mesh.triangles.len(), 5);
    assert!(warnings[0].ends_with("t.ply: ignored 1 face with fewer than three corners"), "{warnings:?}");
}

#[test]
fn broken_ply_is_refused() {
    let folder = Folder::new();
    let text = ply_ascii(true, Some(["s", "t"]));
    for (from, to, part) in [
        ("ply\n", "pl\n", "t.ply: not a PLY file, whose first line is `ply`"),
        ("ascii", "asci", "t.ply: line 2: no format `asci`; export the file again"),
        ("format ascii 1.0\n", "", "the line `format` is missing"),
        ("element vertex 5", "element vertex 6", "line 26: `nz` is missing in `vertex` 5"),
        (
            "element vertex 5",
            "element vertex 99999999999999",
            "line 6: `99999999999999` of `vertex`, which is no number up to 67108864",
        ),
        ("element vertex 5", "element vertex 99999999999999999999999", "no number up to 67108864"),
        ("element vertex 5", "element face 5", "line 16: a second element `face`"),
        ("element material 1", "element material 67108865", "`67108865` of `material`"),
        ("element material 1\n", "", "line 4: a property before the first element"),
        ("property float x", "property float w", "no element `vertex` with x, y and z"),
        ("property float x", "property list uchar float x", "no element `vertex` with x, y and z"),
        ("property float x", "property real x", "line 7: `property real x` is no property"),
        ("vertex_indices", "corners", "no element `face` or `tristrips` with a list `vertex_indices`"),
        ("element face", "element edge", "no element `face`"),
        ("property list uchar int vertex_indices", "property int vertex_indices", "no element `face`"),
        (
            "end_header",
            "end_headers",
            "t.ply: ends within its header, in which line 19, `end_headers`, is not known; fetch or export it again",
        ),
        (
            "end_header",
            "end_header 1",
            "line 19: `end_header 1` is no line of a header; export the file again",
        ),
        ("element material 1", "element material", "`element material` is no line of a header"),
        ("\n3 1 0 4 4", "\n3 1 0 5 4", "t.ply: face 1 names vertex 5 of 5, which count from 0"),
        ("\n3 1 0 4 4", "\n3 1 0 -4 4", "t.ply: face 1 names vertex -4 of 5"),
        ("\n3 1 0 4 4", "\n3 1 0 1.5 4", "t.ply: face 1 names vertex 1.5 of 5"),
        ("\n3 1 0 4 4", "\n300000000000 1 0 4 4", "line 27: 300000000000 is no length of a list in `face` 1"),
        ("\n3 1 0 4 4", "\n-3 1 0 4 4", "-3 is no length of a list"),
        (
            "\n3 1 0 4 4",
            "\n3 1 0",
            "line 27: `vertex_indices` is missing in `face` 1 of 5; mend or export the file again",
        ),
        ("\n-1 0 255 -1 ", "\nnan 0 255 -1 ", "vertex 0 at [NaN, 0.0, -1.0] is not a finite position"),
        ("\n-1 0 255 -1 ", "\n1e99 0 255 -1 ", "not a finite position"),
        ("\n-1 0 255 -1 ", "\nx 0 255 -1 ", "line 21: `x` is no number in `vertex` 0"),
    ] {
        assert!(text.contains(from), "{from:?}");
        let message = folder.refusal("t.ply", text.replacen(from, to, 1));
        assert!(message.contains(part), "{from:?} → {to:?}: {message}");
    }
    // A list whose length is not in the file is not allocated for.
    let header = "ply\nformat binary_little_endian 1.0\nelement vertex 0\nproperty float x\nproperty float y\nproperty float z\n\
                  element face 1\nproperty list uint uint vertex_indices\nend_header\n";
    let bytes = [header.as_bytes(), &u32::MAX.to_le_bytes(), &[0; 64]].concat();
    assert!(folder.refusal("t.ply", bytes).contains("4294967295 is no length of a list"));
    let bytes = [header.as_bytes(), &60_000_000_u32.to_le_bytes(), &[0; 64]].concat();
    assert!(
        folder
            .refusal("t.ply", bytes)
            .contains("t.ply: `vertex_indices` is missing in `face` 0 of 1; mend or export the file again")
    );
}

#[test]
fn truncated_files_are_refused_at_every_length() {
    let folder = Folder::new();
    let binary = ply_binary(false, true, Some(["s", "t"]));
    let (ascii, off) = (ply_ascii(true, None), "OFF\n5 1 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n2 2 2\n4 0 1 2 3");
    for length in 0..binary.len() {
        folder.refusal("t.ply", &binary[..length]);
    }
    // Without the last property, or the last digit's line end, text is no less than complete.
    for length in 0..ascii.len() - 3 {
        folder.refusal("t.ply", &ascii[..length]);
    }
    for length in 0..off.len() - 1 {
        folder.refusal("t.off", &off[..length]);
    }
    assert_eq!(folder.load("t.off", off).0.triangles.len(), 2);
}

#[test]
fn broken_off_is_refused_with_its_line() {
    let folder = Folder::new();
    let text = "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
    for (from, to, part) in [
        ("OFF", "FOF", "t.off: line 1: the word OFF expected, not `FOF`"),
        (
            "OFF",
            "nOFF",
            "t.off: line 1: `nOFF` is not read, OFF with N, C and ST before it is; save it as one of them",
        ),
        ("OFF", "NNOFF", "line 1: `NNOFF` is not read"),
        ("OFF", "OFFSET", "line 1: the word OFF expected, not `OFFSET`"),
        ("OFF", "STOFF", "line 3: a texture coordinate is missing"),
        ("OFF", "4OFF", "`4OFF` is not read"),
        ("OFF", "OFF BINARY", "binary OFF is not read"),
        ("3 1 0", "-3 1 0", "line 2: -3 is no number of vertices"),
        ("3 1 0", "3", "line 2: the number of faces is missing"),
        ("3 1 0", "3 1.5 0", "line 2: 1.5 is no number of faces"),
        ("3 1 0", "4000000000000 1 0", "more than 67108864 vertices"),
        ("3 1 0", "3 4000000000000 0", "more than 67108864 vertices or triangles"),
        ("3 1 0", "3 2 0", "ends where face 1 of 2 should be"),
        ("1 0 0", "1 0", "line 4: a coordinate is missing"),
        ("1 0 0", "1 x 0", "line 4: a coordinate expected, not `x`"),
        ("1 0 0", "1,0 0 0", "line 4: a coordinate expected, not `1,0`"),
        ("1 0 0", "1 nan 0", "vertex 1 at [1.0, NaN, 0.0] is not a finite position"),
        ("3 0 1 2", "3 0 1 3", "line 6: face 0 names vertex 3 of 3, which count from 0"),
        ("3 0 1 2", "3 0 1 -2", "line 6: face 0 names vertex -2 of 3"),
        ("3 0 1 2", "4 0 1 2", "line 6: a vertex index is missing"),
        ("3 0 1 2", "18446744073709551615 0 1 2", "line 6: a vertex index is missing"),
        (
            "3 0 1 2",
            "2 0 1",
            "t.off: has no faces: ignored 1 face with fewer than three corners; export it as a mesh",
        ),
    ] {
        let message = folder.refusal("t.off", text.replacen(from, to, 1));
        assert!(message.contains(part), "{from:?} → {to:?}: {message}");
    }
    assert!(folder.refusal("t.off", b"\xff\xfeO\0F\0F\0").contains("UTF-16 text; save it as ASCII or UTF-8"));
}
