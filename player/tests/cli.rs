//! The binary as a user meets it: exit codes, one-line errors, and the files it writes.

mod display;
mod maps;

use crate::run::{expect_error, expect_success, gpu_there, headless, player, stats};
use crate::support::{self, Bundle, sparse};
use relume_formats::container::Stored as _;
use relume_formats::display::{Display, Tonemap};
use relume_formats::kinds::StoredScene;
use relume_formats::kinds::manifest::{FileEntry, MethodEntry};
use relume_formats::state::{BlinnPhong, Brdf};
use std::path::Path;
use std::process::{Command, Output};

fn exr(path: &Path) -> Vec<[f32; 3]> {
    use exr::prelude::*;
    read()
        .no_deep_data()
        .largest_resolution_level()
        .rgb_channels(
            |size, _| vec![[0.0; 3]; size.area()],
            |pixels, at, (r, g, b): (f32, f32, f32)| {
                pixels[at.y() * support::SIZE[0] as usize + at.x()] = [r, g, b]
            },
        )
        .first_valid_layer()
        .all_attributes()
        .from_file(path)
        .unwrap()
        .layer_data
        .channel_data
        .pixels
}

#[test]
fn help_and_usage() {
    let help = player(&["--help"]);
    expect_success(&help);
    let text = String::from_utf8(help.stdout).unwrap();
    for flag in ["--bytes", "--rate", "--headless", "--contact-sheet", "Exit codes"] {
        assert!(text.contains(flag), "{text}");
    }
    let bundle = Bundle::write(true);
    let folder = bundle.folder().to_str().unwrap();
    expect_error(&player(&[]), 2, "DIR");
    if cfg!(target_os = "linux") {
        expect_error(&player(&[folder]), 2, "no display; add --headless and --frames");
        let nowhere = Command::new(env!("CARGO_BIN_EXE_player"))
            .arg(folder)
            .env("DISPLAY", ":31999")
            .env_remove("WAYLAND_DISPLAY")
            .output();
        expect_error(&nowhere.unwrap(), 2, "add --headless and --frames");
    }
    expect_error(
        &player(&[folder, "--frames", "f.png"]),
        2,
        "--frames is for playing without a window; add --headless",
    );
    expect_error(
        &player(&[folder, "--fps", "12"]),
        2,
        "--fps is for playing without a window; add --headless",
    );
    expect_error(&headless(bundle.folder(), &[]), 2, "nothing to write");
    expect_error(&headless(bundle.folder(), &["--frames", "%d/%d.png"]), 2, "exactly one %d");
    expect_error(&headless(bundle.folder(), &["--frames", "@/f.png", "--colour"]), 2, "--colour");
}

#[test]
fn bad_input() {
    let bundle = Bundle::write(true);
    let frames = ["--frames", "@/f.png"];
    let with = |more: &[&str]| headless(bundle.folder(), &[&frames, more].concat());
    expect_error(&headless(Path::new("no/such/folder"), &frames), 2, "holds no bundle");
    expect_error(&with(&["--method", "photon-volume"]), 2, "this bundle has: transfer-images");
    expect_error(&with(&["--animation", "gloom"]), 2, "this bundle has: glow");
    expect_error(&with(&["--animation", "@/gloom.toml"]), 2, "gloom.toml");
    expect_error(&with(&["--state", "@/absent.toml"]), 2, "absent.toml");
    if !gpu_there() {
        return;
    }
    std::fs::write(bundle.folder().join("state.toml"), "[materials.fixed]\nshininess = 3.0").unwrap();
    expect_error(&with(&["--state", "@/state.toml"]), 2, "state.toml: line 1: sets material `fixed`");
    std::fs::write(
        bundle.folder().join("wild.toml"),
        "duration_s = 1.0\n[[key]]\nt_s = 0.9\nmaterials.a.shininess = 900",
    )
    .unwrap();
    expect_error(&with(&["--animation", "@/wild.toml", "--count", "1"]), 2, "shininess 900");
    expect_error(&with(&["--animation", "glow"]), 2, "each of 15 frames");
    expect_error(&with(&["--adapter", "no such thing"]), 2, "this machine has: ");
    expect_error(&with(&["--adapter", "no such thing"]), 2, "; cpu [");
    assert!(!bundle.folder().join("f.png").exists());
}

