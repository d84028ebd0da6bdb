//! PLY and OFF as other programs write them.

use super::builder;
use super::polygon_file_tests::Folder;

/// A square of two triangles.
const SQUARE: [[f32; 3]; 4] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
const BODY: &str = "0 0 0\n1 0 0\n1 1 0\n0 1 0\n3 0 1 2\n3 0 2 3\n";

fn square_header(rest: &str) -> String {
    format!(
        "ply\nformat ascii 1.0\n{rest}element vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
    )
}

#[test]
fn ply_as_other_programs_write_it() {
    let folder = Folder::new();
    let faces = "element face 2\nproperty list uchar int vertex_indices\nend_header\n";
    let plain = square_header("") + faces + BODY;
    let expected = folder.load("t.ply", &plain).0;
    assert_eq!(
        (expected.positions.as_slice(), expected.triangles.as_slice()),
        (SQUARE.as_slice(), [[0, 1, 2], [0, 2, 3]].as_slice())
    );
    let latin = [b"ply\nformat ascii 1.0\ncomment caf\xE9\n", &plain.as_bytes()[21..]].concat();
    let blank = plain
        .replace("element vertex", "\nelement vertex")
        .replace("1 0 0\n", "1 0 0\n\n  \n")
        .replace("3 0 2 3", "\n3 0 2 3");
    let commented =
        square_header("obj_info x 3\ncomment made by hand\ncomment\n") + "comment within\n" + faces + BODY;
    let named = plain
        .replace("vertex_indices", "vertex_index")
        .replace("uchar int", "uint8 int32")
        .replace("float x", "float64 x");
    let unread = square_header("").replace("property float y", "property float quality\nproperty float y")
        + faces
        + "0 nan 0 0\n1 -1.#IND 0 0\n1 x 1 0\n0 nan 1 0\n3 0 1 2\n3 0 2 3\n";
    let lists = square_header("")
        .replace("property float x", "property list int float rays\nproperty float x")
        + faces
        + "2 nan nan 0 0 0\n0 1 0 0\n1 5 1 1 0\n0 0 1 0\n3 0 1 2\n3 0 2 3\n";
    let faces_first = "ply\nformat ascii 1.0\n".to_owned()
        + faces.trim_end_matches("end_header\n")
        + &square_header("")[21..]
        + "end_header\n3 0 1 2\n3 0 2 3\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n";
    let strips = square_header("")
        + "element tristrips 1\nproperty list int int vertex_indices\nend_header\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n8 0 1 2 -1 0 2 3 3\n";
    let unused = plain.replace("vertex 4", "vertex 5").replace("3 0 1 2", "nan nan nan\n3 0 1 2");
    for (name, text) in [
        ("latin", latin),
        ("mark", [b"\xEF\xBB\xBF", plain.as_bytes()].concat()),
        ("cr lf", plain.replace('\n', "\r\n").into()),
        ("cr", plain.replace('\n', "\r").into()),
        ("blank lines", blank.into()),
        ("comments", commented.into()),
        ("names", named.into()),
        ("nan that nobody reads", unread.into()),
        ("lists that nobody reads", lists.into()),
        ("faces first", faces_first.into()),
        ("strips", strips.into()),
        ("nan that nobody uses", unused.into()),
        ("trailing words", plain.replace("3 0 1 2", "3 0 1 2 255 0 0").into()),
    ] {
        assert_eq!(folder.load("t.ply", text).0, expected, "{name}");
    }
}

