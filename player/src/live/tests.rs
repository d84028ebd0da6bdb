//! Orders and news, without a window.

use super::*;
use crate::gpu::{self, Gpu};
use crate::output::encode_exr;
use crate::session::Request;
use crate::stream::Limits;
use crate::support::{self, Bundle, sparse};
use relume_playback::PlacedState;

fn gpu_there() -> bool {
    support::gpu_there(|| gpu::list().map(|_| ()).map_err(|e| e.to_string()))
}

/// A bundle on show, and what wakes whoever waits for news.
struct Desk {
    live: Live,
    woken: Receiver<()>,
}

impl Desk {
    fn start(folder: &Path, meters: bool) -> Self {
        let (state, limits) = (PlacedState::default(), Limits::default());
        let request = Request {
            folder,
            method: None,
            state,
            animation: None,
            environment: None,
            meters,
            size: None,
            limits,
        };
        let (wake, woken) = channel();
        let session = Session::start(request, || Gpu::open(None)).unwrap();
        let live = Live::start(session, Instant::now(), true, move || {
            let _ = wake.send(());
        })
        .unwrap();
        Self { live, woken }
    }

    /// Works as the window does, until `is_so`.
    fn until(&mut self, is_so: impl Fn(&mut Live) -> bool) {
        while !is_so(&mut self.live) {
            // What was just set is ordered before anything is waited for: nothing else may be under way.
            self.live.order();
            self.woken.recv().expect("the thread has news");
            self.live.take_news();
        }
        self.live.order();
    }

    fn editor(&mut self) -> &mut Editor {
        &mut self.live.shown().unwrap().editor
    }

    /// The size of the picture that is drawn when there is so much room for it, if one is.
    fn picture_at(&mut self, room: [u32; 2]) -> Option<[u32; 2]> {
        self.live.shown().unwrap().take_pixels();
        self.live.shown().unwrap().fill(room);
        // What is saved after it tells that it was obeyed.
        self.live.take_note();
        let folder = tempfile::tempdir().unwrap();
        self.live.save(Save::Png, folder.path()).unwrap();
        self.until(|live| live.note.is_some());
        assert!(self.live.take_note().unwrap().is_ok());
        let shown = self.live.shown().unwrap();
        shown.take_pixels().map(|_| shown.size)
    }

    /// The picture once it shows what was set.
    fn picture(&mut self) -> Vec<u8> {
        self.live.shown().unwrap().take_pixels();
        self.live.order();
        self.until(|live| live.shown().unwrap().pixels.is_some());
        self.live.shown().unwrap().take_pixels().unwrap()
    }
}

#[test]
fn what_is_set_is_shown() {
    if !gpu_there() {
        return;
    }
    let bundle = Bundle::write(true);
    let mut desk = Desk::start(bundle.folder(), false);
    desk.until(|live| {
        live.facts().loading == Loading::Complete && live.shown().is_some_and(|shown| shown.pixels.is_some())
    });
    let first = desk.live.shown().unwrap().take_pixels().unwrap();
    let folder = tempfile::tempdir().unwrap();
    assert_eq!(desk.live.save(Save::State, folder.path()).unwrap(), None);
    assert!(matches!(desk.live.take_note(), Some(Err(reason)) if reason.contains("no state is saved")));
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
    desk.editor().set_exposure(-20.0);
    let dark = desk.picture();
    assert!(
        first.len() == dark.len() && first != dark && dark.chunks(4).all(|pixel| pixel[..3] == [0, 0, 0])
    );
    desk.editor().reset_exposure();
    assert!(desk.picture() == first);
    // Of many looks at once, the last counts.
    for ev in [3.0, -20.0, 5.0] {
        desk.editor().set_exposure(ev);
        desk.live.order();
    }
    desk.editor().set_exposure(-20.0);
    desk.live.order();
    assert!(desk.live.save(Save::Png, folder.path()).unwrap().is_none());
    desk.until(|live| live.note.is_some());
    let png = folder.path().join("synthetic-0001.png");
    assert_eq!(desk.live.take_note(), Some(Ok(format!("saved {}", png.display()))));
    assert!(
        image::open(png).unwrap().to_rgb8().iter().all(|value| *value == 0),
        "a picture shows what was set before it was asked for"
    );
    let state = desk.live.save(Save::State, folder.path()).unwrap().unwrap();
    assert_eq!(std::fs::read_to_string(state).unwrap(), "[camera]\nexposure_ev = -20.0\n");
    assert_eq!(desk.editor().unsaved(), None);
    let statistics: serde_json::Value = serde_json::from_slice(&desk.live.end().statistics.unwrap()).unwrap();
    assert!(statistics["frames"].as_u64().unwrap() >= 1);
}

