//! Hostile names, two bakes at once, full disks, files that are none.

mod names;
mod refusals;

use crate::support::{command, expect_exit};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

/// A room that bakes in well under a second; more keys may follow those of the lamp.
const ROOM: &str = "
    [vary]
    materials = ['clay']
    [render]
    size = [16, 16]
    [camera]
    position = [0.0, 1.0, 3.0]
    target = [0.0, 0.0, 0.0]
    fov_deg = 40.0
    [materials.clay]
    brdf = 'blinn-phong'
    [[object]]
    name = 'ball'
    shape = 'sphere'
    subdivisions = 2
    material = 'clay'
    transform = { scale = 0.5 }
    [[object]]
    name = 'floor'
    shape = 'quad'
    segments = 4
    material = 'clay'
    transform = { translation = [0.0, -0.5, 0.0], scale = 4.0 }
    [[light]]
    name = 'lamp'
    kind = 'point'
    intensity = [10.0, 10.0, 10.0]
    transform = { translation = [0.0, 3.0, 1.0] }
";
const LAMP: &str = "    [[light]]
    name = 'lamp'
    kind = 'point'
    intensity = [10.0, 10.0, 10.0]
    transform = { translation = [0.0, 3.0, 1.0] }
";

/// The room under a sky, with light and view that vary.
fn outdoors() -> String {
    assert!(ROOM.contains(LAMP));
    ROOM.replace(LAMP, "[environment]\n")
        .replace("materials = ['clay']", "light = true\nview = true")
        .replace("[render]", "[render]\nreflections = 1")
}

/// A folder with a scene in it.
struct Place {
    folder: tempfile::TempDir,
}

impl Place {
    fn of(text: &str) -> Self {
        let place = Self { folder: tempfile::tempdir().unwrap() };
        place.write("scene/scene.toml", text);
        place
    }

    /// With the input files of a case.
    fn of_case(case: &str) -> Self {
        let inputs = Path::new(env!("CARGO_MANIFEST_DIR")).join("cases/inputs").join(case);
        let place = Self { folder: tempfile::tempdir().unwrap() };
        for entry in std::fs::read_dir(inputs).unwrap().map(Result::unwrap) {
            place.write(
                &format!("scene/{}", entry.file_name().to_str().unwrap()),
                std::fs::read(entry.path()).unwrap(),
            );
        }
        place
    }