#[test]
fn every_number_of_binary_ply_is_read() {
    let folder = Folder::new();
    let header = |format: &str, scalar: &str, list: &str| {
        format!(
            "ply\r\nformat {format} 1.0\r\nelement vertex 4\r\nproperty {scalar} x\r\nproperty {scalar} y\r\nproperty {scalar} z\r\n\
             element face 2\r\nproperty list {list} vertex_index\r\nend_header\r\n"
        )
    };
    type Encode = fn(f32) -> Vec<u8>;
    let scalars: [(&str, Encode); 16] = [
        ("char", |x| (x as i8).to_le_bytes().to_vec()),
        ("uchar", |x| (x as u8).to_le_bytes().to_vec()),
        ("short", |x| (x as i16).to_le_bytes().to_vec()),
        ("ushort", |x| (x as u16).to_le_bytes().to_vec()),
        ("int", |x| (x as i32).to_le_bytes().to_vec()),
        ("uint", |x| (x as u32).to_le_bytes().to_vec()),
        ("float", |x| x.to_le_bytes().to_vec()),
        ("double", |x| f64::from(x).to_le_bytes().to_vec()),
        ("int8", |x| (x as i8).to_le_bytes().to_vec()),
        ("uint8", |x| (x as u8).to_le_bytes().to_vec()),
        ("int16", |x| (x as i16).to_le_bytes().to_vec()),
        ("uint16", |x| (x as u16).to_le_bytes().to_vec()),
        ("int32", |x| (x as i32).to_le_bytes().to_vec()),
        ("uint32", |x| (x as u32).to_le_bytes().to_vec()),
        ("float32", |x| x.to_le_bytes().to_vec()),
        ("float64", |x| f64::from(x).to_le_bytes().to_vec()),
    ];
    for (big, format) in [(false, "binary_little_endian"), (true, "binary_big_endian")] {
        for (name, encode) in scalars {
            let mut bytes = header(format, name, &format!("{name} {name}")).into_bytes();
            let numbers =
                SQUARE.as_flattened().iter().copied().chain([3.0, 0.0, 1.0, 2.0, 3.0, 0.0, 2.0, 3.0]);
            for number in numbers {
                let mut encoded = encode(number);
                if big {
                    encoded.reverse();
                }
                bytes.extend(encoded);
            }
            let mesh = folder.load("t.ply", bytes).0;
            assert_eq!(
                (mesh.positions.as_slice(), mesh.triangles.as_slice()),
                (SQUARE.as_slice(), [[0, 1, 2], [0, 2, 3]].as_slice()),
                "{format} {name}"
            );
        }
    }
    // A body whose first byte is that of a line feed: 10 vertices' worth of a list, behind a header with
    // Macintosh's line ends.
    let header = "ply\rformat binary_little_endian 1.0\relement other 1\rproperty uchar n\relement vertex 4\r\
                  property float x\rproperty float y\rproperty float z\relement face 2\rproperty list uchar uchar vertex_index\rend_header\r";
    let floats = SQUARE.as_flattened().iter().flat_map(|x| x.to_le_bytes());
    let bytes: Vec<u8> =
        header.bytes().chain([b'\n']).chain(floats).chain([3, 0, 1, 2, 3, 0, 2, 3]).collect();
    assert_eq!(folder.load("t.ply", bytes).0.positions, SQUARE);
}

#[test]
fn off_as_other_programs_write_it() {
    let folder = Folder::new();
    let plain = "OFF\n4 2 0\n".to_owned() + BODY;
    let expected = folder.load("t.off", &plain).0;
    assert_eq!(
        (expected.positions.as_slice(), expected.triangles.as_slice()),
        (SQUARE.as_slice(), [[0, 1, 2], [0, 2, 3]].as_slice())
    );
    for (name, text) in [
        ("counts on the first line", plain.replace("OFF\n", "OFF ").into_bytes()),
        ("no keyword", plain.replace("OFF\n", "").into()),
        ("no edges", plain.replace("4 2 0", "4 2").into()),
        ("mark", [b"\xEF\xBB\xBF", plain.as_bytes()].concat()),
        ("cr lf", plain.replace('\n', "\r\n").into()),
        ("cr", plain.replace('\n', "\r").into()),
        ("latin", [b"OFF # caf\xE9\n", &plain.as_bytes()[4..]].concat()),
        ("blank lines and comments", plain.replace('\n', "\n\n # x\n").into()),
        (
            "colours",
            plain.replace("3 0 1 2", "3 0 1 2 255 0 0").replace("3 0 2 3", "3 0 2 3 0.1 0.2 0.3 1").into(),
        ),
        ("colours of vertices", plain.replace("1 1 0\n", "1 1 0 255 0 0 255\n").into()),
    ] {
        assert_eq!(folder.load("t.off", text).0, expected, "{name}");
    }
}

