//! From a scene file to a [`Scene`]: every name resolved, every file read, every rule checked.

mod animations;
mod environment;
mod imported;
mod imported_lights;
mod imported_materials;
mod lights;
mod materials;
mod names;
mod objects;
mod posing;
mod with_state;

use crate::description::{ErrorFile, RenderFile, SceneFile, VaryFile};
use crate::image_file::Textures;
use crate::scene::{Light, Material, Scene, Vary};
use crate::suggest::Names;
use posing::TO_DEFORM;
use relume_formats::container::MAX_SECTION_BYTES;
use relume_formats::kinds::scene::{MAX_PIXELS, MAX_SIDE, is_legal_size};
use relume_formats::state::{Model, parse_toml, read_text, with_line};
use relume_formats::{Error, Place, Result};
use std::collections::HashSet;
use std::path::Path;

/// Most vertices, and most triangles, of a scene: a section of a bundle holds no more.
const MOST_ELEMENTS: u64 = MAX_SECTION_BYTES / 12;

/// What the meshes of a scene take up so far. Meshes are large, so each asks before it is made, or at the
/// latest before the next one is.
#[derive(Default)]
struct Room {
    vertices: u64,
    triangles: u64,
}

impl Room {
    /// Takes room for a mesh.
    ///
    /// # Errors
    /// `Invalid` if the scene has no more.
    fn take(&mut self, vertices: u64, triangles: u64, place: &Place) -> Result<()> {
        self.vertices = self.vertices.saturating_add(vertices);
        self.triangles = self.triangles.saturating_add(triangles);
        let (count, what) = if self.triangles > MOST_ELEMENTS {
            (self.triangles, "triangles")
        } else {
            (self.vertices, "vertices")
        };
        if count > MOST_ELEMENTS {
            return Err(Error::invalid(
                place,
                format!(
                    "more than {MOST_ELEMENTS} {what} in the scene up to here; lower segments, or simplify meshes"
                ),
            ));
        }
        Ok(())
    }
}

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
    /// Room for meshes.
    room: Room,
}

/// Reads the scene file at `path` and everything it names.
///
/// # Errors
/// `Invalid` or `Unsupported` with file and place for the first rule that is broken, `Io` for a file that is
/// missing or unreadable.
pub fn load(path: &Path) -> Result<Scene> {
    load_text(path, &read_text(path)?)
}

/// As [`load`], as if the file at `path` held `text`, whatever is there.
///
/// # Errors
/// As there.
pub(crate) fn load_text(path: &Path, text: &str) -> Result<Scene> {
    load_unlocated(path, text).map_err(with_line)
}

fn load_unlocated(path: &Path, text: &str) -> Result<Scene> {
    let place = Place::file(path);
    let file: SceneFile = parse_toml(text, &place)?;
    let folder = path.parent().unwrap_or_else(|| Path::new(""));
    names::check(&file, &place)?;
    check_render(&file.render, &place.part("[render]"))?;
    file.camera.validate(&place)?;
    let max_error = max_error(&file.error, &place.part("[error]"))?;
    let mut context = Context {
        place,
        folder,
        shapes_vary: file.vary.shape,
        textures: Textures::default(),
        warnings: Vec::new(),
        room: Room::default(),
    };
    objects::check(&file.object, &mut context)?;
    materials::check(&file.materials, &context.place)?;
    let imported = imported::read(&file.object, &file.materials, &mut context)?;
    let materials = materials::build(&file.materials, imported.materials, &file.vary, &mut context)?;
    let vary = vary(&file.vary, &materials, &context.place)?;
    let objects = objects::build(&file.object, imported.objects, &materials, &mut context)?;
    let lights = lights::build(&file.light, imported.lights, &mut context)?;
    let environment = file
        .environment
        .map(|e| environment::build(&e, folder, &context.place, &mut context.warnings))
        .transpose()?;
    let mut scene = Scene {
        name: scene_name(path, folder),
        file: path.to_path_buf(),
        size: file.render.size,
        reflections: file.render.reflections.map_or_else(|| vary.usual_reflections(), |written| written.0),
        max_error,
        vary,
        camera: file.camera,
        tonemap: file.view.tonemap,
        materials,
        objects,
        lights,
        environment,
        animations: Vec::new(),
        warnings: context.warnings,
    };
    names::expect_legal(&scene)?;
    scene.warn_of_idle_parts();
    // Objects of one file say the same of it.
    let mut told = HashSet::new();
    scene.warnings.retain(|warning| told.insert(warning.clone()));
    scene.animations = animations::read_all(&scene, folder)?;
    Ok(scene)
}

impl Scene {
    fn warn_of_idle_parts(&mut self) {
        let file = Place::file(&self.file);
        if self.lights.is_empty() && self.environment.is_none() {
            self.warnings.push(format!("{file}: neither a light nor an environment, everything is black"));
        } else if !self.is_lit() {
            let reason = "what the lights emit, or the environment's gain, is 0, so that everything is black; raise one of them";
            self.warnings.push(format!("{file}: {reason}"));
        }
        let worn: HashSet<usize> = self.objects.iter().map(|object| object.material).collect();
        for index in &self.vary.materials {
            if !worn.contains(index) {
                let name = &self.materials[*index].name;
                self.warnings.push(format!("{file}: material `{name}` varies, but no object wears it"));
            }
        }
        if self.vary.shape && self.objects.iter().all(|object| object.shape.is_none()) {
            let reason =
                format!("[vary] shape = true, but no object deforms; {TO_DEFORM}, or leave shape out");
            self.warnings.push(format!("{file}: {reason}"));
        }
    }

