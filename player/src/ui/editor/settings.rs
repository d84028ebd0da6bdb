//! What the user has set, to go back to.

use super::{Editor, Part};
use relume_playback::Look;
use std::collections::BTreeSet;

/// Everything that an edit may change.
#[derive(Debug, Clone, PartialEq)]
pub struct Settings {
    pub(in crate::ui) base: Look,
    pub(in crate::ui) held: BTreeSet<Part>,
    playing: bool,
    time_s: f64,
}

impl Editor {
    /// The settings as they are.
    pub fn settings(&self) -> Settings {
        Settings {
            base: self.base.clone(),
            held: self.held.clone(),
            playing: self.playing,
            time_s: self.time_s,
        }
    }

    /// Goes back to `settings`. An animation that has been playing all along stays where it has got to.
    pub fn restore(&mut self, settings: Settings) {
        let played_on = self.playing && settings.playing;
        let time_s = if played_on { self.time_s } else { settings.time_s };
        (self.base, self.held, self.playing, self.time_s) =
            (settings.base, settings.held, settings.playing, time_s);
    }
}