#[test]
fn concave_faces_of_every_format_have_their_area() {
    let folder = Folder::new();
    let points = ["0 0 0", "2 0 0", "2 1 0", "1 1 0", "1 2 0", "0 2 0"];
    let lines = points.join("\n");
    let obj = points.map(|p| format!("v {p}\n")).concat() + "f 1 2 3 4 5 6\n";
    let off = format!("OFF 6 1 6\n{lines}\n6 0 1 2 3 4 5\n");
    let ply = square_header("").replace("vertex 4", "vertex 6")
        + &format!(
            "element face 1\nproperty list uchar uint vertex_indices\nend_header\n{lines}\n6 0 1 2 3 4 5\n"
        );
    for (name, text) in [("t.obj", obj), ("t.off", off), ("t.ply", ply)] {
        let (mesh, warnings) = folder.load(name, text);
        let area: f64 = mesh
            .triangles
            .iter()
            .map(|t| builder::area_vector(t.map(|v| mesh.positions[v as usize])).z / 2.0)
            .sum();
        assert_eq!((area, mesh.triangles.len()), (3.0, 4), "{name}");
        assert_eq!(mesh.normals, [[0.0, 0.0, 1.0]; 6]);
        assert!(warnings.iter().all(|w| !w.contains("cross")), "{warnings:?}");
    }
    let (_, warnings) = folder.load("t.obj", "v 0 0 0\nv 2 0 0\nv 0 1 0\nv 2 3 0\nf 1 2 3 4\n");
    assert!(
        warnings[0].ends_with("t.obj: the outlines of 1 face cross themselves or have no inside; triangulated as fans, which may overlap"),
        "{warnings:?}"
    );
}

#[test]
fn unknown_lines_of_a_ply_header_are_ignored_and_told() {
    let folder = Folder::new();
    let faces = "element face 2\nproperty list uchar int vertex_indices\nend_header\n";
    let text = square_header("Created by Blender3D 247\n") + "x\n" + faces + BODY;
    let (mesh, warnings) = folder.load("t.ply", text);
    assert_eq!(
        (mesh.positions.as_slice(), mesh.triangles.as_slice()),
        (SQUARE.as_slice(), [[0, 1, 2], [0, 2, 3]].as_slice())
    );
    let note =
        "t.ply: ignored 2 unknown lines of the header; the first is line 3, `Created by Blender3D 247`";
    assert!(warnings[0].ends_with(note), "{warnings:?}");
}

#[test]
fn ply_records_may_share_lines_or_take_several() {
    let folder = Folder::new();
    let header = square_header("") + "element face 2\nproperty list uchar int vertex_indices\nend_header\n";
    let expected = folder.load("t.ply", header.clone() + BODY).0;
    for body in [
        "0 0 0 1 0 0\n1 1 0 0 1 0\n3 0 1 2 3 0 2 3\n",
        "0\n0 0\n1 0\n0\n1 1 0\n\n0 1 0\n3\n0 1 2\n3\n0 2\n3",
        "0 0 0 1 0 0 1 1 0 0 1 0 3 0 1 2 3 0 2 3",
    ] {
        assert_eq!(folder.load("t.ply", header.clone() + body).0, expected, "{body:?}");
    }
    // One word too many or too few: neither reading fits, and the one by lines is told.
    let message = folder.refusal("t.ply", header.clone() + "0 0 0 1 0 0\n1 1 0 0 1 0\n3 0 1 2 3 0 2 3 9\n");
    assert!(message.ends_with("t.ply: ends in `vertex` 3 of 4; fetch or export it again"), "{message}");
    let message = folder.refusal("t.ply", header + "0 0\n0 1 0 0 1 1 0 0 1 0 3 0 1 2 3 0 2\n");
    assert!(
        message.ends_with("t.ply: line 10: `z` is missing in `vertex` 0 of 4; mend or export the file again"),
        "{message}"
    );
}

