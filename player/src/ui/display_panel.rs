//! How the display shows the picture: the curve and the exposure.

use super::editor::{Editor, Metering, Part};
use super::light_panel::reset;
use super::panel::section;
use egui::{Slider, SliderClamping, Ui};
use relume_formats::display::Tonemap;

/// Draws what there is to say of the display.
pub fn show(ui: &mut Ui, editor: &mut Editor) {
    section(ui, "DISPLAY");
    curve(ui, editor);
    exposure(ui, editor);
    let (look, scene) = (editor.look(), editor.scene());
    let changed = look.tonemap != scene.tonemap || look.camera.exposure_ev != scene.camera.exposure_ev;
    if reset(ui, editor, "Reset display", changed, &[Part::Exposure, Part::Tonemap]) {
        editor.reset_exposure();
        editor.reset_tonemap();
    }
}

fn curve(ui: &mut Ui, editor: &mut Editor) {
    let now = editor.look().tonemap;
    let mut chosen = now;
    ui.horizontal_wrapped(|ui| {
        for tonemap in Tonemap::ALL {
            let (label, hint) = match tonemap {
                Tonemap::Clamp => ("clamp", "nothing but what is brighter than the display is cut off"),
                Tonemap::Neutral => {
                    ("neutral", "Khronos PBR Neutral: base colours as they are, highlights lead to white")
                }
                Tonemap::Agx => ("AgX", "film-like: soft contrast, much room for highlights"),
            };
            ui.selectable_value(&mut chosen, tonemap, label).on_hover_text(hint);
        }
    });
    if chosen != now {
        editor.set_tonemap(chosen);
    }
}

fn exposure(ui: &mut Ui, editor: &mut Editor) {
    ui.horizontal(|ui| {
        let mut ev = editor.look().camera.exposure_ev;
        let range = editor.exposure_range();
        let slider =
            Slider::new(&mut ev, range).clamping(SliderClamping::Edits).fixed_decimals(2).suffix(" EV");
        let response = ui
            .add(slider)
            .on_hover_text("the curve is given 2^EV times the radiance; EXR files are not exposed");
        if response.changed() {
            editor.set_exposure(ev);
        }
        response.accessible_name("exposure");
        if ui
            .button("Auto")
            .on_hover_text("brings the geometric mean of the picture's luminance to 0.18")
            .clicked()
        {
            editor.meter(Metering::Now);
        }
    });
}
