//! Mistakes in scenes, states, animations and command lines: key, line and remedy.
//!
//! What is expected stands in docs/notes/MESSAGES.md, word for word, so that the notes show what is really printed.

use crate::support::{command, run};
use relume_formats::Place;
use relume_formats::state::{State, with_line};
use std::path::Path;

const TABLE: &str = include_str!("../../docs/notes/MESSAGES.md");

const SCENE: &str = r#"[vary]
materials = ["paint"]
[render]
size = [64, 64]
[camera]
position = [0.0, 1.2, 4.0]
target = [0.0, 0.5, 0.0]
fov_deg = 40.0
[materials.paint]
brdf = "blinn-phong"
kd = [0.6, 0.6, 0.6]
ks = [0.1, 0.1, 0.1]
shininess = 20.0
[materials.steel]
brdf = "ggx"
metallic = 1.0
roughness = 0.4
[[object]]
name = "floor"
shape = "quad"
material = "paint"
[[object]]
name = "ball"
shape = "sphere"
material = "steel"
transform = { translation = [0.0, 1.0, 0.0], scale = 0.5 }
[[light]]
name = "lamp"
kind = "point"
intensity = [10.0, 10.0, 10.0]
transform = { translation = [0.0, 3.0, 1.0] }
[environment]
file = "maps/Studio.hdr"
"#;

