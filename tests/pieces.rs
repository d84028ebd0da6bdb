//! Bakes in pieces: whatever becomes of the parts on the way, they merge into the undivided bundle, byte for
//! byte.

use crate::support::{command, expect_exit};
use relume_bake::stage::Share;
use std::path::{Path, PathBuf};
use std::process::Stdio;
use std::time::{Duration, Instant};

const SCENE: &str = "
    [vary]
    VARY
    [render]
    size = [48, 48]
    reflections = REFLECTIONS
    [camera]
    position = [0.0, 1.0, 4.0]
    target = [0.0, 0.4, 0.0]
    fov_deg = 45.0
    [materials.clay]
    brdf = 'blinn-phong'
    kd = [0.5, 0.4, 0.3]
    [[object]]
    name = 'ball'
    shape = 'sphere'
    subdivisions = 3
    material = 'clay'
    SPHERES
    transform = { translation = [0.0, 0.5, 0.0], scale = 0.5 }
    [[object]]
    name = 'block'
    shape = 'box'
    material = 'clay'
    SPHERES
    transform = { translation = [1.2, 0.5, 0.0], scale = 0.4 }
    [[object]]
    name = 'floor'
    shape = 'quad'
    segments = 12
    material = 'clay'
    transform = { scale = 4.0 }
    [environment]
    file = 'lamps'
";
/// The parts in an order of no meaning, and those of them that are killed on the way.
const ORDER: [u32; 7] = [4, 7, 1, 6, 3, 2, 5];
const KILLED: [u32; 2] = [6, 2];

/// Method, what varies, reflections, spheres, options.
const BAKES: [(&str, &str, u32, &str, &[&str]); 5] = [
    ("transfer-images", "materials = ['clay']", 2, "", &["--spp", "64", "--bases", "4"]),
    ("sparse-transfer", "light = true", 1, "", &["--spp", "16"]),
    ("sparse-transfer", "view = true", 2, "", &["--spp", "4"]),
    (
        "transfer-tensor",
        "light = true\n    materials = ['clay']",
        3,
        "",
        &["--quality", "draft", "--terms", "40"],
    ),
    ("sphere-shadows", "light = true", 1, "spheres = 4", &[]),
];

/// The bundle's files and manifest by name; the report has timings and is left out.
fn bundle(folder: &Path) -> Vec<(String, Vec<u8>)> {
    let is_content =
        |path: &PathBuf| path.is_file() && path.file_name().is_some_and(|name| name != "report.json");
    let mut files: Vec<PathBuf> =
        std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).filter(is_content).collect();
    files.sort();
    files
        .iter()
        .map(|path| (path.file_name().unwrap().to_string_lossy().into_owned(), std::fs::read(path).unwrap()))
        .collect()
}

