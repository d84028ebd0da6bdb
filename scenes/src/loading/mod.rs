//! From a scene file to a [`Scene`]: every name resolved, every file read, every rule checked.

mod animations;
mod environment;
mod environment_map;
mod imported;
mod imported_lights;
mod imported_materials;
mod lights;
mod materials;
mod objects;
mod posing;
mod with_state;

use crate::description::{ErrorFile, RenderFile, SceneFile, VaryFile};
use crate::image_file::Textures;
use crate::scene::{Material, Scene, Vary};
use crate::suggest::unknown_name;
use relume_formats::kinds::scene::MAX_SIDE;
use relume_formats::state::{parse_toml, read_text};
use relume_formats::{Error, Place, Result};
use std::collections::HashSet;
use std::path::Path;

/// What every step of loading one scene needs.
struct Context<'a> {
    /// The scene file.
    place: Place,
    /// Where it lies.
    folder: &'a Path,
    /// Whether objects may deform.
    shapes_vary: bool,
    /// Textures read so far.
    textures: Textures,
    /// What was mended or ignored so far.
    warnings: Vec<String>,
}

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
    let max_error = max_error(&file.error, &place.part("[error]"))?;
    let mut context = Context { place, folder, shapes_vary: file.vary.shape, textures: Textures::default(), warnings: Vec::new() };
    objects::check(&file.object, &context)?;
    materials::check(&file.materials, &context.place)?;
    let imported = imported::read(&file.object, &file.materials, &mut context)?;
    let materials = materials::build(&file.materials, imported.materials, &file.vary.materials, &mut context)?;
    let vary = vary(&file.vary, &materials, &context.place)?;
    let objects = objects::build(&file.object, imported.objects, &materials, &mut context)?;
    let lights = lights::build(&file.light, imported.lights, &mut context)?;
    let environment = file.environment.map(|e| environment::build(&e, folder, &context.place, &mut context.warnings)).transpose()?;
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
        warnings: context.warnings,
    };
    scene.warn_of_idle_parts();
    // Objects of one file say the same of it.
    let mut told = HashSet::new();
    scene.warnings.retain(|warning| told.insert(warning.clone()));
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

fn max_error(file: &ErrorFile, place: &Place) -> Result<f64> {
    if !(file.max.is_finite() && file.max > 0.0) {
        return Err(Error::invalid(place, format!("max {} must be a number above 0", file.max)));
    }
    Ok(file.max)
}

fn vary(file: &VaryFile, materials: &[Material], place: &Place) -> Result<Vary> {
    let in_vary = place.part("[vary] materials");
    expect_unique(file.materials.iter().map(String::as_str), "material", &in_vary)?;
    let known: Vec<&str> = materials.iter().map(|m| m.name.as_str()).collect();
    let indices = file.materials.iter().map(|name| index_of(name, "material", &known, &in_vary)).collect::<Result<Vec<_>>>()?;
    let vary = Vary { light: file.light, view: file.view, shape: file.shape, materials: indices };
    validate_varying(&vary, materials, place)?;
    Ok(vary)
}

/// Checks that the parameters of what varies are within what bases span.
fn validate_varying(vary: &Vary, materials: &[Material], place: &Place) -> Result<()> {
    let mut varying = vary.materials.iter().filter_map(|index| materials.get(*index));
    varying.try_for_each(|m| m.brdf.validate_varying(m.texture.is_some(), &m.name, place))
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

#[cfg(test)]
mod import_mending_tests;
#[cfg(test)]
mod import_refusal_tests;
#[cfg(test)]
mod import_tests;
