//! What is wrong in scenes, on command lines, in states and bundles is told on one line, and nothing
//! half-written is left.

use super::contents;
use crate::support::room::{ROOM, Workshop};
use crate::support::{command, expect_exit, run, write_scene};
use std::path::Path;

#[test]
fn mistakes_in_scenes_get_one_clear_line() {
    let w = Workshop::new();
    let obj = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
    w.write("nan.obj", &format!("{}f 1 2 3\n", obj.replace("v 1 0 0", "v nan 0 0")));
    w.write("empty.obj", obj);
    let object = |file: &str| ROOM.replace("shape = 'sphere'", &format!("file = '{file}'"));
    let cases = [
        (ROOM.replace("[vary]", "[vari]"), "did you mean `vary`"),
        (ROOM.replace("'ball', 'room'", "'bell', 'room'"), "`bell`"),
        (ROOM.replace("material = 'wall'", "material = 'well'"), "`well`"),
        (object("missing.obj"), "missing.obj"),
        (object("nan.obj"), "vertex"),
        (object("empty.obj"), "empty.obj"),
        (ROOM.replace("shininess = 20.0", "shininess = 500.0"), "outside 1..200"),
        (ROOM.replace("ks = [0.3, 0.3, 0.3]", "ks = [0.9, 0.9, 0.9]"), "exceeds 1"),
        (ROOM.replace("materials = ['ball', 'room']", "materials = []"), "nothing to bake"),
        (ROOM.replace("materials = ['ball', 'room']", "view = true"), "has no [environment]"),
        (ROOM.replace("reflections = 2", "reflections = 5"), "at most 2 or all"),
        (ROOM.replace("size = [48, 40]", "size = [0, 40]"), "size"),
        (ROOM.replace("size = [48, 40]", "size = [16000, 16000]"), "a film has at most"),
        (ROOM.replace("radiance = [10.0, 9.0, 8.0]", "radiance = [3e38, 9.0, 8.0]"), "radiance"),
    ];
    for (text, part) in cases {
        let scene = write_scene(w.folder.path(), &text);
        let stderr = expect_exit("bake", &["run", scene.to_str().unwrap(), "-o", &w.path("bad")], 2);
        assert!(stderr.contains(part), "{stderr} does not say {part}");
        assert!(!Path::new(&w.path("bad")).join("manifest.json").exists());
    }
    assert!(expect_exit("bake", &["run", &w.path("nowhere.toml")], 2).contains("nowhere.toml"));
    assert!(expect_exit("bake", &["run", "cornell-not"], 2).contains("cornell-knot"));
    expect_exit("bake", &["run"], 2);
    expect_exit("bake", &["run", "cornell-knot", "--size", "0x9"], 2);
    expect_exit("bake", &["bake-everything"], 2);
    expect_exit("bake", &["info", &w.path("nowhere")], 2);
    expect_exit("bake", &["reference", "cornell-knot", "-o", "x.jpg"], 2);
    expect_exit("bake", &["--help"], 0);
}

/// One sample has no halves that could tell its noise.
#[test]
fn noise_of_single_samples_is_told_to_be_unknown() {
    let w = Workshop::new();
    let arguments = ["run", &w.path("scene.toml"), "-o", &w.path("bundle"), "--spp", "1", "--bases", "2"];
    let said = String::from_utf8(run("bake", &arguments).stdout).unwrap();
    assert!(said.contains("noise over random states: not known"), "{said}");
}

#[test]
fn mistakes_at_playback_get_one_clear_line() {
    let w = Workshop::new();
    w.bake("bundle", &["--spp", "4", "--bases", "4"]);
    let bundle = w.path("bundle");
    let frame = w.path("frame.png");
    let play = |more: &[&str], code| {
        expect_exit("player", &[&[&bundle[..], "--headless", "--frames", &frame], more].concat(), code)
    };
    for (text, part) in [
        ("[materials.wall]\nkd = [0.1, 0.1, 0.1]\n", "`wall`"),
        ("[materials.bell]\nshininess = 3.0\n", "`bell`"),
        ("[lights.lamp]\ngain = [2.0, 2.0, 2.0]\n", "light `lamp`"),
        ("camera = { fov_deg = 20.0 }\n", "camera"),
        ("[materials.ball]\nshininess = 0.5\n", "outside 1..200"),
        ("[materials.ball]\nshinyness = 5.0\n", "did you mean `shininess`"),
    ] {
        let state = w.write("state.toml", text);
        let stderr = play(&["--state", &state], 2);
        assert!(stderr.contains(part), "{stderr} does not say {part}");
    }
    assert!(play(&["--animation", "shin"], 2).contains("shine"));
    assert!(play(&["--size", "99x99"], 2).contains("48x40"));
    play(&["--size", "48x40"], 0);
    let exposure = w.write("state.toml", "camera = { exposure_ev = 1.5 }\n");
    play(&["--state", &exposure], 0);

    let images = w.folder.path().join("bundle/transfer-images.relume");
    let whole = std::fs::read(&images).unwrap();
    let mut flipped = whole.clone();
    let middle = flipped.len() / 2;
    flipped[middle] ^= 4;
    for damaged in [&whole[..whole.len() - 1], &whole[..100], &flipped] {
        std::fs::write(&images, damaged).unwrap();
        std::fs::remove_file(&frame).ok();
        assert!(play(&[], 2).contains("transfer-images.relume"));
        assert!(!Path::new(&frame).exists());
        assert!(expect_exit("bake", &["verify", &bundle], 2).contains("transfer-images.relume"));
    }
}

/// A disk that fills up ends the bake with code 1 and leaves no file that could be taken for finished.
#[test]
fn a_full_disk_leaves_nothing_half_written() {
    let w = Workshop::new();
    let bake = command("bake").get_program().to_str().unwrap().to_owned();
    let (scene, bundle) = (w.path("scene.toml"), w.path("bundle"));
    // With the signal ignored, a write beyond the limit fails as it would on a full disk. 64 KiB hold the
    // scene and not one tile, 512 KiB some tiles.
    for (blocks, kept) in [(128, false), (1024, true)] {
        let script = format!("trap '' XFSZ; ulimit -f {blocks}; exec \"$0\" \"$@\"");
        let output = std::process::Command::new("sh")
            .args(["-c", &script, &bake, "run", &scene, "-o", &bundle, "--spp", "4", "--progress", "none"])
            .output()
            .unwrap();
        let stderr = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(1), "{stderr}");
        assert_eq!(stderr.lines().count(), 1, "{stderr}");
        assert_eq!((stderr.contains("--resume"), Path::new(&bundle).exists()), (kept, kept), "{stderr}");
    }
    for (name, _) in contents(&bundle) {
        assert!(
            !name.contains("partial") && name != "manifest.json" && name != "transfer-images.relume",
            "{name} was left"
        );
    }
}
