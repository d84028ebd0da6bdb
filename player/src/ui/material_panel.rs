//! The list of materials, and the parameters of the selected one.

use super::editor::{Editor, HOLD_RULE, Part};
use super::panel::section;
use super::screen::{Wishes, copied};
use super::style::ACCENT;
use egui::{
    Color32, Context, DragValue, Grid, Key, Rgba, RichText, Slider, SliderClamping, TextEdit, Ui, Vec2,
};
use relume_formats::basis::{hex_from_linear, linear_from_hex};
use relume_formats::kinds::scene::StoredMaterial;
use relume_formats::name::plain;
use relume_formats::state::{BlinnPhong, Brdf, CookTorrance, Ggx, MaterialState, Rgb};

/// Why a slider is disabled.
const NO_TEXTURED_METAL: &str = "this material's colour is a texture; a textured metal's picture is not linear in what was baked, so it stays a dielectric";
/// How long a note about a parameter that gave way stays, in seconds.
const YIELD_NOTE_S: f64 = 2.5;

/// Which parameter gave way to another one of late.
#[derive(Default)]
pub struct Yielded {
    text: &'static str,
    until_s: f64,
}

/// Draws the list and the editor below it, if any material may be edited.
pub fn show(ui: &mut Ui, editor: &mut Editor, yielded: &mut Yielded, wishes: &mut Wishes) {
    if editor.materials().next().is_none() {
        return;
    }
    section(ui, "MATERIALS");
    list(ui, editor);
    let Some(material) = editor.selected().cloned() else {
        ui.label(RichText::new("Click an object, or a name above, to edit it.").weak());
        return;
    };
    section(ui, &plain(&material.name).to_uppercase());
    let before = editor.brdf(&material);
    let change = match before {
        Brdf::BlinnPhong(brdf) => blinn_phong(ui, &brdf, &material),
        Brdf::Ggx(brdf) => ggx(ui, &brdf, &material),
        Brdf::CookTorrance(brdf) => cook_torrance(ui, &brdf, &material),
    };
    if change != MaterialState::default() {
        editor.edit(&material.name, &change);
        yielded.note(ui, &before, &editor.brdf(&material), &change);
    }
    ui.horizontal(|ui| {
        let button = ui.add_enabled(editor.is_edited(&material), egui::Button::new("Reset material"));
        if button.on_hover_text("back to what the scene says").clicked() {
            editor.reset(&material.name);
        }
        if ui
            .button("Copy")
            .on_hover_text("this material as text, for another or for a state file (Ctrl+C)")
            .clicked()
        {
            wishes.tell = copied(ui, editor);
        }
        wishes.paste |= ui.button("Paste").on_hover_text("on this material (Ctrl+V)").clicked();
    });
    ui.horizontal(|ui| {
        let parts = Part::of_material(&material.name);
        let held = parts.iter().filter(|part| editor.is_held(part)).filter_map(Part::label);
        let held: Vec<&str> = held.collect();
        if !held.is_empty() {
            let text = format!("held by hand: {}", held.join(", "));
            ui.label(RichText::new(text).small().color(ACCENT)).on_hover_text(HOLD_RULE);
        } else if parts.iter().any(|part| editor.drives(part)) {
            ui.label(RichText::new("moved by the animation").small().weak()).on_hover_text(HOLD_RULE);
        } else {
            ui.label(RichText::new(" ").small());
        }
    });
}

fn list(ui: &mut Ui, editor: &mut Editor) {
    let look = editor.look();
    let mut clicked = None;
    for material in editor.materials() {
        let selected = editor.selected().is_some_and(|s| s.name == material.name);
        let brdf = look.materials.get(&material.name).unwrap_or(&material.brdf);
        let mark = if editor.is_edited(material) { "  (edited)" } else { "" };
        ui.horizontal(|ui| {
            let (swatch, _) = ui.allocate_exact_size(Vec2::splat(14.0), egui::Sense::hover());
            ui.painter().rect_filled(swatch, 3.0, display_colour(brdf));
            if ui.selectable_label(selected, format!("{}{mark}", plain(&material.name))).clicked() {
                clicked = Some(material.name.clone());
            }
        });
    }
    if clicked.is_some() {
        editor.select(clicked.as_deref());
    }
}

