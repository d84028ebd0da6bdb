//! `[environment]`.

use super::expect_unique;
use crate::description::EnvironmentFile;
use crate::library::{expect_file, locate};
use crate::scene::{Environment, NamedMap};
use crate::skies;
use crate::suggest::unknown_name;
use relume_formats::basis::EquirectMap;
use relume_formats::kinds::scene::EnvironmentLook;
use relume_formats::map_file::read_map;
use relume_formats::state::{EnvironmentState, Rgb, expect_radiometric};
use relume_formats::{Error, Place, Result};
use std::path::Path;
use std::sync::Arc;

/// Name of the evenly white map.
const WHITE: &str = "white";

/// Evenly white. It has more than one texel because tracers sample maps by rows of equal latitude.
fn white_map() -> EquirectMap {
    let (width, height) = (32, 16);
    EquirectMap { width, height, texels: vec![[1.0; 3]; (width * height) as usize] }
}

/// The environment of a scene file in `folder`.
pub(super) fn build(
    file: &EnvironmentFile,
    folder: &Path,
    scene_place: &Place,
    warnings: &mut Vec<String>,
) -> Result<Environment> {
    let place = scene_place.part("[environment]");
    let mut named = |name: &String| named_map(name, &locate(folder, name), &place, warnings);
    let map = named(file.file.as_ref().unwrap_or(&WHITE.to_owned()))?;
    let others = file.others.iter().map(named).collect::<Result<Vec<_>>>()?;
    expect_unique([&map].into_iter().chain(&others).map(|m| m.name.as_str()), "environment map", &place)?;
    let environment = Environment { map, others, gain: file.gain, rotation_deg: file.rotation_deg };
    environment.with(&EnvironmentState::default(), scene_place)
}

/// The map that `name` stands for: a procedural one, or the file at `path`.
pub(super) fn named_map(
    name: &str,
    path: &Path,
    place: &Place,
    warnings: &mut Vec<String>,
) -> Result<NamedMap> {
    let procedural = if name == WHITE { Some(white_map()) } else { skies::by_name(name) };
    if let Some(map) = procedural {
        return Ok(NamedMap { name: name.to_owned(), map: Arc::new(map) });
    }
    if Path::new(name).extension().is_none() {
        let known = skies::NAMES.into_iter().chain([WHITE]);
        return Err(Error::invalid(
            place,
            format!("there is {} (a file ends in .hdr or .exr)", unknown_name("sky", name, known)),
        ));
    }
    expect_file(path, name, place)?;
    let file_name =
        path.file_name().map_or_else(|| name.to_owned(), |name| name.to_string_lossy().into_owned());
    Ok(NamedMap { name: file_name, map: Arc::new(read_map(path, warnings)?) })
}

impl Environment {
    /// What is stored of it: how its map is shown.
    pub fn look(&self) -> EnvironmentLook {
        EnvironmentLook { map: self.map.name.clone(), gain: self.gain, rotation_deg: self.rotation_deg }
    }

    /// This environment with the gain and rotation that `change` names; its map is the caller's.
    ///
    /// # Errors
    /// Those of [`EnvironmentLook::with`], and `Invalid` where a map becomes brighter than anything.
    pub(super) fn with(mut self, change: &EnvironmentState, place: &Place) -> Result<Self> {
        let EnvironmentLook { gain, rotation_deg, .. } = self.look().with(change, place)?;
        (self.gain, self.rotation_deg) = (gain, rotation_deg);
        let maps = [&self.map].into_iter().chain(&self.others);
        let brightest = maps
            .flat_map(|named| &named.map.texels)
            .fold([0.0f32; 3], |m, t| std::array::from_fn(|k| m[k].max(t[k])));
        let shown: Rgb = std::array::from_fn(|k| brightest[k] * self.gain[k]);
        expect_radiometric(shown, "environment: the map's brightest texel times gain", place)?;
        Ok(self)
    }
}
