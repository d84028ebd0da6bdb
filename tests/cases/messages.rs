//! Mistakes in scenes, states, animations and command lines: key, line and remedy.
//!
//! What is expected stands in docs/notes/MESSAGES.md, word for word, so that the notes show what is really
//! printed.

mod mistakes;

use crate::support::{command, copy_folder, run};
use mistakes::{IN_ANIMATIONS, IN_COMMANDS, IN_LOOKS, IN_SCENES, IN_STATES};
use relume_bake::probe::Probe;
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

/// A copy of a case's inputs, to work in.
pub(super) fn copy_of(case: &str) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    copy_folder(&Path::new(env!("CARGO_MANIFEST_DIR")).join("cases/inputs").join(case), folder.path());
    folder
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
    let photo = [b"#?RADIANCE\n\n-Y 2 +X 3\n".as_slice(), &[128, 128, 128, 129].repeat(6)].concat();
    std::fs::write(folder.path().join("photo.hdr"), photo).unwrap();
    let bright = SCENE.replace("size = [64, 64]", "size = [64, 64]\nreflections = 1000");
    for (name, content) in [
        ("wood.png", ""),
        ("scene.toml", SCENE),
        ("bright.toml", &bright),
        ("state.toml", ""),
        ("bundle.relume", ""),
        ("ball.obj", ""),
        ("page.exr", "<!DOCTYPE html>\n<title>not found</title>\n"),
        ("picture.exr", "GIF89a"),
        ("radiance.exr", "#?RADIANCE\n"),
        ("empty.hdr", ""),
    ] {
        std::fs::write(folder.path().join(name), content).unwrap();
    }
    folder
}

/// A message without where this machine keeps its folders.
fn plain(message: &str, folder: &Path) -> String {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap();
    [folder, root]
        .iter()
        .fold(message.to_owned(), |message, above| message.replace(&format!("{}/", above.display()), ""))
}

fn of_scene(folder: &Path, scene: &[u8]) -> String {
    std::fs::write(folder.join("scene.toml"), scene).unwrap();
    let message = relume_scenes::load(&folder.join("scene.toml")).map(|_| ()).unwrap_err().to_string();
    std::fs::write(folder.join("scene.toml"), SCENE).unwrap();
    plain(&message, folder)
}

/// What a look at the scene warns of first.
fn of_look(folder: &Path, what: &str, scene: &str) -> String {
    std::fs::write(folder.join("scene.toml"), scene).unwrap();
    let scene = relume_scenes::load(&folder.join("scene.toml")).unwrap();
    let warnings = Probe::new(&scene, scene.size).unwrap().warnings();
    std::fs::write(folder.join("scene.toml"), SCENE).unwrap();
    plain(warnings.first().unwrap_or_else(|| panic!("{what}: no warning")), folder)
}

/// By the steps of `bake reference --state`.
fn of_state(folder: &Path, state: &str) -> String {
    let path = folder.join("state.toml");
    std::fs::write(&path, state).unwrap();
    let scene = relume_scenes::load(&folder.join("scene.toml")).unwrap();
    let refused = State::read_file(&path)
        .and_then(|state| scene.with_state(&state, &Place::file(&path)).map_err(with_line));
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
    rows.push((
        "UTF-16 text",
        of_scene(folder, &SCENE.encode_utf16().flat_map(u16::to_le_bytes).collect::<Vec<_>>()),
    ));
    rows.push(("Latin-1 text", of_scene(folder, &[SCENE.as_bytes(), b"# f\xfcr\n"].concat())));
    for (what, from, to) in IN_LOOKS {
        assert!(SCENE.contains(from), "{what}");
        rows.push((*what, of_look(folder, what, &SCENE.replacen(from, to, 1))));
    }
    rows.extend(IN_STATES.iter().map(|(what, state)| (*what, of_state(folder, state))));
    rows.extend(IN_ANIMATIONS.iter().map(|(what, animation)| (*what, of_animation(folder, animation))));
    rows.extend(IN_COMMANDS.iter().map(|(what, line)| (*what, of_command(folder, line))));
    rows
}

#[test]
fn mistakes_get_the_messages_of_the_notes() {
    let rows = all();
    let listed =
        TABLE.lines().filter(|line| line.starts_with("| ") && !line.starts_with("| mistake")).count();
    let row = |(what, message): &(&str, String)| format!("| {what} | {} |", message.replace('|', "\\|"));
    let missing: Vec<String> =
        rows.iter().map(row).filter(|row| !TABLE.lines().any(|line| line == row)).collect();
    assert!(missing.is_empty(), "not in docs/notes/MESSAGES.md:\n{}", missing.join("\n"));
    for (_, message) in &rows {
        // Words of the language that this is written in, and of the system.
        for word in [
            "f32",
            "u32",
            "f64",
            "tuple",
            "struct",
            "sequence",
            "NonZero",
            ".rs",
            "os error",
            "invalid type",
            "unexpected key",
        ] {
            assert!(!message.contains(word), "`{word}` in {message}");
        }
    }
    assert_eq!(listed, rows.len(), "docs/notes/MESSAGES.md lists what nobody tried");
}

#[test]
fn a_byte_order_mark_tabs_and_line_ends_of_windows_are_no_mistakes() {
    let folder = workshop();
    let path = folder.path().join("scene.toml");
    std::fs::write(&path, format!("\u{feff}{}", SCENE.replace('\n', "\r\n").replace(" = ", "\t=\t")))
        .unwrap();
    let scene = relume_scenes::load(&path).unwrap();
    assert_eq!((scene.size, scene.camera.fov_deg, scene.objects.len()), ([64, 64], 40.0, 2));
}

#[test]
fn lists_that_are_too_long_are_refused() {
    let folder = copy_of("arrays-too-long");
    let stderr = exits(2, &folder, &["bake", "run", "scene.toml", "-o", "out"]);
    assert_eq!(
        stderr,
        "error: scene.toml: line 4, column 8: render.size: 3 numbers where 2 are expected; remove 1\n"
    );
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
        let warnings: Vec<String> =
            stderr.lines().filter_map(|line| line.strip_prefix("warning: ")).map(str::to_owned).collect();
        (String::from_utf8(output.stdout).unwrap(), warnings)
    };
    let (text, warnings) = plan(&[]);
    assert_eq!(warnings.len(), 3, "BLEND, a normal map, vertex colours: {warnings:?}");
    let listed = text.split("not modelled:").nth(1).unwrap();
    let (json, _) = plan(&["--json"]);
    let json: serde_json::Value = serde_json::from_str(&json).unwrap();
    let list: Vec<&str> =
        json["not_modelled"].as_array().unwrap().iter().filter_map(|sentence| sentence.as_str()).collect();
    for warning in &warnings {
        assert!(
            listed.contains(warning.as_str()) && list.contains(&warning.as_str()),
            "{warning} is not in {listed}"
        );
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
