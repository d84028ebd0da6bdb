//! glTF files that bring their own materials, textures and lights.

use super::*;
use crate::Wrap;
use crate::scene::{Cone, Emitter, Light};
use crate::test_support::Scratch;
use base64::Engine;
use relume_formats::state::{Brdf, FIXED_ROUGHNESS_MIN, Ggx, ROUGHNESS_MIN};
use serde_json::{Value, json};
use std::io::Cursor;

/// A scene around one object that is the file t.gltf; `more` goes before the object.
pub(super) fn scene(more: &str) -> String {
    format!(
        "[render]\nsize = [8, 8]\n[camera]\nposition = [0, 1, 4]\ntarget = [0, 1, 0]\nfov_deg = 40\n{more}\n\
         [[object]]\nname = 'it'\nfile = 't.gltf'\n"
    )
}

pub(crate) fn base64(bytes: &[u8]) -> String {
    base64::engine::general_purpose::STANDARD.encode(bytes)
}

/// Two texels side by side: a colour, opaque, and black, a quarter opaque.
pub(crate) fn png(colour: [u8; 3]) -> Vec<u8> {
    let mut bytes = Cursor::new(Vec::new());
    let [r, g, b] = colour;
    let image = image::RgbaImage::from_raw(2, 1, vec![r, g, b, 255, 0, 0, 0, 64]).unwrap();
    image.write_to(&mut bytes, image::ImageFormat::Png).unwrap();
    bytes.into_inner()
}

pub(super) const UVS: [[f32; 2]; 4] = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];

/// A unit square as positions, normals, texture coordinates as f32, u16 and u8, all at 4 vertices, then 6
/// indices; then a picture.
fn buffer() -> Vec<u8> {
    let square = [[0.0f32, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
    let mut bytes: Vec<u8> = square.iter().flatten().flat_map(|x| x.to_le_bytes()).collect();
    bytes.extend([[0.0f32, 0.0, 1.0]; 4].iter().flatten().flat_map(|x| x.to_le_bytes()));
    bytes.extend(UVS.iter().flatten().flat_map(|x| x.to_le_bytes()));
    bytes.extend(UVS.iter().flatten().flat_map(|x| ((*x * 65535.0) as u16).to_le_bytes()));
    bytes.extend(UVS.iter().flatten().map(|x| (*x * 255.0) as u8));
    bytes.extend([0u16, 1, 2, 0, 2, 3].iter().flat_map(|i| i.to_le_bytes()));
    bytes.extend(png([255, 0, 0]));
    bytes
}

/// Nodes "wall" (material "paint", textured), "lamp" (material "glow") and "plain" (the nameless third
/// material).
pub(super) fn document() -> Value {
    let bytes = buffer();
    let view =
        |offset: usize, length: usize| json!({"buffer": 0, "byteOffset": offset, "byteLength": length});
    let primitive = |material: usize, uvs: usize| json!({"attributes": {"POSITION": 0, "NORMAL": 1, "TEXCOORD_0": uvs, "TEXCOORD_1": 4}, "indices": 5, "material": material});
    json!({
        "asset": {"version": "2.0"}, "scenes": [{"nodes": [0, 1, 2]}],
        "nodes": [
            {"name": "wall", "mesh": 0},
            {"name": "lamp", "mesh": 1, "translation": [0.0, 3.0, 0.0]},
            {"name": "plain", "mesh": 2, "translation": [2.0, 0.0, 0.0]},
        ],
        "meshes": [{"primitives": [primitive(0, 2)]}, {"primitives": [primitive(1, 2)]}, {"primitives": [primitive(2, 3)]}],
        "materials": [
            {"name": "paint", "pbrMetallicRoughness": {
                "baseColorFactor": [0.8, 0.6, 0.4, 1.0], "metallicFactor": 0.0, "roughnessFactor": 0.5, "baseColorTexture": {"index": 0}}},
            {"name": "glow", "emissiveFactor": [1.0, 0.5, 0.0], "extensions": {"KHR_materials_emissive_strength": {"emissiveStrength": 8.0}},
                "pbrMetallicRoughness": {"baseColorFactor": [0.0, 0.0, 0.0, 1.0]}},
            {"pbrMetallicRoughness": {"baseColorFactor": [0.1, 0.2, 0.3, 1.0]}},
        ],
        "textures": [{"source": 0, "sampler": 0}, {"source": 1}],
        "samplers": [{"wrapS": 33071, "wrapT": 33648}],
        "images": [{"bufferView": 6, "mimeType": "image/png"}, {"uri": format!("data:image/png;base64,{}", base64(&png([188, 188, 188])))}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3", "min": [0.0, 0.0, 0.0], "max": [1.0, 1.0, 0.0]},
            {"bufferView": 1, "componentType": 5126, "count": 4, "type": "VEC3"},
            {"bufferView": 2, "componentType": 5126, "count": 4, "type": "VEC2"},
            {"bufferView": 3, "componentType": 5123, "count": 4, "type": "VEC2", "normalized": true},
            {"bufferView": 4, "componentType": 5121, "count": 4, "type": "VEC2", "normalized": true},
            {"bufferView": 5, "componentType": 5123, "count": 6, "type": "SCALAR"},
        ],
        "bufferViews": [view(0, 48), view(48, 48), view(96, 32), view(128, 16), view(144, 8), view(152, 12), view(164, bytes.len() - 164)],
        "buffers": [{"byteLength": bytes.len(), "uri": format!("data:;base64,{}", base64(&bytes))}],
    })
}

/// The document with values replaced or added at JSON pointers.
pub(super) fn changed(changes: &[(&str, Value)]) -> Value {
    let mut document = document();
    for (pointer, value) in changes {
        let (parent, key) = pointer.rsplit_once('/').unwrap();
        match document.pointer_mut(parent).unwrap() {
            Value::Object(object) => drop(object.insert(key.to_owned(), value.clone())),
            Value::Array(array) => array[key.parse::<usize>().unwrap()] = value.clone(),
            other => panic!("{other}"),
        }
    }
    document
}

pub(super) fn try_load(more: &str, document: &Value) -> Result<Scene> {
    let scratch = Scratch::scene(&scene(more));
    scratch.write("t.gltf", document.to_string());
    scratch.load()
}

pub(super) fn load_changed(more: &str, changes: &[(&str, Value)]) -> Scene {
    try_load(more, &changed(changes)).unwrap()
}

pub(super) fn refusal(more: &str, changes: &[(&str, Value)]) -> String {
    let error = try_load(more, &changed(changes)).unwrap_err();
    let message = error.to_string();
    assert!(error.is_bad_input() && !message.contains('\n'), "{message}");
    message
}

pub(super) fn object<'a>(scene: &'a Scene, name: &str) -> &'a crate::scene::Object {
    scene
        .objects
        .iter()
        .find(|o| o.name == name)
        .unwrap_or_else(|| panic!("{:?}", scene.objects.iter().map(|o| &o.name).collect::<Vec<_>>()))
}