#[test]
fn no_adapter_is_a_failure_that_names_the_remedy() {
    let bundle = Bundle::write(true);
    let output = Command::new(env!("CARGO_BIN_EXE_player"))
        .args(["--headless", "--frames", "never.png"])
        .arg(bundle.folder())
        // The Vulkan loader then finds no driver.
        .env("VK_ICD_FILENAMES", "/dev/null")
        .env("VK_DRIVER_FILES", "/dev/null")
        .output()
        .unwrap();
    if cfg!(target_os = "linux") {
        expect_error(&output, 1, "no GPU adapter; install mesa-vulkan-drivers for a software one");
    }
}

#[test]
fn truncated_and_damaged_files() {
    if !gpu_there() {
        return;
    }
    for name in ["scene.relume", "glow.relume", "basis.relume", "images.relume"] {
        let bundle = Bundle::write(true);
        let path = bundle.folder().join(name);
        let bytes = std::fs::read(&path).unwrap();
        std::fs::write(&path, &bytes[..bytes.len() - 7]).unwrap();
        let play = || headless(bundle.folder(), &["--animation", "glow", "--frames", "@/%d.png"]);
        expect_error(&play(), 2, "cut short");
        let mut damaged = bytes.clone();
        *damaged.last_mut().unwrap() ^= 1;
        std::fs::write(&path, damaged).unwrap();
        expect_error(&play(), 2, "checksum");
        std::fs::remove_file(&path).unwrap();
        let missing = format!("{name}: is missing although the manifest lists it; bake it again");
        expect_error(&play(), 2, &missing);
        assert!(!bundle.folder().join("0.png").exists());
    }
}

/// All animations are read, for a bundle is sound or it is not, whatever is played of it.
#[test]
fn a_damaged_animation_is_refused_though_nobody_plays_it() {
    if !gpu_there() {
        return;
    }
    let bundle = Bundle::write(true);
    let path = bundle.folder().join("glow.relume");
    let mut damaged = std::fs::read(&path).unwrap();
    *damaged.last_mut().unwrap() ^= 1;
    std::fs::write(&path, damaged).unwrap();
    expect_error(
        &headless(bundle.folder(), &["--frames", "@/%d.png"]),
        2,
        "glow.relume: section `animation`: checksum",
    );
    assert!(!bundle.folder().join("0.png").exists());
}

#[test]
fn an_animation_becomes_frames_a_sheet_and_statistics() {
    if !gpu_there() {
        return;
    }
    let bundle = Bundle::write(true);
    let files = [
        "--frames",
        "@/png/f%03d.png",
        "--exr",
        "@/deep/er/%d.exr",
        "--contact-sheet",
        "@/sheet.png",
        "--stats",
        "@/s.json",
    ];
    expect_success(&headless(
        bundle.folder(),
        &[&files[..], &["--animation", "glow", "--fps", "8"]].concat(),
    ));
    let at = |name: &str| bundle.folder().join(name);
    assert!(at("png/f003.png").exists() && !at("png/f004.png").exists() && !at("deep/er/4.exr").exists());
    // Frame 1 is at 1/8 s, halfway to the key at 0.25 s.
    let mut materials = support::default_materials();
    materials[0] =
        Brdf::BlinnPhong(BlinnPhong { kd: [0.3, 0.2, 0.15], ..support::blinn_phong(materials[0]) });
    let expected = bundle.evaluate(&materials, |_| true);
    let radiance = exr(&at("deep/er/1.exr"));
    assert!(support::largest_difference(&radiance, &expected) <= 1e-5);
    // PNG = sRGB(curve(2^ev · L)), the scene's exposure being 0.5; one step apart where rounding falls on a
    // boundary.
    let display = Display { exposure_ev: 0.5, tonemap: Tonemap::Neutral };
    let png = image::open(at("png/f001.png")).unwrap().to_rgb8();
    for (pixel, radiance) in png.pixels().zip(&radiance) {
        for (byte, value) in pixel.0.iter().zip(display.shown(*radiance)) {
            let linear = f64::from(value);
            let srgb =
                if linear <= 0.0031308 { 12.92 * linear } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 };
            assert!((f64::from(*byte) - 255.0 * srgb).abs() <= 0.501, "{byte} for {value}");
        }
    }
    let sheet = image::open(at("sheet.png")).unwrap();
    assert_eq!((sheet.width(), sheet.height()), (2 * (37 + 4) + 4, 2 * (23 + 4) + 4));
    let stats = stats(&at("s.json"));
    assert_eq!(
        (&stats["frames"], &stats["method"], &stats["bytes_streamed"]),
        (&4.into(), &"transfer-images".into(), &bundle.playlist_bytes().into())
    );
    assert_eq!(
        (&stats["size"], stats["missing_slots"].as_array().unwrap().len()),
        (&serde_json::json!([37, 23]), 0)
    );
    assert!(
        stats["cpu_ms"]["median"].as_f64().unwrap() > 0.0
            && (stats["gpu_ms"].is_null() || stats["gpu_ms"]["p95"].as_f64().unwrap() > 0.0)
    );
    assert!(
        stats["time_to_first_image_s"].as_f64().unwrap() <= stats["time_to_full_quality_s"].as_f64().unwrap()
    );
    let temporary = std::fs::read_dir(at("png"))
        .unwrap()
        .filter(|e| !e.as_ref().unwrap().path().to_string_lossy().ends_with(".png"));
    assert_eq!(temporary.count(), 0);
}

