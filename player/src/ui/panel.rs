//! The panel: materials, light, shapes, view, animation, display, files, figures; and below, messages.

use super::display_panel;
use super::editor::{Editor, HOLD_RULE, Part};
use super::facts::{Facts, Note, Save};
use super::light_panel;
use super::material_panel::{self, Yielded};
use super::messages;
use super::screen::{Wishes, told};
use super::shape_panel;
use super::style::WARNING;
use egui::{Button, Color32, Grid, Rect, RichText, ScrollArea, Slider, SliderClamping, Ui};
use relume_formats::name::plain;

/// Draws the panel, and adds what the user asks for to `wishes`, and whether the keys are to be told to the
/// other.
pub fn show(
    ui: &mut Ui,
    editor: Option<&mut Editor>,
    facts: &Facts,
    note: Option<&Note>,
    (yielded, helping): (&mut Yielded, &mut bool),
    wishes: &mut Wishes,
) {
    let name = editor.as_deref().map_or("the bundle".into(), |editor| plain(&editor.scene().name));
    messages::show(ui, &name, facts, note, yielded.text(ui.ctx()), wishes);
    // Otherwise what scrolls would reach a few points into the messages.
    ui.shrink_clip_rect(Rect::everything_above(ui.available_rect_before_wrap().bottom()));
    ScrollArea::vertical().auto_shrink([false, false]).show(ui, |ui| {
        ui.add_space(6.0);
        if let Some(editor) = editor {
            ui.heading(RichText::new(plain(&editor.scene().name)).strong());
            edits(ui, editor, helping, wishes);
            material_panel::show(ui, editor, yielded, wishes);
            light_panel::light(ui, editor, facts);
            shape_panel::show(ui, editor);
            light_panel::view(ui, editor);
            animation(ui, editor);
            display_panel::show(ui, editor);
            files(ui, wishes);
            fixed(ui, editor);
        }
        statistics(ui, facts);
    });
}

/// Undo, redo, back to the scene, and help.
fn edits(ui: &mut Ui, editor: &mut Editor, helping: &mut bool, wishes: &mut Wishes) {
    ui.horizontal(|ui| {
        let button = |ui: &mut Ui, label: &str, about: Option<&str>, keys: &str| {
            let hint = about.map_or_else(|| keys.to_owned(), |about| format!("{about} ({keys})"));
            let button = ui.add_enabled(about.is_some(), Button::new(label).min_size([58.0, 0.0].into()));
            button.on_hover_text(hint).on_disabled_hover_text(keys).clicked()
        };
        let undo = button(ui, "Undo", editor.undoes(), "Ctrl+Z");
        let redo = button(ui, "Redo", editor.redoes(), "Shift+Ctrl+Z");
        if undo || redo {
            wishes.tell = told(undo, redo, editor);
        }
        let all = ui.add_enabled(editor.is_anything_edited(), Button::new("Reset all"));
        if all.on_hover_text("everything back to what the scene says; can be undone").clicked() {
            editor.reset_all();
        }
        *helping |= ui.button("?").on_hover_text("all keys, and what the mouse does (F1)").clicked();
    });
}

/// A heading with a line above it.
pub(super) fn section(ui: &mut Ui, title: &str) {
    ui.add_space(6.0);
    ui.separator();
    ui.label(RichText::new(title).small().color(Color32::from_gray(140)));
}

fn animation(ui: &mut Ui, editor: &mut Editor) {
    section(ui, "ANIMATION");
    if editor.animations().is_empty() {
        ui.label(RichText::new("this bundle has none").weak());
        return;
    }
    let mut chosen = editor.active();
    ui.horizontal_wrapped(|ui| {
        ui.selectable_value(&mut chosen, None, "none");
        for (index, animation) in editor.animations().iter().enumerate() {
            ui.selectable_value(&mut chosen, Some(index), plain(&animation.name));
        }
    });
    if chosen != editor.active() {
        editor.choose(chosen);
    }
    ui.add_enabled_ui(editor.animation().is_some(), |ui| player(ui, editor));
}

/// Plays and scrubs the chosen animation. Its row keeps its place where there is none.
fn player(ui: &mut Ui, editor: &mut Editor) {
    let duration_s = editor.animation().map_or(1.0, |animation| f64::from(animation.duration_s));
    ui.horizontal(|ui| {
        let label = if editor.is_playing() { "Pause" } else { "Play" };
        if ui.add(Button::new(label).min_size([58.0, 0.0].into())).on_hover_text(HOLD_RULE).clicked() {
            editor.play_or_pause();
        }
        let mut time_s = editor.time_s();
        // Unless only edits are clamped, the slider rounds what it is shown, and takes that for an edit.
        let slider = Slider::new(&mut time_s, 0.0..=duration_s)
            .clamping(SliderClamping::Edits)
            .fixed_decimals(2)
            .suffix(" s");
        let response = ui.add(slider).on_hover_text(HOLD_RULE);
        if response.changed() {
            editor.scrub(time_s);
        }
        response.accessible_name("time");
    });
    covered(ui, editor);
}

