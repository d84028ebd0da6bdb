//! The light of the environment, and the view.

use super::editor::{Editor, HOLD_RULE, Part};
use super::facts::Facts;
use super::panel::section;
use super::style::{ACCENT, WARNING};
use crate::environment::short_name;
use egui::{ComboBox, DragValue, Grid, RichText, Slider, SliderClamping, Ui};
use relume_formats::kinds::scene::{EnvironmentLook, MAX_GAIN};
use relume_formats::name::plain;
use relume_formats::state::{EnvironmentState, Rgb};
use relume_playback::NOT_MEASURED;

/// Brightest gain on the slider; the fields beside it reach on.
const GAIN_REACH: f32 = 100.0;
/// Smallest gain above 0 on the slider.
const GAIN_LEAST: f64 = 1e-3;

/// What the panel says of a map that is not the bundle's own.
const NOT_THE_BUNDLES: &str = "not the bundle's own map: its stated error was measured under others";

/// Draws what there is to say of the light, if it may change.
pub fn light(ui: &mut Ui, editor: &mut Editor, facts: &Facts) {
    let Some(look) = editor.look().environment.filter(|_| editor.scope().varies().environment) else {
        return;
    };
    section(ui, "LIGHT");
    let mut change = EnvironmentState::default();
    Grid::new("light").num_columns(2).spacing([10.0, 8.0]).show(ui, |ui| {
        ui.label("map");
        change.map = map(ui, &look, &editor.scope().maps);
        ui.end_row();
        ui.label("rotation").on_hover_text("counter-clockwise, seen from above");
        change.rotation_deg = rotation(ui, look.rotation_deg);
        ui.end_row();
        ui.label("gain").on_hover_text("a factor on all light");
        change.gain = brightness(ui, look.gain);
        ui.end_row();
        ui.label("");
        change.gain = channels(ui, look.gain).or(change.gain);
        ui.end_row();
    });
    if change != EnvironmentState::default() {
        editor.edit_light(&change);
    }
    if facts.map_from_outside {
        ui.label(RichText::new(NOT_THE_BUNDLES).small().color(WARNING)).on_hover_text(NOT_MEASURED);
    }
    let changed = editor.look().environment != editor.scene().environment;
    let parts = ["map", "rotation_deg", "gain"].map(Part::Light);
    if reset(ui, editor, "Reset light", changed, &parts) {
        editor.reset_light();
    }
}

/// Draws what there is to say of the view, if it may change.
pub fn view(ui: &mut Ui, editor: &mut Editor) {
    if !editor.scope().varies().camera {
        return;
    }
    section(ui, "VIEW");
    let (camera, home) = (editor.look().camera, editor.scene().camera);
    let changed = (camera.position, camera.target) != (home.position, home.target);
    if reset(ui, editor, "Reset view", changed, &[Part::View]) {
        editor.reset_view();
    }
}

/// A button that gives `parts` back what the scene says, and whether an animation moves them. Returns whether
/// it was clicked.
pub(super) fn reset(ui: &mut Ui, editor: &Editor, label: &str, changed: bool, parts: &[Part]) -> bool {
    let held = parts.iter().any(|part| editor.is_held(part));
    ui.horizontal(|ui| {
        let button = ui
            .add_enabled(changed || held, egui::Button::new(label))
            .on_hover_text("back to what the scene says");
        if held {
            ui.label(RichText::new("held by hand").small().color(ACCENT)).on_hover_text(HOLD_RULE);
        } else if parts.iter().any(|part| editor.drives(part)) {
            ui.label(RichText::new("moved by the animation").small().weak()).on_hover_text(HOLD_RULE);
        }
        button.clicked()
    })
    .inner
}

fn map(ui: &mut Ui, look: &EnvironmentLook, maps: &[String]) -> Option<String> {
    let mut chosen = look.map.clone();
    let combo = ComboBox::from_id_salt("map")
        .width(200.0)
        .selected_text(plain(&short_name(&chosen)).into_owned())
        .show_ui(ui, |ui| {
            for name in maps {
                ui.selectable_value(&mut chosen, name.clone(), plain(&short_name(name)))
                    .on_hover_text(plain(name));
            }
        });
    combo.response.accessible_name("map");
    Some(chosen).filter(|chosen| *chosen != look.map)
}

fn rotation(ui: &mut Ui, rotation_deg: f32) -> Option<f32> {
    let mut new = within_a_turn(rotation_deg);
    // Any angle may be typed; what it comes to is shown and set.
    let response = ui.add(
        Slider::new(&mut new, -180.0..=180.0).clamping(SliderClamping::Never).fixed_decimals(1).suffix("°"),
    );
    let changed = response.changed();
    response.accessible_name("rotation");
    changed.then(|| within_a_turn(new))
}

/// The same angle in −180 to 180.
fn within_a_turn(angle_deg: f32) -> f32 {
    if (-180.0..=180.0).contains(&angle_deg) {
        angle_deg
    } else {
        (angle_deg + 180.0).rem_euclid(360.0) - 180.0
    }
}

/// All channels at once, by the largest.
fn brightness(ui: &mut Ui, gain: Rgb) -> Option<Rgb> {
    let largest = gain.into_iter().fold(0.0, f32::max);
    let mut new = largest;
    let slider = Slider::new(&mut new, 0.0..=GAIN_REACH).logarithmic(true).smallest_positive(GAIN_LEAST);
    let response = ui.add(slider.clamping(SliderClamping::Edits).fixed_decimals(3));
    let changed = response.changed();
    response.accessible_name("gain");
    changed.then(|| if largest > 0.0 { gain.map(|channel| channel / largest * new) } else { [new; 3] })
}

fn channels(ui: &mut Ui, gain: Rgb) -> Option<Rgb> {
    let mut new = gain;
    let mut changed = false;
    ui.horizontal(|ui| {
        ui.spacing_mut().item_spacing.x = 4.0;
        for (channel, letter) in new.iter_mut().zip(["R", "G", "B"]) {
            let drag = DragValue::new(channel).speed(0.01).range(0.0..=MAX_GAIN).max_decimals(3);
            let response = ui.add(drag).on_hover_text(format!("{letter}; drag, or click to type"));
            changed |= response.changed();
            response.accessible_name(format!("gain {letter}"));
        }
    });
    changed.then_some(new)
}
