use super::*;
use relume_bake::methods::asked::Asked;
use relume_bake::methods::registered::Registered;
use relume_bake::scene_hash::scene_hash;
use relume_formats::kinds::manifest::{FileEntry, Manifest, MethodEntry, VERSION};
use serde_json::Value;
use serde_json::json;
use std::collections::BTreeMap;

/// A ball on a plane under an even sky; `vary` and `render` are lines of these tables, `object` of the
/// ball's.
fn ball(vary: &str, render: &str, object: &str) -> Scene {
    let text = format!(
        "[vary]\n{vary}\n[render]\nsize = [32, 24]\n{render}\n\
         [camera]\nposition = [0.0, 2.0, 5.0]\ntarget = [0.0, 0.5, 0.0]\nfov_deg = 40.0\n\
         [materials.white]\nbrdf = 'blinn-phong'\nkd = [0.8, 0.8, 0.8]\n\
         [[object]]\nname = 'plane'\nshape = 'quad'\nsegments = 8\nmaterial = 'white'\ntransform = {{ scale = 4.0 }}\n\
         [[object]]\nname = 'ball'\nshape = 'sphere'\nsubdivisions = 2\nmaterial = 'white'\n{object}\n\
         transform = {{ translation = [0.0, 1.0, 0.0], scale = 0.4 }}\n[environment]\n"
    );
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene.toml");
    std::fs::write(&path, text).unwrap();
    Scene { name: "ball".to_owned(), ..relume_scenes::load(&path).unwrap() }
}

/// Bundles and charts in `folder`.
fn at(folder: &Path) -> Folders<'_> {
    Folders { bundles: folder, charts: folder }
}

/// With what `bake plan SCENE` asks for.
fn planned(scene: &Scene, folders: &Folders<'_>, json: bool) -> Result<String> {
    plan(scene, &Asked::of_scene(scene), folders, json)
}

fn json_of(scene: &Scene, bundles: &Path) -> Value {
    serde_json::from_str(&planned(scene, &at(bundles), true).unwrap()).unwrap()
}

#[test]
fn a_scene_that_varies_nothing_is_told_so() {
    let scene = ball("", "reflections = 1", "");
    let text = planned(&scene, &at(Path::new("none")), false).unwrap();
    assert!(
        text.starts_with(
            "ball varies nothing, so there is nothing to bake: make one image with `bake reference`"
        ),
        "{text}"
    );
    let value = json_of(&scene, Path::new("none"));
    assert_eq!((&value["chosen"], &value["methods"]), (&Value::Null, &json!([])));
}

#[test]
fn what_no_method_does_is_said() {
    let mut scene = ball("light = true\nview = true\nmaterials = ['white']", "reflections = 1", "");
    let value = json_of(&scene, Path::new("none"));
    assert_eq!((&value["chosen"], &value["not_modelled"]), (&json!("transfer-tensor"), &json!([])));
    let methods = value["methods"].as_array().unwrap();
    let fits: Vec<_> = methods
        .iter()
        .map(|m| (m["name"].as_str().unwrap(), m["misfit"].is_null(), m["serves_all"] == true))
        .collect();
    assert_eq!(
        fits,
        [
            ("transfer-images", true, false),
            ("sparse-transfer", true, false),
            ("transfer-tensor", true, true),
            ("sphere-shadows", true, false)
        ]
    );
    let tells: Vec<&str> =
        methods[3]["predicted"]["tells"].as_array().unwrap().iter().filter_map(Value::as_str).collect();
    assert!(
        tells.len() == 2
            && tells[0].starts_with("`plane` casts by ")
            && tells[0].ends_with(" triangles, 0.00 % off")
            && tells[1].starts_with("`ball` casts by "),
        "{tells:?}"
    );
    scene.vary.shape = true;
    let value = json_of(&scene, Path::new("none"));
    assert_eq!(value["chosen"], "sphere-shadows");
    let left_out: Vec<&str> =
        value["not_modelled"].as_array().unwrap().iter().filter_map(Value::as_str).collect();
    assert_eq!(
        left_out,
        [
            "[vary] names material `white`, but sphere-shadows keeps materials as the scene has them",
            "no method varies materials together with light, view, shape"
        ]
    );
}

#[test]
fn where_the_wanted_method_does_not_fit_none_is_chosen_and_the_remedy_is_said() {
    let text = planned(&ball("shape = true", "reflections = 2", ""), &at(Path::new("none")), false).unwrap();
    assert!(
        text.contains(
            "\nsparse-transfer: does not fit: [vary] shape = true, but sparse-transfer keeps shapes fixed"
        ),
        "{text}"
    );
    assert!(
        text.contains(
            "\nchosen: none; sphere-shadows, which would be, does not fit: [render] reflections = 2"
        ),
        "{text}"
    );
}

#[test]
fn meshes_too_coarse_for_light_at_vertices_are_told() {
    let outdoors = ball("light = true\nview = true", "reflections = 1", "");
    let larger = |scene: &Scene, size: [u32; 2]| Scene { size, ..scene.clone() };
    let told = |scene: &Scene| json_of(scene, Path::new("none"))["not_modelled"].to_string();
    // The plane's triangles, 0.7 m of the 2.9 m that the film shows of its middle and more before it, are
    // those of 24 lines of pixels here.
    assert!(!told(&outdoors).contains("triangles"), "{}", told(&outdoors));
    let coarse = told(&larger(&outdoors, [512, 384]));
    assert!(
        coarse.contains("shadows smaller than the triangles of `plane`")
            && coarse.contains("(more than 24 is coarse)"),
        "{coarse}"
    );
    assert!(coarse.contains("raise `segments`") && coarse.contains("use transfer-images"), "{coarse}");
    // Images know the light at pixels.
    let materials = larger(&ball("materials = ['white']", "reflections = 1", ""), [512, 384]);
    assert!(!told(&materials).contains("triangles"), "{}", told(&materials));
}

