use super::*;
use crate::geometry::tidy_name;
use crate::test_support::Scratch;
use relume_formats::state::Brdf;
use serde_json::{Value, json};

/// A glTF of a square in the plane z = 0 for each material, side by side; `None` wears none.
fn gltf(materials: &[Value], worn: &[Option<usize>]) -> String {
    let bytes: Vec<u8> = [[0.0f32, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]]
        .iter()
        .flatten()
        .flat_map(|x| x.to_le_bytes())
        .chain([0u16, 1, 2, 0, 2, 3].iter().flat_map(|i| i.to_le_bytes()))
        .collect();
    let uri =
        format!("data:application/octet-stream;base64,{}", crate::loading::import_tests::base64(&bytes));
    let primitive = |material: &Option<usize>| {
        let mut primitive = json!({"attributes": {"POSITION": 0}, "indices": 1});
        material.iter().for_each(|material| primitive["material"] = json!(material));
        primitive
    };
    let meshes: Vec<Value> =
        worn.iter().map(|material| json!({"primitives": [primitive(material)]})).collect();
    let nodes: Vec<Value> =
        (0..worn.len()).map(|i| json!({"mesh": i, "translation": [i as f64, 0.0, 0.0]})).collect();
    json!({
        "asset": {"version": "2.0"}, "scenes": [{"nodes": (0..worn.len()).collect::<Vec<_>>()}],
        "nodes": nodes, "meshes": meshes, "materials": materials,
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0]},
            {"bufferView": 1, "componentType": 5123, "count": 6, "type": "SCALAR"},
        ],
        "bufferViews": [{"buffer": 0, "byteLength": 48}, {"buffer": 0, "byteOffset": 48, "byteLength": 12}],
        "buffers": [{"byteLength": 60, "uri": uri}],
    })
    .to_string()
    .replace("\"materials\":[],", "")
}

/// A folder with a model in it, and its first scene once everything of it is seen.
fn first_scene(name: &str, content: &str) -> (Scratch, String, Scene) {
    let scratch = Scratch::scene("");
    scratch.write(name, content);
    let starter = Starter::of(&scratch.path(name), &scratch.path("scene.toml"), None).unwrap();
    let seen =
        starter.scene(None).unwrap().materials.into_iter().map(|material| (material.name, 10)).collect();
    let look = Look { exposure_ev: 0.0, seen };
    let (text, scene) = (starter.text(Some(&look)), starter.scene(Some(&look)).unwrap());
    scratch.write("scene.toml", &text);
    assert_eq!(
        scratch.load().unwrap().varying_names(),
        scene.varying_names(),
        "the file means what was looked at"
    );
    (scratch, text, scene)
}

fn named(name: &str) -> Value {
    json!({"name": name, "pbrMetallicRoughness": {"metallicFactor": 0.0}})
}

#[test]
fn materials_of_any_name_vary() {
    let names =
        ["it's \"new\"", "two\nlines\t", "Lack-Glänzend 漆", "a.b", "ground", "back\\slash", "[x] = 1 # no"];
    let materials: Vec<Value> = names.iter().map(|name| named(name)).collect();
    let worn: Vec<Option<usize>> = (0..names.len()).map(Some).collect();
    let (_scratch, text, scene) = first_scene("model.gltf", &gltf(&materials, &worn));
    let mut expected: Vec<String> = names.iter().map(|name| tidy_name(name)).collect();
    let mut listed: Vec<&str> = scene
        .materials
        .iter()
        .map(|material| material.name.as_str())
        .filter(|name| *name != "ground-2")
        .collect();
    listed.sort_unstable();
    expected.sort_unstable();
    assert_eq!(listed, expected, "{text}");
    assert_eq!(
        (scene.varying_names().len(), text.matches("  # less is seen of it").count()),
        (6, 1),
        "{text}"
    );
    assert!(
        scene.materials.iter().any(|material| material.name == "ground-2"),
        "the model's own `ground` keeps its name"
    );
}

#[test]
fn materials_of_one_name_and_none_at_all_vary() {
    let materials = [named("Paint"), named("Paint"), json!({})];
    let (_scratch, text, scene) =
        first_scene("model.gltf", &gltf(&materials, &[Some(0), Some(1), Some(2), None]));
    assert_eq!(scene.varying_names(), ["Paint", "Paint-2", "material-2", "material-default"], "{text}");
    let default = scene.materials.iter().find(|material| material.name == "material-default").unwrap();
    assert!(
        matches!(default.brdf, Brdf::Ggx(ggx) if ggx.metallic == 0.0),
        "what has no material is no metal"
    );
    let (_scratch, _, scene) = first_scene("model.gltf", &gltf(&[], &[None]));
    assert_eq!(scene.varying_names(), ["material-default"]);
}

