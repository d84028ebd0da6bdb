//! The window on a real display, if a virtual one: opened, clicked on, edited, scrubbed, closed, as a user
//! does it.
//!
//! What the window did is read from the files that it saves. Every action is done twice: with `xdotool` on
//! the window, and on a twin of its screen within the test, which tells where things are.

mod display;
mod lit;
mod opened;
mod rebaked;

use crate::desk::{Display, Window};
use crate::support::mirror::{Mirror, press, release};
use crate::support::{self, Bundle, sparse};
use egui::{Event, PointerButton, Pos2, TextureId, Vec2};
use relume_formats::Place;
use relume_formats::state::{Animation, State};
use relume_playback::{Controls, PlacedAnimation, PlacedState, Scope, Seen, Surfaces};
use relume_player::ui::{Editor, Facts, Loading, Picker, Screen, Stage};
use std::path::Path;
use std::process::Command;

/// The same screen without a window.
struct Twin {
    mirror: Mirror,
    screen: Screen,
    editor: Editor,
    picker: Option<Picker>,
    film: [u32; 2],
    /// Whether the film is to have the size that the screen has for it, and that size once told.
    resizes: bool,
    room: Option<[u32; 2]>,
    facts: Facts,
}

impl Twin {
    /// Of images, with the animation `glow` on offer.
    fn new(bundle: &Bundle, size: [f32; 2]) -> Self {
        let picker = Some(Picker::new((&*bundle.images.head).into()));
        Self::of(support::scope(bundle.scene_meta()), ("glow", support::ANIMATION), picker, size)
    }

    /// Of rows, with the animation `turn` on offer.
    fn lit(size: [f32; 2]) -> Self {
        Self::of(sparse::scope(), ("turn", sparse::TURN), None, size)
    }

    fn of(scope: Scope, (name, text): (&str, &str), picker: Option<Picker>, size: [f32; 2]) -> Self {
        let place = || Place::file("twin");
        let animation =
            PlacedAnimation { animation: Animation::parse(name, text, &place()).unwrap(), place: place() };
        let state = PlacedState { state: State::default(), place: place() };
        let film = scope.scene.size;
        let editor = Editor::new(&Controls::new(scope, &state, None, vec![animation]).unwrap());
        let facts = Facts {
            adapter: "twin".to_owned(),
            method: "twin".to_owned(),
            size: Some(film),
            cpu_ms: None,
            gpu_ms: None,
            bytes: 0,
            bytes_expected: 0,
            what: "images",
            pieces: 0,
            pieces_expected: 0,
            map_from_outside: false,
            rebaked: false,
            loading: Loading::Complete,
        };
        let (mirror, screen) = (Mirror::new(size), Screen::default());
        let mut twin = Self { mirror, screen, editor, picker, film, resizes: false, room: None, facts };
        relume_player::ui::set_up_style(twin.mirror.context());
        (0..3).for_each(|_| twin.frame(Vec::new()));
        twin
    }

    fn frame(&mut self, events: Vec<Event>) {
        let Self { mirror, screen, editor, picker, film, resizes, room, facts } = self;
        mirror.frame(events, |ui| {
            let (picture, surfaces) = (TextureId::User(0), &Surfaces::default());
            let (picker, size, resizes) = (picker.as_ref(), *film, *resizes);
            let stage = Stage { editor: &mut *editor, picker, surfaces, size, resizes, picture };
            *room = screen.show(ui, Some(stage), facts, None).picture;
        });
    }

    /// Lets what changes for a while come to rest.
    fn settle(&mut self) {
        (0..60).for_each(|_| self.frame(Vec::new()));
    }

    /// Clicks in the window and here.
    fn click(&mut self, window: &Window<'_>, at: Pos2) {
        let at = at.round();
        window.click(at);
        for events in [vec![Event::PointerMoved(at)], press(at), release(at), Vec::new(), Vec::new()] {
            self.frame(events);
        }
    }

    /// Drags in the window and here.
    fn drag(&mut self, window: &Window<'_>, button: u32, from: Pos2, to: Pos2) {
        let (from, to) = (from.round(), to.round());
        window.drag(button, from, to);
        let button = if button == 1 { PointerButton::Primary } else { PointerButton::Secondary };
        let event =
            |pos, pressed| Event::PointerButton { pos, button, pressed, modifiers: Default::default() };
        self.frame(vec![
            Event::PointerMoved(from),
            event(from, true),
            Event::PointerMoved(to),
            event(to, false),
        ]);
        self.frame(Vec::new());
    }