/// Says which edits the animation covers. The line is there without any, too, so that nothing moves.
fn covered(ui: &mut Ui, editor: &Editor) {
    let parts = Part::words_of(&editor.covered());
    let text =
        if parts.is_empty() { " ".to_owned() } else { format!("covers your edit of {}", parts.join(", ")) };
    let line = ui.add(egui::Label::new(RichText::new(text).small().color(WARNING)).truncate());
    if !parts.is_empty() {
        line.on_hover_text(
            "Edited before this animation was chosen. It comes back with `none`; edit it again to hold it against the animation.",
        );
    }
}

fn files(ui: &mut Ui, wishes: &mut Wishes) {
    section(ui, "FILES");
    ui.horizontal(|ui| {
        let button = ui.add(Button::new("Open…").min_size([72.0, 0.0].into()));
        let hint = "a bundle (its manifest.json), a state, an animation or a map (Ctrl+O)";
        wishes.open |= button.on_hover_text(hint).clicked();
        ui.label(RichText::new("or drop a file on the window").small().weak());
    });
    ui.horizontal(|ui| {
        for what in Save::ALL {
            let (label, hint) = match what {
                Save::Png => ("PNG", "the picture as shown (S)"),
                Save::Exr => ("EXR", "linear radiance, before exposure and curve (E)"),
                Save::State => ("State", "the edits, to be played again with --state (T)"),
            };
            if ui.add(Button::new(label).min_size([72.0, 0.0].into())).on_hover_text(hint).clicked() {
                wishes.save.push(what);
            }
        }
    });
    ui.label(RichText::new("saved into the current folder, never over another file").small().weak());
}

/// Says what this bundle does not let vary, and which entry of the scene file would.
fn fixed(ui: &mut Ui, editor: &Editor) {
    let (varies, scene) = (editor.scope().varies(), editor.scene());
    let parts = [
        (varies.materials.is_empty(), "materials", "materials = [\"NAME\"]"),
        (!varies.environment && scene.environment.is_some(), "light", "light = true"),
        (!varies.camera, "view", "view = true"),
        (varies.shapes.is_empty() && !scene.shapes.is_empty(), "shapes", "shape = true"),
    ];
    let fixed: Vec<_> = parts.into_iter().filter(|(is_fixed, ..)| *is_fixed).collect();
    if fixed.is_empty() {
        return;
    }
    section(ui, "FIXED IN THIS BUNDLE");
    Grid::new("fixed").num_columns(2).spacing([16.0, 3.0]).show(ui, |ui| {
        for (_, name, entry) in fixed {
            ui.label(RichText::new(name).small().weak());
            let label = ui.add(egui::Label::new(RichText::new(entry).small().monospace()).truncate());
            label.on_hover_text(
                "under [vary] in scene.toml, and baked again, it varies; `bake plan` tells by which method",
            );
            ui.end_row();
        }
    });
}

fn statistics(ui: &mut Ui, facts: &Facts) {
    section(ui, "STATISTICS");
    let ms = |ms: Option<f64>| ms.map_or("not measured".to_owned(), |ms| format!("{ms:.2} ms"));
    let mut rows = vec![
        ("GPU time", ms(facts.gpu_ms)),
        ("CPU time", ms(facts.cpu_ms)),
        ("streamed", format!("{} of {} MB", megabytes(facts.bytes), megabytes(facts.bytes_expected))),
        (
            if facts.what.is_empty() { "pieces" } else { facts.what },
            format!("{} of {}", facts.pieces, facts.pieces_expected),
        ),
        ("method", facts.method.clone()),
        ("adapter", facts.adapter.clone()),
    ];
    if let Some([width, height]) = facts.size {
        rows.insert(4, ("size", format!("{width} × {height}")));
    }
    Grid::new("statistics").num_columns(2).spacing([16.0, 3.0]).show(ui, |ui| {
        for (name, value) in rows {
            ui.label(RichText::new(name).small().weak());
            ui.add(egui::Label::new(RichText::new(value).small()).truncate());
            ui.end_row();
        }
    });
    ui.add_space(8.0);
}

pub(super) fn megabytes(bytes: u64) -> String {
    format!("{:.1}", bytes as f64 / 1e6)
}
