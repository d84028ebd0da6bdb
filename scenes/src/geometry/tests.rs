use super::*;
use crate::test_support::{enclosed_volume, open_edges};
use base64::Engine;
use glam::{DVec3, Vec3};
use serde_json::{Value, json};
use std::path::PathBuf;

const TETRAHEDRON: [[f32; 3]; 4] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
const FACES: [[u16; 3]; 4] = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];

struct Folder(tempfile::TempDir);

impl Folder {
    fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    fn write(&self, name: &str, content: impl AsRef<[u8]>) -> PathBuf {
        let path = self.0.path().join(name);
        std::fs::write(&path, content).unwrap();
        path
    }
}

fn load(path: &Path) -> (Mesh, Vec<String>) {
    load_placed(path, None, &DAffine3::IDENTITY)
}

fn load_placed(path: &Path, node: Option<&str>, world_from_file: &DAffine3) -> (Mesh, Vec<String>) {
    let mut warnings = Vec::new();
    (load_file(path, node, world_from_file, None, &mut warnings).unwrap(), warnings)
}

fn refusal(path: &Path, node: Option<&str>) -> String {
    let message = load_file(path, node, &DAffine3::IDENTITY, None, &mut Vec::new()).unwrap_err().to_string();
    assert!(
        message.contains(&*path.file_name().unwrap().to_string_lossy()) && !message.contains('\n'),
        "{message}"
    );
    message
}

/// Positions, then normals if wanted, then 16-bit indices.
fn buffer(normals: bool) -> Vec<u8> {
    let floats = |v: &[[f32; 3]]| v.iter().flatten().flat_map(|x| x.to_le_bytes()).collect::<Vec<u8>>();
    let mut bytes = floats(&TETRAHEDRON);
    bytes.extend(floats(&if normals { [[0.0, 0.0, 2.0]; 4] } else { [[0.0; 3]; 4] }));
    bytes.extend(FACES.as_flattened().iter().flat_map(|i| i.to_le_bytes()));
    bytes
}

/// A tetrahedron in two nodes: "big" scales by 2 and has the child "moved", which moves by 10 along x and
/// carries the mesh.
fn document(uri: Option<String>, normals: bool) -> Value {
    let mut attributes = json!({"POSITION": 0});
    if normals {
        attributes["NORMAL"] = json!(1);
    }
    let mut buffer = json!({"byteLength": 120});
    if let Some(uri) = uri {
        buffer["uri"] = json!(uri);
    }
    json!({
        "asset": {"version": "2.0"}, "scene": 0,
        "scenes": [{"nodes": [0, 2]}],
        "nodes": [
            {"name": "big", "scale": [2.0, 2.0, 2.0], "children": [1]},
            {"name": "moved", "translation": [10.0, 0.0, 0.0], "mesh": 0},
            {"name": "plain", "mesh": 0},
        ],
        "meshes": [{"primitives": [{"attributes": attributes, "indices": 2}]}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3", "min": [0.0, 0.0, 0.0], "max": [1.0, 1.0, 1.0]},
            {"bufferView": 0, "byteOffset": 48, "componentType": 5126, "count": 4, "type": "VEC3"},
            {"bufferView": 1, "componentType": 5123, "count": 12, "type": "SCALAR"},
        ],
        "bufferViews": [{"buffer": 0, "byteLength": 96}, {"buffer": 0, "byteOffset": 96, "byteLength": 24}],
        "buffers": [buffer],
    })
}

fn data_uri(normals: bool) -> Option<String> {
    Some(format!(
        "data:application/octet-stream;base64,{}",
        base64::engine::general_purpose::STANDARD.encode(buffer(normals))
    ))
}

fn glb(document: &Value, bin: &[u8]) -> Vec<u8> {
    let mut json = document.to_string().into_bytes();
    json.resize(json.len().next_multiple_of(4), b' ');
    let chunk = |kind: &[u8], data: &[u8]| [&(data.len() as u32).to_le_bytes(), kind, data].concat();
    let chunks = [chunk(b"JSON", &json), chunk(b"BIN\0", bin)].concat();
    [b"glTF".as_slice(), &2u32.to_le_bytes(), &(chunks.len() as u32 + 12).to_le_bytes(), &chunks].concat()
}

