//! Skins, morph targets and clips of glTF files, against positions computed by hand.

use super::gltf_deforming::load_placed;
use super::*;
use crate::test_support::enclosed_volume;
use base64::Engine;
use glam::{DVec3, Vec3};
use relume_formats::shape::{Interpolation, Property};
use serde_json::{Value, json};

const TURNED: [f32; 4] = [0.0, 0.0, std::f32::consts::FRAC_1_SQRT_2, std::f32::consts::FRAC_1_SQRT_2];
const NOT_TURNED: [f32; 4] = [0.0, 0.0, 0.0, 1.0];

/// A glTF document that grows by accessors; every accessor has a view of its own, of the same index.
struct File {
    document: Value,
    bytes: Vec<u8>,
}

impl File {
    fn accessor(&mut self, component: u32, kind: &str, count: usize, bytes: &[u8]) -> usize {
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        let view = json!({"buffer": 0, "byteOffset": self.bytes.len(), "byteLength": bytes.len()});
        self.bytes.extend_from_slice(bytes);
        let index = self.document["accessors"].as_array().unwrap().len();
        let bounds = [json!([0.0, 0.0, 0.0]), json!([1.0, 1.0, 1.0])];
        let accessor =
            json!({"bufferView": index, "componentType": component, "type": kind, "count": count, "min": bounds[0], "max": bounds[1]});
        self.document["bufferViews"].as_array_mut().unwrap().push(view);
        self.document["accessors"].as_array_mut().unwrap().push(accessor);
        index
    }

    fn floats<const N: usize>(&mut self, kind: &str, values: &[[f32; N]]) -> usize {
        let bytes: Vec<u8> = values.iter().flatten().flat_map(|x| x.to_le_bytes()).collect();
        self.accessor(5126, kind, values.len(), &bytes)
    }

    /// Appends an animation of one channel.
    fn animate<const N: usize>(
        &mut self,
        name: &str,
        node: usize,
        path: &str,
        interpolation: &str,
        times: &[f32],
        kind: &str,
        values: &[[f32; N]],
    ) {
        let times: Vec<[f32; 1]> = times.iter().map(|t| [*t]).collect();
        let (input, output) = (self.floats("SCALAR", &times), self.floats(kind, values));
        self.document["animations"].as_array_mut().unwrap().push(json!({
            "name": name,
            "samplers": [{"input": input, "output": output, "interpolation": interpolation}],
            "channels": [{"sampler": 0, "target": {"node": node, "path": path}}],
        }));
    }

    fn set(&mut self, pointer: &str, value: Value) {
        let (parent, key) = pointer.rsplit_once('/').unwrap();
        match self.document.pointer_mut(parent).unwrap() {
            Value::Object(object) => drop(object.insert(key.to_owned(), value)),
            Value::Array(array) => array[key.parse::<usize>().unwrap()] = value,
            other => panic!("{other}"),
        }
    }

    fn remove(&mut self, pointer: &str, key: &str) {
        self.document.pointer_mut(pointer).unwrap().as_object_mut().unwrap().remove(key);
    }

    fn write(&self, folder: &tempfile::TempDir) -> std::path::PathBuf {
        let mut document = self.document.clone();
        let data = base64::engine::general_purpose::STANDARD.encode(&self.bytes);
        document["buffers"] = json!([{"byteLength": self.bytes.len(), "uri": format!("data:;base64,{data}")}]);
        let path = folder.path().join("t.gltf");
        std::fs::write(&path, document.to_string()).unwrap();
        path
    }

    fn load(&self) -> Deforming {
        let folder = tempfile::tempdir().unwrap();
        load_deforming(&self.write(&folder), &mut Vec::new()).unwrap()
    }

    fn refusal(&self) -> String {
        let folder = tempfile::tempdir().unwrap();
        let error = load_deforming(&self.write(&folder), &mut Vec::new()).unwrap_err();
        let message = error.to_string();
        assert!(error.is_bad_input() && message.contains("t.gltf: ") && !message.contains('\n'), "{message}");
        message
    }
}

/// Accessors of [`arm`] by index.
const JOINTS: usize = 3;
const WEIGHTS: usize = 4;
const MATRICES: usize = 5;

