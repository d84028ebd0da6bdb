//! `[environment]`.

use super::environment_map::{read_map, white_map};
use super::lights::expect_radiometric;
use crate::description::EnvironmentFile;
use crate::library::{expect_file, locate};
use crate::scene::Environment;
use relume_formats::{Error, Place, Result};
use std::path::Path;
use std::sync::Arc;

/// The environment of a scene file in `folder`.
pub(super) fn build(file: &EnvironmentFile, folder: &Path, scene_place: &Place, warnings: &mut Vec<String>) -> Result<Environment> {
    let place = scene_place.part("[environment]");
    let map = match &file.file {
        None => white_map(),
        Some(name) => {
            let path = locate(folder, name);
            expect_file(&path, name, &place)?;
            read_map(&path, warnings)?
        }
    };
    let environment = Environment { map: Arc::new(map), gain: file.gain, rotation_deg: file.rotation_deg };
    check(&environment, &place)?;
    Ok(environment)
}

/// Checks what a file or a state sets.
pub(super) fn check(environment: &Environment, place: &Place) -> Result<()> {
    expect_radiometric(environment.gain, "gain", place)?;
    let brightest = environment.map.texels.iter().fold([0.0f32; 3], |m, t| std::array::from_fn(|k| m[k].max(t[k])));
    let shown = std::array::from_fn(|k| brightest[k] * environment.gain[k]);
    expect_radiometric(shown, "the map's brightest texel times gain", place)?;
    if !environment.rotation_deg.is_finite() {
        return Err(Error::invalid(place, "rotation_deg must be a finite number"));
    }
    Ok(())
}
