//! What `bake run` reports of frames, with players that do as a test tells them.

#![cfg(unix)]

use crate::support::{command, write_scene};
use serde_json::Value;
use std::os::unix::fs::PermissionsExt;
use std::path::Path;
use std::process::Command;

/// A quad under an even sky.
const QUAD: &str = "
    [vary]
    materials = ['white']
    [render]
    size = [16, 16]
    [camera]
    position = [0.0, 2.0, 5.0]
    target = [0.0, 0.5, 0.0]
    fov_deg = 40.0
    [materials.white]
    brdf = 'blinn-phong'
    kd = [0.8, 0.8, 0.8]
    [[object]]
    name = 'plane'
    shape = 'quad'
    material = 'white'
    [environment]
";

/// Bakes the quad with a `bake` beside which `player` stands, a shell script, or nothing; returns what it
/// printed and the report.
fn bake_beside(player: Option<&str>) -> (String, Value) {
    let folder = tempfile::tempdir().unwrap();
    let programs = folder.path().join("a/b");
    std::fs::create_dir_all(&programs).unwrap();
    std::fs::copy(command("bake").get_program(), programs.join("bake")).unwrap();
    if let Some(script) = player {
        let path = programs.join("player");
        std::fs::write(&path, format!("#!/bin/sh\n{script}\n")).unwrap();
        std::fs::set_permissions(&path, std::fs::Permissions::from_mode(0o755)).unwrap();
    }
    let scene = write_scene(folder.path(), QUAD);
    let bundle = folder.path().join("bundle");
    let output = Command::new(programs.join("bake"))
        .args([Path::new("run"), &scene, Path::new("-o"), &bundle])
        .args(["--spp", "4", "--bases", "4", "--progress", "none"])
        .output()
        .unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let report = serde_json::from_slice(&std::fs::read(bundle.join("report.json")).unwrap()).unwrap();
    (String::from_utf8(output.stdout).unwrap(), report)
}

#[test]
fn what_the_player_measured_goes_to_the_report() {
    // The last argument is the file for statistics.
    let script = r#"for last; do :; done; echo '{"adapter": "fake", "frame_ms": {"median": 1.5, "p95": 2.5}, "cpu_ms": null, "gpu_bytes": 7}' > "$last""#;
    let (text, report) = bake_beside(Some(script));
    let expected = serde_json::json!({ "adapter": "fake", "median_ms": 1.5, "p95_ms": 2.5, "states": 6 });
    assert_eq!(report["frame"]["transfer-images"], expected);
    assert!(
        report["methods"]["transfer-images"]["rays"].as_u64().unwrap() > 0,
        "the rest of the report stays: {report}"
    );
    assert!(text.contains("transfer-images: a frame in 1.50 ms, 95 % of them in 2.50 ms, on fake"), "{text}");
}

#[test]
fn a_bake_does_without_a_player_that_is_missing_fails_or_never_ends() {
    let cases = [
        (None, "there is no `player`"),
        (Some("echo 'error: no adapter' >&2; exit 1"), "no adapter"),
        (Some("exec sleep 60"), "longer than 5 s"),
    ];
    for (player, expected) in cases {
        let (text, report) = bake_beside(player);
        let reason = report["frame"]["transfer-images"]["unmeasured"].as_str().unwrap();
        assert!(reason.contains(expected) && !text.contains("a frame in"), "{reason}");
    }
}

/// Steps follow one another, so that they are as long as the bake at most.
#[test]
fn the_report_tells_what_every_step_took() {
    let (_, report) = bake_beside(None);
    let steps = report["steps"].as_object().unwrap();
    for name in ["reading", "looking", "basis", "preparing", "tracing", "packing", "measuring", "writing"] {
        assert!(steps[name].as_f64().unwrap() > 0.0, "{name}: {steps:?}");
    }
    let sum: f64 = steps.values().filter_map(Value::as_f64).sum();
    assert!(sum <= report["seconds"].as_f64().unwrap(), "{report}");
}
