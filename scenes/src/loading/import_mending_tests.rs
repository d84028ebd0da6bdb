//! glTF files whose surfaces emit, whose names repeat, and of which something cannot be seen.

use super::import_tests::{
    UVS, base64, changed, document, lit, load_changed, material, object, png, refusal, scene, try_load,
};
use crate::scene::{Emitter, Scene};
use crate::test_support::Scratch;
use crate::{Filter, Wrap};
use relume_formats::state::{Brdf, Ggx};
use serde_json::{Value, json};

#[test]
fn emission_follows_its_texture_and_can_be_scaled_or_left_out() {
    let textured = |info: Value| {
        [("/materials/0/emissiveFactor", json!([1.0, 0.5, 0.25])), ("/materials/0/emissiveTexture", info)]
    };
    let glow_of = |scene: &Scene| match scene
        .lights
        .iter()
        .find(|light| light.name == "it/paint")
        .map(|light| light.emitter.clone())
    {
        Some(Emitter::Mesh { object, radiance, glow }) => {
            Some((scene.objects[object].name.clone(), radiance, glow.unwrap()))
        }
        _ => None,
    };
    // Through the coordinates that it asks for itself, whatever the base colour asks for.
    let moved = json!({"index": 1, "extensions": {"KHR_texture_transform": {"scale": [2.0, 3.0]}}});
    for (info, scale) in [(json!({"index": 1}), [1.0, 1.0]), (moved, [2.0, 3.0])] {
        let scene = load_changed("[materials.paint]\nemission = 2", &textured(info));
        let (object_name, radiance, glow) = glow_of(&scene).unwrap();
        assert_eq!((object_name.as_str(), radiance), ("it/paint", [2.0, 1.0, 0.5]));
        assert_eq!(*glow.uvs, UVS.map(|[u, v]| [scale[0] * u, scale[1] * v]));
        assert_eq!((glow.texture.texels[0], glow.is_faint()), ([188, 188, 188, 255], false));
        assert_eq!(
            (object(&scene, "it/paint").mesh.uvs.as_slice(), scene.warnings.len()),
            (UVS.as_slice(), 0)
        );
        assert!(material(&scene, "paint").texture.is_some());
    }
    // Without base colour texture, and where the coordinates are missing.
    let plain = json!({"baseColorFactor": [0.8, 0.6, 0.4, 1.0]});
    let mut changes = textured(json!({"index": 1, "texCoord": 1})).to_vec();
    changes.push(("/materials/0/pbrMetallicRoughness", plain));
    assert_eq!(*glow_of(&load_changed("", &changes)).unwrap().2.uvs, UVS);
    let missing = load_changed("", &textured(json!({"index": 1, "texCoord": 7})));
    assert!(glow_of(&missing).is_none() && missing.objects.len() == 3);
    assert!(
        missing.warnings[0]
            .ends_with("emits by a texture, but has no texture coordinates; what it emits is left out")
    );
    // Left out, the surfaces stay.
    let scratch = Scratch::scene(&(scene("") + "lights = false\n"));
    scratch.write("t.gltf", changed(&textured(json!({"index": 1}))).to_string());
    for dark in [
        scratch.load().unwrap(),
        load_changed(
            "[materials.paint]\nemission = 0\n[materials.glow]\nemission = 0.0",
            &textured(json!({"index": 1})),
        ),
    ] {
        assert_eq!(
            (dark.objects.len(), dark.lights.len(), dark.materials.len(), dark.warnings.len()),
            (3, 0, 3, 1),
            "{:?}",
            dark.warnings
        );
        assert!(dark.warnings[0].ends_with("neither a light nor an environment, everything is black"));
    }
    // A texture that is black all over emits nothing.
    let black = json!({"uri": format!("data:image/png;base64,{}", base64(&png([0, 0, 0])))});
    let mut changes = textured(json!({"index": 1})).to_vec();
    changes.push(("/images/1", black));
    assert!(glow_of(&load_changed("", &changes)).is_none());
}

#[test]
fn unlit_materials_are_lit_with_a_warning() {
    let unlit = [
        ("/extensionsUsed", json!(["KHR_materials_unlit"])),
        ("/extensionsRequired", json!(["KHR_materials_unlit"])),
        ("/materials/0/extensions", json!({"KHR_materials_unlit": {}})),
    ];
    let (plain, scene) = (load_changed("", &[]), load_changed("", &unlit));
    assert_eq!(scene.materials, plain.materials);
    assert!(
        scene.warnings[0]
            .ends_with("t.gltf: 1 of 3 materials has KHR_materials_unlit, which is lit here like any other: the light is what is played"),
        "{:?}",
        scene.warnings
    );
    assert_eq!(scene.warnings.len(), plain.warnings.len() + 1);
}

#[test]
fn spheres_are_fitted_to_what_a_file_brings_if_that_is_one_mesh() {
    let load = |more: &str| {
        let scratch = Scratch::scene(&(scene("") + more));
        scratch.write("t.gltf", document().to_string());
        scratch.load()
    };
    let one = load("node = 'wall'\nspheres = 12\n").unwrap();
    let names: Vec<_> = one.objects.iter().map(|object| (object.name.as_str(), object.spheres)).collect();
    assert_eq!(names, [("it", Some(12))], "files are called after it");
    assert_eq!(load("node = 'wall'\n").unwrap().objects[0].name, "it/paint");
    let message = load("spheres = 12\n").unwrap_err().to_string();
    let expected = "`spheres` are fitted to one mesh, but the file brings one for each of 3 materials, `paint`, `glow`, `material-2`; give the object a \
                    `material`, or take parts of one material by `node`";
    assert!(message.contains("object `it`: ") && message.ends_with(expected), "{message}");
}

