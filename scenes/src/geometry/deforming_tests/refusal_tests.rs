//! What breaks the rules is refused with its place.

use super::file::{File, MATRICES, WEIGHTS, arm, morphing};
use serde_json::json;

/// What breaks a sound file, and part of the refusal.
type Case = (fn(&mut File), &'static str);

#[test]
fn broken_skins_are_refused() {
    let cases: [Case; 12] = [
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
        (
            |f| f.set("/accessors/4/count", json!(4_000_000_000_u64)),
            "accessor 4 reaches beyond its buffer or limits",
        ),
        (
            |f| f.set("/accessors/4/componentType", json!(5121)),
            "accessor 4 holds VEC4 of unsigned bytes, expected VEC4 of floats",
        ),
        (
            |f| f.set("/accessors/5/type", json!("VEC4")),
            "accessor 5 holds VEC4 of floats, expected MAT4 of floats",
        ),
    ];
    for (change, part) in cases {
        let mut file = arm();
        change(&mut file);
        let message = file.refusal();
        assert!(message.contains(part), "{part}: {message}");
    }
    // Weights, and a matrix, byte by byte.
    let offset = |file: &File, accessor: usize| {
        file.document["bufferViews"][accessor]["byteOffset"].as_u64().unwrap() as usize
    };
    for (accessor, number, part) in [
        (WEIGHTS, f32::NAN, "vertex 0 has the joint weights [NaN, 0.0, 0.0, 0.0], which must be finite"),
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
    let cases: [Case; 8] = [
        (
            |f| f.animate("A", 0, "translation", "LINEAR", &[0.0, 0.0], &[[0.0; 3]; 2]),
            "clip `A`: track 0: key times must increase",
        ),
        (|f| f.animate("A", 0, "translation", "LINEAR", &[0.0, f32::NAN], &[[0.0; 3]; 2]), "finite times"),
        (
            |f| f.animate("A", 0, "translation", "LINEAR", &[0.0], &[[0.0, f32::NAN, 0.0]]),
            "values must be finite",
        ),
        (
            |f| f.animate("A", 0, "rotation", "LINEAR", &[0.0], &[[0.0; 4]]),
            "rotation [0.0, 0.0, 0.0, 0.0] must be finite and not 0",
        ),
        (
            |f| f.animate("A", 0, "scale", "CUBICSPLINE", &[0.0], &[[0.0; 3]]),
            "animation 0, channel 0: 1 values where its 1 keys need 3",
        ),
        (
            |f| f.animate("A", 0, "scale", "LINEAR", &[0.0], &[[0.0; 4]]),
            "holds VEC4 of floats, expected VEC3 of floats",
        ),
        (
            |f| f.animate("A", 77, "scale", "LINEAR", &[0.0], &[[1.0; 3]]),
            "animation 0, channel 0: names a node or property that is not there",
        ),
        (
            |f| f.animate("A", 0, "colour", "LINEAR", &[0.0], &[[1.0; 3]]),
            "names a node or property that is not there",
        ),
    ];
    for (change, part) in cases {
        let mut file = arm();
        change(&mut file);
        let message = file.refusal();
        assert!(message.contains(part), "{part}: {message}");
    }
    let mut file = arm();
    file.animate("A", 0, "translation", "LINEAR", &[0.0, 1.0], &[[0.0; 3]; 2]);
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
