//! Frames of another size than that which the player was started with.

use super::Player;
use crate::error::{Error, Result};
use crate::lit::drawable;

impl Player {
    /// Draws frames of `size` pixels, width and height, from now on: [`Player::film`] is another one, which is
    /// black until something is drawn, and targets of [`Player::show`] must have the new size. Nothing else is
    /// made anew: no light, shape, mesh or texture is touched, and no shader compiled. The camera keeps its
    /// vertical field of view.
    ///
    /// Frames that were drawn before may still be under way; what they are drawn on goes with them.
    ///
    /// # Errors
    /// If the scene has not arrived yet; if frames of this size cannot be drawn, see
    /// [`Player::drawable_size`]; and of a method whose images are baked at one size, if it is another. Then
    /// nothing has changed.
    pub fn resize(&mut self, size: [u32; 2]) -> Result<()> {
        let Some(playback) = &mut self.playback else { return Err(Error::NothingThere) };
        playback.resize(&self.gpu, size)?;
        if let (Some(film), Some(tonemap)) = (playback.film(), &mut self.tonemap) {
            tonemap.set_film(&self.gpu, film);
        }
        Ok(())
    }

    /// What [`Player::resize`] takes for `size`: that itself or, where the device cannot draw, show and copy so
    /// many pixels, the largest of the same shape. `None` of a method whose images are baked at one size.
    pub fn drawable_size(&self, size: [u32; 2]) -> Option<[u32; 2]> {
        self.method.resizes.then(|| drawable(&self.gpu, size))
    }
}
