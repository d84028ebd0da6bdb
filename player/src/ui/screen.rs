//! Everything in the window: the picture, the panel beside it, the keys.

use super::editor::Editor;
use super::facts::{Facts, Loading, Note, Save};
use super::hand;
use super::highlight::Highlight;
use super::layout;
use super::material_panel::Yielded;
use super::panel;
use super::picker::Picker;
use super::style::{SURROUND, WARNING};
use super::undertaking::Undertaking;
use egui::{
    Align, CentralPanel, Color32, CursorIcon, Frame, Key, Label, Layout, Margin, Modifiers, Panel, Pos2, Rect, RichText, Sense, TextStyle,
    TextureId, Ui, UiBuilder, WidgetInfo,
};
use relume_formats::name::plain;
use relume_playback::{Seen, Surfaces};

/// What the user sees when pointing at something that cannot be edited.
const FIXED: &str = "fixed: not editable in this bundle";
/// Least distance between the hints in the bottom line.
const HINT_GAP: f32 = 24.0;
const KEYS: &str = "S  PNG     E  EXR     T  state     Space  play / pause     Esc  cancel     Q  close";

/// The picture and what belongs to it.
pub struct Stage<'a> {
    /// What the user sets.
    pub editor: &'a mut Editor,
    /// Which material is where, if the view is fixed.
    pub picker: Option<&'a Picker>,
    /// What the camera must not go through.
    pub surfaces: &'a Surfaces,
    /// Size of the picture in pixels of its own.
    pub size: [u32; 2],
    /// The picture.
    pub picture: TextureId,
}

/// What the user asks of the program.
#[derive(Debug, Default, PartialEq, Eq)]
pub struct Wishes {
    /// To save these.
    pub save: Vec<Save>,
    /// To end.
    pub close: bool,
}

/// What the drawing itself must remember.
#[derive(Default)]
pub struct Screen {
    highlight: Highlight,
    /// Set by a click on something fixed, until the next click.
    clicked_fixed: bool,
    yielded: Yielded,
    undertaking: Undertaking,
}

impl Screen {
    /// Draws one frame and applies what the user does to the editor. Without a stage there is nothing to show yet.
    pub fn show(&mut self, ui: &mut Ui, mut stage: Option<Stage<'_>>, facts: &Facts, note: Option<&Note>) -> Wishes {
        if let Some(stage) = &stage {
            self.undertaking.watch(ui.ctx(), stage.editor);
        }
        let mut wishes = keys(ui, stage.as_mut().map(|stage| &mut *stage.editor));
        let frame = Frame::side_top_panel(ui.style()).inner_margin(Margin::symmetric(16, 8));
        layout::panel(ui.max_rect().size()).frame(frame).show(ui, |ui| {
            let editor = stage.as_mut().map(|stage| &mut *stage.editor);
            wishes.save.extend(panel::show(ui, editor, facts, note, &mut self.yielded));
        });
        let surround = Frame::NONE.fill(SURROUND);
        let status = Panel::bottom("status").exact_size(28.0).resizable(false).frame(surround.inner_margin(Margin::symmetric(12, 4)));
        let status = status.show_separator_line(false).show(ui, |ui| ui.max_rect()).inner;
        CentralPanel::default().frame(surround).show(ui, |ui| match stage {
            Some(mut stage) => {
                let seen = self.picture(ui, &mut stage);
                self.status_line(ui, status, seen, &stage);
                self.undertaking.obey_escape(ui.ctx(), stage.editor);
            }
            None => {
                ui.centered_and_justified(|ui| ui.label(RichText::new("waiting for the first image").color(Color32::from_gray(140))));
            }
        });
        wishes
    }

