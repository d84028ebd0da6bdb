//! What the objects that deform show: a clip and a moment of it.

use super::editor::{Editor, Part};
use super::light_panel::reset;
use super::panel::section;
use egui::{ComboBox, Grid, Slider, SliderClamping, Ui};
use relume_formats::kinds::scene::StoredShape;
use relume_formats::name::plain;
use relume_formats::state::{Posed, ShapeState};

/// What a shape without a clip shows.
const AT_REST: &str = "at rest";

/// Draws a clip and a time for every object that may deform.
pub fn show(ui: &mut Ui, editor: &mut Editor) {
    let shapes: Vec<StoredShape> = editor.shapes().cloned().collect();
    if shapes.is_empty() {
        return;
    }
    section(ui, "SHAPES");
    for shape in shapes {
        let posed = editor.look().shapes.get(&shape.object).cloned();
        let mut change = ShapeState::default();
        Grid::new(("shape", &shape.object)).num_columns(2).spacing([10.0, 8.0]).show(ui, |ui| {
            ui.label(plain(&shape.object));
            change.clip = clip(ui, &shape, posed.as_ref());
            ui.end_row();
            ui.label("time");
            change.time_s = time(ui, &shape, posed.as_ref());
            ui.end_row();
        });
        if change != ShapeState::default() {
            editor.edit_shape(&shape.object, &change);
        }
        let label = format!("Reset {}", plain(&shape.object));
        if reset(ui, editor, &label, posed.is_some(), &[Part::Shape(shape.object.clone())]) {
            editor.reset_shape(&shape.object);
        }
    }
}

fn clip(ui: &mut Ui, shape: &StoredShape, posed: Option<&Posed>) -> Option<String> {
    let now = posed.map(|posed| posed.clip.as_str());
    let mut chosen = now;
    let combo = ComboBox::from_id_salt(("clip", &shape.object))
        .width(200.0)
        .selected_text(plain(now.unwrap_or(AT_REST)))
        .show_ui(ui, |ui| {
            for clip in &shape.clips {
                ui.selectable_value(&mut chosen, Some(clip.name.as_str()), plain(&clip.name));
            }
        });
    combo.response.accessible_name(format!("clip of {}", shape.object));
    chosen.filter(|_| chosen != now).map(str::to_owned)
}

/// Within the clip, which repeats.
fn time(ui: &mut Ui, shape: &StoredShape, posed: Option<&Posed>) -> Option<f32> {
    let duration_s = posed
        .and_then(|posed| shape.clips.iter().find(|clip| clip.name == posed.clip))
        .map_or(0.0, |clip| clip.duration_s);
    let time_s = posed.map_or(0.0, |posed| posed.time_s);
    let mut new = if (0.0..=duration_s).contains(&time_s) || duration_s <= 0.0 {
        time_s
    } else {
        time_s.rem_euclid(duration_s)
    };
    let slider = Slider::new(&mut new, 0.0..=duration_s)
        .clamping(SliderClamping::Edits)
        .fixed_decimals(2)
        .suffix(" s");
    let response = ui.add_enabled(duration_s > 0.0, slider);
    let changed = response.changed();
    response.accessible_name(format!("time of {}", shape.object));
    changed.then_some(new)
}
