//! glTF files and textures that are hostile or do not fit.

use super::import_tests::{base64, changed, lit, load_changed, png, refusal, scene, try_load};
use crate::Wrap;
use crate::test_support::Scratch;
use serde_json::json;
use std::sync::Arc;

#[test]
fn hostile_files_are_refused() {
    let texture = "/materials/0/pbrMetallicRoughness/baseColorTexture";
    let huge = format!(
        "data:image/png;base64,{}",
        base64(b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR\x7f\xff\xff\xff\x7f\xff\xff\xff\x08\x06\0\0\0")
    );
    for (pointer, value, part) in [
        (texture, json!({"index": 2}), "not valid glTF"),
        ("/textures/0/source", json!(9), "not valid glTF"),
        ("/textures/0/sampler", json!(9), "not valid glTF"),
        ("/samplers/0/wrapS", json!(1), "not valid glTF"),
        ("/images/0/bufferView", json!(99), "not valid glTF"),
        ("/images/0", json!({"bufferView": 6}), ""),
        ("/images/0", json!({}), "image 0: has neither a buffer view nor a uri"),
        ("/images/0", json!({"uri": "gone.png"}), "gone.png: "),
        ("/images/0", json!({"uri": "https://example.org/a.png"}), "download it"),
        (
            "/images/0",
            json!({"uri": "data:image/png;base64,AAAA"}),
            "image 0: not a picture this version reads",
        ),
        ("/images/0", json!({"uri": huge}), "image 0: "),
        ("/bufferViews/6/byteLength", json!(20), "image 0: broken picture"),
        ("/bufferViews/6/byteLength", json!(u64::MAX), "buffer view 6 reaches beyond its buffer"),
        ("/accessors/2/type", json!("VEC3"), "accessor 2 "),
        ("/accessors/2/componentType", json!(5125), "accessor 2 holds VEC2 of unsigned integers"),
        ("/accessors/2/count", json!(3), "4 positions but 3 texture coordinates"),
        ("/accessors/2/count", json!(u64::MAX), "accessor 2 reaches beyond its buffer"),
        ("/materials/0/pbrMetallicRoughness/metallicFactor", json!(7.0), "material `paint`: base_color"),
        (
            "/materials/0/pbrMetallicRoughness/baseColorFactor",
            json!([1e39, 0.0, 0.0, 1.0]),
            "material `paint`: base_color",
        ),
        ("/materials/0/pbrMetallicRoughness/roughnessFactor", json!(1e38), "is outside 0.12..1"),
        (
            "/materials/1/emissiveFactor",
            json!([-1.0, 0.0, 0.0]),
            "emissive factor times strength [-8.0, 0.0, 0.0] must be numbers of 0 to",
        ),
        (
            "/materials/1/emissiveFactor",
            json!([1e38, 0.0, 0.0]),
            "material `glow`: emissive factor times strength",
        ),
        ("/materials/0/alphaMode", json!("GLASS"), "not valid glTF"),
    ] {
        let changes = [(pointer, value.clone())];
        if part.is_empty() {
            // No media type, though glTF wants one: the bytes say what they are.
            load_changed("", &changes);
            continue;
        }
        let message = refusal("", &changes);
        assert!(message.contains(part), "{pointer} {value}: {message}");
    }
}

#[test]
fn hostile_lights_are_refused() {
    for (light, part) in [
        (
            json!({"type": "point", "intensity": 1e38, "color": [1e38, 1e38, 1e38]}),
            "light `wall`: color times intensity [inf, inf, inf] must be numbers of 0 to",
        ),
        (json!({"type": "point", "intensity": -1.0}), "color times intensity"),
        (json!({"type": "point", "color": [0.0, -1.0, 0.0]}), "color times intensity"),
        (json!({"type": "spot"}), "not valid glTF"),
        (
            json!({"type": "spot", "spot": {"innerConeAngle": 0.7, "outerConeAngle": 0.6}}),
            "cone angles 0.7 and 0.6 must rise",
        ),
        (json!({"type": "spot", "spot": {"outerConeAngle": 3.0}}), "cone angles 0 and 3 must rise"),
        (json!({"type": "spot", "spot": {"outerConeAngle": 0.0}}), "cone angles 0 and 0 must rise"),
        (json!({"type": "laser"}), "not valid glTF"),
        (json!({"intensity": 1.0}), "not a glTF 2.0 file"),
        (json!({"type": "point", "intensity": "NaN"}), "not a glTF 2.0 file"),
    ] {
        let error = try_load("", &lit(&light, json!({"name": "wall", "mesh": 0}))).unwrap_err().to_string();
        assert!(error.contains(part) && !error.contains('\n'), "{light}: {error}");
    }
    for lights in [json!({}), json!({"KHR_lights_punctual": {"lights": []}})] {
        let node = json!({"mesh": 0, "extensions": {"KHR_lights_punctual": {"light": 0}}});
        assert!(refusal("", &[("/extensions", lights), ("/nodes/0", node)]).contains("not valid glTF"));
    }
}

#[test]
fn objects_that_bring_no_material_are_named() {
    for (text, part) in [
        ("shape = 'quad'", "object `it`: needs a `material`; only a glTF file brings its own"),
        ("file = 't.obj'", "object `it`: needs a `material`; only a glTF file brings its own"),
        ("shape = 'quad'\nmaterial = 'm'\nlights = false", "object `it`: `lights` belongs to a glTF file"),
    ] {
        let scratch = Scratch::scene(&scene("").replace("file = 't.gltf'", text));
        scratch.write("t.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
        let message = scratch.load().unwrap_err().to_string();
        assert!(message.contains(part), "{text}: {message}");
    }
    let nothing = try_load("", &changed(&[("/nodes", json!([{}, {}, {}]))])).unwrap_err().to_string();
    assert!(nothing.contains("brings neither a surface nor a light"), "{nothing}");
}

/// A picture beside the scene, on a square of which the mesh has texture coordinates or not.
fn textured(keys: &str, shape: &str) -> Scratch {
    let text = scene(&format!("[materials.m]\nbrdf = 'ggx'\n{keys}"))
        .replace("file = 't.gltf'", &format!("{shape}\nmaterial = 'm'"));
    let scratch = Scratch::scene(&text);
    scratch.write("wall.png", png([9, 8, 7]));
    scratch.write("bare.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    scratch
}

#[test]
fn materials_of_the_scene_file_may_have_textures() {
    let both =
        "texture = 'wall.png'\nalpha_cutoff = 0.5\n[materials.n]\nbrdf = 'blinn-phong'\ntexture = 'wall.png'";
    let scene = textured(both, "shape = 'sphere'").load().unwrap();
    let [m, n] = [0, 1].map(|i| scene.materials[i].clone());
    let texture = m.texture.unwrap();
    assert_eq!(
        (texture.wrap, texture.texels[0], m.alpha_cutoff, n.alpha_cutoff),
        ([Wrap::Repeat; 2], [9, 8, 7, 255], Some(0.5), None)
    );
    assert!(Arc::ptr_eq(&texture, &n.texture.unwrap()), "one file, one texture");
    for (keys, shape, part) in [
        (
            "texture = 'wall.png'",
            "file = 'bare.obj'",
            "object `it`: its material `m` has a texture, but its mesh has no texture coordinates",
        ),
        (
            "texture = 'well.png'",
            "shape = 'quad'",
            "line 9: material `m`: no such file: `well.png`; did you mean `wall.png`?",
        ),
        (
            "texture = 'scene.toml'",
            "shape = 'quad'",
            "scene.toml: not a picture this version reads; it reads PNG and JPEG",
        ),
        ("alpha_cutoff = 0.5", "shape = 'quad'", "material `m`: alpha_cutoff needs a `texture`"),
        (
            "texture = 'wall.png'\nalpha_cutoff = 0",
            "shape = 'quad'",
            "alpha_cutoff 0 must be above 0 and at most 1",
        ),
        ("texture = 'wall.png'\nalpha_cutoff = nan", "shape = 'quad'", "alpha_cutoff NaN must be above 0"),
    ] {
        let message = textured(keys, shape).load().unwrap_err().to_string();
        assert!(message.contains(part), "{keys}: {message}");
    }
}
