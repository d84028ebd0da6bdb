//! Environment maps of the user's own files.

use crate::run::{expect_error, expect_success, gpu_there, headless, stats};
use crate::support::{Bundle, shadows, sparse};
use relume_formats::kinds::Environment;
use relume_player::output::encode_exr;
use std::path::Path;

/// Writes `map` as an EXR file, which holds it to the bit.
fn write(map: &Environment, path: &Path) {
    std::fs::create_dir_all(path.parent().unwrap()).unwrap();
    std::fs::write(path, encode_exr([map.map.width, map.map.height], &map.map.texels).unwrap()).unwrap();
}

/// The frame that `arguments` make, as a file of linear radiance.
fn frame(folder: &Path, arguments: &[&str]) -> Vec<u8> {
    let output = headless(
        folder,
        &[&["--exr", "@/frame.exr", "--stats", "@/stats.json", "--count", "1"], arguments].concat(),
    );
    expect_success(&output);
    let stderr = String::from_utf8_lossy(&output.stderr);
    let warned = stderr.lines().filter(|line| line.starts_with("warning: the environment map")).count();
    assert_eq!(warned, usize::from(stats(&folder.join("stats.json"))["remark"].is_string()), "{stderr}");
    std::fs::read(folder.join("frame.exr")).unwrap()
}

/// However a map is given, the frame is that of the bundle's own map, bit for bit; and only of what comes
/// from outside it is said, and warned once, that it was not measured.
fn expect_the_same(folder: &Path, maps: &[Environment], more: &[&str]) {
    let frame = |arguments: &[&str]| {
        let frame = frame(folder, &[arguments, more].concat());
        (frame, stats(&folder.join("stats.json"))["remark"].as_str().map(str::to_owned))
    };
    let mut frames = Vec::new();
    for map in maps {
        let name = &map.name;
        write(map, &folder.join(format!("maps/my {name}.exr")));
        let turned = "rotation_deg = 33.0, gain = [1.0, 0.5, 2.0] }\n";
        std::fs::write(folder.join("own.toml"), format!("environment = {{ map = '{name}', {turned}"))
            .unwrap();
        std::fs::write(folder.join("turned.toml"), format!("environment = {{ {turned}")).unwrap();
        std::fs::write(
            folder.join("maps/file.toml"),
            format!("environment = {{ map = 'my {name}.exr', {turned}"),
        )
        .unwrap();
        let animation = format!(
            "duration_s = 1.0\n[[key]]\nt_s = 0\nenvironment = {{ map = 'maps/my {name}.exr', {turned}"
        );
        std::fs::write(folder.join("file-animation.toml"), animation).unwrap();
        let (own, remark) = frame(&["--state", "@/own.toml"]);
        assert_eq!(remark, None, "{name}");
        let file = format!("@/maps/my {name}.exr");
        for given in [
            &["--state", "@/maps/file.toml"][..],
            &["--state", "@/turned.toml", "--environment", &file],
            &["--state", "@/own.toml", "--environment", &file],
            &["--animation", "@/file-animation.toml"],
        ] {
            let (theirs, remark) = frame(given);
            assert!(theirs == own, "{name} {given:?}");
            assert!(remark.unwrap().contains("is not one of the bundle's own"), "{given:?}");
        }
        frames.push(own);
    }
    assert!(frames.windows(2).all(|pair| pair[0] != pair[1]), "maps differ");
}

#[test]
fn a_map_by_its_file_shines_as_by_its_name() {
    if !gpu_there() {
        return;
    }
    let rows = sparse::Bundle::write(16, true);
    expect_the_same(rows.folder(), &rows.maps, &[]);
    let shadows = shadows::Bundle::write(true);
    expect_the_same(shadows.folder(), &shadows.maps, &[]);
    expect_the_same(shadows.folder(), &shadows.maps[..2], &["--adapter", "cpu"]);
}

