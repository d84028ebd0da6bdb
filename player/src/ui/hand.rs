//! What the pointer does to the camera.

use super::orbit::Motion;
use egui::{PointerButton, Response, Ui};

/// The distance to the target grows by this factor for every point that the wheel scrolls.
const DOLLY_PER_POINT: f32 = 0.998;

/// What the pointer did on the picture since the last pass.
pub fn motions(ui: &Ui, picture: &Response) -> Vec<Motion> {
    // A drag is one only once it has left the place of a click; what it went until then is part of it.
    let whole = picture.total_drag_delta().filter(|_| picture.drag_started());
    let share = (whole.unwrap_or(picture.drag_delta()) / picture.rect.height().max(1.0)).into();
    let by = |button| picture.dragged_by(button);
    let pans = by(PointerButton::Secondary) || by(PointerButton::Middle);
    let scroll = if picture.hovered() { ui.input(|input| input.smooth_scroll_delta().y) } else { 0.0 };
    [
        (by(PointerButton::Primary), Motion::Orbit(share)),
        (pans, Motion::Pan(share)),
        (scroll != 0.0, Motion::Dolly(DOLLY_PER_POINT.powf(scroll))),
    ]
    .into_iter()
    .filter_map(|(done, motion)| (done && (share != [0.0; 2] || scroll != 0.0)).then_some(motion))
    .collect()
}