pub(super) fn material<'a>(scene: &'a Scene, name: &str) -> &'a Material {
    scene.materials.iter().find(|m| m.name == name).unwrap()
}

#[test]
fn a_file_brings_materials_textures_and_lights() {
    let scene = load_changed("", &[]);
    assert_eq!(
        scene.objects.iter().map(|o| o.name.as_str()).collect::<Vec<_>>(),
        ["it/paint", "it/glow", "it/material-2"]
    );
    assert_eq!(
        scene.materials.iter().map(|m| m.name.as_str()).collect::<Vec<_>>(),
        ["glow", "material-2", "paint"]
    );
    let paint = material(&scene, "paint");
    assert_eq!(paint.brdf, Brdf::Ggx(Ggx { base_color: [0.8, 0.6, 0.4], metallic: 0.0, roughness: 0.5 }));
    let texture = paint.texture.as_ref().unwrap();
    assert_eq!(
        (texture.size, texture.wrap, texture.texels[0]),
        ([2, 1], [Wrap::Clamp, Wrap::Mirror], [255, 0, 0, 255])
    );
    assert_eq!(
        material(&scene, "material-2").brdf,
        Brdf::Ggx(Ggx { base_color: [0.1, 0.2, 0.3], metallic: 1.0, roughness: 1.0 })
    );
    // f32 and normalised u16 coordinates say the same.
    assert_eq!(object(&scene, "it/paint").mesh.uvs, UVS);
    assert_eq!(object(&scene, "it/material-2").mesh.uvs, UVS);
    // Emissive strength times factor is radiance; the square glows where its node is, and reflects.
    assert_eq!(
        scene.lights,
        [Light {
            name: "it/glow".to_owned(),
            emitter: Emitter::Mesh { object: 1, radiance: [8.0, 4.0, 0.0], glow: None }
        }]
    );
    let mesh = &scene.objects[1].mesh;
    assert_eq!((mesh.positions[0], mesh.triangles.len()), ([0.0, 3.0, 0.0], 2));
    assert_eq!(scene.warnings, [] as [&str; 0]);
}