#[test]
fn a_prefix_plays_what_it_holds() {
    if !gpu_there() {
        return;
    }
    let bundle = Bundle::write(true);
    let play = |bytes: u64| {
        headless(bundle.folder(), &["--bytes", &bytes.to_string(), "--exr", "@/p.exr", "--stats", "@/s.json"])
    };
    let all = bundle.playlist_bytes();
    expect_success(&play(all - bundle.manifest.methods[0].files[1].1.bytes / 2));
    let stats = stats(&bundle.folder().join("s.json"));
    let missing: Vec<u64> =
        stats["missing_slots"].as_array().unwrap().iter().map(|v| v.as_u64().unwrap()).collect();
    let slots = bundle.images.images.len();
    assert!((1..slots).contains(&missing.len()) && stats["time_to_full_quality_s"].is_null());
    assert!(stats["bytes_streamed"].as_u64().unwrap() < all);
    // The last images of the file are those that are missing.
    let mut last: Vec<u64> =
        bundle.images.images[slots - missing.len()..].iter().map(|image| image.slot as u64).collect();
    last.sort_unstable();
    assert_eq!(missing, last);
    let expected = bundle.evaluate(&support::default_materials(), |slot| !missing.contains(&(slot as u64)));
    assert!(support::largest_difference(&exr(&bundle.folder().join("p.exr")), &expected) <= 1e-5);
    expect_error(&play(1000), 2, "give at least");
    expect_success(&play(all));
}

#[test]
fn adapters_are_listed_and_found() {
    if !gpu_there() {
        return;
    }
    let list = player(&["--list-adapters"]);
    expect_success(&list);
    let text = String::from_utf8(list.stdout).unwrap();
    let name = text.lines().next().unwrap().split(" [").next().unwrap().to_uppercase();
    let bundle = Bundle::write(false);
    expect_success(&headless(bundle.folder(), &["--adapter", &name, "--frames", "@/f.png", "--count", "1"]));
}

/// A lit bundle, and how to play it with `--exr @/%d.exr` and more.
fn play_lit(bundle: &sparse::Bundle, arguments: &[&str]) -> Output {
    headless(bundle.folder(), &[&["--exr", "@/%d.exr"], arguments].concat())
}

