//! Environment maps that the user adds while a bundle is shown.

use super::Live;
use crate::error::{Error, Result};
use relume_formats::state::EnvironmentState;
use std::path::Path;

impl Live {
    /// Adds the environment map in the file at `path` and lights the scene by it.
    ///
    /// # Errors
    /// If the file holds no map, the light does not vary, or there is nothing to see yet. Then nothing has
    /// changed.
    pub fn add_environment(&mut self, path: &Path) -> Result<()> {
        let Some(shown) = &mut self.shown else {
            return Err(Error::Failed("there is nothing to light yet; wait for the first image".to_owned()));
        };
        let name = self.session.add_environment(path)?;
        shown.editor.add_map(&name);
        shown.editor.edit_light(&EnvironmentState { map: Some(name), ..EnvironmentState::default() });
        // One of the same name may have been exchanged.
        self.stale = true;
        Ok(())
    }
}
