//! OBJ as other programs write it.

use super::polygon_file_tests::Folder;

const TRIANGLE: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";

#[test]
fn whatever_stands_around_a_triangle_it_is_the_same() {
    let folder = Folder::new();
    let (expected, told) = folder.load("t.obj", TRIANGLE);
    assert_eq!(
        (expected.positions.as_slice(), expected.triangles.as_slice()),
        ([[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]].as_slice(), [[0, 1, 2]].as_slice())
    );
    for (name, text) in [
        ("mark", [b"\xEF\xBB\xBF", TRIANGLE.as_bytes()].concat()),
        ("cr lf", TRIANGLE.replace('\n', "\r\n").into_bytes()),
        ("cr", TRIANGLE.replace('\n', "\r").into()),
        ("no last line end", TRIANGLE.trim_end().into()),
        ("blanks", TRIANGLE.replace('\n', " \t\n\n  \n").replace(' ', "  ").into()),
        (
            "latin comment and names",
            [b"# caf\xE9\no \xFC\ng \xE9\nusemtl \xE0\n", TRIANGLE.as_bytes()].concat(),
        ),
        (
            "comments",
            format!(
                "#\n# v 1 2 3\n{}",
                TRIANGLE.replace("1 0 0", "1 0 0 # note").replace("1 2 3", "1 2 3#x")
            )
            .into(),
        ),
        ("comment with a path", format!("# C:\\models\\\n{TRIANGLE}").into()),
        (
            "lines that go on",
            TRIANGLE
                .replace("v 1 0 0", "v 1 \\\n0 \\ \n\\\r\n 0")
                .replace("f 1 2 3", "f 1 \\\n 2 3 \\")
                .into(),
        ),
        ("no names", format!("mtllib\no\ng\n{}", TRIANGLE.replace("f ", "usemtl\ns\nf ")).into()),
        (
            "weights and colours",
            TRIANGLE.replace("v 1 0 0", "v 1 0 0 1.0").replace("v 0 1 0", "v 0 1 0 0.5 0.5 0.5").into(),
        ),
        ("relative indices", TRIANGLE.replace("1 2 3", "-3 2 -1").into()),
        ("vertices behind the face", "f 1 2 3\nv 0 0 0\nv 1 0 0\nv 0 1 0\n".into()),
        ("empty parts of corners", TRIANGLE.replace("1 2 3", "1/ 2// 3").into()),
        ("number formats", "v 0. .0 -0\nv +1.0e0 0 0\nv 0 100E-2 0e5\nf 1 2 3\n".into()),
        ("a vertex that is nowhere and unused", TRIANGLE.replace("f ", "v nan nan 1.#QNAN\nf ").into()),
        ("fo", TRIANGLE.replace("f ", "fo ").into()),
        ("end of file of DOS", [TRIANGLE.as_bytes(), b"\x1A"].concat()),
    ] {
        let (mesh, warnings) = folder.load("t.obj", text);
        assert_eq!(mesh, expected, "{name}");
        assert_eq!(warnings.len(), told.len(), "{name}: {warnings:?}");
    }
}

#[test]
fn what_has_no_surface_is_ignored_with_a_note() {
    let folder = Folder::new();
    let (expected, _) = folder.load("t.obj", TRIANGLE);
    for (more, note) in [
        ("l 1 2\nl 1 2 3\nl 1/1 2/2 3/3 1/1\n", "t.obj: ignored 3 lines, without a surface"),
        ("p 1\np 1 2 3\n", "t.obj: ignored 2 statements of points, without a surface"),
        (
            "cstype bezier\ncurv 0 1 1 2 3\nend\n",
            "ignored 3 statements not read, such as free-form surfaces; the first is line 5",
        ),
    ] {
        let (mesh, warnings) = folder.load("t.obj", format!("{TRIANGLE}{more}"));
        assert_eq!(mesh, expected);
        assert!(warnings[0].contains(note), "{warnings:?}");
    }
}

#[test]
fn corners_may_name_what_the_file_has_none_of() {
    let folder = Folder::new();
    let positions = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\n";
    let (expected, plain) = folder.load("t.obj", format!("{positions}f 1 2 3\nf 2 4 3\n"));
    for (faces, count) in [
        ("f 1/1/1 2/2/2 3/3/3\nf 2/4/4 4/5/5 3/6/6\n", "6 corners of faces name"),
        ("f 1//1 2//1 3//1\nf 2 4 3\n", "3 corners of faces name"),
        ("f -4/-4/-4 -3/-3/-3 -2/-2/-2\nf 2 4 3\n", "3 corners of faces name"),
        ("f 1/9 2 3\nf 2 4 3\n", "1 corner of a face names"),
    ] {
        let (mesh, warnings) = folder.load("t.obj", format!("{positions}{faces}"));
        assert_eq!(mesh, expected, "{faces}");
        let note = format!(
            "t.obj: {count} texture coordinates or normals of which the file has none; read without them"
        );
        assert!(warnings[0].ends_with(&note) && warnings[1..] == plain[..], "{warnings:?}");
    }
    // A number that is out of range among others is a fault.
    let message = folder.refusal("t.obj", format!("{positions}vt 0 0\nf 1/1 2/1 3/2\n"));
    assert!(
        message.ends_with("t.obj: line 6: names texture coordinate 2, of 1; mend or export the file again"),
        "{message}"
    );
    assert!(
        folder
            .refusal("t.obj", format!("{positions}f -5 2 3\n"))
            .contains("names vertex -5, but only 4 come before")
    );
}

