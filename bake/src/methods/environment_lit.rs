//! What methods that are lit by the environment alone have in common: what they refuse and leave out, and the
//! files of light and textures.

use super::coarse;
use crate::compress::statistics::{median, worst};
use crate::error::{BakeError, Result};
use crate::methods::registered::Bundled;
use crate::unfinished::Work;
use relume_formats::Place;
use relume_formats::bundle::{MAX_MAP_TEXELS, MAX_MAPS, Maps, expect_textures};
use relume_formats::container::{Kind, Stored};
use relume_formats::kinds::manifest::FileEntry;
use relume_formats::kinds::textures::{MAX_SIDE, MAX_TEXTURES, MaterialTexture};
use relume_formats::kinds::{Environment, Textures};
use relume_formats::state::Brdf;
use relume_scenes::{Emitter, Glow, Light, Material, NamedMap, Scene};
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// Fails unless the environment is there and the only light, and the textures fit a bundle.
pub(super) fn expect_fit(scene: &Scene, name: &str) -> Result<()> {
    let place = Place::file(&scene.file);
    let refuse = |reason: String| Err(BakeError::invalid(&place, reason));
    if scene.environment.is_none() {
        return refuse(format!("has no [environment], which is the light of {name}; add one"));
    }
    if let Some(light) = scene.lights.iter().find(|light| faint_glow(scene, light).is_none()) {
        let remedy = match emitting_material(scene, light) {
            Some(material) => {
                format!("write `emission = 0` in [materials.\"{material}\"] to let it reflect only")
            }
            None => {
                "remove it, in the [[object]] of a glTF file by `lights = false`, or paint it into the map"
                    .to_owned()
            }
        };
        return refuse(format!("light `{}`: {name} lights by the environment alone; {remedy}", light.name));
    }
    let maps = environments(scene);
    let texels = maps.iter().map(|environment| environment.map.texels.len() as u64).sum::<u64>();
    if maps.len() > MAX_MAPS || texels > MAX_MAP_TEXELS {
        let count = maps.len();
        return refuse(format!(
            "has {count} environment maps of {texels} texels, {name} stores at most {MAX_MAPS} of {MAX_MAP_TEXELS}; leave some out"
        ));
    }
    maps.iter().try_for_each(|map| map.validate(&place))?;
    let textures = scene.materials.iter().filter_map(|m| m.texture.as_ref().map(|t| (&m.name, t)));
    if textures.clone().count() > MAX_TEXTURES {
        return refuse(format!(
            "has {} textures, {name} stores at most {MAX_TEXTURES}; merge some",
            textures.count()
        ));
    }
    match textures.into_iter().find(|(_, t)| t.size.iter().any(|n| *n > MAX_SIDE)) {
        Some((name, _)) => refuse(format!(
            "material `{name}`: a texture has at most {MAX_SIDE} texels a side in a bundle; scale it down"
        )),
        None => Ok(()),
    }
}

/// The material of the surface that is a light.
fn emitting_material<'a>(scene: &'a Scene, light: &Light) -> Option<&'a str> {
    let Emitter::Mesh { object, .. } = light.emitter else { return None };
    scene.materials.get(scene.objects.get(object)?.material).map(|material| material.name.as_str())
}

/// The material of the surface that is a light, if hardly any of it emits.
fn faint_glow<'a>(scene: &'a Scene, light: &Light) -> Option<&'a str> {
    match &light.emitter {
        Emitter::Mesh { glow: Some(glow), .. } if glow.is_faint() => emitting_material(scene, light),
        _ => None,
    }
}

/// What is left out, a sentence each: faint glows, highlights, that materials vary, and shadows within large
/// triangles.
pub(super) fn leaves_out(scene: &Scene, name: &str) -> Vec<String> {
    let highlights = scene.materials.iter().filter(|m| m.brdf.has_highlight());
    let highlights = highlights.map(|m| diffuse_only(m, name));
    let varying = scene.vary.materials.iter().map(|index| &scene.materials[*index].name);
    let varying = varying.map(|material| {
        format!("[vary] names material `{material}`, but {name} keeps materials as the scene has them")
    });
    let glows = glows_left_out(scene, name).into_iter();
    glows.chain(highlights).chain(varying).chain(coarse::notice(scene)).collect()
}

/// The same of a method that shows highlights, and lets materials vary.
pub(super) fn shine_left_out(scene: &Scene, name: &str) -> Vec<String> {
    glows_left_out(scene, name).into_iter().chain(coarse::notice(scene)).collect()
}

/// That faint glows are.
fn glows_left_out(scene: &Scene, name: &str) -> Vec<String> {
    let glows: BTreeSet<&str> = scene.lights.iter().filter_map(|light| faint_glow(scene, light)).collect();
    let share = 100.0 * Glow::FAINT;
    let of_material = |material: &str| {
        format!(
            "material `{material}`: {name} leaves out what its texture emits, {share} % of a white one's at most"
        )
    };
    glows.into_iter().map(of_material).collect()
}