#[test]
fn gltf_buffers_may_be_inline_beside_or_binary() {
    let folder = Folder::new();
    let inline = folder.write("inline.gltf", document(data_uri(true), true).to_string());
    let beside = folder.write("beside.gltf", document(Some("a%20b.bin".into()), true).to_string());
    folder.write("a b.bin", buffer(true));
    let binary = folder.write("binary.glb", glb(&document(None, true), &buffer(true)));
    let (mesh, warnings) = load(&inline);
    assert_eq!(warnings, [] as [&str; 0]);
    assert_eq!((mesh.positions.len(), mesh.triangles.len()), (8, 8), "both nodes");
    assert_eq!(
        mesh.positions[..2],
        [[20.0, 0.0, 0.0], [22.0, 0.0, 0.0]],
        "the parent's scale acts on the child's translation"
    );
    assert_eq!(mesh.positions[4..6], [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]]);
    assert!(mesh.normals.iter().all(|n| *n == [0.0, 0.0, 1.0]), "given normals are used, at unit length");
    assert_eq!(load(&beside).0, mesh);
    assert_eq!(load(&binary).0, mesh);
}

#[test]
fn a_named_node_brings_its_subtree_only() {
    let folder = Folder::new();
    let path = folder.write("t.gltf", document(data_uri(true), true).to_string());
    for (node, volume) in [("big", 8.0 / 6.0), ("moved", 8.0 / 6.0), ("plain", 1.0 / 6.0)] {
        let mesh = load_placed(&path, Some(node), &DAffine3::IDENTITY).0;
        assert!((enclosed_volume(&mesh) - volume).abs() < 1e-6, "{node}");
    }
    assert!(
        refusal(&path, Some("plane"))
            .ends_with("no node `plane`; did you mean `plain`? There are: `big`, `moved`, `plain`")
    );
}

#[test]
fn transforms_keep_meshes_closed_and_facing_outwards() {
    let folder = Folder::new();
    let path = folder.write("t.gltf", document(data_uri(false), false).to_string());
    let turn = DAffine3::from_axis_angle(DVec3::new(1.0, 2.0, -0.5).normalize(), 1.1);
    for scale in [DVec3::new(3.0, 0.5, 1.0), DVec3::new(-3.0, 0.5, 1.0), DVec3::new(-1.0, -2.0, -1.0)] {
        let map = turn * DAffine3::from_scale(scale);
        let (mesh, warnings) = load_placed(&path, Some("plain"), &map);
        assert_eq!(open_edges(&mesh), 0, "{scale}");
        let volume = scale.x.abs() * scale.y.abs() * scale.z.abs() / 6.0;
        assert!((enclosed_volume(&mesh) - volume).abs() < 1e-6, "{scale}");
        // The file has no normals: flat ones, on the outside of each face.
        assert_eq!(mesh.positions.len(), 12);
        assert!(warnings[0].ends_with("1 of 1 primitive has no normals; made flat ones"), "{warnings:?}");
        for t in &mesh.triangles {
            let [a, b, c] = t.map(|v| Vec3::from(mesh.positions[v as usize]));
            let normal = (b - a).cross(c - a).normalize();
            assert!(t.iter().all(|v| normal.dot(mesh.normals[*v as usize].into()) > 1.0 - 1e-5), "{scale}");
        }
    }
}

#[test]
fn a_crease_angle_makes_gltf_without_normals_smooth() {
    let folder = Folder::new();
    let path = folder.write("t.gltf", document(data_uri(false), false).to_string());
    let mut warnings = Vec::new();
    let mesh = load_file(&path, Some("plain"), &DAffine3::IDENTITY, Some(180.0), &mut warnings).unwrap();
    assert_eq!(mesh.positions.len(), 12);
    let corner = mesh
        .positions
        .iter()
        .zip(&mesh.normals)
        .filter(|(p, _)| **p == [0.0; 3])
        .map(|(_, n)| Vec3::from(*n));
    assert!(
        corner.clone().count() == 3
            && corner.clone().all(|n| n.distance(Vec3::splat(-1.0).normalize()) < 1e-6),
        "{mesh:?}"
    );
    assert!(
        warnings.len() == 1 && warnings[0].contains("made normals for 12 of 12 vertices"),
        "{warnings:?}"
    );
}

