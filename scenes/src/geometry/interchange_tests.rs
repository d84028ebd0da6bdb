//! glTF as other programs write it: legal though unusual, slightly wrong, or asking for more than is read.

use super::*;
use crate::test_support::Scratch;
use base64::Engine;
use serde_json::{Value, json};

/// A glTF document of one mesh that grows by accessors; every accessor has a view of its own, of the same
/// index.
pub(super) struct File {
    pub document: Value,
    bytes: Vec<u8>,
}

const TRIANGLE: [[f32; 3]; 3] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];

impl File {
    /// A triangle of area ½ in node 0.
    pub fn triangle() -> Self {
        let document = json!({
            "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
            "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}], "accessors": [], "bufferViews": [],
        });
        let mut file = Self { document, bytes: Vec::new() };
        let positions: Vec<u8> = TRIANGLE.iter().flatten().flat_map(|x| x.to_le_bytes()).collect();
        file.accessor(5126, "VEC3", 3, &positions);
        file
    }

    fn accessor(&mut self, component: u32, kind: &str, count: usize, bytes: &[u8]) -> usize {
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        let view = json!({"buffer": 0, "byteOffset": self.bytes.len(), "byteLength": bytes.len()});
        self.bytes.extend_from_slice(bytes);
        self.document["bufferViews"].as_array_mut().unwrap().push(view);
        let accessors = self.document["accessors"].as_array_mut().unwrap();
        accessors.push(
            json!({"bufferView": accessors.len(), "componentType": component, "type": kind, "count": count}),
        );
        accessors.len() - 1
    }

    fn floats(&mut self, kind: &str, count: usize, values: &[f32]) -> usize {
        self.accessor(5126, kind, count, &values.iter().flat_map(|x| x.to_le_bytes()).collect::<Vec<_>>())
    }

    fn text(&self) -> String {
        let mut document = self.document.clone();
        let data = base64::engine::general_purpose::STANDARD.encode(&self.bytes);
        document["buffers"] =
            json!([{"byteLength": self.bytes.len(), "uri": format!("data:;base64,{data}")}]);
        document.to_string()
    }

    fn try_load(&self, node: Option<&str>) -> Result<(Mesh, Vec<String>)> {
        let scratch = Scratch::scene("");
        scratch.write("t.gltf", self.text());
        let (path, mut warnings) = (scratch.path("t.gltf"), Vec::new());
        let mesh = load_file(&path, node, &DAffine3::IDENTITY, None, &mut warnings)?;
        // What moves is the same at rest, with the same warnings.
        let mut again = Vec::new();
        let deforming = load_placed(&path, node, &DAffine3::IDENTITY, None, &mut again)?;
        assert_eq!((&deforming.rest, &again), (&mesh, &warnings));
        let mut posed = Vec::new();
        deforming.shape.positions(&deforming.shape.rest_pose(), &mut posed);
        assert_eq!(posed, mesh.positions);
        Ok((mesh, warnings))
    }

    pub fn load(&self) -> (Mesh, Vec<String>) {
        self.try_load(None).unwrap()
    }

    pub fn refusal(&self) -> String {
        let error = self.try_load(None).unwrap_err();
        let message = error.to_string();
        assert!(
            error.is_bad_input()
                && message.contains("t.gltf: ")
                && !message.contains('\n')
                && !message.contains(".rs"),
            "{message}"
        );
        message
    }
}

/// Areas of all triangles.
pub(super) fn areas(mesh: &Mesh) -> Vec<f64> {
    let area = |t: &[u32; 3]| 0.5 * builder::area_vector(t.map(|v| mesh.positions[v as usize])).length();
    mesh.triangles.iter().map(area).collect()
}

pub(super) fn is_told(warnings: &[String], end: &str) -> bool {
    warnings.iter().filter(|warning| warning.ends_with(end)).count() == 1
}

#[test]
fn attributes_of_programs_are_ignored() {
    let mut file = File::triangle();
    file.document["meshes"][0]["primitives"][0]["attributes"] =
        json!({"POSITION": 0, "_BATCHID": 0, "_x": 7, "COLOR": 0, "TEXCOORD_x": 9});
    let (mesh, warnings) = file.load();
    assert_eq!((mesh.positions.as_slice(), warnings.len()), (TRIANGLE.as_slice(), 1), "{warnings:?}");
    assert!(is_told(&warnings, "1 of 1 primitive has no normals; made flat ones"));
}

