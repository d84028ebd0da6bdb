//! The binaries as a user runs them.

mod mistakes;
mod programs;

use crate::support::room::{ROOM, Workshop};
use crate::support::waiting::{interrupt, wait_for};
use crate::support::{command, expect_exit, relative_l2, run, write_scene};
use relume_bake::exr_file::read_exr;
use relume_bake::work_log::WorkLog;
use std::path::Path;
use std::process::{Child, Stdio};

/// Names and contents of the files in a folder, timings left out.
fn contents(folder: &str) -> Vec<(String, Vec<u8>)> {
    let entries = std::fs::read_dir(folder).unwrap().map(|e| e.unwrap());
    let mut files: Vec<_> = entries
        .filter(|e| e.file_name() != "report.json")
        .map(|e| (e.file_name().into_string().unwrap(), std::fs::read(e.path()).unwrap_or_default()))
        .collect();
    files.sort();
    files
}

fn film_size(scene: &str) -> [u32; 2] {
    relume_scenes::load(Path::new(scene)).unwrap().size
}

fn pixels(exr: &str) -> Vec<[f32; 3]> {
    let image = read_exr(Path::new(exr)).unwrap();
    let [r, g, b] = ["R", "G", "B"].map(|c| image.channel(c).unwrap());
    r.iter().zip(g).zip(b).map(|((r, g), b)| [*r, *g, *b]).collect()
}

#[test]
fn bake_play_and_compare_with_the_reference() {
    let w = Workshop::new();
    let settings = ["--spp", "64", "--seed", "9"];
    w.bake("bundle", &[&settings[..], &["--bases", "9"]].concat());
    let (bundle, scene) = (w.path("bundle"), w.path("scene.toml"));
    let state = w.write("state.toml", "[materials.ball]\nkd = [0.1, 0.5, 0.2]\nks = [0.4, 0.4, 0.4]\nshininess = 90.0\n[materials.room]\nks = [0.2, 0.2, 0.2]\nshininess = 35.5\n");
    let (played, reference) = (w.path("played.exr"), w.path("reference.exr"));
    expect_exit("player", &[&bundle, "--headless", "--state", &state, "--exr", &played], 0);
    expect_exit(
        "bake",
        &[
            &[
                "reference",
                &scene,
                "--state",
                &state,
                "--paths",
                "gather",
                "--reflections",
                "2",
                "-o",
                &reference,
                "--progress",
                "none",
            ],
            &settings[..],
        ]
        .concat(),
        0,
    );
    let error = relative_l2(&pixels(&played), &pixels(&reference));
    assert!(error < 0.0005, "relative L2 {error}");
    // To look at, of the same size.
    let shown = w.path("reference.png");
    expect_exit("bake", &["reference", &scene, "--spp", "2", "-o", &shown], 0);
    let (png, size) = (std::fs::read(&shown).unwrap(), film_size(&scene));
    assert_eq!(
        (&png[..8], &png[16..24]),
        (&b"\x89PNG\r\n\x1a\n"[..], &size.map(u32::to_be_bytes).concat()[..])
    );

    expect_exit("bake", &["verify", &bundle], 0);
    let info: serde_json::Value =
        serde_json::from_slice(&run("bake", &["info", &bundle, "--json"]).stdout).unwrap();
    assert!(info.to_string().contains("transfer-images"));
    let export = w.path("export");
    expect_exit("bake", &["export", &bundle, "-o", &export], 0);
    for file in ["basis.npy", "parameters.npy", "coefficients.npy"] {
        let found = find(Path::new(&export), file).unwrap_or_else(|| panic!("no {file} was exported"));
        assert_eq!(&std::fs::read(found).unwrap()[..6], b"\x93NUMPY");
    }
    let stats = w.path("stats.json");
    let frames = w.path("frames/%04d.png");
    expect_exit(
        "player",
        &[
            &bundle,
            "--headless",
            "--animation",
            "shine",
            "--fps",
            "10",
            "--frames",
            &frames,
            "--stats",
            &stats,
        ],
        0,
    );
    assert_eq!(std::fs::read_dir(w.path("frames")).unwrap().count(), 5, "ceil(0.5 s · 10/s)");
    let stats: serde_json::Value = serde_json::from_slice(&std::fs::read(stats).unwrap()).unwrap();
    assert_eq!(stats["frames"], 5);
}

/// The file of that name in a folder or below it.
fn find(folder: &Path, name: &str) -> Option<std::path::PathBuf> {
    std::fs::read_dir(folder).unwrap().map(|e| e.unwrap().path()).find_map(|path| {
        if path.is_dir() {
            find(&path, name)
        } else {
            path.file_name().is_some_and(|n| n == name).then_some(path)
        }
    })
}