#[test]
fn off_words_flow_over_lines() {
    let folder = Folder::new();
    let faces = "3 0 1 2 255 0 0\n3 0 2 3\n";
    let expected = folder.load("t.off", "OFF\n4 2 0\n".to_owned() + BODY).0;
    let lines = "0 0 0\n1 0 0\n1 1 0\n0 1 0\n";
    for (name, text) in [
        ("small keyword", format!("off\n4 2 0\n{lines}")),
        ("mixed keyword", format!("Off 4 2 0\n{lines}")),
        ("glued count", format!("OFF4 2 0\n{lines}")),
        ("counts over two lines", format!("OFF\n4\n2 0\n{lines}")),
        ("edges on a line of their own", format!("OFF 4 2\n0\n{lines}")),
        ("counts over three lines", format!("OFF 4\n2 # faces\n\n0\n{lines}")),
        ("two vertices on a line", "OFF\n4 2 0\n0 0 0 1 0 0\n1 1 0 0 1 0 # end\n".to_owned()),
        ("all vertices on the line of the counts", "OFF 4 2 0 0 0 0 1 0 0 1 1 0 0 1 0\n".to_owned()),
        ("vertices over lines", "OFF\n4 2 0\n0\n0 0\n1 0\n0\n1 1 0\n\n0 1 0\n".to_owned()),
        ("colours on lines", "OFF\n4 2 0\n0 0 0 9 9 9 9\n1 0 0 9 9 9 9\n1 1 0 9 9 9 9\n0 1 0\n".to_owned()),
        (
            "colours on lines of their own",
            "COFF\n4 2 0\n0 0 0\n1 1 1 1\n1 0 0\n1 1 1 1\n1 1 0\n0 0 0 1\n0 1 0\n0 0 0 1\n".to_owned(),
        ),
    ] {
        assert_eq!(folder.load("t.off", text + faces).0, expected, "{name}");
    }
}

#[test]
fn off_faces_may_go_on_over_lines() {
    let folder = Folder::new();
    let header = "OFF\n4 2 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n";
    let expected = folder.load("t.off", format!("{header}3 0 1 2\n3 0 2 3\n")).0;
    for faces in [
        "3 0\n1 2\n3 0 2\n3\n",
        "3\n0\n1\n2\n3\n0\n2\n3\n",
        "3 0 1 2 255 0 0\n3 0\n2 3 # end\n",
        "3 0 1 2 3 0 2 3\n",
        "3 0 1 2 3 0\n2 3",
    ] {
        let (mesh, warnings) = folder.load("t.off", format!("{header}{faces}"));
        assert_eq!((mesh, warnings.len()), (expected.clone(), 1), "{faces:?}: {warnings:?}");
    }
    // What is cut short, or has words too many, is no other way of writing.
    for (faces, message) in [
        ("3 0 1\n3 0 2 3\n", "t.off: line 7: a vertex index is missing; mend or export the file again"),
        (
            "3 0 1\n2 255 0 0\n3 0 2 3\n",
            "t.off: line 7: a vertex index is missing; mend or export the file again",
        ),
        ("3 0 1\n2\n3 0 2\n", "t.off: line 7: a vertex index is missing; mend or export the file again"),
    ] {
        assert!(folder.refusal("t.off", format!("{header}{faces}")).ends_with(message), "{faces:?}");
    }
    let (mesh, warnings) = folder.load("t.off", format!("{header}3 0 1 2\n3 0 2 3\n3 0 1 3\n\n2 0 1\n"));
    assert_eq!(mesh, expected);
    assert!(warnings[0].ends_with("t.off: ignored 2 lines after its last face"), "{warnings:?}");
}