#[test]
fn a_named_node_selects_geometry_materials_and_lights() {
    let only = |node: &str| {
        let scratch = Scratch::scene(&(scene("") + &format!("node = '{node}'\n")));
        scratch.write("t.gltf", document().to_string());
        scratch.load()
    };
    let wall = only("wall").unwrap();
    assert_eq!((wall.objects.len(), wall.lights.len(), wall.materials.len()), (1, 0, 1));
    let lamp = only("lamp").unwrap();
    assert_eq!((lamp.objects.len(), lamp.lights.len(), lamp.materials.len()), (1, 1, 1));
}

#[test]
fn an_object_with_a_material_takes_only_geometry() {
    let scratch = Scratch::scene(&(scene("[materials.clay]\nbrdf = 'ggx'") + "material = 'clay'\n"));
    scratch.write("t.gltf", document().to_string());
    let scene = scratch.load().unwrap();
    assert_eq!((scene.objects.len(), scene.lights.len(), scene.materials.len()), (1, 0, 1));
    assert_eq!((scene.objects[0].name.as_str(), scene.objects[0].mesh.triangles.len()), ("it", 6));
}

#[test]
fn texture_coordinates_are_chosen_and_moved_as_the_texture_says() {
    let uvs = |info: Value| {
        let scene = load_changed("", &[("/materials/0/pbrMetallicRoughness/baseColorTexture", info)]);
        object(&scene, "it/paint").mesh.uvs.clone()
    };
    // The second set is of u8.
    assert_eq!(uvs(json!({"index": 0, "texCoord": 1})), UVS);
    // The extension's own example: the lower left quadrant of the image, turned clockwise by a right angle.
    let example = json!({"offset": [0.0, 1.0], "rotation": std::f64::consts::FRAC_PI_2, "scale": [0.5, 0.5]});
    let moved = uvs(json!({"index": 0, "extensions": {"KHR_texture_transform": example}}));
    for (uv, expected) in moved.iter().zip([[0.0, 1.0], [0.0, 0.5], [0.5, 0.5], [0.5, 1.0]]) {
        assert!((uv[0] - expected[0]).abs() < 1e-6 && (uv[1] - expected[1]).abs() < 1e-6, "{moved:?}");
    }
    let other_set = uvs(
        json!({"index": 0, "texCoord": 7, "extensions": {"KHR_texture_transform": {"texCoord": 1, "scale": [2.0, 3.0]}}}),
    );
    assert_eq!(other_set, UVS.map(|[u, v]| [2.0 * u, 3.0 * v]));
    // Without the set that it asks for a part goes without its texture.
    let bare = load_changed(
        "",
        &[("/materials/0/pbrMetallicRoughness/baseColorTexture", json!({"index": 0, "texCoord": 7}))],
    );
    assert!(material(&bare, "paint").texture.is_none() && object(&bare, "it/paint").mesh.uvs.is_empty());
    let note =
        "material `paint`: has a texture, but some that wear it have no texture coordinates; they go without";
    assert!(bare.warnings.len() == 1 && bare.warnings[0].ends_with(note), "{:?}", bare.warnings);
}

#[test]
fn the_scene_file_changes_or_replaces_materials() {
    let changed = load_changed("[vary]\nmaterials = ['paint']\n[materials.paint]\nroughness = 0.8", &[]);
    let paint = material(&changed, "paint");
    assert_eq!(paint.brdf, Brdf::Ggx(Ggx { base_color: [0.8, 0.6, 0.4], metallic: 0.0, roughness: 0.8 }));
    assert!(paint.texture.is_some() && changed.varying_names() == ["paint"]);
    let replaced =
        load_changed("[materials.paint]\nbrdf = 'blinn-phong'\n[materials.glow]\nbrdf = 'ggx'", &[]);
    assert!(material(&replaced, "paint").texture.is_none() && replaced.lights.is_empty());
    assert_eq!(replaced.objects.len(), 3, "what glowed reflects instead");
    for (more, part) in [
        (
            "[materials.paint]\nkd = [0, 0, 0]",
            "material `paint`: is \"ggx\", which has base_color, metallic and roughness, not `kd`",
        ),
        (
            "[materials.paint]\ntexture = 'a.png'",
            "material `paint`: `texture` and `alpha_cutoff` belong to a material that is described whole",
        ),
        (
            "[materials.pant]\nroughness = 0.8",
            "material `pant`: has no `brdf`, and there is no material of a glTF file `pant`; did you mean `paint`?",
        ),
        ("[materials.glow]\nemission = -1", "material `glow`: emission -1 must be a number of 0 or more"),
        ("[materials.glow]\nemission = nan", "material `glow`: emission NaN must be a number of 0 or more"),
        ("[materials.glow]\nemission = 1e30", "material `glow`: emissive factor times strength"),
        (
            "[materials.glow]\nbrdf = 'ggx'\nemission = 1",
            "material `glow`: `emission` scales what a material of a glTF file emits",
        ),
        (
            "[materials.paint]\nemission = 1",
            "material `paint`: has `emission`, but emits nothing that it could scale",
        ),
        (
            "[vary]\nmaterials = ['paint']\n[materials.paint]\nroughness = 0.2",
            "roughness 0.2 is outside 0.32..1",
        ),
        (
            "[vary]\nmaterials = ['paint']\n[materials.paint]\nmetallic = 1",
            "metallic 1 with a textured base colour",
        ),
    ] {
        let message = refusal(more, &[]);
        assert!(message.contains(part), "{more}: {message}");
    }
}