#[test]
fn the_exposure_asked_for_at_the_start_is_no_edit() {
    if !gpu_there() {
        return;
    }
    let bundle = Bundle::write(true);
    let mut desk = Desk::start(bundle.folder(), true);
    desk.until(|live| live.shown().is_some_and(|shown| shown.editor.metering().is_none()));
    let scenes = desk.editor().scene().camera.exposure_ev;
    let editor = desk.editor();
    assert_ne!(editor.look().camera.exposure_ev, scenes);
    editor.commit();
    assert_eq!((editor.undoes(), editor.unsaved()), (None, None));
    desk.live.end().ended.unwrap();
}

#[test]
fn a_map_of_ones_own_lights_the_scene() {
    if !gpu_there() {
        return;
    }
    let bundle = sparse::Bundle::write(16, false);
    let mut desk = Desk::start(bundle.folder(), false);
    desk.until(|live| live.facts().loading == Loading::Complete && live.shown().is_some());
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("dusk.exr");
    let write =
        |red: f32| std::fs::write(&path, encode_exr([32, 16], &[[red, 0.5, 1.0]; 32 * 16]).unwrap()).unwrap();
    write(0.25);
    desk.live.take_file(&path).unwrap();
    desk.until(|live| live.note.is_some());
    assert_eq!(desk.live.take_note(), Some(Ok(format!("lit by {}", path.display()))));
    let first = desk.picture();
    desk.until(|live| live.facts().map_from_outside);
    desk.editor().commit();
    assert_eq!(desk.editor().undoes(), Some("the map"));
    let state = desk.live.save(Save::State, folder.path()).unwrap().unwrap();
    assert_eq!(
        std::fs::read_to_string(state).unwrap(),
        format!("[environment]\nmap = {:?}\n", path.to_str().unwrap())
    );
    // Saved again by another program, and dropped again.
    write(4.0);
    desk.live.take_file(&path).unwrap();
    assert!(desk.picture() != first);
    desk.editor().undo();
    desk.until(|live| !live.facts().map_from_outside);
    desk.live.take_note();
    desk.live.take_file(&folder.path().join("none.exr")).unwrap();
    desk.until(|live| live.note.is_some());
    assert!(matches!(desk.live.take_note(), Some(Err(reason)) if reason.contains("none.exr")));
    desk.live.end().ended.unwrap();
}

#[test]
fn states_and_animations_are_taken_from_files() {
    if !gpu_there() {
        return;
    }
    let bundle = sparse::Bundle::write(16, false);
    let mut desk = Desk::start(bundle.folder(), false);
    desk.until(|live| live.facts().loading == Loading::Complete && live.shown().is_some());
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str, text: &str| {
        let path = folder.path().join(name);
        std::fs::write(&path, text).unwrap();
        path
    };
    let state = file("s.toml", "camera.exposure_ev = 2\nenvironment.rotation_deg = 30\n");
    assert!(desk.live.take_file(&state).unwrap().starts_with("set "));
    let look = desk.editor().look();
    assert_eq!((look.camera.exposure_ev, look.environment.unwrap().rotation_deg), (2.0, 30.0));
    desk.editor().commit();
    assert_eq!(desk.editor().undo().as_deref(), Some("the exposure, the light's rotation"), "one edit");
    // A map that a state names lies beside it.
    std::fs::write(
        folder.path().join("dusk.exr"),
        encode_exr([32, 16], &[[0.25, 0.5, 1.0]; 32 * 16]).unwrap(),
    )
    .unwrap();
    desk.live.take_file(&file("lit.toml", "camera.exposure_ev = 3\nenvironment.map = 'dusk.exr'\n")).unwrap();
    desk.until(|live| live.note.is_some());
    assert!(
        desk.editor().look().environment.unwrap().map.ends_with("dusk.exr")
            && desk.editor().look().camera.exposure_ev == 3.0
    );
    // And so do those of an animation.
    let before = desk.editor().look().environment;
    let dusk = "duration_s = 2\n[[key]]\nt_s = 0\nenvironment.map = 'sun'\n[[key]]\nt_s = 1\nenvironment.map = 'dusk.exr'\n";
    std::fs::copy(folder.path().join("dusk.exr"), folder.path().join("night.exr")).unwrap();
    for map in ["dusk", "night"] {
        desk.live.take_note();
        let said = desk.live.take_file(&file("dusk.toml", &dusk.replace("dusk", map))).unwrap();
        desk.until(|live| {
            live.shown().unwrap().editor.animation().is_some_and(|chosen| chosen.name == "dusk")
        });
        assert!(said.contains("dusk.toml"), "{said}");
        desk.editor().scrub(1.5);
        assert!(desk.editor().look().environment.unwrap().map.ends_with(&format!("{map}.exr")));
        desk.picture();
        desk.editor().choose(None);
    }
    assert_eq!(desk.editor().look().environment, before);
    let turn = file(
        "turn.toml",
        "duration_s = 2\nloop = true\n[[key]]\nt_s = 0\nenvironment.rotation_deg = 0\n[[key]]\nt_s = 1\nenvironment.rotation_deg = 90\n",
    );
    for _ in 0..2 {
        assert!(desk.live.take_file(&turn).unwrap().starts_with("playing "));
    }
    let editor = desk.editor();
    assert!(editor.is_playing() && editor.animation().unwrap().name == "turn");
    assert_eq!(editor.animations().iter().filter(|animation| animation.name == "turn").count(), 1);
    let before = editor.look();
    for (name, text, part) in [
        ("a.toml", "camera.exposure_ev = 99\n", "a.toml: "),
        ("b.toml", "materials.nobody.kd = [0, 0, 0]\n", "b.toml: line 1: "),
        ("c.toml", "camera = \n", "c.toml: line 1, "),
        ("d.toml", "duration_s = 1\n[[key]]\nt_s = 0\nmaterials.x.kd = [0, 0, 0]\n", "d.toml: line 4: "),
        ("e.png", "", "e.png: give a bundle (its folder or manifest.json), a state"),
        ("f.toml", "environment.map = 'gone.exr'\n", "f.toml: "),
    ] {
        let refused = desk.live.take_file(&file(name, text)).unwrap_err();
        assert!(refused.contains(part) && refused.lines().count() == 1, "{refused}");
    }
    assert_eq!(desk.editor().look(), before);
    desk.live.end().ended.unwrap();
}

