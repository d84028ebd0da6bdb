//! Writes sound files and texts into the corpus of every target, for the fuzzer to start from.

use relume_formats::container::Stored;
use relume_formats::kinds::{HaarTable, VisibilityTable};
use relume_formats::state::Model;
use relume_formats_fuzz::raw_file::RawFile;
use relume_formats_fuzz::{recipe, write};
use std::path::Path;

#[allow(missing_docs, reason = "a module of the tests")]
#[path = "../../tests/support/relighting.rs"]
mod relighting;
#[allow(dead_code, missing_docs, reason = "a module of the tests")]
#[path = "../../tests/support/samples.rs"]
mod samples;
#[allow(missing_docs, reason = "a module of the tests")]
#[path = "../../tests/support/scenes.rs"]
mod scenes;
#[allow(missing_docs, reason = "a module of the tests")]
#[path = "../../tests/support/shadows.rs"]
mod shadows;
#[allow(missing_docs, reason = "a module of the tests")]
#[path = "../../tests/support/shapes.rs"]
mod shapes;
#[allow(missing_docs, reason = "a module of the tests")]
#[path = "../../tests/support/spheres.rs"]
mod spheres;
#[allow(missing_docs, reason = "a module of the tests")]
#[path = "../../tests/support/tensors.rs"]
mod tensors;

const STATE: &str = r#"
environment = { map = "sky.exr", rotation_deg = 30.0, gain = [1.0, 1.0, 1.0] }
camera = { position = [0.0, 1.0, 4.0], target = [0.0, 1.0, 0.0], fov_deg = 40.0, exposure_ev = 0.0 }
view.tonemap = "agx"
[lights.ceiling]
gain = [1.0, 1.0, 1.0]
[materials.a]
kd = [0.2, 0.2, 0.2]
ks = [0.4, 0.4, 0.4]
shininess = 50.0
[materials.b]
base_color = [0.2, 0.2, 0.2]
metallic = 0.0
roughness = 0.5
[shapes.fox]
clip = "Walk"
time_s = 0.4
"#;

const ANIMATION: &str = r#"
duration_s = 4.0
loop = true
[[key]]
t_s = 0.5
materials.a.kd = [0.8, 0.0, 0.0]
materials.b.base_color = [0.8, 0.0, 0.0]
camera.exposure_ev = -2
view.tonemap = "clamp"
[[key]]
t_s = 3
materials.a.kd = [0.8, 0.0, 0.0]
materials.b.roughness = 1
shapes.fox.clip = "Walk"
"#;

const MANIFEST: &str = r#"{
    "version": 0, "scene": "box", "scene_hash": "00",
    "scene_file": {"file": "scene.relume", "bytes": 1, "hash": "00"},
    "animations": {"turn": {"file": "turn.relume", "bytes": 1, "hash": "00"}},
    "methods": [{"name": "transfer-images", "files": [["brdf-basis", {"file": "basis.relume", "bytes": 1, "hash": "00"}]],
                 "settings": {"bases": 6}, "errors": {"relative_l2": 0.001}}]
}"#;

fn seed(target: &str, name: &str, content: &[u8]) -> std::io::Result<()> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("corpus").join(target);
    std::fs::create_dir_all(&folder)?;
    std::fs::write(folder.join(name), content)
}

/// As a file and as a recipe.
fn seed_kind(target: &str, number: u64, value: &impl Stored) -> std::io::Result<()> {
    let file = write(value);
    seed(target, &format!("file-{number}"), &[&[1], &file[..]].concat())?;
    seed(target, &format!("recipe-{number}"), &[&[0], &recipe::of(&RawFile::parse(&file))[..]].concat())
}

fn main() -> std::io::Result<()> {
    for number in 0..6 {
        seed_kind("scene", number, &scenes::scene(number))?;
        seed_kind("animation", number, &scenes::animation(number))?;
        seed_kind("brdf_basis", number, &samples::ggx_basis(number, 2 + number as usize, 3))?;
        let grooves = samples::cook_torrance_basis(number, 2 + number as usize, 3);
        seed_kind("brdf_basis", 6 + number, &grooves)?;
        let model = [Model::BlinnPhong, Model::Ggx, Model::CookTorrance][number as usize % 3];
        let tensor = tensors::tensor(number, model, [1 + number as usize % 2, 2, 2]);
        seed("brdf_tensor", &format!("file-{number}"), &[&[1], &write(&tensor)[..]].concat())?;
        seed_kind(
            "transfer_images",
            number,
            &samples::images(number, 1 + number as usize % 2, 2, number % 2 == 0, [3, 2]),
        )?;
        seed_kind("environment", number, &relighting::environment(number, number % 2 == 0))?;
        seed_kind("textures", number, &relighting::textures(number))?;
        seed_kind(
            "sparse_transfer",
            number,
            &relighting::rows(number, 3, 4, number % 2 == 0, &[(1, true), (2, false)]),
        )?;
        seed_kind(
            "sphere_set",
            number,
            &spheres::sphere_set(number, 4, 4 + number as usize, 1 + number as usize, 0.5),
        )?;
        seed_kind("shape", number, &shapes::shape(number, number as usize))?;
    }
    seed("haar_table", "file", &[&[1], &write(&HaarTable::bake())[..]].concat())?;
    // Its lobes are longer than what a recipe makes, and true ones longer than what a fuzzer tries.
    let mut dark = shadows::sphere_shadows(1, &[3, 2, 1], 2);
    dark.lobes.fill(0.0);
    let dark = dark.to_bytes_unchecked(relume_formats::Place::file("seed")).map_err(std::io::Error::other)?;
    seed("sphere_shadows", "file", &[&[1], &dark[..]].concat())?;
    // The whole file is longer than what a fuzzer tries; a byte repeated has the shape at least.
    let mut visibility = RawFile::parse(&write(&VisibilityTable::bake()));
    visibility.sections.iter_mut().for_each(|section| section.set_raw(&[32]));
    seed("visibility_table", "recipe", &[&[0], &recipe::of(&visibility)[..]].concat())?;
    // Its table repeats a few bytes, so the recipe may as well be short.
    let mut smooth = RawFile::parse(&write(&samples::basis(1, 2, true)));
    let lobes = smooth.sections.iter_mut().find(|s| s.name == "lobes");
    let shape = lobes.as_ref().map(|s| s.shape.clone()).unwrap_or_default();
    if let Some(lobes) = lobes {
        lobes.set_raw(&[0; 16]);
        lobes.shape = shape;
    }
    seed("brdf_basis", "recipe-lobes", &[&[0], &recipe::of(&smooth)[..]].concat())?;
    seed("state_toml", "state", STATE.as_bytes())?;
    seed("animation_toml", "animation", ANIMATION.as_bytes())?;
    seed("manifest", "manifest", MANIFEST.as_bytes())
}