#[test]
fn scenes_may_be_empty_or_missing() {
    let two = json!([{"mesh": 0, "children": [1]}, {"mesh": 0, "translation": [0.0, 0.0, 1.0]}]);
    for (scenes, default, triangles, told) in [
        (json!([{"name": "empty"}, {"nodes": [0]}]), Some(1), 2, false),
        (json!([{"nodes": [1]}]), None, 1, false),
        (json!([{"name": "empty"}]), Some(0), 2, true),
        (json!([{"nodes": []}, {"nodes": [1]}]), None, 2, true),
        (json!([]), None, 2, false),
    ] {
        let mut file = File::triangle();
        (file.document["nodes"], file.document["scenes"]) = (two.clone(), scenes.clone());
        file.document.as_object_mut().unwrap().remove("scene");
        if let Some(default) = default {
            file.document["scene"] = json!(default);
        }
        let (mesh, warnings) = file.load();
        assert_eq!(mesh.triangles.len(), triangles, "{scenes}");
        assert_eq!(
            is_told(&warnings, "its default scene is empty; took all nodes of the file"),
            told,
            "{scenes}: {warnings:?}"
        );
    }
    let mut file = File::triangle();
    file.document.as_object_mut().unwrap().remove("scenes");
    let (mesh, warnings) = file.load();
    assert!(
        mesh.triangles.len() == 1 && is_told(&warnings, "its default scene is not there; took what there is"),
        "{warnings:?}"
    );
    file.document.as_object_mut().unwrap().remove("scene");
    assert_eq!(file.load().0.triangles.len(), 1);
}

#[test]
fn extras_may_be_anything_and_nulls_are_nothing() {
    let mut file = File::triangle();
    for extras in [json!("text"), json!(5), json!([1, {}]), json!(null), json!({"a": null})] {
        for pointer in
            ["", "/asset", "/nodes/0", "/meshes/0", "/meshes/0/primitives/0", "/accessors/0", "/scenes/0"]
        {
            file.document.pointer_mut(pointer).unwrap()["extras"] = extras.clone();
        }
        file.document["nodes"][0]["skin"] = json!(null);
        assert_eq!(file.load().0.triangles.len(), 1, "{extras}");
    }
}

#[test]
fn channels_that_move_no_node_are_left_out() {
    let mut file = File::triangle();
    let (input, output) =
        (file.floats("SCALAR", 2, &[0.0, 1.0]), file.floats("VEC3", 2, &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0]));
    let pointer = json!({"path": "pointer", "extensions": {"KHR_animation_pointer": {"pointer": "/nodes/0/translation"}}});
    file.document["animations"] = json!([{
        "samplers": [{"input": input, "output": output}],
        "channels": [
            {"sampler": 0, "target": {"path": "translation"}},
            {"sampler": 0, "target": pointer},
            {"sampler": 0, "target": {"node": 0, "path": "translation"}},
        ],
    }, {"name": "empty"}]);
    file.document["extensionsUsed"] = json!(["KHR_animation_pointer"]);
    let (_, warnings) = file.load();
    assert!(is_told(&warnings, "left out 2 animation channels without a node to move"), "{warnings:?}");
    assert!(is_told(&warnings, "the file uses KHR_animation_pointer, which is ignored"), "{warnings:?}");
    let scratch = Scratch::scene("");
    scratch.write("t.gltf", file.text());
    let clips = load_deforming(&scratch.path("t.gltf"), &mut Vec::new()).unwrap().shape.clips;
    assert_eq!((clips.len(), clips[0].tracks.len(), clips[0].name.as_str()), (1, 1, "clip-0"));
    // Two of one name are told apart.
    let again = file.document["animations"][0].clone();
    file.document["animations"] = json!([again, again, again]);
    file.document["animations"][1]["name"] = json!("clip-0");
    scratch.write("t.gltf", file.text());
    let mut warnings = Vec::new();
    let clips = load_deforming(&scratch.path("t.gltf"), &mut warnings).unwrap().shape.clips;
    assert_eq!(
        clips.iter().map(|clip| clip.name.as_str()).collect::<Vec<_>>(),
        ["clip-0", "clip-0-2", "clip-2"]
    );
    assert!(is_told(&warnings, "names of animations repeat; numbered `clip-0-2`"), "{warnings:?}");
}