/// One colour that stands for a material in the list.
fn display_colour(brdf: &Brdf) -> Color32 {
    let [r, g, b] = match brdf {
        Brdf::BlinnPhong(b) => std::array::from_fn(|k| b.kd[k] + b.ks[k]),
        Brdf::Ggx(g) => g.base_color,
        Brdf::CookTorrance(c) => std::array::from_fn(|k| c.kd[k] + c.ks[k]),
    };
    Rgba::from_rgb(r.clamp(0.0, 1.0), g.clamp(0.0, 1.0), b.clamp(0.0, 1.0)).into()
}

fn blinn_phong(ui: &mut Ui, brdf: &BlinnPhong, material: &StoredMaterial) -> MaterialState {
    let [least, most] = material.editable();
    let mut change = MaterialState::default();
    Grid::new("blinn-phong").num_columns(2).spacing([10.0, 8.0]).show(ui, |ui| {
        [change.kd, change.ks] = diffuse_and_glossy(ui, brdf.kd, brdf.ks);
        ui.label("shininess").on_hover_text("the exponent: larger is sharper");
        change.shininess = slider(ui, "shininess", brdf.shininess, least, most, true);
        ui.end_row();
    });
    change
}

fn cook_torrance(ui: &mut Ui, brdf: &CookTorrance, material: &StoredMaterial) -> MaterialState {
    let [least, most] = material.editable();
    let mut change = MaterialState::default();
    Grid::new("cook-torrance").num_columns(2).spacing([10.0, 8.0]).show(ui, |ui| {
        [change.kd, change.ks] = diffuse_and_glossy(ui, brdf.kd, brdf.ks);
        ui.label("fresnel")
            .on_hover_text("how much of ks is reflected head-on; metals 0.5 to 0.98, most else about 0.04");
        change.fresnel = slider(ui, "fresnel", brdf.fresnel, 0.0, 1.0, false);
        ui.end_row();
        ui.label("roughness").on_hover_text(format!(
            "slope of the facets, smaller is sharper; the bake holds bases for no sharper lobe than {least}'s"
        ));
        change.roughness = slider(ui, "roughness", brdf.roughness, least, most, false);
        ui.end_row();
    });
    change
}

/// The rows of two colours that share what is reflected. Returns those that the user changed.
fn diffuse_and_glossy(ui: &mut Ui, kd: Rgb, ks: Rgb) -> [Option<Rgb>; 2] {
    [("diffuse", "kd", kd), ("glossy", "ks", ks)].map(|(label, name, value)| {
        let about = format!("{name}: linear reflectance of the {label} lobe; kd + ks cannot exceed 1");
        ui.label(label).on_hover_text(about);
        let changed = colour(ui, name, value);
        ui.end_row();
        ui.label("");
        let changed = hex(ui, name, value).or(changed);
        ui.end_row();
        changed
    })
}

fn ggx(ui: &mut Ui, brdf: &Ggx, material: &StoredMaterial) -> MaterialState {
    let ([least, most], textured) = (material.editable(), material.textured);
    let mut change = MaterialState::default();
    Grid::new("ggx").num_columns(2).spacing([10.0, 8.0]).show(ui, |ui| {
        ui.label("base colour").on_hover_text("linear; a texture is multiplied by it");
        change.base_color = colour(ui, "base colour", brdf.base_color);
        ui.end_row();
        ui.label("");
        change.base_color = hex(ui, "base colour", brdf.base_color).or(change.base_color);
        ui.end_row();
        ui.label("metallic");
        change.metallic = ui
            .add_enabled_ui(!textured, |ui| slider(ui, "metallic", brdf.metallic, 0.0, 1.0, false))
            .inner
            .filter(|_| !textured);
        ui.end_row();
        ui.label("roughness").on_hover_text(format!(
            "smaller is sharper; the bake holds bases for no sharper lobe than {least}'s"
        ));
        change.roughness = slider(ui, "roughness", brdf.roughness, least, most, false);
        ui.end_row();
    });
    change
}