#[test]
fn same_bytes_at_one_and_two_threads() {
    let w = Workshop::new();
    w.bake("one", &["--spp", "16", "--threads", "1"]);
    w.bake("two", &["--spp", "16", "--threads", "2"]);
    assert_eq!(contents(&w.path("one")), contents(&w.path("two")));
    w.bake("other", &["--spp", "16", "--seed", "1"]);
    assert_ne!(contents(&w.path("one")), contents(&w.path("other")));
}

/// Starts a bake that takes long enough to be stopped.
fn start_long_bake(w: &Workshop, more: &[&str]) -> Child {
    start_bake(w, "2048", more)
}

fn start_bake(w: &Workshop, samples: &str, more: &[&str]) -> Child {
    let (scene, output) = (w.path("scene.toml"), w.path("bundle"));
    // On one thread, which is far from done when the first tiles are, however many a machine has.
    let arguments = [
        &[
            "run",
            &scene,
            "-o",
            &output,
            "--spp",
            samples,
            "--bases",
            "4",
            "--progress",
            "none",
            "--threads",
            "1",
        ],
        more,
    ]
    .concat();
    command("bake").args(arguments).stderr(Stdio::piped()).spawn().unwrap()
}

fn wait_for_log(w: &Workshop, child: &mut Child, bytes: u64) {
    let log = w.folder.path().join("bundle/unfinished/transfer-images.log");
    // A record that is being written may be lost if the bake is killed now.
    let has_tiles = || {
        let length = std::fs::metadata(&log).ok().map(|file| file.len());
        length.filter(|length| *length > bytes && WorkLog::holds_pieces(&log))
    };
    wait_for(child, "tiles in the log", has_tiles);
}

fn log_length(w: &Workshop) -> u64 {
    std::fs::metadata(w.folder.path().join("bundle/unfinished/transfer-images.log")).unwrap().len()
}

#[test]
fn interrupted_and_killed_bakes_go_on_where_they_were() {
    let w = Workshop::new();
    w.bake("whole", &["--spp", "2048", "--bases", "4"]);
    let mut child = start_long_bake(&w, &[]);
    wait_for_log(&w, &mut child, 16);
    interrupt(&child);
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(130), "{}", String::from_utf8_lossy(&output.stderr));
    assert!(!w.folder.path().join("bundle/manifest.json").exists());

    // Without a word about what to do, nothing is touched.
    let before = log_length(&w);
    let (scene, bundle) = (w.path("scene.toml"), w.path("bundle"));
    let stderr = expect_exit("bake", &["run", &scene, "-o", &bundle, "--spp", "2048", "--bases", "4"], 2);
    assert!(stderr.contains("--resume") && stderr.contains("--force"), "{stderr}");
    let stderr =
        expect_exit("bake", &["run", &scene, "-o", &bundle, "--spp", "2047", "--bases", "4", "--resume"], 2);
    assert!(stderr.contains("other settings"), "{stderr}");
    assert_eq!(log_length(&w), before);

    let mut child = start_long_bake(&w, &["--resume"]);
    wait_for_log(&w, &mut child, before);
    child.kill().unwrap();
    child.wait().unwrap();
    let stderr =
        expect_exit("bake", &["run", &scene, "-o", &bundle, "--spp", "2048", "--bases", "4", "--resume"], 0);
    assert!(stderr.contains("note: tracing: goes on after "), "{stderr}");
    assert_eq!(contents(&w.path("bundle")), contents(&w.path("whole")));
}

/// Killed at twenty moments spread over the whole run, start, measuring and publishing included, and once
/// more while going on: a bake that is resumed ends in the same bytes. Moments are told by the processor time
/// that the bake has had.
#[cfg(target_os = "linux")]
#[test]
fn twenty_kills_change_nothing() {
    use crate::support::waiting::let_work;
    let w = Workshop::new();
    let settings = ["--spp", "256", "--bases", "4"];
    let scene = w.path("scene.toml");
    let start = |bundle: &str| {
        let arguments = ["run", &scene, "-o", bundle, "--progress", "none", "--resume"];
        command("bake")
            .args(arguments)
            .args(settings)
            .stderr(Stdio::null())
            .stdout(Stdio::null())
            .spawn()
            .unwrap()
    };
    // The player's frames, timed at the end, are another process.
    let whole_s = let_work(&mut start(&w.path("whole")), f64::INFINITY);
    let expected = contents(&w.path("whole"));
    let mut unfinished = 0;
    for trial in 0..20u32 {
        let bundle = w.path(&format!("trial-{trial}"));
        // Fractions of the golden ratio spread evenly, however many there are.
        for kill in [trial, trial + 20] {
            let mut child = start(&bundle);
            let_work(&mut child, whole_s * (f64::from(kill) * 0.618_033_988_75).fract());
            child.kill().unwrap();
            child.wait().unwrap();
        }
        unfinished += u32::from(!Path::new(&bundle).join("manifest.json").exists());
        let stderr = expect_exit(
            "bake",
            &[&["run", &scene, "-o", &bundle, "--progress", "none", "--resume"], &settings[..]].concat(),
            0,
        );
        assert_eq!(contents(&bundle), expected, "trial {trial}: {stderr}");
    }
    assert!(unfinished >= 5, "only {unfinished} of 20 bakes were still at work when killed twice");
}