/// What is mistaken, and what stands instead of what in the scene.
const IN_SCENES: &[(&str, &str, &str)] = &[
    ("`[light]` for `[[light]]`", "[[light]]", "[light]"),
    ("`[object]` for `[[object]]`", "[[object]]\nname = \"floor\"", "[object]\nname = \"floor\""),
    ("`[[materials]]` for `[materials.NAME]`", "[materials.paint]", "[[materials]]"),
    ("`[[vary]]` for `[vary]`", "[vary]", "[[vary]]"),
    ("`[lights]` for `[[light]]`", "[[light]]", "[[lights]]"),
    ("`[materiels.paint]`", "[materials.paint]", "[materiels.paint]"),
    ("no name for a material", "[materials.paint]", "[materials]"),
    ("a decimal comma", "fov_deg = 40.0", "fov_deg = 40,0"),
    ("decimal commas in a list", "kd = [0.6, 0.6, 0.6]", "kd = [0,6, 0,6, 0,6]"),
    ("one number for three", "kd = [0.6, 0.6, 0.6]", "kd = 0.6"),
    ("a colour as in CSS", "kd = [0.6, 0.6, 0.6]", "kd = \"#cc8844\""),
    ("a colour as in CSS, without quotes", "kd = [0.6, 0.6, 0.6]", "kd = #cc8844"),
    ("a list that is too long", "size = [64, 64]", "size = [64, 64, 64]"),
    ("a list that is too short", "position = [0.0, 1.2, 4.0]", "position = [0.0, 1.2]"),
    ("a colour with alpha", "kd = [0.6, 0.6, 0.6]", "kd = [0.6, 0.6, 0.6, 1.0]"),
    ("a number in quotes", "fov_deg = 40.0", "fov_deg = \"40\""),
    ("a number that begins with a point", "ks = [0.1, 0.1, 0.1]\nshininess = 20.0", "ks = [0.1, 0.1, 0.1]\nshininess = .9"),
    ("true in quotes", "[vary]", "[vary]\nlight = \"true\""),
    ("True with a capital", "[vary]", "[vary]\nlight = True"),
    ("yes for true", "[vary]", "[vary]\nlight = yes"),
    ("1 for true", "[vary]", "[vary]\nlight = 1"),
    ("a float where a whole number belongs", "size = [64, 64]", "size = [64.0, 64.0]"),
    ("a negative size", "size = [64, 64]", "size = [-64, 64]"),
    ("a text for a list", "materials = [\"paint\"]", "materials = \"paint\""),
    ("a list of two for a scale", "scale = 0.5", "scale = [0.5, 0.5]"),
    ("a misspelt key", "shininess = 20.0", "shinines = 20.0"),
    ("a key cut short", "fov_deg = 40.0", "fov = 40.0"),
    ("a key in capitals", "kd = [0.6", "KD = [0.6"),
    ("a key that is not there", "fov_deg = 40.0", "fov_deg = 40.0\naperture = 2.8"),
    ("a key in the wrong table", "shape = \"quad\"", "shape = \"quad\"\nkd = [0.5, 0.5, 0.5]"),
    ("a camera's key above the first table", "[vary]", "fov_deg = 40.0\n[vary]"),
    ("a key twice", "shininess = 20.0", "shininess = 20.0\nshininess = 30.0"),
    ("a key that is missing", "name = \"ball\"\n", ""),
    ("a table that is missing", "[render]\nsize = [64, 64]\n", ""),
    ("a colon for an equals sign", "fov_deg = 40.0", "fov_deg: 40.0"),
    ("a semicolon at the end", "fov_deg = 40.0", "fov_deg = 40.0;"),
    ("typographic quotation marks", "name = \"ball\"", "name = “ball”"),
    ("a typographic minus", "target = [0.0, 0.5, 0.0]", "target = [0.0, −0.5, 0.0]"),
    ("a name without quotes", "kind = \"point\"", "kind = point"),
    ("a misspelt model", "brdf = \"blinn-phong\"", "brdf = \"phong\""),
    ("a misspelt kind of light", "kind = \"point\"", "kind = \"piont\""),
    ("a misspelt shape", "shape = \"quad\"", "shape = \"plane\""),
    ("another model's key", "shininess = 20.0", "shininess = 20.0\nroughness = 0.3"),
    ("a roughness too small for any material", "roughness = 0.4", "roughness = 0.1"),
    (
        "a roughness too small for one that varies",
        "materials = [\"paint\"]",
        "materials = [\"rough\"]\n[materials.rough]\nbrdf = \"ggx\"\nroughness = 0.2",
    ),
    ("a shininess below 1", "shininess = 20.0", "shininess = 0.9"),
    ("more light than arrives", "ks = [0.1, 0.1, 0.1]", "ks = [0.5, 0.5, 0.5]"),
    ("the wrong quantity of a light", "intensity = [10.0", "radiance = [10.0"),
    ("an unknown material", "material = \"steel\"", "material = \"stel\""),
    ("an unknown material that varies", "materials = [\"paint\"]", "materials = [\"pain\"]"),
    ("two objects of one name", "name = \"ball\"", "name = \"floor\""),
    ("another shape's key", "shape = \"quad\"", "shape = \"quad\"\nsubdivisions = 3"),
    ("a camera that looks nowhere", "target = [0.0, 0.5, 0.0]", "target = [0.0, 1.2, 4.0]"),
    ("a file name in the wrong case", "maps/Studio.hdr", "maps/studio.hdr"),
    ("a folder in the wrong case, a name misspelt", "maps/Studio.hdr", "Maps/Studo.hdr"),
    ("another format's ending", "maps/Studio.hdr", "maps/Studio.exr"),
    ("a file that is not there", "maps/Studio.hdr", "sunset.hdr"),
    ("a folder for a file", "maps/Studio.hdr", "old.hdr"),
    ("a picture that is no map", "maps/Studio.hdr", "wood.png"),
    ("a misspelt sky", "file = \"maps/Studio.hdr\"", "file = \"clear-skies\""),
    ("a misspelt texture", "shininess = 20.0", "shininess = 20.0\ntexture = \"wod.png\""),
];

/// What is mistaken, and a state.
const IN_STATES: &[(&str, &str)] = &[
    ("`[material.NAME]`", "[material.paint]\nkd = [0.5, 0.5, 0.5]\n"),
    ("a number for a colour", "[materials.paint]\nkd = 0.5\n"),
    ("a list that is too long in a state", "[materials.paint]\nkd = [0.5, 0.5, 0.5, 1.0]\n"),
    ("an unknown name", "[camera]\nfov_deg = 30.0\n[materials.pain]\nkd = [0.5, 0.5, 0.5]\n"),
    ("an unknown light", "[lights.lam]\ngain = [2.0, 2.0, 2.0]\n"),
    ("another model's key in a state", "[materials.paint]\nroughness = 0.5\n"),
    ("a value out of its range", "[camera]\nexposure_ev = 1.0\nfov_deg = 180.0\n"),
    ("a misspelt map", "[environment]\nmap = \"studio.hdr\"\n"),
    ("a key outside its table", "kd = [0.5, 0.5, 0.5]\n"),
];