/// A swatch that opens a picker, and the three linear values. Returns the new colour if the user changed it.
fn colour(ui: &mut Ui, name: &str, value: Rgb) -> Option<Rgb> {
    let mut new = value;
    let mut changed = false;
    ui.horizontal(|ui| {
        ui.spacing_mut().item_spacing.x = 4.0;
        // The picker rounds even what it is only shown, by much less than a hand can move it.
        let mut picked = value;
        let swatch = ui.color_edit_button_rgb(&mut picked);
        if picked.iter().zip(value).any(|(picked, value)| (picked - value).abs() > 1e-5) {
            (new, changed) = (picked, true);
        }
        swatch.accessible_name(name);
        for (channel, letter) in new.iter_mut().zip(["R", "G", "B"]) {
            let drag = DragValue::new(channel).speed(0.004).range(0.0..=1.0).fixed_decimals(3);
            let response = ui.add(drag).on_hover_text(format!("{letter}, linear; drag, or click to type"));
            changed |= response.changed();
            response.accessible_name(format!("{name} {letter}"));
        }
    });
    changed.then_some(new)
}

/// The colour as the hexadecimal digits that other programs show and take. Returns the new colour if the user
/// has typed or pasted one.
fn hex(ui: &mut Ui, name: &str, value: Rgb) -> Option<Rgb> {
    let shown = hex_from_linear(value);
    ui.horizontal(|ui| {
        let id = ui.make_persistent_id(("hex", name));
        let mut text = ui.data(|data| data.get_temp::<String>(id)).unwrap_or_else(|| shown.clone());
        let field = TextEdit::singleline(&mut text).id(id).desired_width(76.0).char_limit(9);
        let response = ui
            .add(field)
            .on_hover_text("sRGB, 8 bits a channel: what other programs show; the numbers above are linear");
        ui.label(RichText::new("sRGB").small().weak());
        let called_off = ui.input(|input| input.key_pressed(Key::Escape));
        if response.has_focus() {
            ui.data_mut(|data| data.insert_temp(id, text.clone()));
        } else {
            ui.data_mut(|data| data.remove::<String>(id));
        }
        let done = response.lost_focus() && !called_off && text != shown;
        response.accessible_name(format!("{name} hex"));
        linear_from_hex(&text).filter(|_| done)
    })
    .inner
}

/// Returns the new value if the user changed it.
fn slider(ui: &mut Ui, name: &str, value: f32, least: f32, most: f32, logarithmic: bool) -> Option<f32> {
    let mut new = value;
    let slider = Slider::new(&mut new, least..=most).logarithmic(logarithmic).clamping(SliderClamping::Edits);
    let slider = if logarithmic { slider.fixed_decimals(1) } else { slider.fixed_decimals(3) };
    let response = ui.add(slider).on_disabled_hover_text(NO_TEXTURED_METAL);
    let changed = response.changed();
    response.accessible_name(name);
    changed.then_some(new)
}

impl Yielded {
    /// Notes it if a parameter changed that the user did not set.
    fn note(&mut self, ui: &Ui, before: &Brdf, after: &Brdf, change: &MaterialState) {
        let [before, after] = [before, after].map(|brdf| MaterialState::from(*brdf));
        let text = match (change.kd, change.ks) {
            (Some(_), None) if before.ks != after.ks => {
                "glossy was lowered: diffuse + glossy cannot exceed 1"
            }
            (None, Some(_)) if before.kd != after.kd => {
                "diffuse was lowered: diffuse + glossy cannot exceed 1"
            }
            _ => return,
        };
        *self = Self { text, until_s: ui.input(|input| input.time) + YIELD_NOTE_S };
    }

    /// The note, while it stays.
    pub fn text(&self, ctx: &Context) -> Option<&'static str> {
        let left_s = self.until_s - ctx.input(|input| input.time);
        if left_s > 0.0 {
            ctx.request_repaint_after_secs(left_s as f32);
        }
        Some(self.text).filter(|_| left_s > 0.0)
    }
}