#[test]
fn figures_of_an_earlier_bake_count_if_the_scene_is_the_same() {
    let scene = ball("materials = ['white']", "reflections = 1", "");
    let bundles = tempfile::tempdir().unwrap();
    let folder = bundles.path().join("ball");
    std::fs::create_dir(&folder).unwrap();
    let reads =
        (Registered::find("transfer-images").unwrap().new)(&Asked::of_scene(&scene), &scene).reads(&scene);
    let method = MethodEntry {
        reads: format!("{reads:032x}"),
        name: "transfer-images".to_owned(),
        files: vec![
            ("brdf-basis".to_owned(), FileEntry::of("a.relume", &[0; 70])),
            ("b".to_owned(), FileEntry::of("b.relume", &[0; 30])),
        ],
        settings: BTreeMap::from([("bases".to_owned(), json!(5))]),
        errors: BTreeMap::from([
            ("relative_l2_median".to_owned(), 0.0025),
            ("relative_l2_worst".to_owned(), 0.0075),
        ]),
        measured_on: String::new(),
    };
    let mut manifest = Manifest {
        version: VERSION,
        scene: "ball".to_owned(),
        scene_hash: format!("{:032x}", scene_hash(&scene)),
        scene_file: FileEntry::of("scene.relume", &[]),
        animations: BTreeMap::new(),
        sphere_sets: BTreeMap::new(),
        methods: vec![method],
    };
    manifest.write(&folder).unwrap();
    let report = json!({ "methods": { "transfer-images": { "rays": 2e6, "tracing_seconds": 3.0 } }, "frame": { "transfer-images": { "median_ms": 1.25 } } });
    std::fs::write(folder.join("report.json"), report.to_string()).unwrap();
    let text = planned(&scene, &at(bundles.path()), false).unwrap();
    let stored = "(bases 5): error 0.250 % median, 0.750 % worst; 0.0 MB on disk, 2.0 million rays in 3.0 s, a frame in 1.25 ms";
    assert!(text.contains(stored), "{text}");
    assert_eq!(json_of(&scene, bundles.path())["methods"][0]["stored"]["bytes_on_disk"], 100);

    manifest.methods[0].reads = "0".repeat(32);
    manifest.write(&folder).unwrap();
    let value = json_of(&scene, bundles.path());
    assert!(value["stored_unusable"].as_str().unwrap().contains("another state of the scene"), "{value}");
    assert!(value["methods"][0]["stored"].is_null());
}

#[test]
fn the_best_point_of_a_chart_is_told() {
    let scene = ball("materials = ['white']", "reflections = 1", "");
    let charts = tempfile::tempdir().unwrap();
    let chart = crate::test_chart::chart();
    std::fs::create_dir(charts.path().join("ball")).unwrap();
    crate::files::write(&chart, &charts.path().join("ball")).unwrap();
    let of_method = chart.points.iter().filter(|point| point.method == "transfer-images");
    let best = of_method.map(|point| point.errors.relative_l2.median).fold(f64::INFINITY, f64::min);
    let value = json_of(&scene, charts.path());
    assert_eq!(value["methods"][0]["charted"]["relative_l2_median"], best);
    let text = planned(&scene, &at(charts.path()), false).unwrap();
    assert!(
        text.contains(&format!("{:.3} % median", 100.0 * best))
            && text.contains("nearest to path traced images with"),
        "{text}"
    );
}

#[test]
fn a_plan_is_for_what_is_asked() {
    let scene = ball("materials = ['white']", "reflections = 1", "");
    let predicted = |asked: &Asked| {
        let text = plan(&scene, asked, &at(Path::new("none")), true).unwrap();
        let value: Value = serde_json::from_str(&text).unwrap();
        let methods = value["methods"].as_array().unwrap();
        methods.iter().find(|method| method["name"] == "transfer-images").unwrap().clone()
    };
    let usual = predicted(&Asked::of_scene(&scene));
    let asked = Asked { size: [16, 12], samples: Some(64), bases: Some(4), ..Asked::of_scene(&scene) };
    let fewer = predicted(&Asked { noise: Some(0.02), ..asked });
    assert_eq!((&fewer["settings"]["bases"], &fewer["settings"]["size"]), (&json!(4), &json!([16, 12])));
    let rays = |method: &Value| method["predicted"]["rays"].as_u64().unwrap();
    assert!(rays(&fewer) > 0 && rays(&fewer) < rays(&usual) / 4, "{fewer} {usual}");
    let tells = fewer["predicted"]["tells"].to_string();
    assert!(tells.contains("until noise is about 2 %"), "{tells}");
}

#[test]
fn settings_are_said_in_words() {
    let scene = ball("light = true\nview = true", "reflections = 1", "");
    let text = planned(&scene, &at(Path::new("none")), false).unwrap();
    assert!(text.contains("max_error 0.01, objects (plane, ball), seed 0"), "{text}");
    let asking = ball("light = true\nview = true", "reflections = 1", "spheres = 8");
    let text = planned(&asking, &at(Path::new("none")), false).unwrap();
    assert!(text.contains("objects (plane, ball 8)"), "{text}");
}