    fn at(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn path(&self, name: &str) -> String {
        self.at(name).to_str().unwrap().to_owned()
    }

    fn write(&self, name: &str, content: impl AsRef<[u8]>) {
        std::fs::create_dir_all(self.at(name).parent().unwrap()).unwrap();
        std::fs::write(self.at(name), content).unwrap();
    }

    fn arguments(&self, more: &[&str]) -> Vec<String> {
        let own = [
            "run".to_owned(),
            self.path("scene"),
            "-o".to_owned(),
            self.path("out"),
            "--progress".to_owned(),
            "none".to_owned(),
        ];
        own.into_iter().chain(more.iter().map(|argument| (*argument).to_owned())).collect()
    }

    /// Bakes into `out` and expects this exit code; returns standard error.
    fn bake(&self, more: &[&str], code: i32) -> String {
        let arguments = self.arguments(more);
        expect_exit("bake", &arguments.iter().map(String::as_str).collect::<Vec<_>>(), code)
    }

    /// What `bake run` prints, which exits with 0.
    fn printed(&self, more: &[&str]) -> String {
        let output = command("bake").args(self.arguments(more)).output().unwrap();
        let said =
            format!("{}{}", String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
        assert_eq!(output.status.code(), Some(0), "{said}");
        said
    }

    /// A bake that stands still after `began` has become true; with whoever asks for it again if the bake was
    /// too fast.
    fn stopped(&self, more: &[&str], began: impl Fn() -> bool) -> Stopped {
        loop {
            let mut child = command("bake")
                .args(self.arguments(more))
                .stdout(Stdio::null())
                .stderr(Stdio::piped())
                .spawn()
                .unwrap();
            let start = Instant::now();
            while !began() && child.try_wait().unwrap().is_none() {
                assert!(start.elapsed() < Duration::from_secs(120), "the bake does not get going");
                std::thread::sleep(Duration::from_millis(1));
            }
            signal(&child, "-STOP");
            // It may have ended just before.
            if began() && child.try_wait().unwrap().is_none() {
                return Stopped { child };
            }
            child.wait().unwrap();
            let _ = std::fs::remove_dir_all(self.at("out"));
        }
    }

    /// Bytes in the log of a method.
    fn log_bytes(&self, method: &str) -> u64 {
        std::fs::metadata(self.at("out/unfinished").join(format!("{method}.log"))).map_or(0, |m| m.len())
    }

    /// Names in a folder, sorted.
    fn names(&self, folder: &str) -> Vec<String> {
        let mut names: Vec<String> = std::fs::read_dir(self.at(folder))
            .unwrap()
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .collect();
        names.sort();
        names
    }
}

/// A bake that stands still.
struct Stopped {
    child: Child,
}

impl Stopped {
    /// Lets it go on; its exit code, and what it says.
    fn go_on(self) -> (Option<i32>, String) {
        signal(&self.child, "-CONT");
        let output = self.child.wait_with_output().unwrap();
        (output.status.code(), String::from_utf8_lossy(&output.stderr).into_owned())
    }

    fn kill(mut self) {
        self.child.kill().unwrap();
        self.child.wait().unwrap();
    }
}

fn signal(child: &Child, signal: &str) {
    // One that has ended cannot be stopped.
    let _ =
        Command::new("kill").args([signal, &child.id().to_string()]).stderr(Stdio::null()).status().unwrap();
}

fn busy(child: &Stopped) -> String {
    format!(
        "another bake is at work here (process {}); wait for it, or bake elsewhere with -o",
        child.child.id()
    )
}

#[test]
fn a_second_bake_is_refused_from_the_first_byte_to_the_last() {
    let place = Place::of_case("two-bakes-corrupt");
    let holds = || std::fs::read(place.at("out/unfinished/lock")).is_ok_and(|lock| !lock.is_empty());
    let refuse = |first: &Stopped| {
        for more in [&["--force", "--seed", "1"][..], &["--resume"], &[]] {
            let stderr = place.bake(&[&["--max-error", "10"], more].concat(), 1);
            assert!(stderr.contains(&busy(first)), "{stderr}");
        }
    };
    // As soon as it holds the folder, and when its spheres are written and it measures.
    for began in [&holds as &dyn Fn() -> bool, &|| place.at("out/unfinished/spheres-knot.relume").exists()] {
        let first = place.stopped(&["--max-error", "10", "--resume"], began);
        refuse(&first);
        first.kill();
    }
    // When its manifest stands and only the report is missing.
    let first = place
        .stopped(&["--max-error", "10", "--resume"], || place.at("out/manifest.json").exists() && holds());
    refuse(&first);
    let (code, stderr) = first.go_on();
    assert_eq!(code, Some(0), "{stderr}");
    expect_exit("bake", &["verify", &place.path("out")], 0);
    assert!(!place.at("out/unfinished").exists());
}

#[test]
fn what_another_method_left_unfinished_stays() {
    let place = Place::of_case("two-methods-lose-work");
    let images =
        ["--method", "transfer-images", "--size", "64x64", "--spp", "256", "--bases", "4", "--threads", "1"];
    let rows = ["--method", "sparse-transfer", "--terms", "8", "--spp", "1", "--threads", "1"];
    let first = place.stopped(&images, || place.log_bytes("transfer-images") > 16);
    let stderr = place.bake(&[&rows[..], &["--resume"]].concat(), 1);
    assert!(stderr.contains(&busy(&first)), "{stderr}");
    first.kill();
    let log = std::fs::read(place.at("out/unfinished/transfer-images.log")).unwrap();
    for more in [&["--resume"][..], &[], &["--force"]] {
        place.bake(&[&rows[..], more].concat(), 0);
        assert_eq!(std::fs::read(place.at("out/unfinished/transfer-images.log")).unwrap(), log);
        assert_eq!(place.names("out/unfinished"), ["transfer-images.log"]);
        expect_exit("bake", &["verify", &place.path("out")], 0);
    }
    let stderr = place.bake(&images, 2);
    assert!(
        stderr.contains("holds an unfinished bake; add --resume to go on with it or --force to start again"),
        "{stderr}"
    );
    place.bake(&[&images[..], &["--resume"]].concat(), 0);
    assert!(!place.at("out/unfinished").exists());
    expect_exit("bake", &["verify", &place.path("out")], 0);
}

#[cfg(unix)]
#[test]
fn pipes_are_refused_and_not_waited_for() {
    let pipe = |path: &Path| {
        let _ = std::fs::remove_file(path);
        assert!(Command::new("mkfifo").arg(path).status().unwrap().success());
    };
    let place = Place::of(ROOM);
    place.bake(&["--spp", "1", "--bases", "2"], 0);
    let out = place.path("out");
    for file in ["brdf-basis.relume", "scene.relume", "manifest.json"] {
        let path = place.at("out").join(file);
        let bytes = std::fs::read(&path).unwrap();
        pipe(&path);
        for arguments in [&["info", &out][..], &["verify", &out]] {
            let stderr = expect_exit("bake", arguments, 2);
            assert!(stderr.contains(file), "{stderr}");
        }
        let stderr = expect_exit("player", &[&out, "--headless", "--frames", &place.path("f.png")], 2);
        assert!(stderr.contains("not a regular file"), "{stderr}");
        if file == "scene.relume" {
            let stderr = expect_exit("bake", &["info", &place.path("out/scene.relume")], 2);
            assert!(
                stderr.contains("not a regular file but a pipe, socket or device; give a file"),
                "{stderr}"
            );
        }
        if file != "manifest.json" {
            std::fs::remove_file(&path).unwrap();
            std::fs::write(&path, bytes).unwrap();
        }
    }
    let stderr = place.bake(&["--spp", "1", "--bases", "2"], 2);
    assert!(
        stderr.contains("manifest.json: is no regular file where a bake keeps a file; move it away"),
        "{stderr}"
    );
    std::fs::remove_file(place.at("out/manifest.json")).unwrap();
    place.write("scene/animations/b.toml", "");
    pipe(&place.at("scene/animations/a.toml"));
    let stderr = place.bake(&[], 2);
    assert!(stderr.contains("animations/a.toml: not a regular file"), "{stderr}");
    std::fs::remove_dir_all(place.at("scene/animations")).unwrap();
    place.write("scene/scene.toml", ROOM.replace("shape = 'sphere'\n    subdivisions = 2", "file = 'a.obj'"));
    pipe(&place.at("scene/a.obj"));
    assert!(place.bake(&[], 2).contains("`a.obj` is not a regular file"));
    pipe(&place.at("scene/scene.toml"));
    assert!(expect_exit("bake", &["run", &place.path("scene/scene.toml")], 2).contains("scene.toml"));
}

/// As on a full disk: one line, and what is finished serves again.
#[cfg(target_os = "linux")]
#[test]
fn a_limit_on_file_sizes_ends_a_bake_with_a_line() {
    let place = Place::of(ROOM);
    let settings = ["--size", "64x64", "--spp", "4", "--bases", "2"];
    place.bake(&settings, 0);
    let whole = std::fs::read(place.at("out/transfer-images.relume")).unwrap();
    std::fs::remove_dir_all(place.at("out")).unwrap();
    let output = Command::new("sh")
        .args(["-c", "ulimit -f 256; exec \"$0\" \"$@\""])
        .arg(command("bake").get_program())
        .args(place.arguments(&settings))
        .output()
        .unwrap();
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert_eq!((output.status.code(), stderr.lines().count()), (Some(1), 1), "{stderr}");
    assert!(
        stderr.contains("transfer-images.log: File too large")
            && stderr.trim_end().ends_with("add --resume to go on"),
        "{stderr}"
    );
    place.bake(&[&settings[..], &["--resume"]].concat(), 0);
    assert_eq!(std::fs::read(place.at("out/transfer-images.relume")).unwrap(), whole);
    let full = std::fs::File::options().write(true).open("/dev/full").unwrap();
    let output = command("bake").args(["info", &place.path("out")]).stdout(full).output().unwrap();
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert_eq!((output.status.code(), stderr.lines().count()), (Some(1), 1), "{stderr}");
    assert!(stderr.contains("standard output: No space left on device"), "{stderr}");
}

#[cfg(unix)]
#[test]
fn resuming_is_offered_only_where_there_is_work_to_resume() {
    let place = Place::of(ROOM);
    let link = |to: &str, name: &str| std::os::unix::fs::symlink(to, place.at(name)).unwrap();
    let scene = place.path("scene");
    let expect = |output: &str, code: i32, part: &str| {
        let stderr = expect_exit("bake", &["run", &scene, "-o", output, "--spp", "1", "--bases", "2"], code);
        assert!(stderr.contains(part) && !stderr.contains("--resume"), "{stderr}");
    };
    // Not even root makes folders there.
    expect("/proc/relume", 1, "/proc/relume: ");
    link("nowhere", "dangling");
    expect(&place.path("dangling"), 2, "a link that leads nowhere");
    expect(&place.path("scene/scene.toml"), 2, "is a file where a folder is wanted");
    expect("", 2, "a value is required for '--output <DIR>'");
    std::fs::create_dir(place.at("scene/animations")).unwrap();
    link("a.toml", "scene/animations/a.toml");
    expect(&place.path("out"), 2, "animations/a.toml: ");
    std::fs::remove_dir_all(place.at("scene/animations")).unwrap();
    assert_eq!(place.names(""), ["dangling", "scene"], "nothing was made");

    // Linked folders are folders, the scene's own is one too.
    std::fs::create_dir(place.at("folder")).unwrap();
    link("folder", "linked");
    for output in ["linked", "scene/baked", "scene"] {
        expect_exit("bake", &["run", &scene, "-o", &place.path(output), "--spp", "1", "--bases", "2"], 0);
        expect_exit("bake", &["verify", &place.path(output)], 0);
    }

    let bake = place.stopped(&["--size", "64x64", "--spp", "256", "--bases", "4"], || {
        place.log_bytes("transfer-images") > 16
    });
    std::fs::remove_dir_all(place.at("out")).unwrap();
    let (code, stderr) = bake.go_on();
    assert_eq!(code, Some(1), "{stderr}");
    assert!(stderr.contains("No such file or directory") && !stderr.contains("--resume"), "{stderr}");
}

#[test]
fn a_bundle_of_another_scene_is_replaced_by_force_only_and_one_of_other_settings_with_a_word() {
    let place = Place::of(ROOM);
    let settings = ["--spp", "1", "--bases", "2"];
    place.bake(&settings, 0);
    let before = std::fs::read(place.at("out/manifest.json")).unwrap();
    place.write("other/scene.toml", ROOM);
    let [other, out] = [place.path("other"), place.path("out")];
    let other = [&["run", &other, "-o", &out][..], &settings].concat();
    let stderr = expect_exit("bake", &other, 2);
    assert!(
        stderr.contains(
            "out: holds a bundle of scene `scene`; add --force to replace it, or bake elsewhere with -o"
        ),
        "{stderr}"
    );
    assert_eq!(std::fs::read(place.at("out/manifest.json")).unwrap(), before);
    assert!(!place.printed(&settings).contains("note: "), "the same again replaces nothing");
    let said = place.printed(&["--spp", "2", "--bases", "2", "--size", "8x8"]);
    assert!(
        said.contains("note: will replace the bundle in ")
            && said.contains("a film of 16x16; transfer-images with samples 1; Ctrl-C keeps it as it is\n"),
        "{said}"
    );
    expect_exit("bake", &[&other[..], &["--force"]].concat(), 0);
    expect_exit("bake", &["verify", &out], 0);
    // What somebody else keeps there is nothing to replace either.
    place.write("out/manifest.json", "{ \"name\": \"an app\" }");
    let stderr = place.bake(&settings, 2);
    assert!(stderr.contains("holds a manifest.json that is no bundle's"), "{stderr}");
    assert_eq!(std::fs::read_to_string(place.at("out/manifest.json")).unwrap(), "{ \"name\": \"an app\" }");
}