    /// Where in the window a pixel is that shows the material.
    fn pixel_of(&self, material: &str) -> Pos2 {
        let [width, height] = support::SIZE;
        let mut pixels = (0..height).flat_map(|y| (0..width).map(move |x| [x, y]));
        let [x, y] = pixels
            .find(|pixel| self.picker.as_ref().unwrap().at(*pixel) == Seen::Material(material))
            .unwrap();
        let image = self.mirror.rect("picture");
        image.min
            + Vec2::new((x as f32 + 0.5) / width as f32, (y as f32 + 0.5) / height as f32) * image.size()
    }
}

fn state(path: &Path) -> State {
    relume_formats::state::parse_toml(&std::fs::read_to_string(path).unwrap(), &Place::file(path)).unwrap()
}

/// Asserts that a saved picture is what the CPU makes of `state`.
fn expect_picture(bundle: &Bundle, state: &State, png: &Path) {
    let off = off_by(bundle, state, png);
    assert!(off <= 1.0, "{} is off by {off} of 255", png.display());
}

/// By how many steps of 255 a saved picture differs from what the CPU makes of `state`.
fn off_by(bundle: &Bundle, state: &State, png: &Path) -> f32 {
    let scope = support::scope(bundle.scene_meta());
    let placed = PlacedState { state: state.clone(), place: Place::file("state") };
    let look = Controls::new(scope, &placed, None, Vec::new()).unwrap().base().clone();
    let expected = bundle.evaluate(&["a", "b"].map(|name| look.materials[name]), |_| true);
    radiance_off_by(&expected, look.display(), png)
}

/// By how many steps of 255 a saved picture differs from this radiance.
fn radiance_off_by(expected: &[[f32; 3]], display: relume_formats::display::Display, png: &Path) -> f32 {
    let image = image::open(png).unwrap().to_rgb8();
    assert_eq!(image.pixels().len(), expected.len());
    let mut off: f32 = 0.0;
    for (pixel, radiance) in image.pixels().zip(expected) {
        for (byte, linear) in pixel.0.iter().zip(display.shown(*radiance)) {
            let srgb =
                if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 };
            off = off.max((f32::from(*byte) - 255.0 * srgb).abs());
        }
    }
    off
}

/// Asserts that the picture that a window saved is what the player shows without one, at its size and with
/// these `options`; returns the size in pixels.
fn expect_same_without_window(bundle: &Path, png: &Path, options: &[&str]) -> [u32; 2] {
    let shown = image::open(png).unwrap().to_rgb8();
    let size = format!("{}x{}", shown.width(), shown.height());
    let folder = png.parent().unwrap();
    let alone = Command::new(env!("CARGO_BIN_EXE_player"))
        .arg(bundle)
        .args(["--headless", "--count", "1", "--frames", "alone.png", "--size", &size])
        .args(options)
        .current_dir(folder)
        .output();
    assert!(alone.unwrap().status.success());
    let alone = image::open(folder.join("alone.png")).unwrap().to_rgb8();
    assert_eq!(alone.dimensions(), shown.dimensions());
    assert!(alone.iter().zip(shown.iter()).all(|(a, b)| a.abs_diff(*b) <= 1), "both show the same");
    shown.dimensions().into()
}