#[test]
fn instances_are_meshes_in_their_places() {
    let mut file = File::triangle();
    let translation = file.floats("VEC3", 2, &[0.0, 0.0, 0.0, 5.0, 0.0, 0.0]);
    // None, and a right angle about z, as shares of 32767; the w of neither needs to make it a unit.
    let turns: Vec<u8> =
        [0i16, 0, 0, 32767, 0, 0, 23170, 23170].iter().flat_map(|x| x.to_le_bytes()).collect();
    let rotation = file.accessor(5122, "VEC4", 2, &turns);
    file.document["accessors"][rotation]["normalized"] = json!(true);
    let scale = file.floats("VEC3", 2, &[1.0, 1.0, 1.0, 2.0, 3.0, 1.0]);
    let instancing =
        json!({"attributes": {"TRANSLATION": translation, "ROTATION": rotation, "SCALE": scale, "_ID": 0}});
    file.document["nodes"][0] = json!({"mesh": 0, "translation": [0.0, 0.0, 7.0], "extensions": {"EXT_mesh_gpu_instancing": instancing}});
    file.document["extensionsUsed"] = json!(["EXT_mesh_gpu_instancing"]);
    file.document["extensionsRequired"] = json!(["EXT_mesh_gpu_instancing"]);
    let (mesh, warnings) = file.load();
    let expected = [
        [0.0, 0.0, 7.0],
        [1.0, 0.0, 7.0],
        [0.0, 1.0, 7.0],
        [5.0, 0.0, 7.0],
        [5.0, 2.0, 7.0],
        [2.0, 0.0, 7.0],
    ];
    for (found, expected) in mesh.positions.iter().zip(expected) {
        assert!((0..3).all(|k| (found[k] - expected[k]).abs() < 1e-5), "{:?}", mesh.positions);
    }
    assert_eq!((mesh.triangles.len(), warnings.len()), (2, 1), "{warnings:?}");
    for (pointer, value, part) in [
        ("/accessors/1/count", json!(1), "instances of node 0: [1, 2, 2] values, as many of each are needed"),
        ("/accessors/1/count", json!(2_000_000), "at most 1048576"),
        ("/accessors/3/type", json!("VEC2"), "accessor 3 holds VEC2 of floats"),
        (
            "/nodes/0/extensions/EXT_mesh_gpu_instancing/attributes/SCALE",
            json!(9),
            "instances of node 0: no accessor 9",
        ),
    ] {
        let before = std::mem::replace(file.document.pointer_mut(pointer).unwrap(), value);
        let message = file.refusal();
        assert!(message.contains(part), "{message}");
        *file.document.pointer_mut(pointer).unwrap() = before;
    }
    let huge = json!(1_000_000);
    for accessor in 1..4 {
        file.document["accessors"][accessor]["count"] = huge.clone();
        file.document["accessors"][accessor].as_object_mut().unwrap().remove("bufferView");
    }
    file.document["accessors"][0]["count"] = json!(100_000);
    file.document["accessors"][0].as_object_mut().unwrap().remove("bufferView");
    assert!(
        file.refusal()
            .contains("instances of node 0: 1000000 instances of 100000 vertices, at most 67108864")
    );
}

