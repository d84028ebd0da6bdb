//! The line below the picture: what can be done with it on the left, the keys on the right; in a narrow
//! window the keys have lines of their own.

use super::keys::{Does, GESTURES, TABLE};
use super::style::WARNING;
use egui::{Align, Color32, Label, Layout, Rect, RichText, TextStyle, Ui, UiBuilder, Vec2};
use relume_formats::name::plain;
use relume_playback::Seen;
use std::borrow::Cow;

/// What the user sees when pointing at something that cannot be edited.
const FIXED: &str = "fixed: not editable in this bundle";
const CLICK: &str = "click an object to edit its material";
/// Least distance between the hints on one line.
const HINT_GAP: f32 = 24.0;
const KEY_GAP: &str = "     ";
/// Height of a line, and of the margins above and below all of them.
const LINE: f32 = 20.0;
const MARGINS: f32 = 8.0;
/// Keys have lines of their own as long as those take no more of the window's height; the picture is worth
/// more.
const SHARE: f32 = 0.13;

/// The lines in a window of some size.
pub(super) struct Status {
    /// Whether the camera moves by hand.
    moves: bool,
    /// Whether anything is told apart under the pointer.
    picks: bool,
    /// On the line of the other hints if there is one; none where there is no room.
    keys: Vec<String>,
    /// Whether the keys stand on the line of the other hints.
    beside: bool,
}

impl Status {
    /// As many lines as the keys take in `room`, beside the panel; `height` is the window's. What is under
    /// the pointer changes nothing of it.
    pub fn new(ui: &Ui, moves: bool, picks: bool, room: f32, height: f32) -> Self {
        let told = TABLE.iter().filter(|entry| moves || entry.does != Does::ResetView);
        let keys: Vec<String> =
            told.filter_map(|entry| Some(format!("{}  {}", entry.keys.first()?, entry.hint?))).collect();
        let width = |text: &str, style: TextStyle| {
            ui.painter().layout_no_wrap(text.to_owned(), style.resolve(ui.style()), Color32::WHITE).size().x
        };
        let small = |text: &str| width(text, TextStyle::Small);
        let hint = [hint(moves, picks), FIXED.to_owned()].into_iter().filter(|text| picks || text != FIXED);
        let hint = hint.map(|text| width(&text, TextStyle::Body)).fold(0.0, f32::max);
        let all = keys.join(KEY_GAP);
        if hint + HINT_GAP + small(&all) <= room {
            return Self { moves, picks, keys: vec![all], beside: true };
        }
        let mut lines: Vec<String> = Vec::new();
        for key in keys {
            match lines.last_mut().map(|line| (format!("{line}{KEY_GAP}{key}"), line)) {
                Some((longer, line)) if small(&longer) <= room => *line = longer,
                _ => lines.push(key),
            }
        }
        let fits = LINE * (1.0 + lines.len() as f32) + MARGINS <= SHARE * height
            && lines.iter().all(|line| small(line) <= room);
        Self { moves, picks, keys: if fits { lines } else { Vec::new() }, beside: false }
    }

    pub fn height(&self) -> f32 {
        LINE * if self.beside { 1.0 } else { 1.0 + self.keys.len() as f32 } + MARGINS
    }

    /// Draws into `rect`: what is under the pointer, or what can be done, and the keys.
    pub fn show(&self, ui: &mut Ui, rect: Rect, seen: Seen<'_>, clicked_fixed: bool) {
        let weak = Color32::from_gray(120);
        let (text, colour): (Cow<'_, str>, _) = match seen {
            Seen::Material(name) => (plain(name), Color32::from_gray(220)),
            Seen::Fixed => (FIXED.into(), if clicked_fixed { WARNING } else { weak }),
            Seen::Nothing => (hint(self.moves, self.picks).into(), weak),
        };
        let line = |index: usize| {
            Rect::from_min_size(rect.min + Vec2::new(0.0, LINE * index as f32), Vec2::new(rect.width(), LINE))
        };
        // The caller draws elsewhere.
        let mut child = |place: Rect, layout: Layout| {
            let mut child = ui.new_child(UiBuilder::new().max_rect(place).layout(layout));
            child.set_clip_rect(place);
            child
        };
        let mut left = line(0);
        for (index, text) in self.keys.iter().enumerate() {
            let (place, layout) = match self.beside {
                true => (line(0), Layout::right_to_left(Align::Center)),
                false => (line(index + 1), Layout::left_to_right(Align::Center)),
            };
            let keys = RichText::new(text).small().color(Color32::from_gray(95));
            let width = child(place, layout).label(keys).rect.width();
            if self.beside {
                left.max.x -= width + HINT_GAP;
            }
        }
        child(left, Layout::left_to_right(Align::Center))
            .add(Label::new(RichText::new(text).color(colour)).truncate());
    }
}

/// What can be done with the picture where nothing in particular is under the pointer.
fn hint(moves: bool, picks: bool) -> String {
    let gestures = GESTURES.iter().filter(|gesture| gesture.moves);
    match (moves, picks) {
        (true, _) => {
            let told: Vec<String> =
                gestures.map(|gesture| format!("{}: {}", gesture.how, gesture.words)).collect();
            told.join(KEY_GAP)
        }
        (false, true) => CLICK.to_owned(),
        (false, false) => String::new(),
    }
}