#[test]
fn smooth_materials_are_roughened_with_a_warning() {
    let smooth = [("/materials/0/pbrMetallicRoughness/roughnessFactor", json!(0.05))];
    for (vary, least) in [
        ("", FIXED_ROUGHNESS_MIN),
        ("[vary]\nmaterials = ['paint']", ROUGHNESS_MIN),
        ("[vary]\nmaterials = ['paint']\nroughness_min = 0.2", 0.2),
    ] {
        let scene = load_changed(vary, &smooth);
        assert!(matches!(material(&scene, "paint").brdf, Brdf::Ggx(ggx) if ggx.roughness == least));
        assert_eq!(scene.warnings.len(), 1);
        assert!(
            scene.warnings[0].contains(&format!("raised its roughness from 0.05 to {least}")),
            "{:?}",
            scene.warnings
        );
    }
    assert!(load_changed("[materials.paint]\nroughness = 0.4", &smooth).warnings.is_empty());
}

#[test]
fn masks_fold_the_factor_into_the_cutoff() {
    let masked = |alpha: f64, cutoff: f64| {
        let pbr = json!({"baseColorFactor": [1.0, 1.0, 1.0, alpha], "baseColorTexture": {"index": 0}});
        load_changed(
            "",
            &[
                ("/materials/0/pbrMetallicRoughness", pbr),
                ("/materials/0/alphaMode", json!("MASK")),
                ("/materials/0/alphaCutoff", json!(cutoff)),
            ],
        )
    };
    assert_eq!(material(&masked(0.8, 0.4), "paint").alpha_cutoff, Some(0.5));
    assert_eq!(material(&masked(0.8, 0.0), "paint").alpha_cutoff, None);
    let gone = masked(0.25, 0.5);
    assert_eq!(gone.objects.len(), 2);
    assert!(
        gone.warnings[0].contains("material `paint`: its mask leaves nothing of it"),
        "{:?}",
        gone.warnings
    );
    let plain = load_changed("", &[("/materials/2/alphaMode", json!("MASK"))]);
    assert_eq!(material(&plain, "material-2").alpha_cutoff, None, "an opaque factor needs no mask");
}

#[test]
fn what_is_not_modelled_is_told_once_per_kind() {
    let scene = load_changed(
        "",
        &[
            ("/extensionsUsed", json!(["KHR_materials_ior", "KHR_texture_transform"])),
            ("/materials/0/normalTexture", json!({"index": 0})),
            ("/materials/2/normalTexture", json!({"index": 0})),
            ("/materials/0/occlusionTexture", json!({"index": 0})),
            ("/materials/2/alphaMode", json!("BLEND")),
            (
                "/materials/2/pbrMetallicRoughness",
                json!({"metallicFactor": 1.0, "roughnessFactor": 0.8, "metallicRoughnessTexture": {"index": 1}}),
            ),
            ("/materials/1/emissiveTexture", json!({"index": 1})),
            ("/materials/1/pbrMetallicRoughness", json!({})),
        ],
    );
    for part in [
        "t.gltf: 2 of 3 materials have a normal texture, which is ignored",
        "t.gltf: 1 of 3 materials has an occlusion texture, which is ignored",
        "t.gltf: 1 of 3 materials has alpha mode BLEND, which is shown opaque",
        "t.gltf: 1 of 3 materials has a metallic-roughness texture, whose mean is taken",
        "t.gltf: the file uses KHR_materials_ior, which is ignored",
    ] {
        assert_eq!(
            scene.warnings.iter().filter(|w| w.ends_with(part)).count(),
            1,
            "{part}: {:?}",
            scene.warnings
        );
    }
    assert_eq!(scene.warnings.len(), 5, "{:?}", scene.warnings);
    // The second picture is grey 188 and black: means of 94/255 as plain numbers.
    let Brdf::Ggx(ggx) = material(&scene, "material-2").brdf else { panic!() };
    assert!(
        (ggx.metallic - 94.0 / 255.0).abs() < 1e-6 && (ggx.roughness - 0.8 * 94.0 / 255.0).abs() < 1e-6,
        "{ggx:?}"
    );
}

