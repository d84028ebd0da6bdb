//! What is asked before edits are lost that were not saved.

use super::facts::Save;
use super::screen::Wishes;
use super::style::ACCENT;
use egui::{Button, Context, Id, Key, Modal, Modifiers, RichText};

/// What is asked.
pub const QUESTION: &str = "Close without saving?";

/// Asks what to do about `unsaved` edits; goes on asking while `asking`.
pub fn ask(ctx: &Context, unsaved: &str, asking: &mut bool, wishes: &mut Wishes) {
    let pressed = |key| ctx.input_mut(|input| input.consume_key(Modifiers::NONE, key));
    let (enter, escape) = (pressed(Key::Enter), pressed(Key::Escape));
    let modal = Modal::new(Id::unique("closing")).show(ctx, |ui| {
        ui.set_width(380.0);
        ui.heading(QUESTION);
        ui.add_space(6.0);
        ui.label(format!(
            "Edits of {unsaved} are in no state file. A state plays them again: player BUNDLE --state FILE"
        ));
        ui.add_space(10.0);
        ui.horizontal(|ui| {
            let save = ui.add(Button::new(RichText::new("Save state and close").color(ACCENT))).clicked();
            let discard = ui.button("Close without saving").clicked();
            let cancel = ui.button("Cancel").clicked();
            (save, discard, cancel)
        })
        .inner
    });
    let (save, discard, cancel) = modal.inner;
    if save || enter {
        wishes.save.push(Save::State);
    }
    wishes.close |= save || enter || discard;
    *asking = !(wishes.close || cancel || escape || modal.should_close());
}
