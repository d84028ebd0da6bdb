//! glTF files with skins, morph targets and animations, made by hand.

use super::{Deforming, load_deforming};
use base64::Engine;
use serde_json::{Value, json};

pub(super) const TURNED: [f32; 4] =
    [0.0, 0.0, std::f32::consts::FRAC_1_SQRT_2, std::f32::consts::FRAC_1_SQRT_2];
pub(super) const NOT_TURNED: [f32; 4] = [0.0, 0.0, 0.0, 1.0];

/// A glTF document that grows by accessors; every accessor has a view of its own, of the same index.
pub(super) struct File {
    pub(super) document: Value,
    pub(super) bytes: Vec<u8>,
}

impl File {
    pub(super) fn accessor(&mut self, component: u32, kind: &str, count: usize, bytes: &[u8]) -> usize {
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        let view = json!({"buffer": 0, "byteOffset": self.bytes.len(), "byteLength": bytes.len()});
        self.bytes.extend_from_slice(bytes);
        let index = self.document["accessors"].as_array().unwrap().len();
        let bounds = [json!([0.0, 0.0, 0.0]), json!([1.0, 1.0, 1.0])];
        let accessor = json!({"bufferView": index, "componentType": component, "type": kind, "count": count, "min": bounds[0], "max": bounds[1]});
        self.document["bufferViews"].as_array_mut().unwrap().push(view);
        self.document["accessors"].as_array_mut().unwrap().push(accessor);
        index
    }

    pub(super) fn floats<const N: usize>(&mut self, kind: &str, values: &[[f32; N]]) -> usize {
        let bytes: Vec<u8> = values.iter().flatten().flat_map(|x| x.to_le_bytes()).collect();
        self.accessor(5126, kind, values.len(), &bytes)
    }

    /// Appends an animation of one channel.
    pub(super) fn animate<const N: usize>(
        &mut self,
        name: &str,
        node: usize,
        path: &str,
        interpolation: &str,
        times: &[f32],
        values: &[[f32; N]],
    ) {
        let times: Vec<[f32; 1]> = times.iter().map(|t| [*t]).collect();
        let (input, output) =
            (self.floats("SCALAR", &times), self.floats(["SCALAR", "VEC2", "VEC3", "VEC4"][N - 1], values));
        self.document["animations"].as_array_mut().unwrap().push(json!({
            "name": name,
            "samplers": [{"input": input, "output": output, "interpolation": interpolation}],
            "channels": [{"sampler": 0, "target": {"node": node, "path": path}}],
        }));
    }

    pub(super) fn set(&mut self, pointer: &str, value: Value) {
        let (parent, key) = pointer.rsplit_once('/').unwrap();
        match self.document.pointer_mut(parent).unwrap() {
            Value::Object(object) => drop(object.insert(key.to_owned(), value)),
            Value::Array(array) => array[key.parse::<usize>().unwrap()] = value,
            other => panic!("{other}"),
        }
    }

    pub(super) fn remove(&mut self, pointer: &str, key: &str) {
        self.document.pointer_mut(pointer).unwrap().as_object_mut().unwrap().remove(key);
    }

    pub(super) fn write(&self, folder: &tempfile::TempDir) -> std::path::PathBuf {
        let mut document = self.document.clone();
        let data = base64::engine::general_purpose::STANDARD.encode(&self.bytes);
        document["buffers"] =
            json!([{"byteLength": self.bytes.len(), "uri": format!("data:;base64,{data}")}]);
        let path = folder.path().join("t.gltf");
        std::fs::write(&path, document.to_string()).unwrap();
        path
    }

    pub(super) fn load(&self) -> Deforming {
        let folder = tempfile::tempdir().unwrap();
        load_deforming(&self.write(&folder), &mut Vec::new()).unwrap()
    }