#[test]
fn finished_work_is_reused() {
    let w = Workshop::new();
    w.bake("bundle", &["--spp", "16"]);
    let images = w.folder.path().join("bundle/transfer-images.relume");
    let written = std::fs::metadata(&images).unwrap().modified().unwrap();
    // Defaults of a material that varies, exposure and animations trace nothing again, but arrive in the
    // bundle.
    let changed = ROOM
        .replace("shininess = 20.0", "shininess = 30.0")
        .replace("fov_deg = 45.0", "fov_deg = 45.0\n    exposure_ev = 1.0");
    write_scene(w.folder.path(), &changed);
    w.write(
        "animations/dim.toml",
        "duration_s = 1.0\n[[key]]\nt_s = 0.0\nmaterials.ball.kd = [0.1, 0.1, 0.1]\n",
    );
    w.bake("bundle", &["--spp", "16"]);
    assert_eq!(std::fs::metadata(&images).unwrap().modified().unwrap(), written);
    assert!(w.folder.path().join("bundle/animation-dim.relume").exists());
    // Killed in the middle of publishing: the old manifest is aside, the images are not lost.
    let aside = w.folder.path().join("bundle/unfinished");
    std::fs::create_dir(&aside).unwrap();
    std::fs::rename(w.path("bundle/manifest.json"), aside.join("manifest.json")).unwrap();
    w.bake("bundle", &["--spp", "16"]);
    assert_eq!(std::fs::metadata(&images).unwrap().modified().unwrap(), written);
    expect_exit("bake", &["verify", &w.path("bundle")], 0);
    // Anything that the light depends on does.
    write_scene(w.folder.path(), &changed.replace("[0.7, 0.1, 0.1]", "[0.1, 0.7, 0.1]"));
    w.bake("bundle", &["--spp", "16"]);
    assert_ne!(std::fs::metadata(&images).unwrap().modified().unwrap(), written);
}

/// An unfinished bake in the folder of a finished one is neither forgotten nor thrown away, and the finished
/// one plays until the new one is whole.
#[test]
fn an_unfinished_bake_beside_a_finished_one() {
    let w = Workshop::new();
    w.bake("bundle", &["--spp", "8", "--bases", "4"]);
    let finished = contents(&w.path("bundle"));
    let mut child = start_long_bake(&w, &["--force"]);
    wait_for_log(&w, &mut child, 16);
    child.kill().unwrap();
    child.wait().unwrap();
    expect_exit("bake", &["verify", &w.path("bundle")], 0);
    let (scene, bundle) = (w.path("scene.toml"), w.path("bundle"));
    expect_exit("bake", &["run", &scene, "-o", &bundle, "--spp", "8", "--bases", "4"], 2);
    expect_exit("bake", &["run", &scene, "-o", &bundle, "--spp", "8", "--bases", "4", "--resume"], 2);
    assert!(log_length(&w) > 16);
    w.bake("bundle", &["--spp", "8", "--bases", "4", "--force"]);
    assert_eq!(contents(&bundle), finished);
}

/// Two bakes in one folder would overwrite each other's work.
#[test]
fn a_second_bake_in_the_same_folder_is_refused() {
    let w = Workshop::new();
    let mut child = start_bake(&w, "65536", &[]);
    wait_for_log(&w, &mut child, 15);
    let (scene, bundle) = (w.path("scene.toml"), w.path("bundle"));
    let stderr =
        expect_exit("bake", &["run", &scene, "-o", &bundle, "--spp", "65536", "--bases", "4", "--resume"], 1);
    assert!(stderr.contains("another bake"), "{stderr}");
    child.kill().unwrap();
    child.wait().unwrap();
}
