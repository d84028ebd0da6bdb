//! Everything in the window: the picture, the panel beside it, the keys.

use super::clipboard;
use super::closing;
use super::editor::Editor;
use super::facts::{Facts, Loading, Note, Save};
use super::hand;
use super::help;
use super::highlight::Highlight;
use super::keys::{Does, pressed};
use super::layout;
use super::material_panel::Yielded;
use super::panel;
use super::picker::Picker;
use super::status::Status;
use super::style::SURROUND;
use super::undertaking::Undertaking;
use egui::{
    CentralPanel, Color32, CursorIcon, Event, Frame, Margin, Panel, Pos2, Rect, RichText, Sense, TextureId,
    Ui, WidgetInfo,
};
use relume_formats::name::plain;
use relume_playback::{Seen, Surfaces};

/// Around the line below the picture.
const STATUS_MARGIN: Margin = Margin::symmetric(12, 4);

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
    /// Whether it is drawn at the size that the screen has for it, see [`Wishes::picture`].
    pub resizes: bool,
    /// The picture.
    pub picture: TextureId,
}

/// Where the picture is.
#[derive(Clone, Copy)]
struct Place {
    /// What the pointer takes for the picture.
    area: Rect,
    /// Where its pixels are drawn, as far as that is within `area`.
    image: Rect,
}

/// What the user asks of the program.
#[derive(Debug, Default, PartialEq, Eq)]
pub struct Wishes {
    /// To save these.
    pub save: Vec<Save>,
    /// To be given the text of the clipboard, as an event.
    pub paste: bool,
    /// To show the bundle as it is on disk now.
    pub reload: bool,
    /// To be let choose a file.
    pub open: bool,
    /// To tell this.
    pub tell: Option<Note>,
    /// To draw the picture at this size, in pixels, which it then covers on the display.
    pub picture: Option<[u32; 2]>,
    /// To end, if what is to be saved could be.
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
    /// Whether the user is asked about edits that closing would lose.
    closing: bool,
    /// Whether all keys are told.
    helping: bool,
}

impl Screen {
    /// Has the window closed, unless that would lose edits: then the user is asked.
    pub fn close(&mut self) {
        (self.closing, self.helping) = (true, false);
    }

    /// The title of the window: what is asked, scene, selected material, animation, and whether more is to
    /// come.
    pub fn title(&self, editor: Option<&Editor>, facts: &Facts) -> String {
        let asked = if self.closing { format!("{} - ", closing::QUESTION) } else { String::new() };
        asked + &title(editor, facts)
    }

    /// Draws one frame and applies what the user does to the editor. Without a stage there is nothing to show
    /// yet.
    pub fn show(
        &mut self,
        ui: &mut Ui,
        mut stage: Option<Stage<'_>>,
        facts: &Facts,
        note: Option<&Note>,
    ) -> Wishes {
        if let Some(stage) = &mut stage {
            self.undertaking.watch(ui.ctx(), stage.editor);
        }
        let mut wishes = Wishes::default();
        let moves = stage.as_ref().is_some_and(|stage| stage.editor.scope().varies().camera);
        if !self.closing && !self.helping {
            self.keys(ui, stage.as_mut().map(|stage| &mut *stage.editor), &mut wishes);
        }
        if self.helping {
            self.helping = !pressed(ui, Does::Help) && help::show(ui.ctx(), moves);
        }
        if self.closing {
            self.ask(ui, stage.as_ref().map(|stage| &*stage.editor), &mut wishes);
        }
        // What is behind a question or the help sees no pointer: no tooltip of it may cover them.
        let pointer =
            (self.closing || self.helping).then(|| ui.input_mut(|input| std::mem::take(&mut input.pointer)));
        self.panels(ui, stage, facts, note, &mut wishes);
        if let Some(pointer) = pointer {
            ui.input_mut(|input| input.pointer = pointer);
        }
        wishes
    }

    /// Draws the panel, the picture and the line below it.
    fn panels(
        &mut self,
        ui: &mut Ui,
        mut stage: Option<Stage<'_>>,
        facts: &Facts,
        note: Option<&Note>,
        wishes: &mut Wishes,
    ) {
        let moves = stage.as_ref().is_some_and(|stage| stage.editor.scope().varies().camera);
        let frame = Frame::side_top_panel(ui.style()).inner_margin(Margin::symmetric(16, 8));
        let window = ui.max_rect().size();
        layout::panel(window).frame(frame).show(ui, |ui| {
            let editor = stage.as_mut().map(|stage| &mut *stage.editor);
            panel::show(ui, editor, facts, note, (&mut self.yielded, &mut self.helping), wishes);
        });
        let surround = Frame::NONE.fill(SURROUND);
        let picks = stage.as_ref().is_some_and(|stage| stage.picker.is_some());
        let room = ui.available_width() - 2.0 * f32::from(STATUS_MARGIN.left);
        let status = Status::new(ui, moves, picks, room, window.y);
        let line = Panel::bottom("status")
            .exact_size(status.height())
            .resizable(false)
            .frame(surround.inner_margin(STATUS_MARGIN));
        let line = line.show_separator_line(false).show(ui, |ui| ui.max_rect()).inner;
        CentralPanel::default().frame(surround).show(ui, |ui| match stage {
            Some(mut stage) => {
                let seen = self.picture(ui, &mut stage, wishes);
                status.show(ui, line, seen, self.clicked_fixed);
                self.undertaking.obey_escape(ui.ctx(), stage.editor);
                if self.undertaking.is_over(ui.ctx()) {
                    stage.editor.commit();
                }
            }
            None => {
                ui.centered_and_justified(|ui| {
                    ui.label(RichText::new("waiting for the first image").color(Color32::from_gray(140)))
                });
            }
        });
    }