/// Nodes: 0 "root", moved up by 10, carries 1 "shoulder", which carries 2 "elbow", 1 along x and turned by 90° about z; 3 "body" wears the skin of
/// both, bound with the arm straight at the origin, and lies elsewhere itself. A tetrahedron, a degenerate triangle, and a vertex that only this uses.
fn arm() -> File {
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
    file.floats("VEC3", &[[0.5, 0.0, 0.0], [0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]);
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

fn assert_near(found: &[[f32; 3]], expected: &[[f32; 3]]) {
    assert_eq!(found.len(), expected.len());
    for (f, e) in found.iter().zip(expected) {
        assert!(Vec3::from(*f).distance(Vec3::from(*e)) < 2e-6, "{found:?} {expected:?}");
    }
}

/// The position of every vertex at a time of the first clip.
fn at(deforming: &Deforming, time_s: f32) -> Vec<[f32; 3]> {
    let mut out = Vec::new();
    deforming.shape.positions_at(&deforming.shape.clips[0], time_s, &mut out);
    out
}

fn at_rest(deforming: &Deforming) -> Vec<[f32; 3]> {
    let mut out = Vec::new();
    deforming.shape.positions(&deforming.shape.rest_pose(), &mut out);
    out
}

#[test]
fn a_mesh_rests_where_its_skin_puts_it() {
    let folder = tempfile::tempdir().unwrap();
    let mesh = load_mesh(&arm().write(&folder), &mut Vec::new()).unwrap();
    // The elbow turns (x, y, z) to (1 − y, x − 1, z), the root lifts by 10; the third vertex is ¾ (0, 11, 0) + ¼ (0, 9, 0).
    assert_near(&mesh.positions, &[[0.0, 10.0, 0.0], [1.0, 10.0, 0.0], [0.0, 10.5, 0.0], [1.0, 9.0, 1.0]]);
    // What turns by a share of the right angle has the blend of the axes as its normal.
    let between = Vec3::new(0.75, 0.25, 0.0).normalize().to_array();
    assert_near(&mesh.normals, &[[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], between, [0.0, 1.0, 0.0]]);
    assert_eq!(mesh.triangles.len(), 4);
}

#[test]
fn the_deforming_mesh_is_the_mesh_vertex_by_vertex() {
    let mut flat = arm();
    flat.remove("/meshes/0/primitives/0/attributes", "NORMAL");
    let mut rigid = arm();
    rigid.remove("/nodes/3", "skin");
    let mut both = arm();
    both.set("/nodes/0/mesh", json!(0));
    let mirror = DAffine3::from_scale_rotation_translation(DVec3::new(-2.0, 1.0, 0.5), glam::DQuat::from_rotation_x(0.7), DVec3::ONE);
    let folder = tempfile::tempdir().unwrap();
    for (name, file, vertices) in [("arm", arm(), 4), ("flat", flat, 12), ("rigid", rigid, 4), ("both", both, 8)] {
        for world_from_file in [DAffine3::IDENTITY, mirror] {
            let path = file.write(&folder);
            let (mut warnings, mut of_mesh) = (Vec::new(), Vec::new());
            let deforming = load_placed(&path, None, &world_from_file, &mut warnings).unwrap();
            let mesh = load_file(&path, None, &world_from_file, &mut of_mesh).unwrap();
            assert_eq!((&deforming.rest, &warnings), (&mesh, &of_mesh), "{name}");
            assert_eq!(at_rest(&deforming), mesh.positions, "{name}: to the last bit");
            assert_eq!(mesh.positions.len(), vertices, "{name}");
            // A node that mirrors is undone by the skin, or else flips the triangles: fronts are outside all the same.
            assert!(enclosed_volume(&mesh) > 0.0 || name == "arm" || name == "flat", "{name}: {}", enclosed_volume(&mesh));
        }
    }
}

#[test]
fn what_a_skin_mirrors_keeps_its_front() {
    let folder = tempfile::tempdir().unwrap();
    let mut volumes = Vec::new();
    for scale in [1.0, -1.0] {
        let mut file = arm();
        file.set("/nodes/2/rotation", json!(NOT_TURNED));
        file.set("/nodes/0/scale", json!([scale, 2.0, 1.0]));
        for normals in [true, false] {
            if !normals {
                file.remove("/meshes/0/primitives/0/attributes", "NORMAL");
            }
            let mesh = load_mesh(&file.write(&folder), &mut Vec::new()).unwrap();
            volumes.push(enclosed_volume(&mesh));
            if !normals {
                let [a, b, c] = mesh.triangles[0].map(|v| Vec3::from(mesh.positions[v as usize]));
                assert!((b - a).cross(c - a).dot(Vec3::from(mesh.normals[mesh.triangles[0][0] as usize])) > 0.0);
            }
        }
    }
    // A tetrahedron of 1/6, twice as high.
    assert!(volumes.iter().all(|volume| (volume - 1.0 / 3.0).abs() < 1e-6), "{volumes:?}");
}

#[test]
fn clips_move_joints_and_what_follows_them() {
    let mut file = arm();
    file.animate("Bend", 2, "rotation", "LINEAR", &[0.5, 1.5], "VEC4", &[NOT_TURNED, TURNED]);
    file.animate("Slide", 0, "translation", "STEP", &[0.0, 2.0], "VEC3", &[[0.0; 3], [0.0, 0.0, 5.0]]);
    let deforming = file.load();
    let clips: Vec<_> = deforming.shape.clips.iter().map(|clip| (clip.name.as_str(), clip.duration_s)).collect();
    assert_eq!(clips, [("Bend", 1.5), ("Slide", 2.0)]);
    // Straight until half a second, at the bind pose but for the root.
    for time_s in [-1.0, 0.0, 0.5] {
        assert_near(&at(&deforming, time_s), &[[0.0, 10.0, 0.0], [1.0, 10.0, 0.0], [0.0, 11.0, 0.0], [0.0, 10.0, 1.0]]);
    }
    // By 45° at one second: (−1, 0, 1) from the elbow goes to (−√½, −√½, 1).
    let half = std::f32::consts::FRAC_1_SQRT_2;
    assert_near(&at(&deforming, 1.0)[3..], &[[1.0 - half, 10.0 - half, 1.0]]);
    assert_eq!(at(&deforming, 1.5), at_rest(&deforming));
    assert_eq!(at(&deforming, 9.0), at_rest(&deforming));
    let mut out = Vec::new();
    deforming.shape.positions_at(&deforming.shape.clips[1], 1.9, &mut out);
    assert_near(&out[..2], &[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]]);
    deforming.shape.positions_at(&deforming.shape.clips[1], 2.0, &mut out);
    assert_near(&out[..2], &[[0.0, 0.0, 5.0], [1.0, 0.0, 5.0]]);
}

#[test]
fn every_skin_has_joints_of_its_own() {
    let mut file = arm();
    // A second body, whose skin names the same joints the other way round and has no matrices; then a third, which wears the first skin again.
    file.document["skins"].as_array_mut().unwrap().push(json!({"joints": [2, 1]}));
    let nodes = file.document["nodes"].as_array_mut().unwrap();
    nodes.extend([json!({"name": "second", "mesh": 0, "skin": 1}), json!({"name": "third", "mesh": 0, "skin": 0})]);
    file.set("/scenes/0/nodes", json!([0, 3, 4, 5]));
    file.set("/nodes/2/rotation", json!(NOT_TURNED));
    let deforming = file.load();
    assert_eq!(deforming.shape.joints.len(), 4);
    // Without matrices a vertex lies in its joint: the elbow adds (1, 10, 0), the shoulder (0, 10, 0).
    let straight = [[0.0, 10.0, 0.0], [1.0, 10.0, 0.0], [0.0, 11.0, 0.0], [0.0, 10.0, 1.0]];
    let second = [[1.0, 10.0, 0.0], [1.0, 10.0, 0.0], [0.75, 11.0, 0.0], [0.0, 10.0, 1.0]];
    let rest = at_rest(&deforming);
    assert_near(&rest[..4], &straight);
    assert_near(&rest[rest.len() - 4..], &straight);
    // Two of its corners meet, so that two of its triangles are gone, but no vertex.
    assert_near(&rest[4..8], &second);
    let folder = tempfile::tempdir().unwrap();
    let only = load_placed(&file.write(&folder), Some("second"), &DAffine3::IDENTITY, &mut Vec::new()).unwrap();
    assert_near(&at_rest(&only), &second);
}

/// The body without its skin, with two morph targets: the first moves vertex 4 up by 2, the second, in a sparse accessor without a view, vertices 2
/// and 3 by −1 along z.
fn morphing() -> File {
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

#[test]
fn morph_targets_add_up_and_their_weights_move() {
    let mut file = morphing();
    file.animate("Breathe", 3, "weights", "LINEAR", &[0.0, 1.0], "SCALAR", &[[0.0], [1.0], [2.0], [3.0]]);
    let deforming = file.load();
    let rest = [[100.0, 0.0, 0.0], [101.0, 0.0, 0.0], [100.0, 1.0, 0.0], [100.0, 1.0, 1.0]];
    assert_eq!(deforming.rest.positions, rest, "half of the first target");
    assert_eq!(at_rest(&deforming), rest);
    // Key by key the weights of both targets: (0, 1), (2, 3); halfway (1, 2).
    assert_eq!(at(&deforming, 0.5), [[100.0, 0.0, 0.0], [101.0, 0.0, -2.0], [100.0, 1.0, -2.0], [100.0, 2.0, 1.0]]);
    // Flat shading takes triangles apart, and morph targets with them.
    file.remove("/meshes/0/primitives/0/attributes", "NORMAL");
    let flat = file.load();
    assert_eq!(flat.rest.positions.len(), 12);
    let (tip, moved) = ([100.0, 1.0, 1.0], [100.0, 2.0, 1.0]);
    let places =
        |positions: &[[f32; 3]], wanted| positions.iter().enumerate().filter(|(_, p)| **p == wanted).map(|(v, _)| v).collect::<Vec<_>>();
    assert_eq!(places(&at(&flat, 0.5), moved), places(&flat.rest.positions, tip));
    // A node's own weights come before the mesh's.
    file.set("/nodes/3/weights", json!([0.0, 1.0]));
    assert!(places(&file.load().rest.positions, [101.0, 0.0, -1.0]).len() == 3);
}

#[test]
fn splines_and_normalised_integers_are_read() {
    let mut file = morphing();
    // In-tangents, values, out-tangents, each of both targets; one span of two seconds.
    let keys = [[9.0], [9.0], [0.0], [1.0], [0.5], [0.0], [0.25], [0.0], [2.0], [1.0], [9.0], [9.0]];
    file.animate("Spline", 3, "weights", "CUBICSPLINE", &[0.0, 2.0], "SCALAR", &keys);
    let track = &file.load().shape.clips[0].tracks;
    assert_eq!(track.len(), 2);
    assert_eq!((track[0].property, track[0].interpolation), (Property::MorphWeight(0), Interpolation::CubicSpline));
    assert_eq!(track[0].values, [9.0, 0.0, 0.5, 0.25, 2.0, 9.0]);
    assert_eq!(track[1].values, [9.0, 1.0, 0.0, 0.0, 1.0, 9.0]);
    let mut file = arm();
    // Rotations as 16-bit and weights as 8-bit shares: 23170/32767 ≈ √½, and 192 : 64 = 3 : 1.
    file.animate("Bend", 2, "rotation", "LINEAR", &[0.0], "VEC4", &[TURNED]);
    let shares: Vec<u8> = [0i16, 0, 23170, 23170].iter().flat_map(|x| x.to_le_bytes()).collect();
    let output = file.accessor(5122, "VEC4", 1, &shares);
    file.set(&format!("/accessors/{output}/normalized"), json!(true));
    file.set("/animations/0/samplers/0/output", json!(output));
    let weights =
        file.accessor(5121, "VEC4", 5, &[[255, 0, 0, 0], [255, 0, 0, 0], [255, 0, 0, 0], [192, 64, 0, 0], [255, 0, 0, 0]].concat());
    file.set(&format!("/accessors/{weights}/normalized"), json!(true));
    file.set("/meshes/0/primitives/0/attributes/WEIGHTS_0", json!(weights));
    let deforming = file.load();
    assert_near(&at_rest(&deforming), &arm().load().rest.positions);
    assert_near(&at(&deforming, 0.0), &at_rest(&deforming));
}

#[test]
fn nodes_move_meshes_without_a_skin() {
    let mut file = arm();
    file.set("/nodes/2", json!({"name": "elbow", "mesh": 0, "translation": [1.0, 0.0, 0.0]}));
    file.set("/scenes/0/nodes", json!([0]));
    file.animate("Turn", 1, "rotation", "LINEAR", &[0.0, 1.0], "VEC4", &[NOT_TURNED, TURNED]);
    let deforming = file.load();
    assert_eq!(deforming.shape.joints.len(), 1);
    assert_near(&at(&deforming, 0.0), &[[1.0, 10.0, 0.0], [2.0, 10.0, 0.0], [1.0, 11.0, 0.0], [1.0, 10.0, 1.0]]);
    assert_near(&at(&deforming, 1.0), &[[0.0, 11.0, 0.0], [0.0, 12.0, 0.0], [-1.0, 11.0, 0.0], [0.0, 11.0, 1.0]]);
}

#[test]
fn clips_that_move_nothing_of_the_scene_are_left_out() {
    let mut file = arm();
    file.document["nodes"].as_array_mut().unwrap().push(json!({"name": "elsewhere"}));
    file.animate("Elsewhere", 4, "translation", "LINEAR", &[0.0], "VEC3", &[[0.0; 3]]);
    file.animate("Weightless", 3, "weights", "LINEAR", &[0.0], "SCALAR", &[[0.0]]);
    file.animate("", 1, "scale", "LINEAR", &[0.0], "VEC3", &[[1.0; 3]]);
    let deforming = file.load();
    let clips: Vec<_> = deforming.shape.clips.iter().map(|clip| (clip.name.as_str(), clip.duration_s)).collect();
    assert_eq!(clips, [("clip-2", 0.0)], "a clip of one pose, named by its number");
}

#[test]
fn broken_skins_are_refused() {
    let cases: [(fn(&mut File), &str); 12] = [
        (|f| f.bytes[136] = 2, "mesh 0, primitive 0: vertex 0 follows joint 2 of 2"),
        (|f| f.set("/skins/0/joints", json!([1])), "follows joint 1 of 1"),
        (|f| f.set("/skins/0/joints", json!([])), "skin 0: 0 joints, 1 to 65536 are allowed"),
        (|f| f.set("/skins/0/joints", json!([1, 2, 0])), "skin 0: 3 joints but 2 inverse bind matrices"),
        (|f| f.set("/skins/0/joints", json!([1, 7])), "not valid glTF"),
        (|f| f.set("/scenes/0/nodes", json!([3])), "skin 0: its joint, node 1, is not in the scene"),
        (|f| f.remove("/meshes/0/primitives/0/attributes", "WEIGHTS_0"), "it lacks JOINTS_0 or WEIGHTS_0"),
        (|f| f.set("/accessors/4/count", json!(4)), "joints for 5 vertices but weights for 4"),
        (
            |f| {
                f.set("/accessors/3/count", json!(4));
                f.set("/accessors/4/count", json!(4));
            },
            "5 positions but 4 joints and weights",
        ),
        (|f| f.set("/accessors/4/count", json!(4_000_000_000_u64)), "accessor 4 reaches beyond its buffer or limits"),
        (|f| f.set("/accessors/4/componentType", json!(5121)), "accessor 4 holds U8 Vec4, expected [F32] Vec4"),
        (|f| f.set("/accessors/5/type", json!("VEC4")), "accessor 5 holds F32 Vec4, expected [F32] Mat4"),
    ];
    for (change, part) in cases {
        let mut file = arm();
        change(&mut file);
        let message = file.refusal();
        assert!(message.contains(part), "{part}: {message}");
    }
    // Weights, and a matrix, byte by byte.
    let offset = |file: &File, accessor: usize| file.document["bufferViews"][accessor]["byteOffset"].as_u64().unwrap() as usize;
    for (accessor, number, part) in [
        (WEIGHTS, 0.0f32, "vertex 0 has the joint weights [0.0, 0.0, 0.0, 0.0], which must be at least 0 and not all 0"),
        (WEIGHTS, -1.0, "vertex 0 has the joint weights [-1.0, 0.0, 0.0, 0.0]"),
        (WEIGHTS, f32::NAN, "vertex 0 has the joint weights [NaN, 0.0, 0.0, 0.0]"),
        (WEIGHTS, f32::INFINITY, "vertex 0 has the joint weights [inf, 0.0, 0.0, 0.0]"),
        (MATRICES, f32::NAN, "vertex 0 at [NaN, NaN, NaN] is not a finite position"),
    ] {
        let mut file = arm();
        let start = offset(&file, accessor);
        file.bytes[start..start + 4].copy_from_slice(&number.to_le_bytes());
        let message = file.refusal();
        assert!(message.contains(part), "{part}: {message}");
    }
}

#[test]
fn broken_animations_and_morph_targets_are_refused() {
    let two = [[0.0; 3]; 2];
    let cases: [(fn(&mut File), &str); 9] = [
        (|f| f.animate("A", 0, "translation", "LINEAR", &[0.0, 0.0], "VEC3", &[[0.0; 3]; 2]), "clip `A`: track 0: key times must increase"),
        (|f| f.animate("A", 0, "translation", "LINEAR", &[0.0, f32::NAN], "VEC3", &[[0.0; 3]; 2]), "finite times"),
        (|f| f.animate("A", 0, "translation", "LINEAR", &[0.0], "VEC3", &[[0.0, f32::NAN, 0.0]]), "values must be finite"),
        (
            |f| f.animate("A", 0, "rotation", "LINEAR", &[0.0], "VEC4", &[[0.0; 4]]),
            "rotation [0.0, 0.0, 0.0, 0.0] must be finite and not 0",
        ),
        (
            |f| f.animate("A", 0, "scale", "CUBICSPLINE", &[0.0], "VEC3", &[[0.0; 3]]),
            "animation 0, channel 0: 1 values where its 1 keys need 3",
        ),
        (|f| f.animate("A", 0, "scale", "LINEAR", &[0.0], "VEC4", &[[0.0; 4]]), "holds F32 Vec4, expected [F32] Vec3"),
        (
            |f| f.animate("A", 77, "scale", "LINEAR", &[0.0], "VEC3", &[[1.0; 3]]),
            "animation 0, channel 0: names a node or property that is not there",
        ),
        (|f| f.animate("A", 0, "colour", "LINEAR", &[0.0], "VEC3", &[[1.0; 3]]), "names a node or property that is not there"),
        (
            |f| {
                f.animate("A", 0, "scale", "LINEAR", &[0.0], "VEC3", &[[1.0; 3]]);
                f.animate("A", 1, "scale", "LINEAR", &[0.0], "VEC3", &[[1.0; 3]]);
            },
            "two clips are called `A`; mend the model or export it again",
        ),
    ];
    for (change, part) in cases {
        let mut file = arm();
        change(&mut file);
        let message = file.refusal();
        assert!(message.contains(part), "{part}: {message}");
    }
    let mut file = arm();
    file.animate("A", 0, "translation", "LINEAR", &[0.0, 1.0], "VEC3", &two);
    let input = file.document["animations"][0]["samplers"][0]["input"].clone();
    file.set(&format!("/accessors/{input}/count"), json!(5_000_000_000_u64));
    assert!(file.refusal().contains("more than 4194304 keys in all animations"));
    let mut file = morphing();
    let up = file.document["meshes"][0]["primitives"][0]["targets"][0]["POSITION"].clone();
    file.set(&format!("/accessors/{up}/count"), json!(4));
    assert!(file.refusal().contains("accessor 6 holds 4 displacements of 5 vertices"), "{}", file.refusal());
    let mut file = morphing();
    let start = file.document["bufferViews"][7]["byteOffset"].as_u64().unwrap() as usize;
    file.bytes[start] = 5;
    assert!(file.refusal().contains("accessor 9 changes element 5 of 5"), "{}", file.refusal());
}

#[test]
fn matrices_stand_still_and_other_formats_have_no_clips() {
    let mut file = arm();
    file.set("/nodes/0", json!({"children": [1], "matrix": [2, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 10, 0, 1]}));
    assert_near(&file.load().rest.positions[..2], &[[0.0, 10.0, 0.0], [2.0, 10.0, 0.0]]);
    file.animate("A", 0, "scale", "LINEAR", &[0.0], "VEC3", &[[1.0; 3]]);
    assert!(file.refusal().contains("moves node 1, which has a matrix"), "{}", file.refusal());
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("t.obj");
    std::fs::write(&path, "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").unwrap();
    assert_eq!(load_mesh(&path, &mut Vec::new()).unwrap().triangles.len(), 1);
    assert!(load_deforming(&path, &mut Vec::new()).unwrap_err().to_string().contains("only .gltf and .glb files hold shapes that deform"));
}

fn asset(name: &str) -> std::path::PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../assets").join(name)
}

/// The least and the greatest coordinates.
fn bounds(positions: &[[f32; 3]]) -> [Vec3; 2] {
    let vectors = positions.iter().map(|p| Vec3::from(*p));
    vectors.fold([Vec3::INFINITY, Vec3::NEG_INFINITY], |[least, greatest], p| [least.min(p), greatest.max(p)])
}

#[test]
#[ignore = "needs make assets"]
fn the_fox_walks() {
    let mut warnings = Vec::new();
    let fox = load_deforming(&asset("fox.glb"), &mut warnings).unwrap();
    assert_eq!(fox.rest, load_mesh(&asset("fox.glb"), &mut Vec::new()).unwrap());
    assert_eq!((fox.rest.positions.len(), fox.rest.triangles.len(), fox.shape.joints.len()), (1728, 576, 24), "{warnings:?}");
    assert_eq!(at_rest(&fox), fox.rest.positions);
    // The model is stored in its bind pose, which is its rest pose.
    for (rest, stored) in fox.rest.positions.iter().zip(&fox.shape.positions) {
        assert!(Vec3::from(*rest).distance(Vec3::from(*stored)) < 1e-3, "{rest:?} {stored:?}");
    }
    let clips: Vec<_> = fox.shape.clips.iter().map(|clip| (clip.name.as_str(), (clip.duration_s * 24.0).round())).collect();
    assert_eq!(clips, [("Survey", 82.0), ("Walk", 17.0), ("Run", 28.0)]);
    let walk = &fox.shape.clips[1];
    assert!((walk.duration_s - 0.708_333_3).abs() < 1e-6);
    let [rest_least, rest_greatest] = bounds(&fox.rest.positions);
    let (mut out, mut seen) = (Vec::new(), Vec::new());
    for frame in 0..=17 {
        fox.shape.positions_at(walk, frame as f32 / 24.0, &mut out);
        let [least, greatest] = bounds(&out);
        let (size, rest_size) = (greatest - least, rest_greatest - rest_least);
        assert!(size.cmpgt(0.5 * rest_size).all() && size.cmplt(2.0 * rest_size).all(), "frame {frame}: {size} of {rest_size}");
        assert!(least.y > -0.1 * rest_size.y, "frame {frame}: feet at {}", least.y);
        assert!((least + greatest).distance(rest_least + rest_greatest) < rest_size.length(), "frame {frame}: walks on the spot");
        seen.push(out.clone());
    }
    // The walk is a cycle: its last pose is near its first, and its middle is not.
    let apart = |a: &[[f32; 3]], b: &[[f32; 3]]| a.iter().zip(b).map(|(a, b)| Vec3::from(*a).distance(Vec3::from(*b))).fold(0.0, f32::max);
    assert!(apart(&seen[0], &seen[17]) < 0.2 * apart(&seen[0], &seen[8]), "{} {}", apart(&seen[0], &seen[17]), apart(&seen[0], &seen[8]));
}

#[test]
#[ignore = "needs make assets"]
fn the_cube_morphs() {
    let cube = load_deforming(&asset("morph-cube.glb"), &mut Vec::new()).unwrap();
    assert_eq!(cube.rest, load_mesh(&asset("morph-cube.glb"), &mut Vec::new()).unwrap());
    assert_eq!((cube.rest.positions.len(), cube.rest.triangles.len(), cube.shape.morph_targets.len()), (24, 12, 2));
    assert_eq!((cube.shape.clips.len(), cube.shape.clips[0].name.as_str(), cube.shape.clips[0].tracks.len()), (1, "Square", 2));
    assert!((cube.shape.clips[0].duration_s - 4.2).abs() < 1e-4);
    assert_eq!(at_rest(&cube), cube.rest.positions);
    assert!((enclosed_volume(&cube.rest) - 8.0).abs() < 1e-3, "a cube of 2");
    // Both targets only push sides of the cube along one axis, by nearly its size: it shrinks and never leaves its bounds.
    let [least, greatest] = bounds(&cube.rest.positions);
    let volumes = (0..=42).map(|frame| {
        let positions = at(&cube, frame as f32 / 10.0);
        let [l, g] = bounds(&positions);
        assert!(l.cmpge(least - 1e-3).all() && g.cmple(greatest + 1e-3).all(), "frame {frame}: {l} {g}");
        enclosed_volume(&Mesh { positions, ..cube.rest.clone() })
    });
    let (smallest, largest) = volumes.fold((f64::INFINITY, 0.0f64), |(s, l), v| (s.min(v), l.max(v)));
    assert!(smallest > -1e-3 && smallest < 1.0 && (largest - 8.0).abs() < 1e-2, "{smallest} {largest}");
}
