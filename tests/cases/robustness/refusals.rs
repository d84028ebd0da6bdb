//! What no reader would take, what does not fit the machine, and pictures that show nothing.

use super::{LAMP, Place, ROOM, outdoors};
use crate::support::{command, expect_exit, run};
use std::process::Command;

#[test]
fn films_that_no_reader_takes_are_refused_before_the_bake() {
    let place = Place::of_case("film-size-not-checked");
    let stderr = place.bake(&["--size", "16384x16384"], 2);
    assert!(stderr.contains("16384x16384 pixels, an image holds at most 20336019; lower --size"), "{stderr}");
    let text = std::fs::read_to_string(place.at("scene/scene.toml")).unwrap();
    place.write("scene/scene.toml", text.replace("size = [64, 64]", "size = [16384, 16384]"));
    let stderr = place.bake(&[], 2);
    assert!(stderr.contains("[render]: size [16384, 16384]: a film has at most 20336019 pixels; lower it"), "{stderr}");
    assert_eq!(place.names(""), ["scene"]);
}

#[test]
fn a_twist_too_short_for_its_keys_is_refused_and_the_shortest_is_played() {
    let place = Place::of_case("twist-too-short");
    let stderr = place.bake(&[], 2);
    assert!(stderr.contains("object `o`: twist_s 1e-300 must be at least 0.001 s and at most a day"), "{stderr}");
    assert_eq!(place.names(""), ["scene"]);
    let text = std::fs::read_to_string(place.at("scene/scene.toml")).unwrap();
    place.write("scene/scene.toml", text.replace("1e-300", "0.001"));
    place.bake(&[], 0);
    expect_exit("bake", &["verify", &place.path("out")], 0);
}

#[cfg(target_os = "linux")]
#[test]
fn a_scene_too_large_is_refused_before_its_meshes_are_made() {
    let quad = |number: u32| format!("[[object]]\nname = '{number}'\nshape = 'quad'\nsegments = 2048\nmaterial = 'clay'\n");
    let place = Place::of(&format!("{ROOM}{}", (0..40).map(quad).collect::<String>()));
    // Two GB do for the program, not for a tenth of the meshes.
    let output = Command::new("sh")
        .args(["-c", "ulimit -v 2000000; exec \"$0\" \"$@\""])
        .arg(command("bake").get_program())
        .args(place.arguments(&["--threads", "1"]))
        .output()
        .unwrap();
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{stderr}");
    assert!(stderr.contains("object `1`: more than 11184810 triangles in the scene up to here; lower segments"), "{stderr}");
}

/// A picture that shows nothing has no error, and the user is told.
#[test]
fn black_pictures_are_told_of_and_have_no_figure() {
    let spheres = |text: String| text.replace("shape = 'sphere'", "spheres = 1\n    shape = 'sphere'");
    let inside = |text: String| text.replace("position = [0.0, 1.0, 3.0]", "position = [0.0, 0.1, 0.0]");
    let (images, rows, shadows) = (["--spp", "4", "--bases", "2"], ["--spp", "1", "--terms", "4"], ["--method", "sphere-shadows"]);
    let cases: [(&str, String, &[&str]); 8] = [
        ("camera inside the ball", inside(ROOM.to_owned()), &images),
        ("camera below the floor", ROOM.replace("[0.0, 1.0, 3.0]", "[0.0, -3.0, 3.0]").replace("scale = 4.0", "scale = 100.0"), &images),
        ("lamp that emits nothing", ROOM.replace("[10.0, 10.0, 10.0]", "[0.0, 0.0, 0.0]"), &images),
        (
            "lamp that faces away",
            ROOM.replace("'point'", "'area'")
                .replace("intensity", "radiance")
                .replace("1.0] }\n", "1.0], rotation_deg = [90.0, 0.0, 0.0] }\n"),
            &images,
        ),
        ("no light", ROOM.replace(LAMP, ""), &images),
        ("sky of gain 0", outdoors().replace("[environment]", "[environment]\ngain = [0, 0, 0]"), &rows),
        ("camera inside the ball, under a sky", inside(outdoors()), &rows),
        ("camera inside the ball, with shadows of spheres", spheres(inside(outdoors())), &shadows),
    ];
    for (what, text, settings) in cases {
        let place = Place::of(&text);
        let said = place.printed(settings);
        assert!(
            said.contains("warning: ") && said.contains("the picture is black, no light reaches what the camera sees"),
            "{what}: {said}"
        );
        assert!(said.contains("no error figure: the picture is black") && !said.contains("error over held-out states"), "{what}: {said}");
        expect_exit("bake", &["verify", &place.path("out")], 0);
        if settings == images {
            let info = String::from_utf8(run("bake", &["info", &place.path("out")]).stdout).unwrap();
            assert!(info.contains("errors    none, for nothing that was compared is lit"), "{what}: {info}");
        }
    }
    // Black materials that vary are something else: light reaches them.
    let said = Place::of(&ROOM.replace("brdf = 'blinn-phong'", "brdf = 'blinn-phong'\n    kd = [0, 0, 0]")).printed(&images);
    assert!(said.contains("error over held-out states: median ") && !said.contains("black"), "{said}");
    let said = Place::of(ROOM).printed(&images);
    assert!(said.contains("error over held-out states: median ") && !said.contains("black"), "{said}");
}

#[test]
fn a_bake_that_takes_more_memory_than_it_may_is_refused_at_once() {
    let place = Place::of(ROOM);
    let stderr = place.bake(&["--memory", "0.001"], 1);
    assert!(stderr.contains("MiB of memory and 1 MiB are allowed by --memory; lower --size or --bases"), "{stderr}");
    assert_eq!(place.names(""), ["scene"]);
    place.bake(&["--memory", "8", "--spp", "1", "--bases", "2"], 0);
    place.bake(&["--memory", "-1"], 2);
}
