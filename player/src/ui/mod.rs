//! What the user sees and sets. [`Editor`] and [`Picker`] know nothing of drawing; [`Screen`] draws them with
//! egui and needs no window.

mod clipboard;
mod closing;
mod display_panel;
mod editor;
mod facts;
mod hand;
mod help;
mod highlight;
mod keys;
mod layout;
mod legal;
mod light_panel;
mod material_panel;
mod messages;
mod orbit;
mod panel;
mod picker;
mod screen;
mod shape_panel;
mod status;
mod style;
mod turns;
mod undertaking;

pub use editor::{Editor, Kept, Metering, Part};
pub use facts::{Facts, Loading, Note, Save};
pub use orbit::Motion;
pub use picker::Picker;
pub use screen::{Screen, Stage, Wishes};
pub use style::set_up as set_up_style;
pub use turns::run_in_turns;

#[cfg(test)]
mod tests;
