//! From a scene file to a [`Scene`]: every name resolved, every file read, every rule checked.

mod animations;
mod environment;
mod environment_map;
mod lights;
mod materials;
mod objects;
mod with_state;

use crate::description::{RenderFile, SceneFile};
use crate::scene::{Scene, Vary};
use crate::suggest::unknown_name;
use relume_formats::kinds::scene::MAX_SIDE;
use relume_formats::state::{parse_toml, read_text};
use relume_formats::{Error, Place, Result};
use std::collections::HashSet;
use std::path::Path;

/// Reads the scene file at `path` and everything it names.
///
/// # Errors
/// `Invalid` or `Unsupported` with file and place for the first rule that is broken, `Io` for a file that is missing or unreadable.
pub fn load(path: &Path) -> Result<Scene> {
    let place = Place::file(path);
    let file: SceneFile = parse_toml(&read_text(path)?, &place)?;
    let folder = path.parent().unwrap_or_else(|| Path::new(""));
    check_render(&file.render, &place.part("[render]"))?;
    file.camera.validate(&place)?;
    let mut warnings = Vec::new();
    let materials = materials::build(&file.materials, &place)?;
    let material_names: Vec<&str> = materials.iter().map(|m| m.name.as_str()).collect();
    let vary = Vary {
        light: file.vary.light,
        view: file.vary.view,
        shape: file.vary.shape,
        materials: varying_materials(&file.vary.materials, &material_names, &place.part("[vary] materials"))?,
    };
    let objects = objects::build(&file.object, &material_names, folder, &place, &mut warnings)?;
    let lights = lights::build(&file.light, &place)?;
    let environment = file.environment.map(|e| environment::build(&e, folder, &place, &mut warnings)).transpose()?;
    let max_error = file.error.max;
    if !(max_error.is_finite() && max_error > 0.0) {
        return Err(Error::invalid(&place.part("[error]"), format!("max {max_error} must be a number above 0")));
    }
    let mut scene = Scene {
        name: scene_name(path, folder),
        file: path.to_path_buf(),
        size: file.render.size,
        reflections: file.render.reflections,
        max_error,
        vary,
        camera: file.camera,
        materials,
        objects,
        lights,
        environment,
        animations: Vec::new(),
        warnings,
    };
    scene.warn_of_idle_parts();
    scene.animations = animations::read_all(&scene, folder)?;
    Ok(scene)
}

impl Scene {
    fn warn_of_idle_parts(&mut self) {
        if self.lights.is_empty() && self.environment.is_none() {
            self.warnings.push(format!("{}: neither a light nor an environment, everything is black", self.file.display()));
        }
        for index in &self.vary.materials {
            if !self.objects.iter().any(|object| object.material == *index) {
                let name = &self.materials[*index].name;
                self.warnings.push(format!("{}: material `{name}` varies, but no object wears it", self.file.display()));
            }
        }
    }
}

fn check_render(render: &RenderFile, place: &Place) -> Result<()> {
    if render.size.iter().any(|n| !(1..=MAX_SIDE).contains(n)) {
        return Err(Error::invalid(place, format!("size {:?} is outside 1..{MAX_SIDE}", render.size)));
    }
    if render.reflections == 0 {
        return Err(Error::invalid(place, "reflections 0 shows nothing but lights; 1 is direct light, 2 adds one bounce"));
    }
    Ok(())
}

fn varying_materials(names: &[String], known: &[&str], place: &Place) -> Result<Vec<usize>> {
    expect_unique(names.iter().map(String::as_str), "material", place)?;
    names.iter().map(|name| index_of(name, "material", known, place)).collect()
}

/// The index of `name` among `known`, or an error that suggests one.
fn index_of(name: &str, what: &str, known: &[&str], place: &Place) -> Result<usize> {
    let found = known.iter().position(|known| *known == name);
    found.ok_or_else(|| Error::invalid(place, unknown_name(what, name, known.iter().copied())))
}

fn expect_unique<'a>(names: impl IntoIterator<Item = &'a str>, what: &str, place: &Place) -> Result<()> {
    let mut seen = HashSet::new();
    match names.into_iter().find(|name| !seen.insert(*name)) {
        Some(twice) => Err(Error::invalid(place, format!("two {what}s are called `{twice}`; rename or remove one"))),
        None => Ok(()),
    }
}

/// A scene is called as its folder, or as its file if that is not called scene.toml.
fn scene_name(path: &Path, folder: &Path) -> String {
    if let Some(stem) = path.file_stem().filter(|stem| *stem != "scene") {
        return stem.to_string_lossy().into_owned();
    }
    let here = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    let absolute = here.canonicalize().unwrap_or_else(|_| here.to_path_buf());
    absolute.file_name().map_or_else(|| "scene".to_owned(), |name| name.to_string_lossy().into_owned())
}

#[cfg(test)]
mod tests;
