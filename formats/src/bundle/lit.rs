//! Maps and textures against the scene, and against the main file of a method that lights by the environment.

use super::refuse;
use crate::error::{Place, Result};
use crate::kinds::{Environment, StoredScene, Textures, scene};
use std::collections::BTreeSet;

/// Most environment maps of a method.
pub const MAX_MAPS: usize = 64;
/// Most texels of all of them: a player keeps them all.
pub const MAX_MAP_TEXELS: u64 = 1 << 26;

/// The environment maps of a method so far.
#[derive(Debug, Clone, Default)]
pub struct Maps {
    names: Vec<String>,
    texels: u64,
}

impl Maps {
    /// Adds the map at `place`.
    ///
    /// # Errors
    /// If there is one of this name, or there are too many, or too large ones.
    pub fn add(&mut self, environment: &Environment, place: &Place) -> Result<()> {
        let (name, map) = (&environment.name, &environment.map);
        if self.names.contains(name) {
            return refuse(place, format!("is the second environment map called `{name}`"));
        }
        self.names.push(name.clone());
        self.texels += map.texels.len() as u64;
        if self.names.len() > MAX_MAPS || self.texels > MAX_MAP_TEXELS {
            return refuse(
                place,
                format!(
                    "is one environment map too many: at most {MAX_MAPS} of {MAX_MAP_TEXELS} texels together are possible"
                ),
            );
        }
        Ok(())
    }

    /// Their names, in their order.
    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// Fails unless the map that `scene` shows is among them.
    fn expect_scene(&self, scene: &scene::Meta, place: &Place) -> Result<()> {
        match &scene.environment {
            None => refuse(place, "needs an environment, and the scene has none"),
            Some(look) if self.names.contains(&look.map) => Ok(()),
            Some(look) => refuse(
                place,
                format!("has no environment map `{}` before it, which the scene shows", look.map),
            ),
        }
    }
}

/// Fails unless the textures at `place` are those of exactly the textured materials of `scene`, with
/// coordinates for each of its vertices.
pub fn expect_textures(textures: &Textures, scene: &StoredScene, place: &Place) -> Result<()> {
    let (uvs, vertices) = (textures.uvs.len(), scene.positions.len());
    if uvs != vertices {
        return refuse(
            place,
            format!("has texture coordinates for {uvs} vertices, the scene has {vertices}"),
        );
    }
    let there: BTreeSet<u32> = textures.textures.iter().map(|texture| texture.material).collect();
    let textured =
        (0..).zip(&scene.meta.materials).filter(|(_, material)| material.textured).map(|(index, _)| index);
    let expected: BTreeSet<u32> = textured.collect();
    let name = |index: &u32| {
        scene
            .meta
            .materials
            .get(*index as usize)
            .map_or("no material at all", |material| material.name.as_str())
    };
    if let Some(missing) = expected.difference(&there).next() {
        return refuse(
            place,
            format!("has no texture of material `{}`, which is textured in the scene", name(missing)),
        );
    }
    match there.difference(&expected).next() {
        Some(stranger) => refuse(
            place,
            format!("has a texture of `{}`, which is not textured in the scene", name(stranger)),
        ),
        None => Ok(()),
    }
}

/// Fails unless the main file at `place`, with what it calls `what` for so many `vertices`, fits `scene` and
/// what came before it: `maps`, and textures or none.
pub fn expect_lit(
    what: &str,
    vertices: u64,
    scene: &StoredScene,
    maps: &Maps,
    textures: bool,
    place: &Place,
) -> Result<()> {
    let there = scene.positions.len();
    if vertices != there as u64 {
        return refuse(place, format!("has {what} for {vertices} vertices of a scene of {there}"));
    }
    let textured = scene.meta.materials.iter().find(|material| material.textured);
    if let Some(material) = textured.filter(|_| !textures) {
        return refuse(
            place,
            format!("needs the scene's textures before it: material `{}` has one", material.name),
        );
    }
    maps.expect_scene(&scene.meta, place)
}
