//! Bringing the picture up to date, its exposure too where that follows from the picture.

use super::Live;
use crate::error::Result;
use crate::ui::Metering;

impl Live {
    /// Brings the picture up to date, doing no more than what has changed asks for, and without waiting for
    /// the GPU unless the exposure is to be set by the picture. Returns whether it changed.
    pub fn draw(&mut self) -> Result<bool> {
        let changed = self.draw_changes()?;
        if self.meter()? {
            return self.draw_changes();
        }
        Ok(changed)
    }

    /// Exposes by the picture if that is asked for and there is one to go by. Returns whether it has.
    fn meter(&mut self) -> Result<bool> {
        let Some(metering) = self.shown.as_ref().and_then(|shown| shown.editor.metering()) else { return Ok(false) };
        let is_whole = !self.is_loading() && !self.stale;
        if self.drawn.is_none() || (metering == Metering::WhenWhole && !is_whole) {
            return Ok(false);
        }
        let ev = self.session.metered_ev()?;
        if let Some(shown) = &mut self.shown {
            shown.editor.metered(ev);
        }
        Ok(true)
    }
}
