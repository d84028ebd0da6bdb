//! Colours and spacing: dark and neutral, so that the surroundings do not tint what the eye sees in the
//! picture.

use egui::{Color32, Context, CornerRadius, FontId, Margin, Stroke, TextStyle, Theme, Vec2};

/// Around the picture.
pub const SURROUND: Color32 = Color32::from_gray(24);
/// The panel.
const PANEL: Color32 = Color32::from_gray(34);
/// Lines between sections.
const LINE: Color32 = Color32::from_gray(52);
/// What is selected, and the outline around it.
pub const ACCENT: Color32 = Color32::from_rgb(255, 176, 64);
/// Something the user should notice.
pub const WARNING: Color32 = Color32::from_rgb(255, 120, 96);

/// Sets the style of everything drawn in `ctx`.
pub fn set_up(ctx: &Context) {
    ctx.set_theme(Theme::Dark);
    ctx.style_mut_of(Theme::Dark, |style| {
        style.text_styles.insert(TextStyle::Body, FontId::proportional(13.5));
        style.text_styles.insert(TextStyle::Button, FontId::proportional(13.5));
        style.text_styles.insert(TextStyle::Heading, FontId::proportional(17.0));
        style.text_styles.insert(TextStyle::Small, FontId::proportional(11.5));
        style.spacing.item_spacing = Vec2::new(8.0, 6.0);
        style.spacing.button_padding = Vec2::new(8.0, 3.0);
        style.spacing.slider_width = 150.0;
        style.spacing.menu_margin = Margin::same(8);
        let visuals = &mut style.visuals;
        visuals.panel_fill = PANEL;
        visuals.window_fill = PANEL;
        visuals.extreme_bg_color = Color32::from_gray(20);
        visuals.slider_trailing_fill = true;
        visuals.selection.bg_fill = Color32::from_rgb(110, 76, 28);
        visuals.selection.stroke = Stroke::new(1.0, ACCENT);
        visuals.widgets.noninteractive.bg_stroke = Stroke::new(1.0, LINE);
        visuals.widgets.noninteractive.fg_stroke.color = Color32::from_gray(205);
        visuals.widgets.inactive.fg_stroke.color = Color32::from_gray(220);
        for widget in [
            &mut visuals.widgets.inactive,
            &mut visuals.widgets.hovered,
            &mut visuals.widgets.active,
            &mut visuals.widgets.open,
        ] {
            widget.corner_radius = CornerRadius::same(4);
        }
    });
}