#[test]
fn accessors_may_be_sparse_or_empty() {
    let mut file = File::triangle();
    let indices = file.accessor(5121, "SCALAR", 2, &[1, 2]);
    let values = file.floats("VEC3", 2, &[3.0, 0.0, 0.0, 0.0, 1.0, 0.0]);
    let sparse = json!({"count": 2, "indices": {"bufferView": indices, "componentType": 5121}, "values": {"bufferView": values}});
    file.document["accessors"][0]["sparse"] = sparse.clone();
    assert_eq!(areas(&file.load().0), [1.5]);
    // Without a view all others are 0.
    file.document["accessors"][0].as_object_mut().unwrap().remove("bufferView");
    assert_eq!(file.load().0.positions, [[0.0, 0.0, 0.0], [3.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
    file.document["accessors"][0]["sparse"]["indices"]["componentType"] = json!(5123);
    assert!(file.refusal().contains("accessor 0 reaches beyond its buffer"));
    // Indices and texture coordinates may be sparse too.
    let mut file = File::triangle();
    let changes = file.accessor(5121, "SCALAR", 2, &[1, 2]);
    let corners = json!({"componentType": 5121, "type": "SCALAR", "count": 3,
        "sparse": {"count": 2, "indices": {"bufferView": changes, "componentType": 5121}, "values": {"bufferView": changes}}});
    file.document["accessors"].as_array_mut().unwrap().push(corners);
    file.document["meshes"][0]["primitives"][0]["indices"] = json!(2);
    assert_eq!(areas(&file.load().0), [0.5]);
    file.document["accessors"][0].as_object_mut().unwrap().remove("bufferView");
    assert!(file.refusal().contains("no usable triangle (1 degenerate)"), "all of it is 0");
    file.document["accessors"][0]["count"] = json!(60_000_000);
    assert!(file.refusal().contains("accessor 0 has 60000000 elements without data"));
}

#[test]
fn quantised_vertices_are_read() {
    let bytes = |values: &[i16]| values.iter().flat_map(|x| x.to_le_bytes()).collect::<Vec<u8>>();
    let mut file = File::triangle();
    let positions = [
        // i16 that are shares, with four bytes more between vertices than they need.
        (
            5122,
            true,
            bytes(&[0, 0, 0, 9, 32767, 0, 0, 9, 0, -32767, 0, 9]),
            8,
            [[1.0, 0.0, 0.0], [0.0, -1.0, 0.0]],
        ),
        (
            5122,
            false,
            bytes(&[0, 0, 0, 9, 300, 0, 0, 9, 0, -2, 0, 9]),
            8,
            [[300.0, 0.0, 0.0], [0.0, -2.0, 0.0]],
        ),
        (5120, true, vec![0, 0, 0, 9, 127, 0, 0, 9, 0, 128, 0, 9], 4, [[1.0, 0.0, 0.0], [0.0, -1.0, 0.0]]),
        (5121, false, vec![0, 0, 0, 9, 200, 0, 0, 9, 0, 4, 0, 9], 4, [[200.0, 0.0, 0.0], [0.0, 4.0, 0.0]]),
        (5123, true, bytes(&[0, 0, 0, 9, -1, 0, 0, 9, 0, -1, 0, 9]), 8, [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]),
    ];
    let normals = file.accessor(5120, "VEC3", 3, &[0, 0, 127, 9, 0, 0, 127, 9, 0, 0, 127, 9]);
    let uvs = file.accessor(5123, "VEC2", 3, &bytes(&[0, 0, 4096, 0, 0, 1]));
    file.document["bufferViews"][normals]["byteStride"] = json!(4);
    file.document["accessors"][normals]["normalized"] = json!(true);
    for (component, normalised, data, stride, [second, third]) in positions {
        let at = file.accessor(component, "VEC3", 3, &data);
        file.document["bufferViews"][at]["byteStride"] = json!(stride);
        file.document["accessors"][at]["normalized"] = json!(normalised);
        file.document["meshes"][0]["primitives"][0]["attributes"] =
            json!({"POSITION": at, "NORMAL": normals, "TEXCOORD_0": uvs});
        file.document["extensionsRequired"] = json!(["KHR_mesh_quantization"]);
        let (mesh, warnings) = file.load();
        assert_eq!(mesh.positions, [[0.0; 3], second, third], "{component} {normalised}");
        assert_eq!(
            (mesh.normals[0], mesh.uvs[1], warnings.len()),
            ([0.0, 0.0, 1.0], [4096.0, 0.0], 0),
            "{warnings:?}"
        );
    }
}

#[test]
fn weights_are_mended() {
    let mut file = File::triangle();
    let joints = file.accessor(5121, "VEC4", 3, &[0; 12]);
    let weights = file.floats("VEC4", 3, &[0.0, 0.0, 0.0, 0.0, 1.0, -0.01, 0.0, 0.0, 3.0, 1.0, 0.0, 0.0]);
    file.document["meshes"][0]["primitives"][0]["attributes"] =
        json!({"POSITION": 0, "JOINTS_0": joints, "WEIGHTS_0": weights});
    file.document["nodes"] =
        json!([{"mesh": 0, "skin": 0, "children": [1]}, {"translation": [0.0, 0.0, 2.0]}]);
    file.document["skins"] = json!([{"joints": [1]}]);
    let (mesh, warnings) = file.load();
    assert_eq!(mesh.positions, TRIANGLE.map(|[x, y, _]| [x, y, 2.0]));
    assert!(
        is_told(&warnings, "mended the joint weights of 2 vertices, which were below 0 or all 0"),
        "{warnings:?}"
    );
}

#[test]
fn nodes_of_one_name_are_numbered() {
    let mut file = File::triangle();
    let at = |z: f64| json!({"name": "X", "mesh": 0, "translation": [0.0, 0.0, z]});
    file.document["nodes"] = json!([at(1.0), at(2.0), {"name": "Y\u{7}", "mesh": 0}]);
    file.document["scenes"][0]["nodes"] = json!([0, 1, 2]);
    let z = |node: &str| file.try_load(Some(node)).map(|(mesh, warnings)| (mesh.positions[0][2], warnings));
    let (height, warnings) = z("X").unwrap();
    assert!(
        height == 1.0 && is_told(&warnings, "2 nodes are called `X`; took the first, the others are `X-2`"),
        "{warnings:?}"
    );
    let (height, warnings) = z("X-2").unwrap();
    assert!(height == 2.0 && warnings.len() == 1, "{warnings:?}");
    assert_eq!(z("Y\u{7}").unwrap().0, 0.0);
    assert!(z("Z").unwrap_err().to_string().contains("There are: `X`, `X-2`, `Y`"));
}

#[test]
fn what_is_required_and_not_read_is_named_with_a_remedy() {
    let required = |names: Value| {
        let mut file = File::triangle();
        file.document["extensionsRequired"] = names;
        file.refusal()
    };
    for (name, remedy) in [
        ("KHR_draco_mesh_compression", "`npx @gltf-transform/cli copy in.glb out.glb`"),
        ("EXT_meshopt_compression", "`npx @gltf-transform/cli copy in.glb out.glb`"),
        ("EXT_texture_webp", "`npx @gltf-transform/cli png --formats webp in.glb out.glb`"),
        ("KHR_texture_basisu", "`npx @gltf-transform/cli ktxdecompress in.glb out.glb`"),
        ("KHR_materials_pbrSpecularGlossiness", "`npx @gltf-transform/cli metalrough in.glb out.glb`"),
        ("VENDOR_thing", "export it without"),
    ] {
        let message = required(json!(["KHR_texture_transform", name]));
        assert!(
            message.ends_with(remedy)
                && message.contains(&format!("t.gltf: requires {name}, which is not supported")),
            "{message}"
        );
    }
    // Data for an extension alone, which the file does not say that it requires.
    let mut file = File::triangle();
    file.document["meshes"][0]["primitives"][0]["extensions"] =
        json!({"KHR_draco_mesh_compression": {"bufferView": 0, "attributes": {"POSITION": 0}}});
    assert_eq!(file.load().0.triangles.len(), 1, "vertices are there without it too");
    file.document["accessors"][0].as_object_mut().unwrap().remove("bufferView");
    assert!(file.refusal().contains("stores vertices by KHR_draco_mesh_compression, which is not supported"));
    let scratch = Scratch::scene("");
    let mut document = File::triangle().document;
    document["buffers"] =
        json!([{"byteLength": 36, "extensions": {"EXT_meshopt_compression": {"fallback": true}}}]);
    scratch.write("t.gltf", document.to_string());
    let message = load_mesh(&scratch.path("t.gltf"), &mut Vec::new()).unwrap_err().to_string();
    assert!(
        message.contains("stores vertices by EXT_meshopt_compression, which is not supported"),
        "{message}"
    );
}

#[test]
fn text_is_read_however_it_is_wrapped_and_refused_in_words() {
    let scratch = Scratch::scene("");
    let load = |text: &[u8]| {
        scratch.write("t.gltf", text);
        load_mesh(&scratch.path("t.gltf"), &mut Vec::new())
            .map(|mesh| mesh.triangles.len())
            .map_err(|e| e.to_string())
    };
    let text = File::triangle().text();
    assert_eq!(load(format!("\u{FEFF}{text}\0\0").as_bytes()), Ok(1));
    assert_eq!(load(text.replace(r#""count":3"#, r#""count":3.0"#).as_bytes()), Ok(1));
    assert_eq!(load(text.replace(r#""version":"2.0""#, r#""version":2.0"#).as_bytes()), Ok(1));
    assert_eq!(load(text.replace("==\"", "\"").replace("=\"", "\"").as_bytes()), Ok(1));
    assert_eq!(
        load(text.replace(r#""version":"2.0""#, r#""version":"2.1","minVersion":"2.0""#).as_bytes()),
        Ok(1)
    );
    for (text, part) in [
        (
            text.replace(r#""count":3"#, r#""count":"3""#),
            "accessors[0]: not a glTF 2.0 file (invalid type: string \"3\", expected u64)",
        ),
        (
            text.replace(r#""version":"2.0""#, r#""version":"1.0""#),
            "is glTF of version 1.0, only 2.0 is read",
        ),
        (
            text.replace(r#""version":"2.0""#, r#""version":1"#),
            "t.gltf: is glTF of version 1, only 2.0 is read; convert it to glTF 2.0",
        ),
        (
            text.replace(r#""version":"2.0""#, r#""version":0.8"#),
            "t.gltf: is glTF of version 0.8, only 2.0 is read; convert it to glTF 2.0",
        ),
        (text.replace(r#""asset""#, r#""assets""#), "it has no asset.version"),
        (
            text.replace(r#""version":"2.0""#, r#""version":"2.1","minVersion":"2.1""#),
            "t.gltf: needs glTF of version 2.1 (asset.minVersion), only 2.0 is read; export it as glTF 2.0",
        ),
        (
            text.replace(r#""version":"2.0""#, r#""version":2.5,"minVersion":2.1"#),
            "needs glTF of version 2.1 (asset.minVersion)",
        ),
        (
            text.replace(r#""mesh":0"#, r#""mesh":7"#),
            "nodes[0].mesh: not valid glTF (it names what is not there)",
        ),
        (text[..text.len() / 2].to_owned(), "not a glTF 2.0 file (EOF while parsing"),
        ("{\"a\":".repeat(1000), "recursion limit exceeded"),
        (String::new(), "not a glTF 2.0 file"),
        ("[]".to_owned(), "it has no asset.version"),
    ] {
        let message = load(text.as_bytes()).unwrap_err();
        assert!(message.contains(part) && !message.contains('\n'), "{part}: {message}");
    }
}

#[test]
fn hidden_and_flattened_nodes_leave_the_rest() {
    let mut file = File::triangle();
    file.document["scenes"][0]["nodes"] = json!([0, 1, 2, 3]);
    let singular = [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 0.0, 0.0, 5.0, 1.0];
    file.document["nodes"] = json!([{"mesh": 0}, {"mesh": 0, "scale": [0, 0, 0]}, {"mesh": 0, "scale": [1, 0, 1]}, {"mesh": 0, "matrix": singular}]);
    let (mesh, warnings) = file.load();
    assert_eq!(areas(&mesh), [0.5, 0.5]);
    assert_eq!((mesh.positions[3], mesh.normals[3]), ([0.0, 0.0, 5.0], [0.0, 0.0, 1.0]));
    assert!(is_told(&warnings, "dropped 2 degenerate of 4 triangles (zero area)"), "{warnings:?}");
}

#[test]
fn primitives_without_positions_are_not_drawn() {
    let mut file = File::triangle();
    file.document["meshes"][0]["primitives"] =
        json!([{"attributes": {"NORMAL": 0}}, {"attributes": {"POSITION": 0, "NORMAL": 0}}]);
    let (mesh, warnings) = file.load();
    assert_eq!(mesh.triangles.len(), 1);
    assert!(is_told(&warnings, "ignored 1 of 2 primitives, without positions"), "{warnings:?}");
}