#[test]
fn another_bake_is_noticed_and_the_picture_stays() {
    if !gpu_there() {
        return;
    }
    let (bundle, other) = (Bundle::write(true), Bundle::write(false));
    let manifest = bundle.folder().join(relume_formats::kinds::manifest::FILE_NAME);
    let first = std::fs::read(&manifest).unwrap();
    let mut desk = Desk::start(bundle.folder(), false);
    desk.until(|live| {
        live.facts().loading == Loading::Complete && live.shown().is_some_and(|shown| shown.pixels.is_some())
    });
    let before = desk.live.shown().unwrap().take_pixels().unwrap();
    bundle.bake_again(&other);
    desk.until(|live| live.facts().rebaked);
    desk.editor().set_exposure(-20.0);
    desk.picture();
    desk.editor().reset_exposure();
    assert!(desk.picture() == before && desk.live.facts().rebaked, "it can be edited as before");
    // The very same bake again is no other one.
    std::fs::write(&manifest, first).unwrap();
    desk.until(|live| !live.facts().rebaked);
    desk.live.end().ended.unwrap();
}

#[test]
fn who_closes_before_the_first_picture_has_statistics_too() {
    if !gpu_there() {
        return;
    }
    let bundle = Bundle::write(true);
    let request = Request {
        folder: bundle.folder(),
        method: None,
        state: PlacedState::default(),
        animation: None,
        environment: None,
        meters: false,
        size: None,
        // So slow that there is never anything to see.
        limits: Limits { bytes: None, bytes_per_second: Some(1) },
    };
    let session = Session::start(request, || Gpu::open(None)).unwrap();
    let Outcome { statistics, ended } = Live::start(session, Instant::now(), true, || {}).unwrap().end();
    ended.unwrap();
    let statistics: serde_json::Value = serde_json::from_slice(&statistics.unwrap()).unwrap();
    assert_eq!((statistics["frames"].as_u64(), &statistics["cpu_ms"]), (Some(0), &serde_json::Value::Null));
    assert!(statistics["time_to_first_image_s"].is_null());
}

#[test]
fn a_bundle_that_fails_before_the_first_picture_is_hopeless() {
    if !gpu_there() {
        return;
    }
    let bundle = Bundle::write(true);
    let path = bundle.folder().join("scene.relume");
    let mut bytes = std::fs::read(&path).unwrap();
    *bytes.last_mut().unwrap() ^= 1;
    std::fs::write(&path, bytes).unwrap();
    let mut desk = Desk::start(bundle.folder(), false);
    desk.until(|live| live.is_hopeless());
    assert_eq!(desk.live.end().ended.unwrap_err().exit_code(), 2);
}