#[test]
fn open_click_edit_scrub_save_close() {
    let Some(display) = Display::open() else { return };
    let bundle = Bundle::write(true);
    let mut window =
        Window::open(&display, bundle.folder(), &["--stats", "stats.json"], "synthetic - Relume");
    let mut twin = Twin::new(&bundle, window.size());
    window.expect_nothing_set();
    let default_png = window.folder.path().join("synthetic-0001.png");
    window.wait("the picture", |_| default_png.metadata().ok().filter(|file| file.len() > 0));
    expect_picture(&bundle, &State::default(), &default_png);

    twin.click(&window, twin.pixel_of("a"));
    window.wait_for_title("synthetic - a - Relume");
    let rail = twin.mirror.rect("shininess");
    twin.drag(&window, 1, rail.center(), Pos2::new(rail.right() + 30.0, rail.center().y));
    window.wait_for_title("synthetic - a (edited) - Relume");
    let edited = state(&window.save("t", "synthetic-0001.toml"));
    assert_eq!(edited.materials.keys().collect::<Vec<_>>(), ["a"]);
    assert_eq!((edited.materials["a"].shininess, &edited.camera), (Some(200.0), &None));
    let edited_png = window.save("s", "synthetic-0002.png");
    expect_picture(&bundle, &edited, &edited_png);
    assert_ne!(std::fs::read(&edited_png).unwrap(), std::fs::read(&default_png).unwrap());
    window.save("e", "synthetic-0001.exr");

    twin.click(&window, twin.mirror.rect("glow").center());
    window.wait_for_title("synthetic - a (edited) - glow playing");
    let rail = twin.mirror.rect("time");
    twin.drag(&window, 1, rail.center(), Pos2::new(rail.left() - 30.0, rail.center().y));
    window.wait_for_title("synthetic - a (edited) - glow paused");
    let scrubbed = state(&window.save("t", "synthetic-0002.toml"));
    let kd = scrubbed.materials["a"].kd.unwrap();
    assert!(kd.iter().zip([0.1, 0.2, 0.3]).all(|(kd, at_start)| (kd - at_start).abs() < 1e-5), "{kd:?}");
    window.keys("space");
    window.wait_for_title("synthetic - a (edited) - glow playing");

    let stats_path = window.folder.path().join("stats.json");
    window.keys("q");
    // The folder goes with the window.
    let stats = window.wait_for_stats(&stats_path);
    let (code, stderr) = window.end();
    assert_eq!((code, stderr.as_str()), (Some(0), ""));
    assert!(
        stats["frames"].as_u64().unwrap() >= 3 && stats["missing_slots"].as_array().unwrap().is_empty(),
        "{stats}"
    );
    assert!(
        stats["time_to_first_image_s"].as_f64().unwrap() <= stats["time_to_full_quality_s"].as_f64().unwrap()
    );
}

#[test]
fn a_saved_state_is_played_again() {
    let Some(display) = Display::open() else { return };
    let bundle = Bundle::write(false);
    let text = "[camera]\nexposure_ev = -1.5\n\n[materials.b]\nkd = [0.1, 0.6, 0.2]\nks = [0.5, 0.25, 0.3]\nshininess = 33.25\n";
    let path = bundle.folder().join("edit.toml");
    std::fs::write(&path, text).unwrap();
    let mut window =
        Window::open(&display, bundle.folder(), &["--state", path.to_str().unwrap()], "synthetic - Relume");
    let saved = window.save("t", "synthetic-0001.toml");
    window.wait("the state", |_| Some(()).filter(|()| std::fs::read_to_string(&saved).unwrap() == text));
    let png = window.save("s", "synthetic-0001.png");
    expect_picture(&bundle, &state(&path), &png);
    window.keys("q");
    assert_eq!(window.end(), (Some(0), String::new()));
}

#[test]
fn the_first_image_comes_before_the_last_byte() {
    let Some(display) = Display::open() else { return };
    let bundle = Bundle::write(true);
    // All of it would take a minute, in which the busiest machine opens a window.
    let rate = (bundle.playlist_bytes() / 60).to_string();
    let mut window = Window::open(&display, bundle.folder(), &["--rate", &rate], "synthetic - loading");
    let twin = Twin::new(&bundle, window.size());
    // It can be edited while it loads.
    window.click(twin.pixel_of("b"));
    window.wait_for_title("synthetic - b - loading");
    window.save("s", "synthetic-0001.png");
    window.keys("q");
    assert_eq!(window.end(), (Some(0), String::new()));
}

