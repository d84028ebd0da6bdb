//! All keys and gestures, told in a window of their own.

use super::keys::{GESTURES, Group, TABLE};
use super::panel::section;
use egui::{Context, Grid, Id, Modal, RichText, ScrollArea};

/// Its heading.
pub const TITLE: &str = "Keys and mouse";
/// Room for the title, the margins and the window's edge.
const AROUND: f32 = 100.0;

/// Tells all keys and gestures, those of the camera if it moves. Returns whether it goes on.
pub fn show(ctx: &Context, moves: bool) -> bool {
    let modal = Modal::new(Id::unique("help")).show(ctx, |ui| {
        ui.heading(TITLE);
        let height = (ctx.content_rect().height() - AROUND).max(0.0);
        ScrollArea::vertical().max_height(height).min_scrolled_height(height).show(ui, |ui| {
            for group in Group::ALL {
                section(ui, group.title());
                Grid::new(group.title()).num_columns(2).spacing([16.0, 3.0]).min_col_width(110.0).show(
                    ui,
                    |ui| {
                        let mut row = |how: &str, words: &str| {
                            ui.label(RichText::new(how).small().strong());
                            ui.label(RichText::new(words).small());
                            ui.end_row();
                        };
                        let gestures = GESTURES.iter().filter(|gesture| gesture.group == group);
                        gestures
                            .filter(|gesture| moves || !gesture.moves)
                            .for_each(|gesture| row(gesture.how, gesture.words));
                        TABLE
                            .iter()
                            .filter(|entry| entry.group == group)
                            .for_each(|entry| row(&entry.keys.join(" or "), entry.words));
                    },
                );
            }
        });
        ui.add_space(8.0);
        ui.button("Close help").clicked()
    });
    !(modal.inner || modal.should_close())
}
