//! A picture without a window.

use super::*;
use crate::gpu::{self, Gpu};
use crate::session::Request;
use crate::stream::Limits;
use crate::support::{self, Bundle, sparse};
use crate::ui::Motion;
use relume_formats::display::{Tonemap, auto_exposure_ev};
use relume_formats::state::{EnvironmentState, MaterialState};
use relume_playback::PlacedState;

/// A picture, and what the user sets.
struct Shown {
    picture: Picture,
    editor: Option<Editor>,
    size: [u32; 2],
}

impl Shown {
    fn start(folder: &Path, limits: Limits) -> Self {
        let state = PlacedState::default();
        let request = Request {
            folder,
            method: None,
            state,
            animation: None,
            environment: None,
            meters: false,
            size: None,
            limits,
        };
        let session = Session::start(request, || Gpu::open(None)).unwrap();
        Self { picture: Picture::new(session, Instant::now(), true), editor: None, size: [0, 0] }
    }

    /// With all of the bundle in `folder`.
    fn load(folder: &Path) -> Self {
        let mut shown = Self::start(folder, Limits::default());
        shown.take_in();
        shown
    }

    fn take_in(&mut self) {
        while self.picture.is_loading() {
            self.picture.poll().unwrap();
            if let Some(ready) = self.picture.ready() {
                (self.editor, self.size) = (Some(ready.editor), ready.size);
            }
        }
    }

    fn editor(&mut self) -> &mut Editor {
        self.editor.as_mut().unwrap()
    }

    /// Whether the picture changes, and does so once only.
    fn draws_once(&mut self) -> bool {
        let look = self.editor().look();
        let draws = self.picture.draw(&look).unwrap();
        assert!(!self.picture.draw(&look).unwrap(), "drawn twice");
        draws
    }