#[test]
fn quick_hands_and_second_thoughts() {
    let Some(display) = Display::open() else { return };
    let bundle = Bundle::write(true);
    let mut window = Window::open(&display, bundle.folder(), &[], "synthetic - Relume");
    let mut twin = Twin::new(&bundle, window.size());
    twin.click(&window, twin.pixel_of("a"));
    twin.settle();
    let [red, green, blue] = ["kd R", "kd G", "kd B"].map(|field| twin.mirror.rect(field).center());
    // Two numbers, faster than the window is drawn.
    window.click_and_type(red, "0 period 2 5 Tab 0 period 1 2 5 Return t");
    let kd = |path: &Path| state(path).materials["a"].kd.unwrap();
    let saved = kd(&window.saved("synthetic-0001.toml"));
    let before = support::blinn_phong(support::default_materials()[0]).kd;
    assert_eq!(saved, [0.25, 0.125, before[2]]);
    // Escape brings back what was, and never closes the window.
    window.click_and_type(blue, "0 period 9 Escape Escape Escape t");
    assert_eq!(kd(&window.saved("synthetic-0002.toml")), saved);
    // From one program to another.
    window.click_and_type(green, "ctrl+a ctrl+c Escape t");
    window.saved("synthetic-0003.toml");
    let mut other = Window::open(&display, bundle.folder(), &[], "synthetic - Relume");
    other.click(twin.pixel_of("a"));
    other.wait_for_title("synthetic - a - Relume");
    other.click_and_type(blue, "ctrl+v Return t");
    assert_eq!(kd(&other.saved("synthetic-0001.toml")), [before[0], before[1], 0.125]);
    other.keys("q");
    assert_eq!(other.end(), (Some(0), String::new()));
    window.focus();
    window.keys("q");
    assert_eq!(window.end(), (Some(0), String::new()));
}

#[test]
fn edits_are_undone_and_not_lost() {
    let Some(display) = Display::open() else { return };
    let bundle = Bundle::write(true);
    let mut window = Window::open(&display, bundle.folder(), &[], "synthetic - Relume");
    let mut twin = Twin::new(&bundle, window.size());
    twin.click(&window, twin.pixel_of("a"));
    twin.settle();
    let [red, blue] = ["kd R", "kd B"].map(|field| twin.mirror.rect(field).center());
    window.click_and_type(red, "0 period 2 5 Return ctrl+z");
    window.expect_nothing_set();
    window.keys("ctrl+shift+z");
    // A window that is asked to close asks back, and stays if that is called off.
    window.ask_to_close();
    window.wait_for_title("Close without saving? - synthetic - a (edited) - ");
    window.keys("Escape");
    let kd = |path: &Path| state(path).materials["a"].kd.unwrap();
    assert_eq!(kd(&window.save("t", "synthetic-0001.toml"))[0], 0.25);
    window.click_and_type(blue, "0 period 5 Return q Return");
    let folder = std::mem::replace(&mut window.folder, tempfile::tempdir().unwrap());
    assert_eq!(window.end(), (Some(0), String::new()));
    let saved = kd(&folder.path().join("synthetic-0002.toml"));
    assert_eq!([saved[0], saved[2]], [0.25, 0.5]);
}

#[test]
fn a_source_that_fails_leaves_the_picture() {
    let Some(display) = Display::open() else { return };
    let bundle = Bundle::write(true);
    let path = bundle.folder().join("images.relume");
    let mut bytes = std::fs::read(&path).unwrap();
    *bytes.last_mut().unwrap() ^= 1;
    std::fs::write(&path, bytes).unwrap();
    let mut window = Window::open(&display, bundle.folder(), &[], "synthetic - Relume");
    window.save("s", "synthetic-0001.png");
    window.keys("q");
    let (code, stderr) = window.end();
    assert_eq!(code, Some(2), "{stderr}");
    assert!(
        stderr.starts_with("error: ") && stderr.lines().count() == 1 && stderr.contains("checksum"),
        "{stderr}"
    );
}

#[test]
fn it_can_be_closed_from_outside() {
    let Some(display) = Display::open() else { return };
    let bundle = Bundle::write(true);
    let window =
        Window::open(&display, bundle.folder(), &["--animation", "glow"], "synthetic - glow playing");
    display.xdotool(&format!("windowclose {}", window.id)).unwrap();
    assert_eq!(window.end(), (Some(0), String::new()), "its window was destroyed");
    let window = Window::open(&display, bundle.folder(), &[], "synthetic - Relume");
    let killed = Command::new("kill").args(["-INT", &window.child.id().to_string()]).status().unwrap();
    assert!(killed.success());
    let (code, stderr) = window.end();
    assert_eq!(code, Some(130), "{stderr}");
    assert!(stderr.starts_with("error: interrupted") && stderr.lines().count() == 1, "{stderr}");
}