#[test]
fn light_view_and_size_are_set() {
    if !gpu_there() {
        return;
    }
    let bundle = sparse::Bundle::write(16, false);
    let file = |name: &str, text: &str| std::fs::write(bundle.folder().join(name), text).unwrap();
    for (text, part) in [
        ("environment.map = \"moon\"", "no map `moon`; this bundle has: noise, sun, black, even"),
        ("environment.gain = [1.0, -0.5, 1.0]", "gain"),
        ("environment.gain = [1.0, nan, 1.0]", "gain"),
        ("environment.rotation_deg = inf", "rotation_deg"),
        ("camera.fov_deg = 500.0", "fov_deg"),
        ("materials.grid.kd = [0.1, 0.1, 0.1]", "sets material `grid`"),
    ] {
        file("state.toml", text);
        expect_error(&play_lit(&bundle, &["--state", "@/state.toml"]), 2, part);
    }
    file("moon.toml", "duration_s = 1.0\n[[key]]\nt_s = 0.5\nenvironment.map = \"moon\"");
    expect_error(
        &play_lit(&bundle, &["--animation", "@/moon.toml"]),
        2,
        "at 0.5 s: environment: no map `moon`",
    );
    file(
        "through.toml",
        "duration_s = 1.0\n[[key]]\nt_s = 0\ncamera.position = [0, 0, 3]\n[[key]]\nt_s = 1\ncamera.position = [0, 0, -3]",
    );
    expect_error(&play_lit(&bundle, &["--animation", "@/through.toml"]), 2, "the position meets the target");
    expect_error(
        &play_lit(&bundle, &["--animation", "glow", "--method", "sparse-transfer"]),
        2,
        "sets material `a`",
    );
    expect_error(&play_lit(&bundle, &["--method", "sphere-shadows"]), 2, "this bundle has: sparse-transfer");
    assert!(!bundle.folder().join("0.exr").exists());

    expect_success(&play_lit(&bundle, &["--size", "64x32", "--stats", "@/s.json"]));
    let stats = stats(&bundle.folder().join("s.json"));
    assert_eq!((&stats["size"], &stats["method"]), (&serde_json::json!([64, 32]), &"sparse-transfer".into()));
    assert_eq!(
        (&stats["pieces"], &stats["pieces_arrived"], &stats["pieces_expected"]),
        (&"blocks".into(), &5.into(), &5.into())
    );
    assert!(
        stats["image_bytes_per_frame"].as_u64().unwrap() > 3000
            && stats["time_to_full_quality_s"].is_number()
    );
    let pixels = image_size(&bundle.folder().join("0.exr"));
    assert_eq!(pixels, [64, 32]);
    let images = Bundle::write(true);
    expect_error(
        &headless(images.folder(), &["--frames", "@/f.png", "--size", "64x32"]),
        2,
        "this bundle was baked at 37x23",
    );
}

fn image_size(path: &Path) -> [usize; 2] {
    let meta = exr::meta::MetaData::read_from_file(path, false).unwrap();
    let size = meta.headers[0].layer_size;
    [size.x(), size.y()]
}

#[test]
fn an_animation_of_the_light_goes_through_its_states() {
    if !gpu_there() {
        return;
    }
    let bundle = sparse::Bundle::write(16, true);
    expect_success(&play_lit(&bundle, &["--animation", "turn", "--fps", "4", "--count", "5"]));
    let frame = |i: usize| std::fs::read(bundle.folder().join(format!("{i}.exr"))).unwrap();
    let frames: Vec<_> = (0..5).map(frame).collect();
    // Frame 2 is halfway; frame 4 at the second key. Each is what its state alone shows.
    for (number, text) in [
        (
            2,
            "environment = { map = \"noise\", rotation_deg = 45.0, gain = [1.5, 1.0, 0.5] }\ncamera.position = [0.5, 0.0, 3.0]",
        ),
        (
            4,
            "environment = { map = \"sun\", rotation_deg = 90.0, gain = [2.0, 1.0, 0.0] }\ncamera.position = [1.0, 0.0, 3.0]",
        ),
    ] {
        std::fs::write(bundle.folder().join("state.toml"), text).unwrap();
        expect_success(&headless(bundle.folder(), &["--state", "@/state.toml", "--exr", "@/state.exr"]));
        assert!(
            std::fs::read(bundle.folder().join("state.exr")).unwrap() == frames[number],
            "frame {number}"
        );
    }
    assert!(frames[0] != frames[1] && frames[3] != frames[4]);
}