#[test]
fn the_bundles_own_map_comes_before_a_file_of_its_name() {
    if !gpu_there() {
        return;
    }
    let mut maps = sparse::maps();
    maps[1].name = "sun.exr".to_owned();
    let bundle = sparse::Bundle::of(sparse::scene([11, 7]), maps, None, sparse::transfer(77, 16, false));
    let at = |name: &str| bundle.folder().join(name);
    std::fs::remove_file(at("turn.relume")).unwrap();
    std::fs::write(at("sun.exr"), "no map at all").unwrap();
    std::fs::write(at("s.toml"), "environment.map = 'sun.exr'\n").unwrap();
    let mut manifest = bundle.manifest.clone();
    manifest.animations.remove("turn");
    manifest.write(bundle.folder()).unwrap();
    frame(bundle.folder(), &["--state", "@/s.toml"]);
    assert!(stats(&at("stats.json"))["remark"].is_null());
    // Who names the file means it.
    expect_error(
        &headless(bundle.folder(), &["--exr", "@/f.exr", "--environment", "@/sun.exr"]),
        2,
        "sun.exr: is no OpenEXR file",
    );
}

#[test]
fn what_is_no_map_is_refused_in_one_line() {
    if !gpu_there() {
        return;
    }
    let (rows, images) = (sparse::Bundle::write(16, false), Bundle::write(true));
    let at = |name: &str| rows.folder().join(name);
    let with = |more: &[&str]| headless(rows.folder(), &[&["--frames", "@/f.png"], more].concat());
    std::fs::write(at("text.hdr"), "hello").unwrap();
    std::fs::write(at("square.exr"), encode_exr([16, 16], &[[1.0; 3]; 256]).unwrap()).unwrap();
    std::fs::write(at("bright.exr"), encode_exr([4, 2], &[[1e13; 3]; 8]).unwrap()).unwrap();
    std::fs::create_dir(at("folder.exr")).unwrap();
    for (file, part) in [
        ("@/gone.exr", "gone.exr: "),
        (
            "@/text.hdr",
            "text.hdr: is no Radiance file, though its name says so, but a text; save the picture again",
        ),
        ("@/square.exr", "square.exr: 16 × 16 texels, square as mirror balls"),
        ("@/bright.exr", "bright.exr: a radiance is outside 0..1e12; mend or scale the picture"),
        ("@/manifest.json", "it reads .hdr and .exr, convert it"),
        ("@/folder.exr", "folder.exr: not a regular file but a folder; give a file"),
    ] {
        expect_error(&with(&["--environment", file]), 2, part);
    }
    for (text, part) in [
        (
            "camera.exposure_ev = 1\n[environment]\nmap = 'gone.exr'\n",
            "s.toml: line 3: environment: no map `gone.exr`, nor a file of that name",
        ),
        (
            "[environment]\nmap = 'nois'\n",
            "no map `nois`; this bundle has: noise, sun, black, even; did you mean `noise`?",
        ),
        ("[environment]\nmap = 'text.hdr'\n", "text.hdr: is no Radiance file"),
        ("[environment]\nmap = 'square.exr'\n", "16 × 16 texels"),
    ] {
        std::fs::write(at("s.toml"), text).unwrap();
        expect_error(&with(&["--state", "@/s.toml"]), 2, part);
    }
    assert!(!at("f.png").exists());
    write(&rows.maps[0], &images.folder().join("sky.exr"));
    let given = headless(images.folder(), &["--frames", "@/f.png", "--environment", "@/sky.exr"]);
    expect_error(
        &given,
        2,
        "this bundle does not vary the light, so no map can be added; leave it out, or add light = true to [vary]",
    );
    std::fs::write(images.folder().join("s.toml"), "environment.map = 'sky.exr'\n").unwrap();
    expect_error(
        &headless(images.folder(), &["--frames", "@/f.png", "--state", "@/s.toml"]),
        2,
        "sets [environment], which this bundle does not vary",
    );
}