    /// Whether anything emits light, wherever it goes.
    fn is_lit(&self) -> bool {
        let shines = |light: &Light| light.emitter.emission().iter().any(|x| *x > 0.0);
        let environment =
            self.environment.iter().flat_map(|e| e.map.map.texels.iter().map(|texel| (texel, &e.gain)));
        self.lights.iter().any(shines)
            || environment.into_iter().any(|(texel, gain)| texel.iter().zip(gain).any(|(t, g)| t * g > 0.0))
    }
}

fn check_render(render: &RenderFile, place: &Place) -> Result<()> {
    if render.size.iter().any(|n| !(1..=MAX_SIDE).contains(n)) {
        return Err(Error::invalid(place, format!("size {:?} is outside 1..{MAX_SIDE}", render.size)));
    }
    if !is_legal_size(render.size) {
        return Err(Error::invalid(
            place,
            format!("size {:?}: a film has at most {MAX_PIXELS} pixels; lower it", render.size),
        ));
    }
    if render.reflections.is_some_and(|reflections| reflections.0 == 0) {
        return Err(Error::invalid(
            place,
            "reflections 0 shows nothing but lights; 1 is direct light, 2 adds one bounce",
        ));
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
    let known = Names::new("material", materials.iter().map(|m| m.name.as_str()));
    let varying = listed(&file.materials, &known, &place.part("[vary] materials"))?;
    let in_painted = place.part("[vary] painted");
    let painted = listed(&file.painted, &known, &in_painted)?;
    if let Some(whole) = painted.iter().find(|index| !varying.contains(index)) {
        let name = &materials[*whole].name;
        let reason = format!("`{name}` is not among the materials that vary; add it there");
        return Err(Error::invalid(&in_painted, reason));
    }
    let vary = Vary {
        light: file.light,
        view: file.view,
        shape: file.shape,
        materials: varying,
        painted,
        shininess_max: file.shininess_max,
        roughness_min: file.roughness_min,
    };
    expect_sharpest(&vary, materials, place)?;
    validate_varying(&vary, materials, place)?;
    Ok(vary)
}

/// Indices of the materials that a list names, each once.
fn listed(names: &[String], known: &Names<'_>, place: &Place) -> Result<Vec<usize>> {
    let mut seen = HashSet::new();
    if let Some(twice) = names.iter().find(|name| !seen.insert(name.as_str())) {
        return Err(Error::invalid(place, format!("`{twice}` is listed twice; remove one")));
    }
    names.iter().map(|name| known.index_of(name, place)).collect()
}

/// Checks that sharper lobes are asked for only of models that vary, and that bases can follow them.
fn expect_sharpest(vary: &Vary, materials: &[Material], place: &Place) -> Result<()> {
    let varying = vary.materials.iter().filter_map(|index| materials.get(*index));
    let varying: Vec<Model> = varying.map(|material| material.brdf.model()).collect();
    let asked = [
        ("shininess_max", vary.shininess_max, &[Model::BlinnPhong][..]),
        ("roughness_min", vary.roughness_min, &[Model::Ggx, Model::CookTorrance]),
    ];
    for (key, value, models) in asked {
        let Some(value) = value else { continue };
        let place = place.part("[vary]");
        let of_it: Vec<&Model> = varying.iter().filter(|model| models.contains(model)).collect();
        if of_it.is_empty() {
            let models: Vec<String> = models.iter().map(|model| format!("\"{}\"", model.name())).collect();
            let reason = format!("`{key}`: no material that varies is {}; remove it", models.join(" or "));
            return Err(Error::invalid(&place, reason));
        }
        for model in of_it {
            model
                .expect_sharpest(value)
                .map_err(|fault| Error::invalid(&place, format!("`{key}` {fault}")))?;
        }
    }
    Ok(())
}

/// Checks that the parameters of what varies are within what bases span.
fn validate_varying(vary: &Vary, materials: &[Material], place: &Place) -> Result<()> {
    let mut varying = vary.materials.iter().filter_map(|index| materials.get(*index));
    varying.try_for_each(|m| {
        let sharpest = vary.sharpest(m.brdf.model());
        m.brdf.validate_varying(m.texture.is_some(), sharpest, &m.name, place)
    })
}

fn expect_unique<'a>(names: impl IntoIterator<Item = &'a str>, what: &str, place: &Place) -> Result<()> {
    let mut seen = HashSet::new();
    match names.into_iter().find(|name| !seen.insert(*name)) {
        Some(twice) => {
            Err(Error::invalid(place, format!("two {what}s are called `{twice}`; rename or remove one")))
        }
        None => Ok(()),
    }
}

/// A scene is called as its folder, or as its file if that is not called scene.toml.
fn scene_name(path: &Path, folder: &Path) -> String {
    if let Some(stem) = path.file_stem().filter(|stem| *stem != "scene") {
        return names::of_file(stem);
    }
    let here = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    let absolute = here.canonicalize().unwrap_or_else(|_| here.to_path_buf());
    absolute.file_name().map_or_else(|| "scene".to_owned(), names::of_file)
}

#[cfg(test)]
mod tests;

#[cfg(test)]
mod import_mending_tests;
#[cfg(test)]
mod import_refusal_tests;
#[cfg(test)]
pub(crate) mod import_tests;
