//! A first scene for any model: what `bake new` writes.
//!
//! [`Starter::of`] looks at the model; [`Starter::text`] is the scene file, commented for its reader;
//! [`Starter::scene`] is what that file means, so that it can be looked at before it is written.

mod framing;
mod model;
mod paths;
mod placing;
mod quoting;
mod text;

#[cfg(test)]
mod tests;

use crate::loading::load_text;
use crate::scene::Scene;
use framing::Framing;
use model::Model;
pub use paths::{is_model, name_of};
use placing::Placing;
use relume_formats::Result;
use std::path::{Path, PathBuf};

/// What a look at the first picture of the scene adds to its file.
#[derive(Debug, Clone, PartialEq)]
pub struct Look {
    /// Steps by which the display is to brighten the picture.
    pub exposure_ev: f32,
    /// Materials that are seen, by name, each with how many pixels of that picture show it; the one with the
    /// most first.
    pub seen: Vec<(String, u32)>,
}

/// The first scene for a model.
#[derive(Debug)]
pub struct Starter {
    /// Where the scene file is to be.
    scene_file: PathBuf,
    /// The model's path from there.
    model_path: String,
    model: Model,
    placing: Placing,
    framing: Framing,
}

impl Starter {
    /// Looks at the model in `file`, for a scene file at `scene_file`, whose folder must be there. `scale` is
    /// how many metres the model's unit is, if somebody knows.
    ///
    /// # Errors
    /// `Io` if there is no such file, `Invalid` or `Unsupported` if it cannot be read or shows no surface, or
    /// its path cannot stand in a scene file.
    pub fn of(file: &Path, scene_file: &Path, scale: Option<f64>) -> Result<Self> {
        paths::expect_model(file)?;
        let model = Model::read(file)?;
        let placing = Placing::new(&model.extent, scale);
        let framing = Framing::new(&placing);
        Ok(Self {
            model_path: paths::relative(file, scene_file)?,
            scene_file: scene_file.to_path_buf(),
            model,
            placing,
            framing,
        })
    }

    /// The line of a scene file at `scene_file` that names the model in `file`.
    ///
    /// # Errors
    /// As [`Starter::of`], for paths.
    pub fn file_line(file: &Path, scene_file: &Path) -> Result<String> {
        paths::expect_model(file)?;
        Ok(text::file_line(&paths::relative(file, scene_file)?))
    }

    /// The scene file. Without a look at the scene nothing varies.
    pub fn text(&self, look: Option<&Look>) -> String {
        text::of(self, look)
    }

    /// The scene of that file.
    ///
    /// # Errors
    /// Those of [`crate::load`].
    pub fn scene(&self, look: Option<&Look>) -> Result<Scene> {
        load_text(&self.scene_file, &self.text(look))
    }
}