#[test]
fn strips_and_fans_become_triangles() {
    // The square 0 1 / 2 3 as a strip and around vertex 0 as a fan: two triangles with the same facing.
    let folder = Folder::new();
    for (mode, order) in [(5, [0u16, 1, 2, 3]), (6, [0, 1, 3, 2])] {
        let positions = [[0.0f32, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0]];
        let mut bytes: Vec<u8> = positions.iter().flatten().flat_map(|x| x.to_le_bytes()).collect();
        bytes.extend(order.iter().flat_map(|i| i.to_le_bytes()));
        let uri = format!("data:;base64,{}", base64::engine::general_purpose::STANDARD.encode(bytes));
        let document = json!({
            "asset": {"version": "2.0"}, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
            "meshes": [{"primitives": [
                {"attributes": {"POSITION": 0}, "indices": 1, "mode": mode},
                {"attributes": {"POSITION": 0}, "mode": 1},
            ]}],
            "accessors": [
                {"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3", "min": [0.0, 0.0, 0.0], "max": [1.0, 1.0, 0.0]},
                {"bufferView": 1, "componentType": 5123, "count": 4, "type": "SCALAR"},
            ],
            "bufferViews": [{"buffer": 0, "byteLength": 48}, {"buffer": 0, "byteOffset": 48, "byteLength": 8}],
            "buffers": [{"byteLength": 56, "uri": uri}],
        });
        let (mesh, warnings) = load(&folder.write("s.gltf", document.to_string()));
        assert_eq!(mesh.triangles.len(), 2);
        let area: f32 = mesh
            .triangles
            .iter()
            .map(|t| t.map(|v| Vec3::from(mesh.positions[v as usize])))
            .map(|[a, b, c]| (b - a).cross(c - a).z)
            .sum();
        assert_eq!(area, 2.0, "mode {mode}: twice the square, all facing +z");
        assert!(
            warnings.iter().any(|w| w.ends_with("ignored 1 of 2 primitives, which is points or lines")),
            "{warnings:?}"
        );
    }
}

#[test]
fn broken_gltf_is_refused() {
    let folder = Folder::new();
    let change = |pointer: &str, value: Value| {
        let mut document = document(data_uri(true), true);
        *document.pointer_mut(pointer).unwrap() = value;
        refusal(&folder.write("t.gltf", document.to_string()), None)
    };
    for (pointer, value, part) in [
        ("/accessors/2/count", json!(13), "accessor 2 reaches beyond its buffer"),
        ("/accessors/0/count", json!(u64::MAX), "more than 67108864 vertices"),
        ("/accessors/1/count", json!(u64::MAX), "accessor 1 reaches beyond its buffer"),
        ("/accessors/1/count", json!(3), "4 positions but 3 normals"),
        ("/accessors/0/componentType", json!(5125), "accessor 0 holds VEC3 of unsigned integers"),
        ("/bufferViews/0/byteLength", json!(1000), "reaches beyond its buffer"),
        ("/buffers/0/byteLength", json!(121), "buffer 0: 120 bytes, 121 are declared"),
        ("/buffers/0/uri", json!("gone.bin"), "gone.bin: "),
        ("/buffers/0/uri", json!("https://example.org/a.bin"), "download it"),
        ("/buffers/0/uri", json!("data:;base64,???"), "broken base64"),
        ("/nodes/1", json!({"children": [0]}), "t.gltf: node 0 is below itself; export the file again"),
        ("/nodes/0/children", json!([7]), "not valid glTF"),
        (
            "/asset",
            json!({"version": "2.0", "x": 1, "minVersion": 3}),
            "needs glTF of version 3 (asset.minVersion)",
        ),
    ] {
        let message = change(pointer, value);
        assert!(message.contains(part), "{pointer}: {message}");
    }
    let mut bytes = buffer(true);
    bytes[96] = 9;
    let message = refusal(&folder.write("t.glb", glb(&document(None, true), &bytes)), None);
    assert!(
        message.ends_with("mesh 0, primitive 0: triangle 0 names vertex 9 of 4; mend the mesh"),
        "{message}"
    );
    bytes[0..4].copy_from_slice(&f32::NAN.to_le_bytes());
    let message = refusal(&folder.write("t.glb", glb(&document(None, true), &bytes)), None);
    assert!(message.contains("vertex 0 at [NaN, 0.0, 0.0] is not a finite position"), "{message}");
    assert!(
        refusal(&folder.write("t.glb", &glb(&document(None, true), &bytes)[..40]), None)
            .contains("not a whole binary glTF 2.0 file")
    );
}