/// That a material is shown without its highlight, of which a metal is made.
fn diffuse_only(material: &Material, name: &str) -> String {
    let shown = &material.name;
    match material.brdf {
        Brdf::Ggx(ggx) if ggx.metallic > 0.5 => {
            format!(
                "material `{shown}`: {name} shows its diffuse part only, and metals have next to none: it will be black; set metallic = 0"
            )
        }
        Brdf::CookTorrance(brdf) if brdf.kd == [0.0; 3] => {
            format!(
                "material `{shown}`: {name} shows its diffuse part only, and it has none: it will be black; raise kd"
            )
        }
        _ => format!("material `{shown}`: {name} shows its diffuse part only"),
    }
}

/// The maps that a bundle carries, as it stores them.
pub fn environments(scene: &Scene) -> Vec<Environment> {
    let maps = scene.environment.iter().flat_map(|e| [&e.map].into_iter().chain(&e.others));
    maps.map(|named: &NamedMap| Environment::kept(named.name.clone(), &named.map)).collect()
}

/// Writes the maps, which are `environments`, and the textures of `scene`: the first files of a method.
///
/// # Errors
/// If one cannot be written.
pub(super) fn files(
    scene: &Scene,
    environments: &[Environment],
    work: &Work<'_>,
) -> Result<Vec<(String, FileEntry)>> {
    let mut files = Vec::new();
    for (number, environment) in environments.iter().enumerate() {
        let written = work.write(environment, &format!("environment-{number}.relume"))?;
        files.push((Environment::KIND.name().to_owned(), written));
    }
    if let Some(textures) = textures(scene) {
        files.push((Textures::KIND.name().to_owned(), work.write(&textures, "textures.relume")?));
    }
    Ok(files)
}

/// What the player needs to draw textures; `None` if there are none.
fn textures(scene: &Scene) -> Option<Textures> {
    let textures: Vec<MaterialTexture> = (0..)
        .zip(&scene.materials)
        .filter_map(|(material, m)| {
            Some(MaterialTexture {
                material,
                alpha_cutoff: m.alpha_cutoff,
                texture: (**m.texture.as_ref()?).clone(),
            })
        })
        .collect();
    let mut uvs = Vec::new();
    for object in &scene.objects {
        let mesh = &object.mesh;
        uvs.extend((0..mesh.positions.len()).map(|vertex| mesh.uvs.get(vertex).copied().unwrap_or_default()));
    }
    (!textures.is_empty()).then_some(Textures { uvs, textures })
}

/// Median and worst error for the manifest of each set of `measured` errors, by what its name ends with.
/// Lights that show nothing have no error, and where none shows anything there is no figure.
pub(super) fn figures(measured: &[(&str, &[f64])]) -> BTreeMap<String, f64> {
    let mut figures = BTreeMap::new();
    for (ending, errors) in measured {
        let lit: Vec<f64> = errors.iter().copied().filter(|error| !error.is_nan()).collect();
        if !lit.is_empty() {
            figures.insert(format!("relative_l2_median{ending}"), median(&lit));
            figures.insert(format!("relative_l2_worst{ending}"), worst(&lit));
        }
    }
    figures
}

/// Bytes on disk of what [`environments`] and [`textures`] give.
pub(super) fn stored_bytes(scene: &Scene) -> Result<usize> {
    let place = || Place::file(&scene.file);
    let maps =
        environments(scene).iter().map(|map| Ok(map.to_bytes(place())?.len())).sum::<Result<usize>>()?;
    Ok(maps
        + textures(scene)
            .map(|textures| textures.to_bytes(place()))
            .transpose()?
            .map_or(0, |bytes| bytes.len()))
}

/// Checks maps and textures among the `files` of a method against the scene of `bundle`; returns the maps.
/// `other` is told of every other file, which come behind them, and of what came before.
pub(super) fn verify(
    bundle: &Bundled<'_>,
    files: &[(Kind, PathBuf)],
    mut other: impl FnMut(Kind, &Path, &Lit) -> relume_formats::Result<()>,
) -> relume_formats::Result<Maps> {
    let mut lit = Lit::default();
    for (kind, path) in files {
        let place = Place::file(path);
        match kind {
            Kind::Environment => lit.maps.add(&Environment::read_file(path)?, &place)?,
            Kind::Textures => {
                expect_textures(&Textures::read_file(path)?, bundle.scene, &place)?;
                lit.textured = true;
            }
            kind => other(*kind, path, &lit)?,
        }
    }
    Ok(lit.maps)
}

/// Maps and textures of a method.
#[derive(Default)]
pub(super) struct Lit {
    /// The maps.
    pub maps: Maps,
    /// Whether there are textures.
    pub textured: bool,
}
