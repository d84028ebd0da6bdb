//! What there is to say at the moment: how loading stands, and what happened last. It has a place of its own
//! below the panel, so that nothing moves when a message comes or goes; what is too long for it is told whole
//! when pointed at.

use super::facts::{Facts, Loading, Note};
use super::panel::megabytes;
use super::style::{ACCENT, WARNING};
use egui::{Color32, Frame, Label, Margin, Panel, ProgressBar, RichText, Ui};

/// Height of the place, in points: two lines.
const HEIGHT: f32 = 48.0;
/// Height of a line.
const LINE: f32 = 18.0;

/// Draws the messages at the lower end of `ui`: of loading, and below `yielded` or else what happened last.
pub fn show(ui: &mut Ui, facts: &Facts, note: Option<&Note>, yielded: Option<&str>) {
    let frame = Frame::NONE.inner_margin(Margin { top: 8, ..Margin::ZERO });
    Panel::bottom("messages").exact_size(HEIGHT).resizable(false).frame(frame).show(ui, |ui| {
        ui.spacing_mut().item_spacing.y = 2.0;
        loading(ui, facts);
        let weak = ui.visuals().weak_text_color();
        match (yielded, note) {
            (Some(text), _) => line(ui, text, WARNING),
            (None, Some(Ok(done))) => line(ui, done, weak),
            (None, Some(Err(reason))) => line(ui, reason, WARNING),
            (None, None) => {}
        }
    });
}

fn loading(ui: &mut Ui, facts: &Facts) {
    let Facts { what, pieces, pieces_expected, .. } = facts;
    match &facts.loading {
        Loading::Arriving => {
            let share = facts.bytes as f32 / facts.bytes_expected.max(1) as f32;
            let text =
                format!("loading: {} of {} MB", megabytes(facts.bytes), megabytes(facts.bytes_expected));
            ui.add(ProgressBar::new(share).text(RichText::new(text).small()).desired_height(LINE - 2.0));
        }
        Loading::Complete => line(ui, "", WARNING),
        Loading::Prefix => line(
            ui,
            &format!("the first {pieces} of {pieces_expected} {what}, as asked for by --bytes"),
            ACCENT,
        ),
        Loading::Stopped(reason) => line(
            ui,
            &format!("the picture stands still: {reason}; save the state (T) and start again"),
            WARNING,
        ),
        Loading::Failed(reason) => {
            line(
                ui,
                &format!("loading ended early, with {pieces} of {pieces_expected} {what}: {reason}"),
                WARNING,
            );
        }
    }
}

/// One line of a fixed height.
fn line(ui: &mut Ui, text: &str, colour: Color32) {
    let label = Label::new(RichText::new(text).small().color(colour)).truncate();
    ui.allocate_ui([ui.available_width(), LINE].into(), |ui| {
        ui.set_min_height(LINE);
        ui.add(label);
    });
}