#[test]
fn a_name_in_two_files_stands_for_one_material_or_is_numbered() {
    let scratch = Scratch::scene(&scene(
        "[[object]]\nname = 'other'\nfile = 'u.gltf'\n[[object]]\nname = 'again'\nfile = 'u.gltf'",
    ));
    scratch.write("t.gltf", document().to_string());
    scratch.write("u.gltf", document().to_string());
    assert_eq!(scratch.load().unwrap().materials.len(), 3);
    scratch.write(
        "u.gltf",
        changed(&[("/materials/0/pbrMetallicRoughness/roughnessFactor", json!(0.7))]).to_string(),
    );
    let scene = scratch.load().unwrap();
    assert_eq!(
        scene.materials.iter().map(|m| m.name.as_str()).collect::<Vec<_>>(),
        ["glow", "material-2", "paint", "paint-2"]
    );
    let worn = |name: &str| scene.materials[object(&scene, name).material].name.as_str();
    assert_eq!([worn("other/paint"), worn("again/paint"), worn("it/paint-2")], ["paint", "paint", "paint-2"]);
    let told: Vec<_> = scene
        .warnings
        .iter()
        .filter(|w| w.contains("material `paint` differs from the one of this name in"))
        .collect();
    assert!(told.len() == 1 && told[0].ends_with("called it `paint-2`"), "{:?}", scene.warnings);
}

#[test]
fn names_that_repeat_in_a_file_are_numbered() {
    let scene = load_changed(
        "",
        &[("/materials/1/name", json!("paint")), ("/materials/0/name", json!("material-2"))],
    );
    let names: Vec<_> = scene.objects.iter().map(|o| o.name.as_str()).collect();
    assert_eq!(names, ["it/material-2", "it/paint", "it/material-2-2"]);
    assert!(
        scene.warnings.len() == 1
            && scene.warnings[0].ends_with("names of materials repeat; numbered `material-2-2`"),
        "{:?}",
        scene.warnings
    );
    let scene = load_changed("", &[("/materials/1/name", json!("paint"))]);
    assert_eq!(scene.lights[0].name, "it/paint-2");
    let bases: Vec<_> = scene.materials.iter().map(|m| (m.name.as_str(), m.brdf)).collect();
    assert!(matches!(bases[1], ("paint", Brdf::Ggx(Ggx { base_color: [0.8, 0.6, 0.4], .. }))), "{bases:?}");
    assert!(matches!(bases[2], ("paint-2", Brdf::Ggx(Ggx { base_color: [0.0, 0.0, 0.0], .. }))), "{bases:?}");
}

#[test]
fn parts_that_cannot_be_seen_are_left_out() {
    let hidden = load_changed("", &[("/nodes/1/scale", json!([0.0, 0.0, 0.0]))]);
    assert_eq!((hidden.objects.len(), hidden.lights.len(), hidden.materials.len()), (2, 0, 2));
    assert!(
        hidden.warnings[0]
            .ends_with("material `glow`: its triangles have no area, its surfaces are left out"),
        "{:?}",
        hidden.warnings
    );
    let zero = json!([0.0, 0.0, 0.0]);
    let all = refusal(
        "",
        &[("/nodes/0/scale", zero.clone()), ("/nodes/1/scale", zero.clone()), ("/nodes/2/scale", zero)],
    );
    assert!(
        all.contains("object `it`: nothing of ")
            && all.contains("is left to show: material `paint`: its triangles have no area"),
        "{all}"
    );
    // A light that has no direction left is left out alone.
    let sun =
        try_load("", &lit(&json!({"type": "directional"}), json!({"name": "sun", "scale": [0.0, 0.0, 0.0]})))
            .unwrap();
    assert!(sun.lights.iter().all(|light| light.name != "sun"));
    assert!(
        sun.warnings
            .iter()
            .any(|w| w.ends_with("light `sun`: its node's scale leaves it no direction, left it out")),
        "{:?}",
        sun.warnings
    );
}

#[test]
fn pictures_of_other_kinds_are_left_out_and_samplers_may_be_sharp() {
    let webp = json!([{"sampler": 0, "extensions": {"EXT_texture_webp": {"source": 0}}}, {"source": 1}]);
    let scene = load_changed("", &[("/textures", webp), ("/extensionsUsed", json!(["EXT_texture_webp"]))]);
    assert!(material(&scene, "paint").texture.is_none());
    for part in [
        "1 of 3 materials has a texture whose picture is of a kind that is not read, which is ignored",
        "uses EXT_texture_webp, which is ignored",
    ] {
        assert_eq!(scene.warnings.iter().filter(|w| w.ends_with(part)).count(), 1, "{:?}", scene.warnings);
    }
    let fallback = json!([{"source": 0, "sampler": 0, "extensions": {"EXT_texture_webp": {"source": 1}}}, {"source": 1}]);
    let scene = load_changed("", &[("/textures", fallback), ("/samplers/0", json!({"magFilter": 9728}))]);
    let texture = material(&scene, "paint").texture.clone().unwrap();
    assert_eq!(
        (texture.texels[0], texture.filter, texture.wrap),
        ([255, 0, 0, 255], Filter::Nearest, [Wrap::Repeat; 2])
    );
    // Without a filter for nearby pictures they are smooth, as in every viewer.
    for sampler in [json!({"minFilter": 9728}), json!({"magFilter": 9729, "minFilter": 9984}), json!({})] {
        assert_eq!(
            material(&load_changed("", &[("/samplers/0", sampler)]), "paint").texture.clone().unwrap().filter,
            Filter::Linear
        );
    }
}