#[test]
fn a_corner_lacks_only_what_it_does_not_name() {
    let folder = Folder::new();
    let text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nvt 0 0\nvt 1 0\nvt 0.25 1\nvn 0 1 0\nf 1/1/1 2/2/1 3/3/1\nf 2 4//1 3/3\n";
    let (mesh, warnings) = folder.load("t.obj", text);
    assert_eq!(mesh.triangles, [[0, 1, 2], [3, 4, 5]]);
    assert_eq!(mesh.uvs, [[0.0, 1.0], [1.0, 1.0], [0.25, 0.0], [0.0, 0.0], [0.0, 0.0], [0.25, 0.0]]);
    let (given, made) = ([0.0, 1.0, 0.0], [0.0, 0.0, 1.0]);
    assert_eq!(mesh.normals, [given, given, given, made, given, made]);
    assert!(
        warnings[0].ends_with("gave the texture coordinates (0, 0) to 2 of 6 vertices, which had none"),
        "{warnings:?}"
    );
    assert!(warnings[1].contains("made normals for 2 of 6 vertices"), "{warnings:?}");
    // One coordinate of a texture, and three.
    let (mesh, _) = folder.load("t.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0.5\nvt 0.5 0.25 9\nf 1/1 2/2 3/2\n");
    assert_eq!(mesh.uvs, [[0.5, 1.0], [0.5, 0.75], [0.5, 0.75]]);
}

#[test]
fn what_cannot_be_read_names_its_line() {
    let folder = Folder::new();
    for (from, to, part) in [
        (
            "v 1 0 0",
            "v 1,5 0 0",
            "t.obj: line 2: `1,5` is no coordinate of a vertex; mend or export the file again",
        ),
        ("v 1 0 0", "v 1 0", "line 2: a coordinate of a vertex is missing"),
        ("v 1 0 0", "v 1 \\\n\n0", "line 2: a coordinate of a vertex is missing"),
        ("f 1 2 3", "f 0 1 2", "line 4: names vertex 0, but they count from 1"),
        ("f 1 2 3", "f 1 2 4", "line 4: names vertex 4, of 3"),
        ("f 1 2 3", "\r\nf 1 2 -4", "line 5: names vertex -4, but only 3 come before"),
        ("f 1 2 3", "vt 0 0\nf 1/2 2 3", "line 5: names texture coordinate 2, of 1"),
        ("f 1 2 3", "f 1/1/1/1 2 3", "line 4: `1/1/1/1` is no corner of a face"),
        ("f 1 2 3", "f 1//// 2 3", "line 4: `1////` is no corner of a face, which has at most three numbers"),
        ("f 1 2 3", "f /1 2 3", "line 4: `` is no number of a vertex"),
        ("f 1 2 3", "f 1.5 2 3", "line 4: `1.5` is no number of a vertex"),
        ("f 1 2 3", "vt x 0\nf 1 2 3", "line 4: `x` is no texture coordinate"),
        ("f 1 2 3", "vn 0 0\nf 1 2 3", "line 4: a component of a normal is missing"),
        ("f 1 2 3", "f 1 2 3\u{1b}[2J", "line 4: `3\\u{1b}[2J` is no number of a vertex"),
        ("v 1 0 0", "v nan 0 0", "line 4: names vertex 2 at [NaN, 0.0, 0.0], which is not finite"),
        ("f 1 2 3", "l 1 2 3", "t.obj: has no faces: ignored 1 line, without a surface; export it as a mesh"),
    ] {
        let message = folder.refusal("t.obj", TRIANGLE.replace(from, to));
        assert!(message.contains(part), "{to:?}: {message}");
    }
    let wide: Vec<u8> = TRIANGLE.encode_utf16().flat_map(u16::to_le_bytes).collect();
    assert!(
        folder
            .refusal("t.obj", [b"\xFF\xFE", wide.as_slice()].concat())
            .contains("UTF-16 text; save it as ASCII or UTF-8")
    );
    assert!(folder.refusal("t.obj", wide).contains("UTF-16"));
}
