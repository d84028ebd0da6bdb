//! `[environment]`.

use super::environment_map::{read_map, white_map};
use super::expect_unique;
use super::lights::expect_radiometric;
use crate::description::EnvironmentFile;
use crate::library::{expect_file, locate};
use crate::scene::{Environment, NamedMap};
use crate::skies;
use crate::suggest::unknown_name;
use relume_formats::{Error, Place, Result};
use std::path::Path;
use std::sync::Arc;

/// Name of the evenly white map.
const WHITE: &str = "white";

/// The environment of a scene file in `folder`.
pub(super) fn build(file: &EnvironmentFile, folder: &Path, scene_place: &Place, warnings: &mut Vec<String>) -> Result<Environment> {
    let place = scene_place.part("[environment]");
    let mut named = |name: &String| named_map(name, &locate(folder, name), &place, warnings);
    let map = named(file.file.as_ref().unwrap_or(&WHITE.to_owned()))?;
    let others = file.others.iter().map(named).collect::<Result<Vec<_>>>()?;
    expect_unique([&map].into_iter().chain(&others).map(|m| m.name.as_str()), "environment map", &place)?;
    let environment = Environment { map, others, gain: file.gain, rotation_deg: file.rotation_deg };
    check(&environment, &place)?;
    Ok(environment)
}

/// The map that `name` stands for: a procedural one, or the file at `path`.
pub(super) fn named_map(name: &str, path: &Path, place: &Place, warnings: &mut Vec<String>) -> Result<NamedMap> {
    let procedural = if name == WHITE { Some(white_map()) } else { skies::by_name(name) };
    if let Some(map) = procedural {
        return Ok(NamedMap { name: name.to_owned(), map: Arc::new(map) });
    }
    if Path::new(name).extension().is_none() {
        let known = skies::NAMES.into_iter().chain([WHITE]);
        return Err(Error::invalid(place, format!("there is {} (a file ends in .hdr or .exr)", unknown_name("sky", name, known))));
    }
    expect_file(path, name, place)?;
    let file_name = path.file_name().map_or_else(|| name.to_owned(), |name| name.to_string_lossy().into_owned());
    Ok(NamedMap { name: file_name, map: Arc::new(read_map(path, warnings)?) })
}

/// Checks what a file or a state sets.
pub(super) fn check(environment: &Environment, place: &Place) -> Result<()> {
    expect_radiometric(environment.gain, "gain", place)?;
    let maps = [&environment.map].into_iter().chain(&environment.others);
    let brightest = maps.flat_map(|named| &named.map.texels).fold([0.0f32; 3], |m, t| std::array::from_fn(|k| m[k].max(t[k])));
    let shown = std::array::from_fn(|k| brightest[k] * environment.gain[k]);
    expect_radiometric(shown, "the map's brightest texel times gain", place)?;
    if !environment.rotation_deg.is_finite() {
        return Err(Error::invalid(place, "rotation_deg must be a finite number"));
    }
    Ok(())
}