    pub(super) fn refusal(&self) -> String {
        let folder = tempfile::tempdir().unwrap();
        let error = load_deforming(&self.write(&folder), &mut Vec::new()).unwrap_err();
        let message = error.to_string();
        assert!(error.is_bad_input() && message.contains("t.gltf: ") && !message.contains('\n'), "{message}");
        message
    }
}

/// Accessors of [`arm`] by index.
pub(super) const JOINTS: usize = 3;
pub(super) const WEIGHTS: usize = 4;
pub(super) const MATRICES: usize = 5;

/// Nodes: 0 "root", moved up by 10, carries 1 "shoulder", which carries 2 "elbow", 1 along x and turned by
/// 90° about z; 3 "body" wears the skin of both, bound with the arm straight at the origin, and lies
/// elsewhere itself. A tetrahedron, a degenerate triangle, and a vertex that only this uses.
pub(super) fn arm() -> File {
    let document = json!({
        "asset": {"version": "2.0"}, "scenes": [{"nodes": [0, 3]}],
        "nodes": [
            {"name": "root", "translation": [0.0, 10.0, 0.0], "children": [1]},
            {"name": "shoulder", "children": [2]},
            {"name": "elbow", "translation": [1.0, 0.0, 0.0], "rotation": TURNED},
            {"name": "body", "mesh": 0, "skin": 0, "translation": [100.0, 0.0, 0.0], "scale": [-7.0, 1.0, 1.0]},
        ],
        "skins": [{"joints": [1, 2], "inverseBindMatrices": MATRICES}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "NORMAL": 1, "JOINTS_0": JOINTS, "WEIGHTS_0": WEIGHTS}, "indices": 2}]}],
        "accessors": [], "bufferViews": [], "animations": [],
    });
    let mut file = File { document, bytes: Vec::new() };
    file.floats(
        "VEC3",
        &[[0.5, 0.0, 0.0], [0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
    );
    file.floats("VEC3", &[[1.0, 0.0, 0.0]; 5]);
    file.accessor(5121, "SCALAR", 15, &[0, 0, 1, 1, 3, 2, 1, 2, 4, 1, 4, 3, 2, 3, 4]);
    // Vertex 3 follows both joints, with weights whose sum is 4; joints without a weight may be anything.
    file.accessor(5121, "VEC4", 5, &[0, 0, 0, 0, 0, 9, 9, 9, 1, 0, 0, 0, 0, 1, 0, 0, 1, 0, 0, 0]);
    let one = [1.0, 0.0, 0.0, 0.0];
    file.floats("VEC4", &[one, one, one, [3.0, 1.0, 0.0, 0.0], one]);
    let straight = |x: f32| [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, -x, 0.0, 0.0, 1.0];
    file.floats("MAT4", &[straight(0.0), straight(1.0)]);
    file
}

/// The body without its skin, with two morph targets: the first moves vertex 4 up by 2, the second, in a
/// sparse accessor without a view, vertices 2 and 3 by −1 along z.
pub(super) fn morphing() -> File {
    let mut file = arm();
    file.set("/nodes/3", json!({"name": "body", "mesh": 0, "translation": [100.0, 0.0, 0.0]}));
    let mut up = [[0.0; 3]; 5];
    up[4] = [0.0, 2.0, 0.0];
    let up = file.floats("VEC3", &up);
    let indices = file.accessor(5123, "SCALAR", 2, &[2, 0, 3, 0]);
    let values = file.floats("VEC3", &[[0.0, 0.0, -1.0]; 2]);
    let sparse = file.floats::<3>("VEC3", &[]);
    file.set(&format!("/accessors/{sparse}/count"), json!(5));
    file.remove(&format!("/accessors/{sparse}"), "bufferView");
    file.set(
        &format!("/accessors/{sparse}/sparse"),
        json!({"count": 2, "indices": {"bufferView": indices, "componentType": 5123}, "values": {"bufferView": values}}),
    );
    file.set("/meshes/0/primitives/0/targets", json!([{"POSITION": up}, {"POSITION": sparse}]));
    file.set("/meshes/0/weights", json!([0.5, 0.0]));
    file
}
