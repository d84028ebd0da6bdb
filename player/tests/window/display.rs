//! Curve, exposure and a map of the user's own, in the window as without one.

use super::{Twin, expect_picture, expect_same_without_window, state};
use crate::desk::{Display, Window};
use crate::support::{Bundle, sparse};
use relume_formats::display::{Tonemap, auto_exposure_ev};
use relume_formats::state::State;
use relume_player::output::encode_exr;
use std::path::PathBuf;

/// Saves states, from this number on, until one has an exposure that the picture asked for: the picture may
/// take its time. Returns its file and the next number.
fn exposed(window: &mut Window<'_>, scene: &str, mut number: usize) -> (PathBuf, usize) {
    loop {
        let path = window.save("t", &format!("{scene}-{number:04}.toml"));
        number += 1;
        if std::fs::read_to_string(&path).is_ok_and(|text| text.contains("exposure_ev")) {
            return (path, number);
        }
    }
}

#[test]
fn curve_and_exposure_are_set_by_hand() {
    let Some(display) = Display::open() else { return };
    let bundle = Bundle::write(true);
    let mut window = Window::open(&display, bundle.folder(), &[], "synthetic - Relume");
    let mut twin = Twin::new(&bundle, window.size());
    // Whole, so that the picture is that which the exposure is taken from.
    window.expect_nothing_set();
    twin.click(&window, twin.mirror.rect("AgX").center());
    twin.click(&window, twin.mirror.rect("Auto").center());
    let (saved, _) = exposed(&mut window, "synthetic", 1);
    let saved = state(&saved);
    let (_, radiance) = relume_player::render_once(bundle.folder(), &State::default(), None).unwrap();
    let ev = saved.camera.clone().unwrap().exposure_ev.unwrap();
    assert!((ev - auto_exposure_ev(&radiance).unwrap()).abs() < 1e-4, "{ev}");
    assert_eq!(saved.view.as_ref().unwrap().tonemap, Some(Tonemap::Agx));
    expect_picture(&bundle, &saved, &window.save("s", "synthetic-0002.png"));
    twin.editor.set_tonemap(Tonemap::Agx);
    twin.editor.set_exposure(ev);
    (0..3).for_each(|_| twin.frame(Vec::new()));
    twin.click(&window, twin.mirror.rect("Reset display").center());
    window.expect_nothing_set();
    window.keys("q");
    assert_eq!(window.end(), (Some(0), String::new()));
}

#[test]
fn a_map_from_a_file_shows_the_same_without_a_window() {
    let Some(display) = Display::open() else { return };
    let bundle = sparse::Bundle::write(16, true);
    let map = bundle.map("sun");
    let sky = bundle.folder().join("my sky.exr");
    std::fs::write(&sky, encode_exr([map.width, map.height], &map.texels).unwrap()).unwrap();
    let options = ["--environment", sky.to_str().unwrap(), "--exposure", "auto", "--stats", "stats.json"];
    let mut window = Window::open(&display, bundle.folder(), &options, "lit - Relume");
    // Metered once the picture is whole, and then another picture.
    let (saved, _) = exposed(&mut window, "lit", 1);
    assert_eq!(state(&saved).environment.unwrap().map.as_deref(), sky.to_str());
    let png = window.save("s", "lit-0001.png");
    expect_same_without_window(bundle.folder(), &png, &["--state", saved.to_str().unwrap()]);
    let stats_path = window.folder.path().join("stats.json");
    window.keys("q");
    assert!(window.wait_for_stats(&stats_path)["remark"].is_string());
    assert_eq!(window.end(), (Some(0), String::new()));
}
