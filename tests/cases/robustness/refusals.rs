//! What no reader would take, what does not fit the machine, and pictures that show nothing.

use super::{LAMP, Place, ROOM, outdoors};
use crate::support::{command, expect_exit, job, run, scene};
use relume_bake::bundle;
use relume_bake::inspect;
use relume_bake::methods::asked::Asked;
use relume_bake::methods::choice::METHODS;
use relume_bake::unfinished::Leftover;
use std::process::Command;

#[test]
fn films_that_no_reader_takes_are_refused_before_the_bake() {
    let place = Place::of_case("film-size-not-checked");
    let stderr = place.bake(&["--size", "16384x16384"], 2);
    assert!(stderr.contains("16384x16384 pixels, an image holds at most 20336019; lower --size"), "{stderr}");
    let text = std::fs::read_to_string(place.at("scene/scene.toml")).unwrap();
    place.write("scene/scene.toml", text.replace("size = [64, 64]", "size = [16384, 16384]"));
    let stderr = place.bake(&[], 2);
    assert!(
        stderr.contains("[render]: size [16384, 16384]: a film has at most 20336019 pixels; lower it"),
        "{stderr}"
    );
    assert_eq!(place.names(""), ["scene"]);
}

#[test]
fn a_twist_too_short_for_its_keys_is_refused_and_the_shortest_is_played() {
    let place = Place::of_case("twist-too-short");
    let stderr = place.bake(&[], 2);
    assert!(
        stderr.contains("object `o`: twist_s 1e-300 must be at least 0.001 s and at most a day"),
        "{stderr}"
    );
    assert_eq!(place.names(""), ["scene"]);
    let text = std::fs::read_to_string(place.at("scene/scene.toml")).unwrap();
    place.write("scene/scene.toml", text.replace("1e-300", "0.001"));
    place.bake(&[], 0);
    expect_exit("bake", &["verify", &place.path("out")], 0);
}

#[cfg(target_os = "linux")]
#[test]
fn a_scene_too_large_is_refused_before_its_meshes_are_made() {
    let quad = |number: u32| {
        format!("[[object]]\nname = '{number}'\nshape = 'quad'\nsegments = 2048\nmaterial = 'clay'\n")
    };
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
    assert!(
        stderr.contains("object `1`: more than 11184810 triangles in the scene up to here; lower segments"),
        "{stderr}"
    );
}

/// A picture that shows nothing has no error.
#[test]
fn black_pictures_have_no_figure() {
    let inside = |text: String| text.replace("position = [0.0, 1.0, 3.0]", "position = [0.0, 0.1, 0.0]");
    let away = "1.0], rotation_deg = [90.0, 0.0, 0.0] }\n";
    let area = ROOM.replace("'point'", "'area'").replace("intensity", "radiance");
    let below = ROOM.replace("[0.0, 1.0, 3.0]", "[0.0, -3.0, 3.0]").replace("scale = 4.0", "scale = 100.0");
    // What, whether it is black, whether there is a figure: of the rows of vertices there is one wherever the
    // camera is.
    let cases = [
        ("the room", ROOM.to_owned(), false, true),
        (
            "black materials that vary",
            ROOM.replace("brdf = 'blinn-phong'", "brdf = 'blinn-phong'\n    kd = [0, 0, 0]"),
            false,
            true,
        ),
        ("camera inside the ball", inside(ROOM.to_owned()), true, false),
        ("camera below the floor", below, true, false),
        ("lamp that emits nothing", ROOM.replace("[10.0, 10.0, 10.0]", "[0.0, 0.0, 0.0]"), true, false),
        ("lamp that faces away", area.replace("1.0] }\n", away), true, false),
        ("no light", ROOM.replace(LAMP, ""), true, false),
        ("under a sky", outdoors(), false, true),
        ("sky of gain 0", outdoors().replace("[environment]", "[environment]\ngain = [0, 0, 0]"), true, true),
        ("camera inside the ball, under a sky", inside(outdoors()), true, true),
    ];
    for (what, text, is_black, has_figure) in cases {
        let (place, scene) = (Place::of(&text), scene(&text));
        let method = METHODS[usize::from(scene.vary.light)];
        let asked = Asked { samples: Some(4), bases: Some(2), terms: Some(4), ..Asked::of_scene(&scene) };
        let out = place.at("out");
        let (summary, _) = bundle::run(
            &scene,
            &[(method.new)(&asked, &scene)],
            scene.size,
            &out,
            Leftover::Refuse,
            0,
            &job(),
        )
        .unwrap();
        let errors = &summary.methods[0].entry.errors;
        assert_eq!(
            (summary.is_black, errors.contains_key("relative_l2_worst")),
            (is_black, has_figure),
            "{what}: {errors:?}"
        );
        inspect::verify(&out).unwrap();
    }
}

#[test]
fn black_pictures_are_told_of() {
    let text = ROOM.replace("position = [0.0, 1.0, 3.0]", "position = [0.0, 0.1, 0.0]");
    let place = Place::of(&text);
    let said = place.printed(&["--spp", "4", "--bases", "2"]);
    assert!(
        said.contains("warning: ")
            && said.contains("the picture is black, no light reaches what the camera sees"),
        "{said}"
    );
    assert!(
        said.contains("no error figure: the picture is black")
            && !said.contains("error over held-out states"),
        "{said}"
    );
    let info = String::from_utf8(run("bake", &["info", &place.path("out")]).stdout).unwrap();
    assert!(info.contains("errors    none, for nothing that was compared is lit"), "{info}");
    place.write("scene/scene.toml", outdoors().replace("[environment]", "[environment]\ngain = [0, 0, 0]"));
    let said = place.printed(&["--spp", "1", "--terms", "4"]);
    assert!(said.contains("the picture is black, no light reaches what the camera sees"), "{said}");
    assert!(
        said.contains("no error figure: the picture is black")
            && !said.contains("error over held-out states"),
        "{said}"
    );
}

#[test]
fn a_bake_that_takes_more_memory_than_it_may_is_refused_at_once() {
    let place = Place::of(ROOM);
    let stderr = place.bake(&["--memory", "0.1", "--size", "512x512"], 2);
    assert!(
        stderr.contains("MiB of memory and 102 MiB are allowed by --memory; lower --size or --bases"),
        "{stderr}"
    );
    assert_eq!(place.names(""), ["scene"]);
    place.bake(&["--memory", "8", "--spp", "1", "--bases", "2"], 0);
    place.bake(&["--memory", "-1"], 2);
}
