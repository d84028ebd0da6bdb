//! `bake plan` as a user runs it, and its predictions against real bakes.

use crate::shadows;
use crate::support::relit;
use crate::support::room::ROOM;
use crate::support::{command, expect_exit, write_scene};
use serde_json::Value;
use std::path::Path;

/// The room as large as predictions need.
fn room() -> String {
    ROOM.replace("size = [48, 40]", "size = [96, 80]")
}

/// Runs `bake` in `folder` and returns what it prints.
fn bake_in(folder: &Path, arguments: &[&str]) -> String {
    let output = command("bake").args(arguments).current_dir(folder).output().unwrap();
    assert!(output.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

fn json(text: &str) -> Value {
    serde_json::from_str(text).unwrap()
}

/// Plans the scene, bakes it with the defaults that the plan is for, and compares what was predicted with
/// what came.
fn check_predictions(scene: &str, method: &str) {
    let folder = tempfile::tempdir().unwrap();
    let path = write_scene(folder.path(), scene);
    let path = path.to_str().unwrap();
    let plan = json(&bake_in(folder.path(), &["plan", path, "--json"]));
    assert_eq!(plan["chosen"], method, "{plan}");
    bake_in(folder.path(), &["run", path, "-o", "bundle", "--progress", "none"]);
    let bundle = folder.path().join("bundle");
    let info = json(&bake_in(folder.path(), &["info", "bundle", "--json"]));
    let report = json(&std::fs::read_to_string(bundle.join("report.json")).unwrap());
    let candidate = plan["methods"].as_array().unwrap().iter().find(|m| m["name"] == method).unwrap();
    let predicted = &candidate["predicted"];
    let ratio = |predicted: &Value, actual: &Value| predicted.as_f64().unwrap() / actual.as_f64().unwrap();
    let rays = ratio(&predicted["rays"], &report["methods"][method]["rays"]);
    let bytes = ratio(&predicted["bytes_on_disk"], &info["totals"]["bytes_on_disk"]);
    println!("{method}: predicted over actual: rays {rays:.3}, bytes {bytes:.3}");
    // Rays are those of a hundred and more receivers or pixels, each within a factor of two of the mean: a
    // few per cent of chance.
    assert!((rays - 1.0).abs() < 0.25, "rays {rays}");
    // Bytes are halves and steps counted in a sample, times what such take in the library's bundles; how many
    // terms or bases there are is found on the sample.
    assert!((1.0 / 1.5..1.5).contains(&bytes), "bytes {bytes}");
    assert!(
        predicted["seconds"].as_f64().unwrap() > 0.0 && predicted["bytes_of_memory"].as_f64().unwrap() > 1e6
    );
}

#[test]
fn predictions_of_transfer_images_come_true() {
    check_predictions(&room(), "transfer-images");
}

#[test]
fn predictions_of_sparse_transfer_come_true() {
    check_predictions(&format!("{} file = 'lamps'\n", relit::BALL), "sparse-transfer");
}

#[test]
fn predictions_of_bounced_light_come_true() {
    let bounced = relit::BALL.replace("reflections = 1", "reflections = 2");
    check_predictions(&format!("{bounced} file = 'lamps'\n"), "sparse-transfer");
}

#[test]
fn predictions_of_sphere_shadows_come_true() {
    check_predictions(&shadows::knot(), "sphere-shadows");
}

#[test]
fn plans_tell_what_is_stored_and_never_fail_for_want_of_it() {
    let folder = tempfile::tempdir().unwrap();
    let path = write_scene(folder.path(), &room());
    let path = path.to_str().unwrap();
    let name = folder.path().file_name().unwrap().to_str().unwrap();
    let before = json(&bake_in(folder.path(), &["plan", path, "--json"]));
    assert!(before["methods"][0]["stored"].is_null() && before["stored_unusable"].is_null());
    bake_in(folder.path(), &["run", path, "--spp", "4", "--bases", "4", "--progress", "none"]);
    let after = json(&bake_in(folder.path(), &["plan", path, "--json"]));
    let stored = &after["methods"][0]["stored"];
    assert_eq!((&stored["settings"]["bases"], &stored["settings"]["samples"]), (&4.into(), &4.into()));
    let manifest =
        json(&std::fs::read_to_string(folder.path().join("baked").join(name).join("manifest.json")).unwrap());
    assert_eq!(stored["errors"], manifest["methods"][0]["errors"]);
    // Colours of materials that vary change no hash; a fixed shape does.
    write_scene(folder.path(), &room().replace("scale = 0.5", "scale = 0.4"));
    let changed = json(&bake_in(folder.path(), &["plan", path, "--json"]));
    assert!(changed["methods"][0]["stored"].is_null() && changed["stored_unusable"].is_string());
    let text = bake_in(folder.path(), &["plan", path, "--max-error", "0.3"]);
    assert!(text.contains("stored figures are left out: ") && text.contains("max_error 0.3"), "{text}");
}

#[test]
fn what_varies_nothing_or_is_not_there_ends_as_it_should() {
    let folder = tempfile::tempdir().unwrap();
    let still = room().replace("materials = ['ball', 'room']", "");
    let path = write_scene(folder.path(), &still);
    let text = bake_in(folder.path(), &["plan", path.to_str().unwrap()]);
    assert!(text.contains("varies nothing") && text.contains("`bake reference`"), "{text}");
    let stderr = expect_exit("bake", &["plan", "no-such-scene"], 2);
    assert!(stderr.contains("no-such-scene"), "{stderr}");
}
