//! A bundle on show without a window.

use super::*;
use crate::gpu::{self, Gpu};
use crate::session::Request;
use crate::stream::Limits;
use crate::support::{self, Bundle, sparse};
use crate::ui::Motion;
use relume_formats::display::{Tonemap, auto_exposure_ev};
use relume_formats::state::{EnvironmentState, MaterialState};
use relume_playback::PlacedState;

fn live(folder: &Path, limits: Limits) -> Live {
    let state = PlacedState::default();
    let request = Request { folder, method: None, state, animation: None, environment: None, meters: false, size: None, limits };
    Live::new(Session::start(request, || Gpu::open(None)).unwrap(), Instant::now(), true)
}

fn load(live: &mut Live) {
    while live.is_loading() {
        live.poll().unwrap();
    }
}

fn gpu_there() -> bool {
    support::gpu_there(|| gpu::list().map(|_| ()).map_err(|e| e.to_string()))
}

#[test]
fn no_more_is_drawn_than_has_changed() {
    if !gpu_there() {
        return;
    }
    let bundle = Bundle::write(true);
    let mut live = live(bundle.folder(), Limits::default());
    assert!(!live.draw().unwrap() && live.shown().is_none(), "nothing is there yet");
    load(&mut live);
    assert!(live.draw().unwrap() && !live.draw().unwrap());
    live.shown().unwrap().editor.set_exposure(2.0);
    assert!(live.draw().unwrap() && !live.draw().unwrap());
    live.shown().unwrap().editor.edit("a", &MaterialState { shininess: Some(3.0), ..Default::default() });
    assert!(live.draw().unwrap() && !live.draw().unwrap());
    live.shown().unwrap().editor.select(Some("b"));
    assert!(!live.draw().unwrap());
    let facts = live.facts();
    assert_eq!((facts.pieces, facts.bytes), (facts.pieces_expected, facts.bytes_expected));
    let statistics: serde_json::Value = serde_json::from_slice(&live.statistics().unwrap().unwrap()).unwrap();
    assert_eq!(statistics["frames"], 2, "exposure needs no new sum");
    live.finish().unwrap();
}

#[test]
fn the_picture_is_metered_without_a_new_frame() {
    if !gpu_there() {
        return;
    }
    let bundle = Bundle::write(true);
    let mut live = live(bundle.folder(), Limits::default());
    load(&mut live);
    live.draw().unwrap();
    let ev = auto_exposure_ev(&live.session.read_film().unwrap()).unwrap();
    let editor = &mut live.shown().unwrap().editor;
    editor.set_exposure(9.0);
    editor.set_tonemap(Tonemap::Agx);
    editor.meter(Metering::Now);
    assert!(live.draw().unwrap() && !live.draw().unwrap());
    assert_eq!(live.shown().unwrap().editor.look().camera.exposure_ev, ev);
    let statistics: serde_json::Value = serde_json::from_slice(&live.statistics().unwrap().unwrap()).unwrap();
    assert_eq!(statistics["frames"], 1, "neither exposure nor curve need a new sum");
    live.finish().unwrap();
}

#[test]
fn a_map_of_the_users_own_shines_and_is_saved_by_its_path() {
    if !gpu_there() {
        return;
    }
    let (bundle, folder) = (sparse::Bundle::write(16, false), tempfile::tempdir().unwrap());
    let path = folder.path().join("my sky.exr");
    let write = |map: &str| {
        let map = bundle.map(map);
        std::fs::write(&path, encode_exr([map.width, map.height], &map.texels).unwrap()).unwrap();
    };
    write("sun");
    let mut live = live(bundle.folder(), Limits::default());
    load(&mut live);
    live.draw().unwrap();
    let error = live.add_environment(&folder.path().join("gone.exr")).unwrap_err();
    assert!(error.to_string().contains("gone.exr") && !live.facts().map_from_outside);
    live.add_environment(&path).unwrap();
    assert!(live.draw().unwrap() && live.facts().map_from_outside);
    let state = std::fs::read_to_string(live.save(Save::State, folder.path()).unwrap()).unwrap();
    assert_eq!(state, format!("[environment]\nmap = {:?}\n", path.to_str().unwrap()));
    let first = live.session.read_film().unwrap();
    // Saved again by another program, and dropped again.
    write("even");
    live.add_environment(&path).unwrap();
    assert!(live.draw().unwrap() && live.session.read_film().unwrap() != first);
    live.shown().unwrap().editor.reset_light();
    assert!(live.draw().unwrap() && !live.facts().map_from_outside);
    live.finish().unwrap();
}