    /// What `--stats` writes, and the end.
    fn end(mut self) -> serde_json::Value {
        let statistics = self.picture.statistics().unwrap().unwrap();
        self.picture.finish().unwrap();
        serde_json::from_slice(&statistics).unwrap()
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
    let mut shown = Shown::start(bundle.folder(), Limits::default());
    assert!(
        shown.picture.ready().is_none() && shown.picture.pixels().unwrap().is_empty(),
        "nothing is there yet"
    );
    shown.take_in();
    assert!(shown.draws_once());
    shown.editor().set_exposure(2.0);
    assert!(shown.draws_once());
    shown.editor().edit("a", &MaterialState { shininess: Some(3.0), ..Default::default() });
    assert!(shown.draws_once());
    shown.editor().select(Some("b"));
    assert!(!shown.draws_once());
    let facts = shown.picture.facts();
    assert_eq!((facts.pieces, facts.bytes), (facts.pieces_expected, facts.bytes_expected));
    assert_eq!(shown.end()["frames"], 2, "exposure needs no new sum");
}

#[test]
fn pixels_are_those_of_the_file() {
    if !gpu_there() {
        return;
    }
    // A width of which rows are padded on their way.
    let bundle = Bundle::write(true);
    let mut shown = Shown::load(bundle.folder());
    shown.draws_once();
    let folder = tempfile::tempdir().unwrap();
    let png = image::open(shown.picture.save(PictureFile::Png, folder.path()).unwrap()).unwrap().to_rgba8();
    assert_eq!([png.width(), png.height()], shown.size);
    let pixels = shown.picture.pixels().unwrap();
    assert!(
        pixels.len() == png.as_raw().len()
            && pixels.iter().zip(png.as_raw()).all(|(a, b)| a.abs_diff(*b) <= 1)
    );
    assert_eq!(shown.picture.pixels().unwrap(), pixels, "as often as is wanted");
}

#[test]
fn the_picture_is_metered_without_a_new_frame() {
    if !gpu_there() {
        return;
    }
    let bundle = Bundle::write(true);
    let mut shown = Shown::load(bundle.folder());
    assert_eq!(shown.picture.metered(Metering::Now).unwrap(), None, "nothing is drawn");
    shown.draws_once();
    let ev = auto_exposure_ev(&shown.picture.session.read_film().unwrap());
    shown.editor().set_exposure(9.0);
    shown.editor().set_tonemap(Tonemap::Agx);
    assert!(shown.draws_once() && ev.is_some());
    for metering in [Metering::Now, Metering::WhenWhole] {
        assert_eq!(shown.picture.metered(metering).unwrap(), Some(ev));
    }
    assert_eq!(shown.end()["frames"], 1, "neither exposure nor curve need a new sum");
}

#[test]
fn every_animation_is_on_offer() {
    if !gpu_there() {
        return;
    }
    let bundle = Bundle::write(true);
    let mut shown = Shown::load(bundle.folder());
    let editor = shown.editor();
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
    let mut shown = Shown::load(bundle.folder());
    assert!(shown.draws_once());
    let facts = shown.picture.facts();
    assert!(matches!(&facts.loading, Loading::Failed(reason) if reason.contains("checksum")), "{facts:?}");
    assert_eq!(facts.pieces, facts.pieces_expected - 1);
    let folder = tempfile::tempdir().unwrap();
    let saved =
        [PictureFile::Png, PictureFile::Exr].map(|what| shown.picture.save(what, folder.path()).unwrap());
    assert!(saved.iter().all(|path| path.exists()) && saved[0].ends_with("synthetic-0001.png"));
    assert_eq!(shown.picture.finish().unwrap_err().exit_code(), 2);
}

#[test]
fn light_and_view_are_drawn_when_they_change() {
    if !gpu_there() {
        return;
    }
    let bundle = sparse::Bundle::write(16, false);
    let mut shown = Shown::load(bundle.folder());
    assert!(shown.draws_once());
    shown.editor().move_camera(Motion::Orbit([0.1, 0.1]), &Surfaces::default());
    assert!(shown.draws_once());
    shown.editor().edit_light(&EnvironmentState { rotation_deg: Some(20.0), ..Default::default() });
    assert!(shown.draws_once());
    shown.editor().set_exposure(1.0);
    assert!(shown.draws_once());
    let facts = shown.picture.facts();
    assert_eq!(
        (facts.what, facts.pieces, facts.pieces_expected, facts.size),
        ("blocks", 5, 5, Some(sparse::SIZE))
    );
    assert_eq!(shown.end()["frames"], 3, "exposure needs no new frame");
}

#[test]
fn a_prefix_is_no_failure() {
    if !gpu_there() {
        return;
    }
    let bundle = Bundle::write(true);
    let mut shown = Shown::start(
        bundle.folder(),
        Limits { bytes: Some(bundle.playlist_bytes() - 1), ..Limits::default() },
    );
    shown.take_in();
    assert!(shown.draws_once());
    assert_eq!(shown.picture.facts().loading, Loading::Prefix);
    shown.picture.finish().unwrap();
}

#[test]
fn what_a_frame_took_is_told_when_it_is_done() {
    if !gpu_there() {
        return;
    }
    let bundle = sparse::Bundle::write(16, false);
    let mut shown = Shown::load(bundle.folder());
    assert!(shown.draws_once() && shown.picture.facts().cpu_ms.is_none(), "drawing waits for nothing");
    for turn in 1..5 {
        shown
            .editor()
            .edit_light(&EnvironmentState { rotation_deg: Some(turn as f32), ..Default::default() });
        assert!(shown.draws_once());
    }
    shown.picture.pixels().unwrap();
    shown.picture.take_costs().unwrap();
    assert!(shown.picture.facts().cpu_ms.is_some());
    let statistics = shown.end();
    assert_eq!(statistics["frames"], 5);
    assert!(
        statistics["time_to_full_quality_s"].as_f64().unwrap()
            >= statistics["time_to_first_image_s"].as_f64().unwrap()
    );
}