/// What is mistaken, and an animation.
const IN_ANIMATIONS: &[(&str, &str)] = &[
    ("`[key]` for `[[key]]`", "duration_s = 1\n[key]\nt_s = 0\nmaterials.paint.shininess = 3\n"),
    ("a key without a time", "duration_s = 1\n[[key]]\nmaterials.paint.shininess = 3\n"),
    ("a time in quotes", "duration_s = 1\n[[key]]\nt_s = \"0.5\"\nmaterials.paint.shininess = 3\n"),
    ("no duration", "[[key]]\nt_s = 0\nmaterials.paint.shininess = 3\n"),
    (
        "times that go back",
        "duration_s = 2\n[[key]]\nt_s = 1\nmaterials.paint.shininess = 3\n[[key]]\nt_s = 0.5\nmaterials.paint.shininess = 4\n",
    ),
    (
        "two values at one time",
        "duration_s = 2\n[[key]]\nt_s = 1\nmaterials.paint.shininess = 3\n[[key]]\nt_s = 1\nmaterials.paint.shininess = 4\n",
    ),
    ("a key after the end", "duration_s = 2\n[[key]]\nt_s = 3\nmaterials.paint.shininess = 3\n"),
    ("an animation of nothing", "duration_s = 2\nloop = true\n"),
    ("a misspelt key of an animation", "duration_s = 2\nlooping = true\n[[key]]\nt_s = 0\nmaterials.paint.shininess = 3\n"),
    (
        "a value out of its range at a key",
        "duration_s = 2\n[[key]]\nt_s = 0\nmaterials.paint.shininess = 3\n[[key]]\nt_s = 1.5\nmaterials.paint.shininess = 300\n",
    ),
    ("an unknown material in an animation", "duration_s = 2\n[[key]]\nt_s = 0\nmaterials.pant.shininess = 3\n"),
];

/// What is mistaken, and a command line in a folder with scene.toml and an empty folder `bundle`.
const IN_COMMANDS: &[(&str, &[&str])] = &[
    ("a misspelt command", &["bake", "rnu", "scene.toml"]),
    ("a misspelt scene file", &["bake", "plan", "scen.toml"]),
    ("a misspelt option", &["bake", "run", "scene.toml", "--quallity", "draft"]),
    ("a misspelt value", &["bake", "run", "scene.toml", "--quality", "drat"]),
    ("a misspelt method", &["bake", "run", "scene.toml", "--method", "sparse-transfers"]),
    ("one number for a size", &["bake", "run", "scene.toml", "--size", "64"]),
    ("words for a number", &["bake", "run", "scene.toml", "--spp", "many"]),
    ("a decimal comma on the command line", &["bake", "run", "scene.toml", "--max-error", "0,01"]),
    ("an error of nothing", &["bake", "run", "scene.toml", "--max-error", "0"]),
    ("another method's option", &["bake", "run", "scene.toml", "--terms", "20"]),
    ("a misspelt bundle", &["bake", "verify", "bundel"]),
    ("a folder that is no bundle", &["bake", "verify", "bundle"]),
    ("a misspelt file", &["bake", "info", "bundle.relum"]),
    ("a state that is not there", &["bake", "reference", "scene.toml", "--state", "stat.toml", "-o", "a.exr"]),
    ("another format for references", &["bake", "reference", "scene.toml", "-o", "a.png"]),
    ("no bundle for the player", &["player"]),
    ("a misspelt bundle for the player", &["player", "bundel", "--headless", "--frames", "a.png"]),
    ("words for frames a second", &["player", "bundle", "--fps", "fast"]),
    ("a misspelt option of the player", &["player", "bundle", "--headles"]),
];

/// A copy of a case's inputs, to work in.
pub(super) fn copy_of(case: &str) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    copy(&Path::new(env!("CARGO_MANIFEST_DIR")).join("cases/inputs").join(case), folder.path());
    folder
}

fn copy(from: &Path, to: &Path) {
    for entry in std::fs::read_dir(from).unwrap().map(|entry| entry.unwrap()) {
        let to = to.join(entry.file_name());
        if entry.path().is_dir() {
            std::fs::create_dir(&to).unwrap();
            copy(&entry.path(), &to);
        } else {
            std::fs::copy(entry.path(), &to).unwrap();
        }
    }
}