    /// Draws the picture; returns what is under the pointer.
    fn picture<'a>(&mut self, ui: &mut Ui, stage: &mut Stage<'a>) -> Seen<'a> {
        let rect = layout::image_rect(ui.max_rect(), stage.size, ui.pixels_per_point());
        let moves = stage.editor.scope().varies().camera;
        let response = ui.allocate_rect(rect, if moves { Sense::click_and_drag() } else { Sense::click() });
        response.widget_info(|| WidgetInfo::labeled(egui::accesskit::Role::Image, true, "picture"));
        if moves {
            hand::motions(ui, &response).into_iter().for_each(|motion| stage.editor.move_camera(motion, stage.surfaces));
        }
        let pixel = response.hover_pos().and_then(|position| layout::pixel_at(rect, stage.size, position));
        let seen = stage.picker.zip(pixel).map_or(Seen::Nothing, |(picker, pixel)| picker.at(pixel));
        if response.clicked() {
            self.clicked_fixed = seen == Seen::Fixed;
            if let Seen::Material(name) = seen {
                stage.editor.select(Some(name));
            }
        }
        let whole = Rect::from_min_max(Pos2::ZERO, Pos2::new(1.0, 1.0));
        ui.painter().image(stage.picture, rect, whole, Color32::WHITE);
        if let Some(picker) = stage.picker {
            self.outline(ui, stage, picker, seen, rect);
        }
        seen
    }

    /// Outlines the material under the pointer, or the one that was selected last.
    fn outline(&mut self, ui: &Ui, stage: &Stage<'_>, picker: &Picker, seen: Seen<'_>, rect: Rect) {
        let hovered = if let Seen::Material(name) = seen { Some(name) } else { None };
        if hovered.is_some() {
            ui.ctx().set_cursor_icon(CursorIcon::PointingHand);
        }
        let selected = stage.editor.selected().map(|material| material.name.clone());
        if let Some(outline) = self.highlight.texture(ui.ctx(), picker, hovered, selected.as_deref()) {
            let whole = Rect::from_min_max(Pos2::ZERO, Pos2::new(1.0, 1.0));
            ui.painter().image(outline.id(), rect, whole, Color32::WHITE);
        }
    }

    /// What is under the pointer, or what can be done with the picture, on the left; the keys, on the right, where there is room for both.
    fn status_line(&self, ui: &mut Ui, rect: Rect, seen: Seen<'_>, stage: &Stage<'_>) {
        let moves = stage.editor.scope().varies().camera;
        let weak = Color32::from_gray(120);
        let (text, colour) = match seen {
            Seen::Material(name) => (plain(name), Color32::from_gray(220)),
            Seen::Fixed => (FIXED.into(), if self.clicked_fixed { WARNING } else { weak }),
            Seen::Nothing if moves => (hand::HELP.into(), weak),
            Seen::Nothing if stage.picker.is_none() => ("".into(), weak),
            Seen::Nothing => ("click an object to edit its material".into(), weak),
        };
        let keys = if moves { format!("V  reset view     {KEYS}") } else { KEYS.to_owned() };
        let width = |text: &str, style: TextStyle| ui.painter().layout_no_wrap(text.to_owned(), style.resolve(ui.style()), weak).size().x;
        let both_fit = width(&text, TextStyle::Body) + HINT_GAP + width(&keys, TextStyle::Small) <= rect.width();
        let line = UiBuilder::new().max_rect(rect).layout(Layout::left_to_right(Align::Center));
        let mut line = ui.new_child(line);
        line.set_clip_rect(rect);
        line.add(Label::new(RichText::new(text).color(colour)).truncate());
        if both_fit {
            line.with_layout(Layout::right_to_left(Align::Center), |ui| {
                ui.label(RichText::new(keys).small().color(Color32::from_gray(95)))
            });
        }
    }
}

/// The keys of the window, unless the user types into a field.
fn keys(ui: &mut Ui, editor: Option<&mut Editor>) -> Wishes {
    let mut wishes = Wishes::default();
    if ui.ctx().text_edit_focused() {
        return wishes;
    }
    let pressed = |key| ui.input_mut(|input| input.consume_key(Modifiers::NONE, key));
    for (key, save) in [(Key::S, Save::Png), (Key::E, Save::Exr), (Key::T, Save::State)] {
        if pressed(key) {
            wishes.save.push(save);
        }
    }
    if let Some(editor) = editor {
        if pressed(Key::Space) {
            editor.play_or_pause();
        }
        if editor.scope().varies().camera && pressed(Key::V) {
            editor.reset_view();
        }
    }
    wishes.close = pressed(Key::Q);
    wishes
}

/// The title of the window: scene, selected material, animation, and whether more is to come.
pub fn title(editor: Option<&Editor>, facts: &Facts) -> String {
    let mut parts = Vec::new();
    if let Some(editor) = editor {
        parts.push(editor.scene().name.clone());
        parts.extend(editor.selected().map(|m| format!("{}{}", m.name, if editor.is_edited(m) { " (edited)" } else { "" })));
        let doing = if editor.is_playing() { "playing" } else { "paused" };
        parts.extend(editor.animation().map(|animation| format!("{} {doing}", animation.name)));
    }
    if facts.loading == Loading::Arriving {
        parts.push("loading".to_owned());
    }
    parts.push("Relume player".to_owned());
    plain(&parts.join(" - ")).into_owned()
}