    /// Draws the picture; returns what is under the pointer.
    fn picture<'a>(&mut self, ui: &mut Ui, stage: &mut Stage<'a>, wishes: &mut Wishes) -> Seen<'a> {
        let Place { area: rect, image } = place(ui, stage, wishes);
        let moves = stage.editor.scope().varies().camera;
        let response = ui.allocate_rect(rect, if moves { Sense::click_and_drag() } else { Sense::click() });
        response.widget_info(|| WidgetInfo::labeled(egui::accesskit::Role::Image, true, "picture"));
        if moves {
            hand::motions(ui, &response)
                .into_iter()
                .for_each(|motion| stage.editor.move_camera(motion, stage.surfaces));
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
        ui.painter().with_clip_rect(rect).image(stage.picture, image, whole, Color32::WHITE);
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

    /// The keys of the window, unless the user types into a field.
    fn keys(&mut self, ui: &mut Ui, editor: Option<&mut Editor>, wishes: &mut Wishes) {
        if ui.ctx().text_edit_focused() {
            return;
        }
        for (does, save) in [(Does::Png, Save::Png), (Does::Exr, Save::Exr), (Does::State, Save::State)] {
            if pressed(ui, does) {
                wishes.save.push(save);
            }
        }
        wishes.reload |= pressed(ui, Does::Reload);
        wishes.open |= pressed(ui, Does::Open);
        self.closing |= pressed(ui, Does::Close);
        self.helping |= pressed(ui, Does::Help);
        let Some(editor) = editor else { return };
        if pressed(ui, Does::Play) {
            editor.play_or_pause();
        }
        if editor.scope().varies().camera && pressed(ui, Does::ResetView) {
            editor.reset_view();
        }
        // The longer chord first, for the shorter one takes it, too.
        let redo = pressed(ui, Does::Redo);
        let undo = pressed(ui, Does::Undo);
        if self.undertaking.is_over(ui.ctx()) {
            wishes.tell = told(undo, redo, editor);
        }
        pasted_and_copied(ui, editor, wishes);
    }

    /// Asks about edits that closing would lose; without any, there is nothing to ask.
    fn ask(&mut self, ui: &Ui, editor: Option<&Editor>, wishes: &mut Wishes) {
        match editor.and_then(Editor::unsaved) {
            Some(unsaved) => closing::ask(ui.ctx(), &unsaved, &mut self.closing, wishes),
            None => (wishes.close, self.closing) = (true, false),
        }
    }
}

/// Where the picture is, and the wish for its size if that follows.
fn place(ui: &Ui, stage: &Stage<'_>, wishes: &mut Wishes) -> Place {
    let (room, pixels_per_point) = (ui.max_rect(), ui.pixels_per_point());
    if !stage.resizes {
        let area = layout::image_rect(room, stage.size, pixels_per_point);
        return Place { area, image: area };
    }
    let (area, pixels) = layout::whole_pixels(room, pixels_per_point);
    wishes.picture = Some(pixels);
    // Until a picture of that size is there, the last one stands for it.
    Place { area, image: layout::as_high_as(area, stage.size, pixels_per_point) }
}

/// Undoes or does again, and says what.
pub(super) fn told(undo: bool, redo: bool, editor: &mut Editor) -> Option<Note> {
    let said = |did: &str, about: Option<String>| {
        about.map_or_else(|| Err(format!("there is nothing to {did}")), |about| Ok(format!("{did}: {about}")))
    };
    match (undo, redo) {
        (true, _) => Some(said("undo", editor.undo())),
        (_, true) => Some(said("redo", editor.redo())),
        _ => None,
    }
}

/// Copies the selected material, and takes what is pasted.
fn pasted_and_copied(ui: &Ui, editor: &mut Editor, wishes: &mut Wishes) {
    let events = ui.input(|input| input.events.clone());
    for event in events {
        match event {
            Event::Copy => wishes.tell = copied(ui, editor).or(wishes.tell.take()),
            Event::Paste(text) => wishes.tell = Some(clipboard::paste(&text, editor)),
            _ => {}
        }
    }
}

/// Copies the selected material, and says so.
pub(super) fn copied(ui: &Ui, editor: &Editor) -> Option<Note> {
    let text = clipboard::copied(editor)?;
    ui.ctx().copy_text(text);
    Some(Ok("copied the material as text; Ctrl+V pastes it on another".to_owned()))
}

/// The title without what is asked.
fn title(editor: Option<&Editor>, facts: &Facts) -> String {
    let mut parts = Vec::new();
    if let Some(editor) = editor {
        parts.push(editor.scene().name.clone());
        parts.extend(
            editor
                .selected()
                .map(|m| format!("{}{}", m.name, if editor.is_edited(m) { " (edited)" } else { "" })),
        );
        let doing = if editor.is_playing() { "playing" } else { "paused" };
        parts.extend(editor.animation().map(|animation| format!("{} {doing}", animation.name)));
    }
    if facts.loading == Loading::Arriving {
        parts.push("loading".to_owned());
    }
    parts.push("Relume player".to_owned());
    plain(&parts.join(" - ")).into_owned()
}