/// The document with a light of KHR_lights_punctual at its first node.
pub(super) fn lit(light: &Value, node: Value) -> Value {
    let mut node = node;
    node["extensions"] = json!({"KHR_lights_punctual": {"light": 0}});
    changed(&[("/extensions", json!({"KHR_lights_punctual": {"lights": [light]}})), ("/nodes/0", node)])
}

#[test]
fn punctual_lights_follow_their_nodes_and_the_object() {
    let placed = "transform = { translation = [0, 0, 5], scale = 2 }\n";
    let load = |light: Value, node: Value| {
        let scratch = Scratch::scene(&(scene("") + placed));
        scratch.write("t.gltf", lit(&light, node).to_string());
        scratch.load().unwrap()
    };
    let down = json!({"name": "spot", "translation": [1.0, 2.0, 3.0], "rotation": [-(0.5f64.sqrt()), 0.0, 0.0, 0.5f64.sqrt()]});
    let close = |a: [f32; 3], b: [f32; 3]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-6);
    let scene = load(
        json!({"type": "point", "color": [1.0, 0.5, 0.25], "intensity": 40.0, "name": "bulb", "range": 9.0}),
        down.clone(),
    );
    let Emitter::Point { position, intensity, cone: None } = scene.lights[0].emitter else {
        panic!("{:?}", scene.lights)
    };
    assert!(close(position, [2.0, 4.0, 11.0]) && intensity == [40.0, 20.0, 10.0], "{position:?}");
    assert_eq!(scene.lights[0].name, "spot");
    assert!(
        scene.warnings[0].ends_with("1 of 1 light has a range, which is ignored"),
        "{:?}",
        scene.warnings
    );
    let spot =
        json!({"type": "spot", "intensity": 3.0, "spot": {"innerConeAngle": 0.2, "outerConeAngle": 0.6}});
    let Emitter::Point { cone: Some(Cone { direction, cos_inner, cos_outer }), .. } =
        load(spot, down.clone()).lights[0].emitter
    else {
        panic!()
    };
    assert!(
        close(direction, [0.0, -1.0, 0.0]) && (cos_inner, cos_outer) == (0.2f32.cos(), 0.6f32.cos()),
        "{direction:?}"
    );
    let hard = json!({"type": "spot", "spot": {"innerConeAngle": 0.6, "outerConeAngle": 0.6}});
    let Emitter::Point { cone: Some(cone), .. } = load(hard, down.clone()).lights[0].emitter else {
        panic!()
    };
    assert!(cone.cos_outer < cone.cos_inner && cone.cos_inner - cone.cos_outer < 1e-3);
    let sun = load(json!({"type": "directional", "intensity": 3.0}), json!({"rotation": down["rotation"]}));
    let Emitter::Directional { direction, irradiance } = sun.lights[0].emitter else { panic!() };
    assert!(close(direction, [0.0, -1.0, 0.0]) && irradiance == [3.0; 3] && sun.lights[0].name == "light-0");
}

#[test]
fn light_names_are_made_unique_and_lights_can_be_left_out() {
    let document = lit(&json!({"type": "point"}), json!({"name": "lamp", "mesh": 0}));
    let twice = "[[object]]\nname = 'again'\nfile = 't.gltf'\ntransform = { translation = [9, 0, 0] }\n\
                 [[light]]\nname = 'lamp'\nkind = 'point'\nintensity = [1, 1, 1]";
    let names = |scene: &Scene| scene.lights.iter().map(|l| l.name.clone()).collect::<Vec<_>>();
    let scene = try_load(twice, &document).unwrap();
    assert_eq!(names(&scene), ["lamp", "lamp-2", "again/glow", "lamp-3", "it/glow"]);
    // The same file twice is read as the same materials and textures.
    assert_eq!((scene.objects.len(), scene.materials.len()), (6, 3));
    assert!(
        scene.warnings.iter().any(|w| w.ends_with("names of lights repeat; numbered `lamp-2`, `lamp-3`")),
        "{:?}",
        scene.warnings
    );
    let scratch = Scratch::scene(&(import_tests::scene("") + "lights = false\n"));
    scratch.write("t.gltf", document.to_string());
    let dark = scratch.load().unwrap();
    assert!(dark.lights.is_empty() && dark.objects.len() == 3);
}