#[test]
fn every_animation_is_on_offer() {
    if !gpu_there() {
        return;
    }
    let bundle = Bundle::write(true);
    let mut live = live(bundle.folder(), Limits::default());
    load(&mut live);
    let editor = &mut live.shown().unwrap().editor;
    assert_eq!(editor.animations().iter().map(|a| a.name.as_str()).collect::<Vec<_>>(), ["glow"]);
    assert_eq!((editor.active(), editor.is_playing()), (None, false));
}

#[test]
fn what_came_before_a_failure_stays() {
    if !gpu_there() {
        return;
    }
    let bundle = Bundle::write(true);
    let path = bundle.folder().join("images.relume");
    let mut bytes = std::fs::read(&path).unwrap();
    *bytes.last_mut().unwrap() ^= 1;
    std::fs::write(&path, bytes).unwrap();
    let mut live = live(bundle.folder(), Limits::default());
    load(&mut live);
    assert!(live.draw().unwrap());
    let facts = live.facts();
    assert!(matches!(&facts.loading, Loading::Failed(reason) if reason.contains("checksum")), "{facts:?}");
    assert_eq!(facts.pieces, facts.pieces_expected - 1);
    let folder = tempfile::tempdir().unwrap();
    let saved = Save::ALL.map(|what| live.save(what, folder.path()).unwrap());
    assert!(saved.iter().all(|path| path.exists()) && saved[0].ends_with("synthetic-0001.png"));
    assert_eq!(live.finish().unwrap_err().exit_code(), 2);
}

#[test]
fn light_and_view_are_drawn_when_they_change() {
    if !gpu_there() {
        return;
    }
    let bundle = sparse::Bundle::write(16, false);
    let mut live = live(bundle.folder(), Limits::default());
    load(&mut live);
    assert!(live.draw().unwrap() && !live.draw().unwrap());
    live.shown().unwrap().editor.move_camera(Motion::Orbit([0.1, 0.1]), &Surfaces::default());
    assert!(live.draw().unwrap() && !live.draw().unwrap());
    live.shown().unwrap().editor.edit_light(&EnvironmentState { rotation_deg: Some(20.0), ..Default::default() });
    assert!(live.draw().unwrap() && !live.draw().unwrap());
    live.shown().unwrap().editor.set_exposure(1.0);
    assert!(live.draw().unwrap() && !live.draw().unwrap());
    let facts = live.facts();
    assert_eq!((facts.what, facts.pieces, facts.pieces_expected, facts.size), ("blocks", 5, 5, Some(sparse::SIZE)));
    let statistics: serde_json::Value = serde_json::from_slice(&live.statistics().unwrap().unwrap()).unwrap();
    assert_eq!(statistics["frames"], 3, "exposure needs no new frame");
    live.finish().unwrap();
}

#[test]
fn a_prefix_is_no_failure() {
    if !gpu_there() {
        return;
    }
    let bundle = Bundle::write(true);
    let mut live = live(bundle.folder(), Limits { bytes: Some(bundle.playlist_bytes() - 1), ..Limits::default() });
    load(&mut live);
    assert!(live.draw().unwrap());
    assert_eq!(live.facts().loading, Loading::Prefix);
    live.finish().unwrap();
}

#[test]
fn what_a_frame_took_is_told_when_it_is_done() {
    if !gpu_there() {
        return;
    }
    let bundle = sparse::Bundle::write(16, false);
    let mut live = live(bundle.folder(), Limits::default());
    load(&mut live);
    assert!(live.draw().unwrap() && live.awaits_frames() && live.facts().cpu_ms.is_none(), "drawing waits for nothing");
    for turn in 1..5 {
        live.shown().unwrap().editor.edit_light(&EnvironmentState { rotation_deg: Some(turn as f32), ..Default::default() });
        assert!(live.draw().unwrap());
    }
    assert!(live.is_behind());
    while live.awaits_frames() {
        live.poll().unwrap();
    }
    assert!(!live.is_behind() && live.facts().cpu_ms.is_some());
    let statistics: serde_json::Value = serde_json::from_slice(&live.statistics().unwrap().unwrap()).unwrap();
    assert_eq!(statistics["frames"], 5);
    assert!(statistics["time_to_full_quality_s"].as_f64().unwrap() >= statistics["time_to_first_image_s"].as_f64().unwrap());
}