#[test]
fn ply_keywords_are_of_any_case_and_what_follows_the_data_is_told() {
    let folder = Folder::new();
    let plain = square_header("") + "element face 2\nproperty list uchar int vertex_indices\nend_header\n";
    let expected = folder.load("t.ply", plain.clone() + BODY).0;
    let shouted = plain
        .replace("format ascii", "FORMAT Ascii")
        .replace("ply", "PLY")
        .replace("property float", "Property FLOAT")
        .replace("list uchar int", "LIST UChar INT")
        .replace("element", "ELEMENT")
        .replace("end_header", "END_HEADER");
    assert_eq!(folder.load("t.ply", shouted + BODY).0, expected);
    for (more, note) in [("3 0 1 3\n", "1 line"), ("\nhello\nworld\n", "2 lines")] {
        let (mesh, warnings) = folder.load("t.ply", plain.clone() + BODY + more);
        assert_eq!(mesh, expected);
        assert!(
            warnings[0].ends_with(&format!("t.ply: ignored {note} after the data that the header tells of")),
            "{warnings:?}"
        );
    }
    assert!(
        folder
            .load("t.ply", plain.clone() + BODY + "\n \n")
            .1
            .iter()
            .all(|warning| !warning.contains("after"))
    );
    let binary = |more: &[u8]| {
        let mut bytes = plain.replace("ascii", "BINARY_LITTLE_ENDIAN").into_bytes();
        SQUARE.as_flattened().iter().for_each(|x| bytes.extend(x.to_le_bytes()));
        for face in [[0i32, 1, 2], [0, 2, 3]] {
            bytes.push(3);
            face.iter().for_each(|vertex| bytes.extend(vertex.to_le_bytes()));
        }
        bytes.extend(more);
        folder.load("t.ply", bytes)
    };
    assert_eq!(binary(b"\n"), binary(b""));
    assert_eq!(binary(b"").0, expected);
    let (mesh, warnings) = binary(&[1, 2, 3, 4, 5]);
    assert_eq!(mesh, expected);
    assert!(
        warnings[0].ends_with("t.ply: ignored 5 bytes after the data that the header tells of"),
        "{warnings:?}"
    );
}

#[test]
fn off_vertices_have_what_the_keyword_says() {
    let folder = Folder::new();
    let corners = [("0 0 0", "0 0.25"), ("1 0 0", "1 0.25"), ("0 1 0", "0 1")];
    for (keyword, between, has_uvs) in [
        ("STOFF", "", true),
        ("STCOFF", " 0.5 0.5 0.5 1", true),
        ("STCOFF", " 0.5 0.5 0.5", true),
        ("STNOFF", " 0 0 -2", true),
        ("STCNOFF", " 0 0 -2 0.5 0.5 0.5 1", true),
        ("STNCOFF", " 0 0 -2 0.5 0.5 0.5", true),
        ("NCOFF", " 0 0 -2 0.5 0.5 0.5 1", false),
        ("CNOFF", " 0 0 -2 255 0 0", false),
        ("stncoff", " 0 0 -2 1 1 1 1", true),
        ("noff", " 0 0 -2", false),
    ] {
        let uv = |uv: &str| if has_uvs { format!(" {uv}") } else { String::new() };
        let vertices = corners.map(|(position, st)| format!("{position}{between}{}\n", uv(st))).concat();
        let (mesh, _) = folder.load("t.off", format!("{keyword}\n3 1 3\n{vertices}3 0 1 2\n"));
        assert_eq!(mesh.positions, [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], "{keyword}");
        let z = if between.contains("-2") { -1.0 } else { 1.0 };
        assert_eq!(mesh.normals, [[0.0, 0.0, z]; 3], "{keyword}");
        let uvs: &[[f32; 2]] = if has_uvs { &[[0.0, 0.75], [1.0, 0.75], [0.0, 0.0]] } else { &[] };
        assert_eq!(mesh.uvs, uvs, "{keyword}: v goes up from the last row, as in OBJ");
    }
    // The same flowing, where every colour is of four numbers.
    let text = "STCNOFF 3 1 3\n0 0 0 0 0 1 1 1 1 1 0 0.25 1 0 0 0 0 1\n1 1 1 1 1 0.25 0 1 0 0 0 1 1 1 1 1 0 1\n3 0 1 2\n";
    assert_eq!(folder.load("t.off", text).0.uvs, [[0.0, 0.75], [1.0, 0.75], [0.0, 0.0]]);
}