#[test]
fn the_picture_takes_the_size_that_there_is_for_it() {
    if !gpu_there() {
        return;
    }
    let bundle = sparse::Bundle::write(16, false);
    let mut desk = Desk::start(bundle.folder(), false);
    desk.until(|live| live.facts().loading == Loading::Complete && live.shown().is_some());
    // As the border of a window is dragged: of many sizes the last counts, and it comes before what is saved.
    for width in 40..140 {
        desk.live.shown().unwrap().fill([width, 50]);
        desk.live.order();
    }
    let folder = tempfile::tempdir().unwrap();
    desk.live.save(Save::Png, folder.path()).unwrap();
    desk.until(|live| live.note.is_some());
    let png = image::open(folder.path().join("lit-0001.png")).unwrap();
    assert_eq!([png.width(), png.height()], [139, 50]);
    desk.until(|live| live.facts().size == Some([139, 50]));
    let shown = desk.live.shown().unwrap();
    assert_eq!((shown.size, shown.take_pixels().unwrap().len()), ([139, 50], 4 * 139 * 50));
    assert!(desk.picture_at([139, 50]).is_none(), "nothing is drawn for the size that there is");
    // A window without a limit has a picture of the same shape.
    let huge = desk.picture_at([1, 1 << 20]).unwrap();
    assert!(huge[0] == 1 && huge[1] < 1 << 20);
    assert_eq!(desk.picture_at([1, 1]), Some([1, 1]));
    desk.live.end().ended.unwrap();
}

#[test]
fn a_baked_picture_keeps_its_size() {
    if !gpu_there() {
        return;
    }
    let bundle = Bundle::write(true);
    let mut desk = Desk::start(bundle.folder(), false);
    desk.until(|live| live.facts().loading == Loading::Complete && live.shown().is_some());
    assert_eq!(desk.picture_at([64, 64]), None);
    let shown = desk.live.shown().unwrap();
    assert!(!shown.resizes && shown.size == support::SIZE);
    desk.live.end().ended.unwrap();
}

#[test]
fn edits_that_do_not_fit_another_bake_are_saved_before_they_go() {
    if !gpu_there() {
        return;
    }
    let bundle = Bundle::write(true);
    let mut desk = Desk::start(bundle.folder(), false);
    desk.until(|live| live.shown().is_some());
    desk.editor().set_exposure(1.0);
    let mut kept = desk.editor().kept();
    let gone: State = toml::from_str("[materials.gone]\nshininess = 5.0\n").unwrap();
    kept.state.materials.extend(gone.materials);
    let (folder, whole) = (tempfile::tempdir().unwrap(), kept.state.clone());
    let said = desk.live.keep(kept.clone(), folder.path()).unwrap_err();
    let file = folder.path().join("synthetic-0001.toml");
    assert_eq!(said, format!("no longer fits: material gone; all is saved in {}", file.display()));
    assert_eq!(State::read_file(&file).unwrap(), whole);
    kept.is_saved = true;
    let said = desk.live.keep(kept, folder.path()).unwrap_err();
    assert_eq!(said, "no longer fits: material gone", "what is in a file needs no other");
    desk.live.end().ended.unwrap();
}

/// Two animations at once, as when two files are dropped together: each gets the maps that it names.
#[test]
fn animations_that_wait_for_their_maps_are_not_mixed_up() {
    if !gpu_there() {
        return;
    }
    let bundle = sparse::Bundle::write(16, false);
    let mut desk = Desk::start(bundle.folder(), false);
    desk.until(|live| live.facts().loading == Loading::Complete && live.shown().is_some());
    let folder = tempfile::tempdir().unwrap();
    for name in ["dusk", "night"] {
        let at = |extension: &str| folder.path().join(format!("{name}.{extension}"));
        std::fs::write(at("exr"), encode_exr([32, 16], &[[0.25, 0.5, 1.0]; 32 * 16]).unwrap()).unwrap();
        let text = format!("duration_s = 2\n[[key]]\nt_s = 0\nenvironment.map = '{name}.exr'\n");
        std::fs::write(at("toml"), text).unwrap();
        desk.live.take_file(&at("toml")).unwrap();
    }
    let is_there =
        |editor: &Editor, name: &str| editor.animations().iter().any(|animation| animation.name == name);
    desk.until(|live| {
        let editor = &live.shown().unwrap().editor;
        ["dusk", "night"].iter().all(|name| is_there(editor, name))
    });
    let note = desk.live.take_note().unwrap();
    assert!(note.as_ref().is_ok_and(|said| said.ends_with("night.toml")), "{note:?}");
    assert!(desk.editor().look().environment.unwrap().map.ends_with("night.exr"));
    desk.live.end().ended.unwrap();
}