/// Runs a command line in `folder`, expects that exit code, and returns standard error.
pub(super) fn exits(code: i32, folder: &tempfile::TempDir, line: &[&str]) -> String {
    let output = command(line[0]).args(&line[1..]).current_dir(folder.path()).output().unwrap();
    let stderr = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(code), "{line:?}: {stderr}");
    stderr
}

/// A folder with the scene and what it names, and things with similar names.
fn workshop() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    for name in ["maps", "old.hdr", "bundle", "animations"] {
        std::fs::create_dir(folder.path().join(name)).unwrap();
    }
    let map = [b"#?RADIANCE\n\n-Y 1 +X 2\n".as_slice(), &[128, 128, 128, 129].repeat(2)].concat();
    std::fs::write(folder.path().join("maps/Studio.hdr"), map).unwrap();
    for (name, content) in [("wood.png", ""), ("scene.toml", SCENE), ("state.toml", ""), ("bundle.relume", "")] {
        std::fs::write(folder.path().join(name), content).unwrap();
    }
    folder
}

/// A message without where this machine keeps its folders.
fn plain(message: &str, folder: &Path) -> String {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap();
    [folder, root].iter().fold(message.to_owned(), |message, above| message.replace(&format!("{}/", above.display()), ""))
}

fn of_scene(folder: &Path, scene: &[u8]) -> String {
    std::fs::write(folder.join("scene.toml"), scene).unwrap();
    let message = relume_scenes::load(&folder.join("scene.toml")).map(|_| ()).unwrap_err().to_string();
    std::fs::write(folder.join("scene.toml"), SCENE).unwrap();
    plain(&message, folder)
}

/// By the steps of `bake reference --state`.
fn of_state(folder: &Path, state: &str) -> String {
    let path = folder.join("state.toml");
    std::fs::write(&path, state).unwrap();
    let scene = relume_scenes::load(&folder.join("scene.toml")).unwrap();
    let refused = State::read_file(&path).and_then(|state| scene.with_state(&state, &Place::file(&path)).map_err(with_line));
    plain(&refused.map(|_| ()).unwrap_err().to_string(), folder)
}

fn of_animation(folder: &Path, animation: &str) -> String {
    let path = folder.join("animations/turn.toml");
    std::fs::write(&path, animation).unwrap();
    let message = relume_scenes::load(&folder.join("scene.toml")).map(|_| ()).unwrap_err().to_string();
    std::fs::remove_file(path).unwrap();
    plain(&message, folder)
}

fn of_command(folder: &Path, line: &[&str]) -> String {
    let output = command(line[0]).args(&line[1..]).current_dir(folder).output().unwrap();
    let stderr = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(2), "{line:?}: {stderr}");
    assert_eq!(stderr.lines().count(), 1, "{line:?}: {stderr}");
    plain(stderr.trim_end().strip_prefix("error: ").unwrap(), folder)
}

/// Every mistake with its message.
fn all() -> Vec<(&'static str, String)> {
    let folder = workshop();
    let folder = folder.path();
    let mut rows = Vec::new();
    for (what, from, to) in IN_SCENES {
        assert!(SCENE.contains(from), "{what}");
        rows.push((*what, of_scene(folder, SCENE.replacen(from, to, 1).as_bytes())));
    }
    rows.push(("UTF-16 text", of_scene(folder, &SCENE.encode_utf16().flat_map(u16::to_le_bytes).collect::<Vec<_>>())));
    rows.push(("Latin-1 text", of_scene(folder, &[SCENE.as_bytes(), b"# f\xfcr\n"].concat())));
    rows.extend(IN_STATES.iter().map(|(what, state)| (*what, of_state(folder, state))));
    rows.extend(IN_ANIMATIONS.iter().map(|(what, animation)| (*what, of_animation(folder, animation))));
    rows.extend(IN_COMMANDS.iter().map(|(what, line)| (*what, of_command(folder, line))));
    rows
}