/// Names of the logs in a folder, which need not be there.
fn kept_logs(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let mut names: Vec<String> = entries.map(|entry| entry.file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

/// Starts a part, kills it once there is something in a log (or it is done), and goes on.
fn kill_on_the_way(arguments: &[&str], folder: &Path) {
    let mut child =
        command("bake").args(arguments).stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
    let began = |folder: &Path| {
        let logs = std::fs::read_dir(folder.join("unfinished")).into_iter().flatten().flatten();
        logs.filter(|entry| entry.path().extension().is_some_and(|e| e == "log"))
            .any(|entry| entry.metadata().is_ok_and(|m| m.len() > 16))
    };
    let start = Instant::now();
    while child.try_wait().unwrap().is_none() && !began(folder) {
        assert!(start.elapsed() < Duration::from_secs(300), "nothing is ever in a log");
        std::thread::sleep(Duration::from_millis(1));
    }
    let _ = child.kill();
    child.wait().unwrap();
}

#[test]
fn seven_parts_in_any_order_two_of_them_killed_merge_into_the_same_bytes() {
    for (method, vary, reflections, spheres, options) in BAKES {
        let place = tempfile::tempdir().unwrap();
        let text = SCENE
            .replace("VARY", vary)
            .replace("REFLECTIONS", &reflections.to_string())
            .replace("SPHERES", spheres);
        let scene = crate::support::write_scene(place.path(), &text).display().to_string();
        let at = |name: &str| place.path().join(name).display().to_string();
        let common =
            [&["run", &scene, "--method", method, "--progress", "none", "--threads", "2"][..], options]
                .concat();
        expect_exit("bake", &[&common[..], &["-o", &at("whole")]].concat(), 0);
        let mut folders = Vec::new();
        for number in ORDER {
            let (folder, pieces) = (at(&format!("part {number}")), format!("{number}/7"));
            let part = [&common[..], &["--pieces", &pieces, "-o", &folder]].concat();
            if KILLED.contains(&number) {
                kill_on_the_way(&part, Path::new(&folder));
                let resumed = [&part[..], &["--resume"]].concat();
                expect_exit("bake", &resumed, 0);
            } else {
                expect_exit("bake", &part, 0);
            }
            folders.push(folder);
        }
        let merged = at("merged");
        let merge = |folders: &[String], code: i32| {
            let folders: Vec<&str> = folders.iter().map(String::as_str).collect();
            expect_exit(
                "bake",
                &[&["merge", "--progress", "none", "-o", &merged][..], &folders].concat(),
                code,
            )
        };
        let missing = merge(&folders[1..], 2);
        assert!(missing.contains("the pieces 4/7 are missing; bake them with --pieces 4/7"), "{missing}");
        merge(&folders, 0);
        let (whole, merged) = (bundle(Path::new(&at("whole"))), bundle(Path::new(&merged)));
        let names =
            |files: &[(String, Vec<u8>)]| files.iter().map(|(name, _)| name.clone()).collect::<Vec<_>>();
        assert_eq!(names(&whole), names(&merged), "{method}");
        whole.iter().zip(&merged).for_each(|(a, b)| assert!(a.1 == b.1, "{method}: {} differs", a.0));
        assert!(!Path::new(&at("merged")).join("unfinished").exists(), "nothing is left over");
        let kept = |name: &str| kept_logs(&Path::new(&at(name)).join("traced"));
        assert_eq!(kept("merged"), kept("whole"), "{method}");
        assert_eq!(kept("whole").is_empty(), method == "transfer-images");
    }
}

#[test]
fn what_cannot_be_merged_is_refused() {
    let place = tempfile::tempdir().unwrap();
    let text = SCENE.replace("VARY", "light = true").replace("REFLECTIONS", "1").replace("SPHERES", "");
    let scene = crate::support::write_scene(place.path(), &text).display().to_string();
    let at = |name: &str| place.path().join(name).display().to_string();
    let part = |pieces: &str, terms: &str| {
        let folder = at(&format!("{}-{terms}", pieces.replace('/', "of")));
        expect_exit(
            "bake",
            &[
                "run",
                &scene,
                "--terms",
                terms,
                "--spp",
                "1",
                "--pieces",
                pieces,
                "-o",
                &folder,
                "--progress",
                "none",
            ],
            0,
        );
        folder
    };
    let (one, two, other) = (part("1/2", "8"), part("2/2", "8"), part("2/2", "9"));
    for command in [&["info", &one][..], &["verify", &one], &["export", &one, "-o", &at("exported")]] {
        let message = expect_exit("bake", command, 2);
        assert!(
            message.contains("holds a part of a bake, and no bundle; make one of all parts"),
            "{message}"
        );
    }
    let refused =
        |folders: &[&str]| expect_exit("bake", &[&["merge", "-o", &at("out")][..], folders].concat(), 2);
    for (folders, expected) in [
        (&[&one[..], &other][..], "is a part of another bake than"),
        (&[&two], "the pieces 1/2 are missing"),
        (&[&one, &one], "has the pieces 1/2, as has"),
        (&[&one, &at("")], "holds no part of a bake; make one with `bake run SCENE --pieces I/N -o DIR`"),
    ] {
        let message = refused(folders);
        assert!(message.contains(expected), "{message}");
        assert!(!Path::new(&at("out")).exists());
    }
    let message =
        expect_exit("bake", &["run", &scene, "--terms", "8", "--pieces", "2/2", "-o", &one, "--resume"], 2);
    assert!(
        message.contains("holds the pieces 1/2; give each part a folder of its own with -o"),
        "{message}"
    );
    let moved = text.replace("translation = [0.0, 0.5, 0.0]", "translation = [0.1, 0.5, 0.0]");
    crate::support::write_scene(place.path(), &moved);
    let message = refused(&[&one, &two]);
    assert!(message.contains("scene.toml: has changed since its parts were baked; restore it"), "{message}");
    crate::support::write_scene(place.path(), &text);
    expect_exit("bake", &["merge", "-o", &at("bundle"), &one, &two], 0);
    let message =
        expect_exit("bake", &["run", &scene, "--terms", "8", "--pieces", "2/2", "-o", &at("bundle")], 2);
    assert!(
        message.contains("bundle: holds a bundle; give each part a folder of its own with -o"),
        "{message}"
    );
    // A bundle of something else is left as it is.
    let other = tempfile::tempdir().unwrap();
    let theirs = crate::support::write_scene(other.path(), &text);
    let strangers = other.path().join("bundle").display().to_string();
    expect_exit(
        "bake",
        &[
            "run",
            theirs.to_str().unwrap(),
            "--terms",
            "8",
            "--spp",
            "1",
            "-o",
            &strangers,
            "--progress",
            "none",
        ],
        0,
    );
    let message = expect_exit("bake", &["merge", "-o", &strangers, &one, &two], 2);
    assert!(
        message.contains("holds a bundle of scene `") && !Path::new(&strangers).join("unfinished").exists(),
        "{message}"
    );
    // Machines have the scene in places of their own.
    let folder = other.path().join(place.path().file_name().unwrap());
    std::fs::create_dir(&folder).unwrap();
    let scene = crate::support::write_scene(&folder, &text).display().to_string();
    let far = other.path().join("far").display().to_string();
    expect_exit(
        "bake",
        &["run", &scene, "--terms", "8", "--spp", "1", "--pieces", "2/2", "-o", &far, "--progress", "none"],
        0,
    );
    std::fs::rename(place.path().join("scene.toml"), place.path().join("gone.toml")).unwrap();
    expect_exit("bake", &["merge", "-o", &at("of both"), &one, &far], 0);
    assert!(bundle(Path::new(&at("of both"))) == bundle(Path::new(&at("bundle"))));
    std::fs::rename(place.path().join("gone.toml"), place.path().join("scene.toml")).unwrap();
    std::fs::write(Path::new(&two).join("unfinished/shard.json"), "{").unwrap();
    assert!(refused(&[&one, &two]).contains("shard.json: is damaged or of another version"));
    let message = expect_exit("bake", &["run", &scene, "--pieces", "3/2"], 2);
    assert!(message.contains("expected I/N such as 3/100"), "{message}");
    assert!(Share::WHOLE.has(3) && !Share::WHOLE.is_part());
}