/// Transfer images hold no metal with a texture: what hardly is metal is shown as none, what is stays fixed,
/// and something always varies.
#[test]
fn metals_with_textures_are_dealt_with() {
    let picture = format!(
        "data:image/png;base64,{}",
        crate::loading::import_tests::base64(&crate::loading::import_tests::png([255, 0, 0]))
    );
    let textured = |metallic: f64| json!({"pbrMetallicRoughness": {"metallicFactor": metallic, "baseColorTexture": {"index": 0}}});
    let with_texture = |document: String| {
        let mut document: Value = serde_json::from_str(&document).unwrap();
        document["textures"] = json!([{"source": 0}]);
        document["images"] = json!([{"uri": picture}]);
        // Any numbers of two floats at 4 vertices do as texture coordinates.
        document["accessors"]
            .as_array_mut()
            .unwrap()
            .push(json!({"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC2"}));
        for mesh in document["meshes"].as_array_mut().unwrap() {
            mesh["primitives"][0]["attributes"]["TEXCOORD_0"] = json!(2);
        }
        document.to_string()
    };
    let materials = [textured(0.3), textured(0.9)];
    let (_scratch, text, scene) =
        first_scene("model.gltf", &with_texture(gltf(&materials, &[Some(0), Some(1)])));
    assert_eq!(scene.varying_names(), ["material-0"], "{text}");
    assert!(matches!(scene.materials[0].brdf, Brdf::Ggx(ggx) if ggx.metallic == 0.0));
    assert!(text.contains("# \"material-1\",  # a metal with a texture"), "{text}");
    let (_scratch, text, scene) = first_scene("model.gltf", &with_texture(gltf(&materials[1..], &[Some(0)])));
    assert_eq!(scene.varying_names(), ["ground"], "{text}");
}

/// What the comments of the file say of B, done line by line, gives a scene in which light and view vary.
#[test]
fn the_other_way_that_the_file_tells_of_is_a_scene() {
    let (scratch, text, _) = first_scene("model.obj", &tetrahedron(2.0, [0.0; 3]));
    let (before, rest) = text.split_once("materials = [").unwrap();
    let (_, after) = rest.split_once("]\n").unwrap();
    let (head, ground) = after.split_once("name = \"ground\"").unwrap();
    let (large, small) = ground.split_once("\n# B, whose shadows").unwrap();
    let (large, _) = large.split_once("transform = ").unwrap();
    let small = small.split_once('\n').unwrap().1.replacen("# segments", "segments", 1).replacen(
        "# transform",
        "transform",
        1,
    );
    let followed = format!("{before}{head}name = \"ground\"{large}{small}").replace("# B: ", "");
    scratch.write("scene.toml", &followed);
    let scene = scratch.load().unwrap();
    assert!(scene.vary.light && scene.vary.view && scene.vary.materials.is_empty(), "{followed}");
    assert_eq!(scene.environment.unwrap().others.len(), 2);
    assert_eq!(scene.objects.last().unwrap().mesh.triangles.len(), 2 * 96 * 96);
}

/// A tetrahedron of the given size about a point, as an OBJ file.
fn tetrahedron(size: f64, [x, y, z]: [f64; 3]) -> String {
    let vertex =
        |dx: f64, dy: f64, dz: f64| format!("v {} {} {}\n", x + dx * size, y + dy * size, z + dz * size);
    let vertices =
        [vertex(-0.5, -0.5, -0.5), vertex(0.5, -0.5, -0.5), vertex(0.0, -0.5, 0.5), vertex(0.0, 0.5, 0.0)]
            .concat();
    format!("{vertices}f 1 2 3\nf 1 4 2\nf 2 4 3\nf 3 4 1\n")
}

#[test]
fn models_of_any_size_and_place_stand_on_the_ground_at_the_origin() {
    for (size, at, metres) in [
        (1.8, [0.0; 3], 1.8),
        (180.0, [0.0, 90.0, 0.0], 1.8),
        (1.5e-6, [0.0; 3], 1.5),
        (3e8, [0.0; 3], 3.0),
        (2.0, [4e6, -3e6, 1e6], 2.0),
    ] {
        let (_scratch, text, scene) = first_scene("a model's.obj", &tetrahedron(size, at));
        let model = &scene.objects.iter().find(|object| object.name == "model").unwrap().mesh;
        let bounds = |k: usize| {
            let side = model.positions.iter().map(|p| f64::from(p[k]));
            (side.clone().fold(f64::INFINITY, f64::min), side.fold(f64::NEG_INFINITY, f64::max))
        };
        // What is far away was rounded to half a metre when its file was read.
        let tolerance = if at[0] == 0.0 { 1e-3 * metres } else { 0.5 };
        for (k, (low, high)) in [(0, (-0.5, 0.5)), (1, (0.0, 1.0)), (2, (-0.5, 0.5))] {
            let (found_low, found_high) = bounds(k);
            assert!(
                (found_low - low * metres).abs() <= tolerance
                    && (found_high - high * metres).abs() <= tolerance,
                "{size}, {k}: {text}"
            );
        }
        assert_eq!(scene.varying_names(), ["model"]);
    }
}

#[test]
fn what_is_no_model_is_refused_by_what_it_is() {
    let scratch = Scratch::scene("");
    scratch.write("chair.txt", "");
    scratch.write("chair.obj", "v 0 0 0\n");
    std::fs::create_dir(scratch.path("folder.obj")).unwrap();
    for (name, reason) in [
        ("chair.glb", "chair.glb: no such file; did you mean"),
        ("chair.txt", "chair.txt: is no model; name a .glb, .gltf, .obj, .ply or .off file"),
        ("folder.obj", "folder.obj: is no model"),
        ("chair.obj", "chair.obj: "),
    ] {
        let error = Starter::of(&scratch.path(name), &scratch.path("scene.toml"), None).unwrap_err();
        assert!(error.is_bad_input() && error.to_string().contains(reason), "{error}");
    }
}