/// A cube of quads, in two groups, with relative indices in one.
const OBJ_CUBE: &str = "mtllib gone.mtl
v -1 -1 -1\nv 1 -1 -1\nv 1 1 -1\nv -1 1 -1\nv -1 -1 1\nv 1 -1 1\nv 1 1 1\nv -1 1 1
g sides
f 1 5 8 4\nf 2 3 7 6\nf 1 2 6 5\nf 4 8 7 3
g ends
f -8 -5 -6 -7\nf 5 6 7 8
";

#[test]
fn obj_polygons_become_triangles_across_groups() {
    let folder = Folder::new();
    let (mesh, warnings) = load(&folder.write("cube.obj", OBJ_CUBE));
    assert_eq!(open_edges(&mesh), 0);
    assert!((enclosed_volume(&mesh) - 8.0).abs() < 1e-6);
    assert_eq!((mesh.positions.len(), mesh.triangles.len()), (24, 12), "each side has corners of its own");
    assert!(
        warnings[0].contains("made normals for 8 of 8 vertices, 24 now as hard edges part them, as none or zero were there: smooth where faces meet at less than 40"),
        "{warnings:?}"
    );
}

#[test]
fn obj_normals_are_used_where_they_are() {
    let folder = Folder::new();
    let text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 3\nvn 0 0 0\nf 1//1 2//1 3//2\n";
    let (mesh, warnings) = load(&folder.write("t.obj", text));
    assert_eq!(mesh.normals, [[0.0, 0.0, 1.0]; 3]);
    assert!(warnings[0].contains("made normals for 1 of 3 vertices"), "{warnings:?}");
    // A corner that names none, beside a normal that is not the triangle's.
    let (mesh, warnings) = load(&folder.write("t.obj", text.replace("3//2", "3").replace("0 0 3", "3 0 0")));
    assert_eq!(mesh.normals, [[1.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]);
    assert!(warnings[0].contains("made normals for 1 of 3 vertices"), "{warnings:?}");
}

#[test]
fn both_sides_of_a_sheet_get_normals() {
    let folder = Folder::new();
    let text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nf 6 5 4\n";
    let (mesh, _) = load(&folder.write("t.obj", text));
    assert_eq!(mesh.normals.iter().map(|n| n[2]).collect::<Vec<_>>(), [1.0, 1.0, 1.0, -1.0, -1.0, -1.0]);
}

#[test]
fn degenerate_triangles_are_dropped_and_counted() {
    let folder = Folder::new();
    let text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0.5 0 0\nv 1e-12 0 0\nv 0 1e-12 0\nf 1 2 3\nf 1 1 2\nf 1 4 2\nf 1 5 6\n";
    let (mesh, warnings) = load(&folder.write("t.obj", text));
    assert_eq!((mesh.triangles.len(), mesh.positions.len()), (1, 3), "and the vertices that only they used");
    assert!(warnings[0].ends_with("t.obj: dropped 3 degenerate of 4 triangles (zero area)"), "{warnings:?}");
    let message = refusal(&folder.write("t.obj", text.replace("f 1 2 3\n", "")), None);
    assert!(
        message.ends_with("no usable triangle (3 degenerate); check the mesh and its scale"),
        "{message}"
    );
    // A long thin triangle that single precision can tell from a line stays.
    let (mesh, _) = load(&folder.write("t.obj", "v 0 0 0\nv 1 0 0\nv 0 1e-5 0\nf 1 2 3\n"));
    assert_eq!(mesh.triangles.len(), 1);
}

#[test]
fn broken_obj_is_refused_with_its_line() {
    let folder = Folder::new();
    for (text, part) in [
        (
            "v 0 0 0\nv 1 x 0\n",
            "t.obj: line 2: `x` is no coordinate of a vertex; mend or export the file again",
        ),
        ("v 0 0 0\nf 1 2 3\n", "t.obj: line 2: names vertex 2, of 1; mend"),
        ("v 0 0 0\nf 1 1 -5\n", "t.obj: line 2: names vertex -5, but only 1 come before; mend"),
        (
            "v 0 0 0\nvn 0 0 1\nf 1//6148914691236517206 1 1\n",
            "t.obj: line 3: names normal 4294967295, of 1; mend",
        ),
        (
            "v 0 0 0\nv inf 0 0\nv 0 1 0\nf 1 2 3\n",
            "t.obj: line 4: names vertex 2 at [inf, 0.0, 0.0], which is not finite; mend",
        ),
        (
            "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nf 1/1 2/-2 3/1\n",
            "t.obj: line 5: names texture coordinate -2, but only 1 come before; mend",
        ),
        ("", "t.obj: has no faces; export it as a mesh"),
    ] {
        let message = refusal(&folder.write("t.obj", text), None);
        assert!(message.contains(part), "{text}: {message}");
    }
}

#[test]
fn other_formats_and_nodes_of_obj_are_refused() {
    let folder = Folder::new();
    assert!(refusal(&folder.write("t.stl", ""), None).contains("it reads .gltf, .glb, .obj, .ply and .off"));
}

#[test]
fn texture_coordinates_come_along() {
    let folder = Folder::new();
    let with = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 9 9 9\nvt 0 0\nvt 1 0\nvt 0.25 0.75\nf 1/1 2/2 3/3\n";
    let (mesh, _) = load(&folder.write("t.obj", with));
    // OBJ's v goes up. The unused vertex takes nothing away from the others.
    assert_eq!(mesh.uvs, [[0.0, 1.0], [1.0, 1.0], [0.25, 0.25]]);
    let (mesh, _) = load(&folder.write("t.obj", with.replace("/1", "").replace("/2", "").replace("/3", "")));
    assert!(mesh.uvs.is_empty());
    // Two groups, of which one has none; then a coordinate that is no number.
    let (mesh, warnings) = load(&folder.write("t.obj", format!("{with}g other\nf 1 3 2\n")));
    assert_eq!(mesh.uvs.len(), mesh.positions.len());
    assert_eq!(mesh.uvs[3..], [[0.0; 2]; 3]);
    assert!(
        warnings
            .iter()
            .any(|w| w.ends_with("gave the texture coordinates (0, 0) to 3 of 6 vertices, which had none")),
        "{warnings:?}"
    );
    let (mesh, warnings) = load(&folder.write("t.obj", with.replace("vt 1 0", "vt nan 0")));
    assert_eq!(mesh.uvs[1], [0.0; 2]);
    assert!(
        warnings.iter().any(|w| w.ends_with(
            "gave the texture coordinates (0, 0) to 1 of 3 vertices in place of what was not finite"
        )),
        "{warnings:?}"
    );
}

/// What a scene would refuse as a name is gone from the names of other programs.
#[test]
fn names_of_other_programs_are_tidied_by_the_rule_for_names() {
    for (given, expected) in
        [(" Lack\u{61c} rot\n", "Lack  rot"), ("a\u{202e}b\u{1b}c", "a b c"), ("päper", "päper")]
    {
        assert_eq!(tidy_name(given), expected);
        assert!(relume_formats::name::fault(expected).is_none());
    }
    assert_eq!(tidy_name(&"x".repeat(1000)).len(), relume_formats::name::MAX_CHARS);
}