#[test]
fn the_first_known_method_is_preferred_and_another_can_be_chosen() {
    if !gpu_there() {
        return;
    }
    // A bundle of images whose scene has as many vertices as the rows.
    let mut bundle = Bundle::write(true);
    let mut scene = StoredScene::read_file(&bundle.folder().join("scene.relume")).unwrap();
    let lit =
        sparse::Bundle::of(sparse::scene([11, 7]), sparse::maps(), None, sparse::even_transfer(3, 4, 1.0));
    (scene.meta.varies_light, scene.meta.environment) = (true, lit.scene.meta.environment.clone());
    bundle.manifest.scene_file =
        FileEntry::of("scene.relume", &scene.write_file(&bundle.folder().join("scene.relume")).unwrap());
    let rows = lit.manifest.methods[0].clone();
    for (_, entry) in &rows.files {
        std::fs::copy(lit.folder().join(&entry.file), bundle.folder().join(&entry.file)).unwrap();
    }
    let future = MethodEntry { name: "future".to_owned(), files: Vec::new(), ..rows.clone() };
    let images = bundle.manifest.methods[0].clone();
    let played = |methods: [&MethodEntry; 3], arguments: &[&str]| {
        let mut manifest = bundle.manifest.clone();
        manifest.methods = methods.map(MethodEntry::clone).to_vec();
        manifest.write(bundle.folder()).unwrap();
        expect_success(&headless(bundle.folder(), &[&["--stats", "@/s.json"], arguments].concat()));
        stats(&bundle.folder().join("s.json"))["method"].as_str().unwrap().to_owned()
    };
    assert_eq!(played([&future, &rows, &images], &[]), "sparse-transfer");
    assert_eq!(played([&images, &rows, &future], &[]), "transfer-images");
    assert_eq!(played([&images, &rows, &future], &["--method", "sparse-transfer"]), "sparse-transfer");
    // An animation of materials is of the one, one of the light of the other.
    assert_eq!(played([&images, &rows, &future], &["--animation", "glow"]), "transfer-images");
    expect_error(
        &headless(
            bundle.folder(),
            &["--stats", "@/s.json", "--animation", "glow", "--method", "sparse-transfer"],
        ),
        2,
        "material `a`",
    );
    expect_error(
        &headless(bundle.folder(), &["--stats", "@/s.json", "--method", "future"]),
        2,
        "method `future` is unknown to this player",
    );
}

#[test]
fn a_prefix_of_blocks_plays() {
    if !gpu_there() {
        return;
    }
    let bundle = sparse::Bundle::write(16, true);
    let play = |bytes: u64| play_lit(&bundle, &["--bytes", &bytes.to_string(), "--stats", "@/s.json"]);
    let output = play(1000);
    expect_error(&output, 2, "give at least");
    let text = String::from_utf8(output.stderr).unwrap();
    let least: u64 = text.trim().rsplit(' ').next().unwrap().parse().unwrap();
    expect_error(&play(least - 1), 2, "give at least");
    let missing = |bytes: u64| {
        expect_success(&play(bytes));
        stats(&bundle.folder().join("s.json"))["missing_slots"].clone()
    };
    assert_eq!(missing(least), serde_json::json!([1, 2, 3, 4]));
    let files: u64 = bundle.manifest.methods[0].files.iter().map(|(_, entry)| entry.bytes).sum();
    let animations: u64 = bundle.manifest.animations.values().map(|entry| entry.bytes).sum();
    let all = files + animations + bundle.manifest.scene_file.bytes;
    assert_eq!((missing(all - 1), missing(all)), (serde_json::json!([4]), serde_json::json!([])));
}

#[cfg(target_os = "linux")]
#[test]
fn an_interrupt_ends_it_with_130() {
    if !gpu_there() {
        return;
    }
    let bundle = Bundle::write(true);
    let mut child = Command::new(env!("CARGO_BIN_EXE_player"))
        .arg(bundle.folder())
        // At this rate loading would take minutes.
        .args(["--headless", "--rate", "100", "--exr", "never.exr"])
        .stderr(std::process::Stdio::piped())
        .spawn()
        .unwrap();
    crate::run::wait_until_it_listens(&mut child);
    let killed = Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap();
    assert!(killed.success());
    expect_error(&child.wait_with_output().unwrap(), 130, "interrupted");
}