#[test]
fn mistakes_get_the_messages_of_the_notes() {
    let rows = all();
    let listed = TABLE.lines().filter(|line| line.starts_with("| ") && !line.starts_with("| mistake")).count();
    let row = |(what, message): &(&str, String)| format!("| {what} | {} |", message.replace('|', "\\|"));
    let missing: Vec<String> = rows.iter().map(row).filter(|row| !TABLE.lines().any(|line| line == row)).collect();
    assert!(missing.is_empty(), "not in docs/notes/MESSAGES.md:\n{}", missing.join("\n"));
    for (_, message) in &rows {
        // Words of the language that this is written in, and of the system.
        for word in ["f32", "u32", "f64", "tuple", "struct", "sequence", "NonZero", ".rs", "os error", "invalid type", "unexpected key"] {
            assert!(!message.contains(word), "`{word}` in {message}");
        }
    }
    assert_eq!(listed, rows.len(), "docs/notes/MESSAGES.md lists what nobody tried");
}

#[test]
fn a_byte_order_mark_tabs_and_line_ends_of_windows_are_no_mistakes() {
    let folder = workshop();
    let path = folder.path().join("scene.toml");
    std::fs::write(&path, format!("\u{feff}{}", SCENE.replace('\n', "\r\n").replace(" = ", "\t=\t"))).unwrap();
    let scene = relume_scenes::load(&path).unwrap();
    assert_eq!((scene.size, scene.camera.fov_deg, scene.objects.len()), ([64, 64], 40.0, 2));
}

#[test]
fn lists_that_are_too_long_are_refused() {
    let folder = copy_of("arrays-too-long");
    let stderr = exits(2, &folder, &["bake", "run", "scene.toml", "-o", "out"]);
    assert_eq!(stderr, "error: scene.toml: line 4, column 8: render.size: 3 numbers where 2 are expected; remove 1\n");
    assert!(!folder.path().join("out").exists());
}

#[test]
fn a_plan_lists_what_was_ignored_at_loading() {
    let folder = copy_of("plan-says-nothing-left-out");
    let plan = |more: &[&str]| {
        let scene = folder.path().join("scene.toml");
        let output = run("bake", &[&["plan", scene.to_str().unwrap()], more].concat());
        assert_eq!(output.status.code(), Some(0));
        let stderr = String::from_utf8(output.stderr).unwrap();
        let warnings: Vec<String> = stderr.lines().filter_map(|line| line.strip_prefix("warning: ")).map(str::to_owned).collect();
        (String::from_utf8(output.stdout).unwrap(), warnings)
    };
    let (text, warnings) = plan(&[]);
    assert_eq!(warnings.len(), 3, "BLEND, a normal map, vertex colours: {warnings:?}");
    let listed = text.split("not modelled:").nth(1).unwrap();
    let (json, _) = plan(&["--json"]);
    let json: serde_json::Value = serde_json::from_str(&json).unwrap();
    let list: Vec<&str> = json["not_modelled"].as_array().unwrap().iter().filter_map(|sentence| sentence.as_str()).collect();
    for warning in &warnings {
        assert!(listed.contains(warning.as_str()) && list.contains(&warning.as_str()), "{warning} is not in {listed}");
    }
}

/// Each method leaves out what the other plays, and says so; the bundle is sound.
#[test]
fn animations_of_other_methods_are_left_out() {
    let folder = copy_of("animation-not-of-the-method");
    let common = ["bake", "run", "scene.toml", "--spp", "1", "--size", "32x32", "--progress", "none", "-o"];
    for (method, choice, other, left_out, kept) in [
        ("transfer-images", ["--bases", "4"], "sparse-transfer", "turn", "paint"),
        ("sparse-transfer", ["--terms", "4"], "transfer-images", "paint", "turn"),
    ] {
        let stderr = exits(0, &folder, &[&common[..], &[method, "--method", method], &choice].concat());
        let warning = format!(
            "warning: animations/{left_out}.toml: {method} does not play this animation, {other} does; it is left out, add --method {other} to keep it\n"
        );
        assert!(stderr.contains(&warning), "{stderr}");
        exits(0, &folder, &["bake", "verify", method]);
        assert!(folder.path().join(method).join(format!("animation-{kept}.relume")).exists());
        assert!(!folder.path().join(method).join(format!("animation-{left_out}.relume")).exists());
    }
}
