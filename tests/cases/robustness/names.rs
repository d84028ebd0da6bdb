//! Names that lead out of a folder, steer a terminal, or never end.

use super::{Place, ROOM};
use crate::support::run;

#[test]
fn nothing_is_written_outside_the_folder_whatever_objects_are_called() {
    let place = Place::of_case("shape-name-traversal");
    std::fs::create_dir_all(place.at("out/unfinished/shape-x")).unwrap();
    let stderr = place.bake(&["--max-error", "10"], 2);
    assert!(
        stderr.contains("object `x/../../../ESCAPED`: the name of an object that deforms has only a-z A-Z 0-9 . _ - and blanks"),
        "{stderr}"
    );
    assert_eq!(place.names(""), ["out", "scene"]);
    assert_eq!(
        (place.names("out"), place.names("out/unfinished")),
        (vec!["unfinished".to_owned()], vec!["shape-x".to_owned()])
    );
    let text = std::fs::read_to_string(place.at("scene/scene.toml")).unwrap();
    for (name, reason) in [
        ("..", "has only a-z"),
        ("/etc/x", "has only a-z"),
        ("a\\\\b", "has only a-z"),
        ("é", "has only a-z"),
        ("\\u001b[2J", "`\\u{1b}[2J`: its name has the control character \\u{1b}; remove it"),
        ("a\\nb", "`a\\nb`: its name has the control character"),
        ("\\u202Ex", "`\\u{202e}x`: its name has the control character"),
        ("", "its name is empty"),
        (&"n".repeat(190), "its name is longer than 128 characters"),
        (&"n".repeat(300_000), "its name is longer than 128 characters"),
    ] {
        place.write("scene/scene.toml", text.replace("x/../../../ESCAPED", name));
        let stderr = place.bake(&["--max-error", "10"], 2);
        assert!(
            stderr.contains(reason)
                && stderr.len() < 600
                && !stderr.contains('\u{1b}')
                && stderr.lines().count() == 1,
            "{stderr}"
        );
    }
    assert_eq!(place.names(""), ["out", "scene"]);
}

#[test]
fn names_of_materials_lights_and_references_are_bounded() {
    let long = "y".repeat(200_000);
    for (from, to, reason) in [
        ("[materials.clay]", format!("[materials.{long}]"), "material `yyyy"),
        ("[materials.clay]", "[materials.\"a\\nb\"]".to_owned(), "material `a\\nb`"),
        ("'lamp'", format!("'{long}'"), "light `yyyy"),
        ("'lamp'", "\"\\u009b2J\"".to_owned(), "light `\\u{9b}2J`"),
        ("['clay']", format!("['{long}']"), "no material `yyyy"),
        ("material = 'clay'", format!("material = '{long}'"), "no material `yyyy"),
    ] {
        assert!(ROOM.contains(from));
        let stderr = Place::of(&ROOM.replacen(from, &to, 1)).bake(&[], 2);
        assert!(stderr.contains(reason) && stderr.len() < 600 && !stderr.contains('\u{9b}'), "{stderr}");
    }
}

/// What a hostile bundle says of itself is printed, and does nothing.
#[test]
fn info_cannot_steer_a_terminal() {
    let place = Place::of(ROOM);
    place.bake(&["--spp", "1", "--bases", "2"], 0);
    let manifest = std::fs::read_to_string(place.at("out/manifest.json")).unwrap();
    for (from, to) in [
        ("\"samples\"", "\"sam\\u001b[2Jples\""),
        ("\"relative_l2_median\"", "\"a\\u202eb\\u009b\""),
        ("\"scene\": \"scene\"", "\"scene\": \"s\\u001b]0;x\\u0007\""),
    ] {
        assert!(manifest.contains(from), "{manifest}");
        place.write("out/manifest.json", manifest.replace(from, to));
        for more in [&[][..], &["--json"]] {
            let output = run("bake", &[&["info", &place.path("out")], more].concat());
            let said = format!(
                "{}{}",
                String::from_utf8_lossy(&output.stdout),
                String::from_utf8_lossy(&output.stderr)
            );
            assert!(!said.chars().any(|c| (c.is_control() && c != '\n') || c == '\u{202e}'), "{said:?}");
            assert!(said.contains("1b}") || said.contains("\\u001b") || said.contains("202e"), "{said}");
        }
    }
}
