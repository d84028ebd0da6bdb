//! What there is to say at the moment: how loading stands or that it is out of date, and what happened last.
//! It has a place of its own below the panel, so that nothing moves when a message comes or goes; what is too
//! long for it is told whole when pointed at.

use super::facts::{Facts, Loading, Note};
use super::panel::megabytes;
use super::screen::Wishes;
use super::style::{ACCENT, WARNING};
use egui::{Align, Color32, Frame, Label, Layout, Margin, Panel, ProgressBar, RichText, Ui};

/// Height of the place, in points: two lines.
const HEIGHT: f32 = 48.0;
/// Height of a line.
const LINE: f32 = 18.0;

/// Draws the messages at the lower end of `ui`: of the bundle, which is called `name`, and below `yielded` or
/// else what happened last.
pub fn show(
    ui: &mut Ui,
    name: &str,
    facts: &Facts,
    note: Option<&Note>,
    yielded: Option<&str>,
    wishes: &mut Wishes,
) {
    let frame = Frame::NONE.inner_margin(Margin { top: 8, ..Margin::ZERO });
    Panel::bottom("messages").exact_size(HEIGHT).resizable(false).frame(frame).show(ui, |ui| {
        ui.spacing_mut().item_spacing.y = 2.0;
        if facts.rebaked {
            wishes.reload |= rebaked(ui, name);
        } else {
            loading(ui, facts);
        }
        let weak = ui.visuals().weak_text_color();
        match (yielded, note) {
            (Some(text), _) => line(ui, text, WARNING),
            (None, Some(Ok(done))) => line(ui, done, weak),
            (None, Some(Err(reason))) => line(ui, reason, WARNING),
            (None, None) => {}
        }
    });
}

/// Says that another bake is on disk, with a button to show it. Returns whether it was clicked.
fn rebaked(ui: &mut Ui, name: &str) -> bool {
    let text = RichText::new(format!("{name} was baked again; press F5 to show it")).small().color(ACCENT);
    let layout = Layout::right_to_left(Align::Center);
    ui.allocate_ui_with_layout([ui.available_width(), LINE].into(), layout, |ui| {
        let button = ui.small_button("Show").on_hover_text("your edits are kept as far as they fit (F5)");
        ui.with_layout(Layout::left_to_right(Align::Center), |ui| ui.add(Label::new(text).truncate()));
        button.clicked()
    })
    .inner
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
