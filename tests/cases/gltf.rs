//! glTF as other programs write it.

use crate::support::{expect_exit, run};
use relume_bake::exr_file::read_exr;
use serde_json::Value;
use std::path::{Path, PathBuf};

/// A copy of the inputs of a case, removed with this value.
struct Case(tempfile::TempDir);

impl Case {
    fn new(name: &str) -> Self {
        let case = Self(tempfile::tempdir().unwrap());
        let inputs = Path::new(env!("CARGO_MANIFEST_DIR")).join("cases/inputs").join(name);
        for file in std::fs::read_dir(inputs).unwrap().map(|file| file.unwrap().path()) {
            std::fs::copy(&file, case.path(file.file_name().unwrap().to_str().unwrap())).unwrap();
        }
        case
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn text(&self, name: &str) -> String {
        self.path(name).to_string_lossy().into_owned()
    }

    /// Changes the text of a file.
    fn edit(&self, name: &str, from: &str, to: &str) {
        let text = std::fs::read_to_string(self.path(name)).unwrap();
        assert!(text.contains(from), "{text}");
        std::fs::write(self.path(name), text.replace(from, to)).unwrap();
    }

    /// The scene as `bake export` has it.
    fn exported(&self) -> Value {
        expect_exit("bake", &["export", &self.text("scene.toml"), "-o", &self.text("out")], 0);
        serde_json::from_slice(&std::fs::read(self.path("out/scene.json")).unwrap()).unwrap()
    }

    /// Names and triangles of all objects but the floor, names of all lights, and warnings.
    fn loaded(&self) -> (Vec<(String, u64)>, Vec<String>, Vec<String>) {
        let scene = self.exported();
        let text = |value: &Value| value.as_str().unwrap().to_owned();
        let objects = scene["objects"].as_array().unwrap().iter().skip(1);
        let lights = scene["lights"].as_array().unwrap().iter().map(|light| text(&light["name"]));
        let warnings = scene["warnings"].as_array().unwrap().iter().map(text);
        (
            objects.map(|o| (text(&o["name"]), o["triangles"].as_u64().unwrap())).collect(),
            lights.collect(),
            warnings.collect(),
        )
    }

    /// Radiance by pixel of a reference image, and its width.
    fn reference(&self, more: &[&str]) -> (Vec<[f32; 3]>, usize) {
        let (scene, out) = (self.text("scene.toml"), self.text("r.exr"));
        expect_exit("bake", &[&["reference", &scene, "-o", &out], more].concat(), 0);
        let image = read_exr(Path::new(&out)).unwrap();
        let [r, g, b] = ["R", "G", "B"].map(|channel| image.channel(channel).unwrap());
        (r.iter().zip(g).zip(b).map(|((r, g), b)| [*r, *g, *b]).collect(), image.width)
    }
}

fn only(name: &str, triangles: u64) -> Vec<(String, u64)> {
    vec![(name.to_owned(), triangles)]
}

#[test]
fn legal_files_load_whole() {
    for (case, objects, warning) in [
        (
            "gltf-channel-without-node",
            only("model", 1),
            Some("left out 1 animation channel without a node to move"),
        ),
        ("gltf-custom-attribute", only("model", 1), None),
        ("gltf-empty-scene", only("model", 1), None),
        ("gltf-instancing-silent", only("model", 2), None),
        ("gltf-sparse-position", only("model", 1), None),
        (
            "gltf-same-material-name",
            vec![("model/Mat".to_owned(), 1), ("model/Mat-2".to_owned(), 1)],
            Some("names of materials repeat; numbered `Mat-2`"),
        ),
        (
            "gltf-one-degenerate-material",
            only("model/a", 2),
            Some("material `b`: its triangles have no area, its surfaces are left out"),
        ),
    ] {
        let (found, _, warnings) = Case::new(case).loaded();
        assert_eq!(found, objects, "{case}");
        assert!(
            warning.is_none_or(|warning| warnings.iter().any(|w| w.ends_with(warning))),
            "{case}: {warnings:?}"
        );
    }
}

#[test]
fn what_stays_refused_is_named_with_a_remedy() {
    let case = Case::new("gltf-draco-message");
    let told = "draco.gltf: requires KHR_draco_mesh_compression, which is not supported; convert it by `npx @gltf-transform/cli copy in.glb out.glb`\n";
    let message = expect_exit("bake", &["export", &case.text("scene.toml"), "-o", &case.text("out")], 2);
    assert!(message.ends_with(told), "{message}");
    let message = expect_exit(
        "bake",
        &["spheres", &case.text("draco.gltf"), "-n", "1", "-o", &case.text("s.relume")],
        2,
    );
    assert!(message.ends_with(told), "{message}");
}

/// A plate whose texture is red and white, with a few texels that glow: they do, and the rest reflects its
/// texture.
#[test]
fn a_plate_with_a_few_glowing_texels_keeps_its_picture() {
    let case = Case::new("gltf-emissive-texture-kills-surface");
    let (objects, lights, warnings) = case.loaded();
    assert_eq!(
        (objects, lights),
        (only("model/m0", 2), vec!["sun".to_owned(), "model/m0".to_owned()]),
        "{warnings:?}"
    );
    let samples = ["--spp", "64", "--reflections", "1"];
    let (glowing, width) = case.reference(&samples);
    case.edit("scene.toml", "[[light]]", "[materials.m0]\nemission = 0\n[[light]]");
    let (dark, _) = case.reference(&samples);
    assert_eq!(case.loaded().1, ["sun"]);
    // What reflects is the same but for noise of the light of 4 texels of 1024; what glows adds at most their
    // radiance of 1.
    let added: Vec<f32> = glowing.iter().zip(&dark).map(|(a, b)| a[1] - b[1]).collect();
    let lit = added.iter().filter(|x| **x > 0.2).count();
    let plate = dark.iter().filter(|pixel| pixel[1] > 0.1).count();
    assert!((4..40).contains(&lit) && plate > width * 10, "{lit} {plate}");
    // At the edge of the texels their light fades; elsewhere there is noise, for lights are chosen at random.
    assert!(added.iter().all(|x| (-0.03..1.05).contains(x)), "{added:?}");
    assert!(added.iter().filter(|x| x.abs() > 0.03).count() < 80);
    // It varies as well as others do, and what is baked is taken by every reader.
    case.edit("scene.toml", "materials = [\"paint\"]", "materials = [\"m0\"]");
    case.edit("scene.toml", "emission = 0", "emission = 1");
    let (scene, bundle) = (case.text("scene.toml"), case.text("bundle"));
    expect_exit(
        "bake",
        &[
            "run",
            &scene,
            "--bases",
            "12",
            "--spp",
            "4",
            "--size",
            "24x24",
            "--max-error",
            "10",
            "-o",
            &bundle,
        ],
        0,
    );
    expect_exit("bake", &["verify", &bundle], 0);
}

/// Where the light varies, methods leave a faint glow out and say so; what glows brightly is refused with a
/// remedy.
#[test]
fn a_few_glowing_texels_do_not_make_a_scene_unbakeable() {
    let case = Case::new("gltf-emissive-texture-kills-surface");
    let text = std::fs::read_to_string(case.path("scene.toml")).unwrap();
    let (before, _) = text.split_once("[[light]]").unwrap();
    let varying = before.replace("materials = [\"paint\"]", "light = true\nview = true")
        + "[environment]\nfile = \"clear-sky\"\n";
    std::fs::write(case.path("scene.toml"), &varying).unwrap();
    let plan = run("bake", &["plan", &case.text("scene.toml")]);
    let told = String::from_utf8_lossy(&plan.stdout).into_owned() + &String::from_utf8_lossy(&plan.stderr);
    assert!(
        plan.status.success()
            && told.contains("leaves out what its texture emits, 5 % of a white one's at most"),
        "{told}"
    );
    case.edit("lamp.gltf", ", \"emissiveTexture\": {\"index\": 1}", "");
    let message = expect_exit("bake", &["run", &case.text("scene.toml"), "-o", &case.text("out")], 2);
    assert!(
        message.contains("light `model/m0`")
            && message.contains("write `emission = 0` in [materials.\"m0\"]"),
        "{message}"
    );
    std::fs::write(case.path("scene.toml"), varying + "[materials.m0]\nemission = 0\n").unwrap();
    let plan = run("bake", &["plan", &case.text("scene.toml")]);
    assert!(String::from_utf8_lossy(&plan.stdout).contains("sparse-transfer: fits"), "{plan:?}");
}

/// Four sharp squares: red and green above blue and yellow.
#[test]
fn texels_are_sharp_where_the_sampler_says_so() {
    let case = Case::new("gltf-nearest-filter-ignored");
    let (pixels, width) = case.reference(&["--spp", "16", "--reflections", "1"]);
    // The camera looks from (0.5, 0.6, 3) to (0.5, 0.5, 0), 40° high.
    let colour = |x: f64, y: f64| {
        let (dx, dy, dz) = (x - 0.5, y - 0.6, -3.0);
        let (forward, up) = ([0.0, -0.1, -3.0], [0.0, 3.0, -0.1]);
        let length = (0.1f64.powi(2) + 9.0).sqrt();
        let along = (dy * forward[1] + dz * forward[2]) / length;
        let scale = 0.5 * width as f64 / 20.0f64.to_radians().tan() / along;
        let (column, row) = (
            0.5 * width as f64 + dx * scale,
            0.5 * width as f64 - (dy * up[1] + dz * up[2]) / length * scale,
        );
        pixels[row as usize * width + column as usize]
    };
    let bright = |[r, g, b]: [f32; 3]| [r > 0.3, g > 0.3, b > 0.3];
    let share = |[r, g, b]: [f32; 3]| r.min(g).min(b) / r.max(g).max(b);
    for (x, y, expected) in [
        (0.0, 1.0, [true, false, false]),
        (1.0, 1.0, [false, true, false]),
        (0.0, 0.0, [false, false, true]),
        (1.0, 0.0, [true, true, false]),
    ] {
        let corner = |reach: f64| colour(0.5 + (x - 0.5) * reach, 0.5 + (y - 0.5) * reach);
        // As clear at a tenth of the way to the corner as at the corner, but for the pixel that an edge
        // crosses.
        for reach in [0.12, 0.5, 0.9] {
            let seen = corner(reach);
            assert_eq!(bright(seen), expected, "{x} {y} {reach}: {seen:?}");
            assert!(expected == [true, true, false] || share(seen) < 0.1, "{x} {y} {reach}: {seen:?}");
        }
    }
}

#[test]
fn nothing_outside_the_folder_of_a_gltf_is_read() {
    let case = Case::new("gltf-reads-outside");
    std::fs::create_dir_all(case.path("a/b")).unwrap();
    for file in ["scene.toml", "a.gltf", "t.png"] {
        std::fs::rename(case.path(file), case.path("a/b").join(file)).unwrap();
    }
    let message = expect_exit(
        "bake",
        &["run", &case.text("a/b/scene.toml"), "--terms", "4", "--spp", "1", "-o", &case.text("out")],
        2,
    );
    let told = "buffer 1: names `../../secret.bin`, which is not in the folder of the glTF file or below; put it there and name it by a relative path\n";
    assert!(message.ends_with(told), "{message}");
    assert!(!case.path("out").exists());
    let absolute = case.text("secret.bin");
    for uri in [
        "%2e%2e/../secret.bin",
        "..\\..\\secret.bin",
        absolute.as_str(),
        &format!("file://{absolute}"),
        "x/../../../secret.bin",
    ] {
        let text = std::fs::read_to_string(case.path("a/b/a.gltf")).unwrap();
        std::fs::write(case.path("a/b/b.gltf"), text.replace("../../secret.bin", &uri.replace('\\', "\\\\")))
            .unwrap();
        let message = expect_exit(
            "bake",
            &["spheres", &case.text("a/b/b.gltf"), "-n", "1", "-o", &case.text("s.relume")],
            2,
        );
        assert!(message.contains("which is not in the folder of the glTF file or below"), "{uri}: {message}");
    }
}

/// Names and objects by the hundred thousand take seconds.
#[test]
fn many_of_one_name_are_told_apart() {
    let case = Case::new("gltf-custom-attribute");
    case.edit("scene.toml", "material = \"paint\"\n[[light]]", "[[light]]");
    let mut document: Value =
        serde_json::from_slice(&std::fs::read(case.path("custom.gltf")).unwrap()).unwrap();
    let n = 20_000;
    let primitive = document["meshes"][0]["primitives"][0].clone();
    document["materials"] = (0..n).map(|_| serde_json::json!({"name": "Material"})).collect();
    document["meshes"] = (0..n)
        .map(|material| {
            let mut primitive = primitive.clone();
            primitive["material"] = material.into();
            serde_json::json!({ "primitives": [primitive] })
        })
        .collect();
    document["nodes"] = (0..n).map(|mesh| serde_json::json!({"mesh": mesh, "name": "Node"})).collect();
    document["scenes"][0]["nodes"] = (0..n).collect();
    std::fs::write(case.path("custom.gltf"), document.to_string()).unwrap();
    let scene = relume_scenes::load(&case.path("scene.toml")).unwrap();
    assert_eq!((scene.objects.len(), scene.materials.len()), (n + 1, n + 1));
    assert_eq!(scene.objects[n].name, format!("model/Material-{n}"));
}
