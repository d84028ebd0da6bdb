//! Nodes of glTF that are no tree, and files that have no faces.

use super::interchange_tests::{File, areas, is_told};
use serde_json::{Value, json};

#[test]
fn nodes_that_are_no_tree_are_told_as_what_they_are() {
    let load = |nodes: Value, roots: Value| {
        let mut file = File::triangle();
        file.document["nodes"] = nodes;
        file.document["scenes"][0]["nodes"] = roots;
        file
    };
    for (nodes, roots, message) in [
        (
            json!([{"mesh": 0, "children": [0]}]),
            json!([0]),
            "t.gltf: node 0 is below itself; export the file again",
        ),
        (
            json!([{"children": [1]}, {"mesh": 0, "children": [0]}]),
            json!([0]),
            "t.gltf: node 0 is below itself; export the file again",
        ),
        (
            json!([{"children": [1, 1]}, {"mesh": 0}]),
            json!([0]),
            "t.gltf: node 1 is listed twice by its parent; export the file again",
        ),
        (
            json!([{"children": [2]}, {"children": [2]}, {"mesh": 0}]),
            json!([0, 1]),
            "t.gltf: node 2 has two parents; export the file again",
        ),
        (
            json!([{"children": [1]}, {"mesh": 0}]),
            json!([0, 1]),
            "t.gltf: node 1 is both a root of the scene and below another node; export the file again",
        ),
        (
            json!([{"children": [1]}, {"mesh": 0}]),
            json!([1, 0]),
            "t.gltf: node 1 is both a root of the scene and below another node; export the file again",
        ),
    ] {
        let refusal = load(nodes, roots).refusal();
        assert!(refusal.ends_with(message), "{refusal}");
    }
    let (mesh, warnings) = load(json!([{"mesh": 0}]), json!([0, 0])).load();
    assert_eq!(areas(&mesh), [0.5]);
    assert!(is_told(&warnings, "its scene lists node 0 more than once; took it once"), "{warnings:?}");
}

#[test]
fn files_without_faces_are_told_as_such() {
    let mut file = File::triangle();
    file.document["meshes"][0]["primitives"][0]["mode"] = json!(0);
    let message =
        "t.gltf: has no faces: ignored 1 of 1 primitive, which is points or lines; export it as a mesh";
    assert!(file.refusal().ends_with(message), "{}", file.refusal());
    file.document["nodes"] = json!([{}]);
    let message = "t.gltf: has no faces: none of its nodes that were taken has a mesh; export it as a mesh";
    assert!(file.refusal().ends_with(message), "{}", file.refusal());
}
