//! The files in `corpus/crashers` once made a reader panic, or take all memory; each must be refused in one
//! line that names it.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "a test fails by panicking")]

use std::path::Path;

const VIEW: &str = "[render]\nsize = [8, 8]\n[camera]\nposition = [0.0, 1.0, 4.0]\ntarget = [0.0, 1.0, 0.0]\nfov_deg = 40.0\n";

/// A scene that names `file` where files of its type belong.
fn scene_of(file: &str) -> String {
    let material = "[materials.a]\nbrdf = \"blinn-phong\"\nkd = [0.5, 0.5, 0.5]\nks = [0.0, 0.0, 0.0]\nshininess = 10.0\n";
    let quad = "[[object]]\nname = \"quad\"\nmaterial = \"a\"\nshape = \"quad\"\n";
    let part = match file.rsplit('.').next().unwrap() {
        "hdr" | "exr" => format!("{material}{quad}[environment]\nfile = \"{file}\"\n"),
        "png" | "jpg" => format!("{material}texture = \"{file}\"\n{quad}"),
        _ => format!("{material}[[object]]\nname = \"a\"\nmaterial = \"a\"\nfile = \"{file}\"\n"),
    };
    format!("{VIEW}{part}")
}

#[test]
fn every_crasher_is_refused() {
    let mut refused = 0;
    for entry in std::fs::read_dir(Path::new(env!("CARGO_MANIFEST_DIR")).join("corpus/crashers")).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_name().unwrap().to_str().unwrap();
        let folder = tempfile::tempdir().unwrap();
        std::fs::copy(&path, folder.path().join(name)).unwrap();
        std::fs::write(folder.path().join("scene.toml"), scene_of(name)).unwrap();
        let error = relume_scenes::load(&folder.path().join("scene.toml")).expect_err(name);
        let message = error.to_string();
        assert!(
            error.is_bad_input() && message.contains(name) && !message.contains('\n'),
            "{name}: {message}"
        );
        refused += 1;
    }
    assert!(refused > 0, "the folder of crashers is not where this test looks");
}
