//! States and animations from files, taken while a bundle is shown.

use super::Editor;
use relume_formats::bundle::expect_playable;
use relume_formats::state::{Animation, State};
use relume_formats::{Place, Result};
use relume_playback::Look;

impl Editor {
    /// Sets all that `state` says, as one edit.
    ///
    /// # Errors
    /// `Invalid` for what does not vary, is not there or is not legal. Then nothing has changed.
    pub fn take_state(&mut self, state: &State, place: &Place) -> Result<()> {
        state.expect_only(&self.scope.varies(), place)?;
        self.look().with(state, &self.scope, place)?;
        self.set(state);
        Ok(())
    }

    /// Offers `animation`, in the place of one that has its name, and plays it.
    ///
    /// # Errors
    /// `Invalid` for what does not vary, is not there or is not legal. Then nothing has changed.
    pub fn take_animation(&mut self, animation: Animation, place: &Place) -> Result<()> {
        expect_playable(&animation, &Look::default_of(self.scene()), &self.scope, place)?;
        let same = self.animations.iter().position(|other| other.name == animation.name);
        let index = same.unwrap_or(self.animations.len());
        match self.animations.get_mut(index) {
            Some(other) => *other = animation,
            // At the end, for steps back know animations by their places.
            None => self.animations.push(animation),
        }
        self.choose(Some(index));
        Ok(())
    }
}
