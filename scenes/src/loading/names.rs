//! Names in scenes: checked before anything is read or traced, as they end up in file names, bundles and
//! terminals.

use crate::description::SceneFile;
use crate::scene::Scene;
use relume_formats::name::{self, MAX_CHARS, plain};
use relume_formats::{Place, Result};
use std::ffi::OsStr;

/// Checks the names that a scene file gives.
pub(super) fn check(file: &SceneFile, place: &Place) -> Result<()> {
    let objects = file.object.iter().map(|object| ("object", object.name.as_str()));
    let materials = file.materials.keys().map(|name| ("material", name.as_str()));
    let lights = file.light.iter().map(|light| ("light", light.name.as_str()));
    objects.chain(materials).chain(lights).try_for_each(|(what, name)| name::validate(what, name, place))
}

/// Checks all names of a scene, those that come from its files and those that were made of two included.
pub(super) fn expect_legal(scene: &Scene) -> Result<()> {
    let objects = scene.objects.iter().map(|object| ("object", object.name.as_str()));
    let materials = scene.materials.iter().map(|material| ("material", material.name.as_str()));
    let lights = scene.lights.iter().map(|light| ("light", light.name.as_str()));
    let shapes = scene.objects.iter().filter_map(|object| object.shape.as_deref());
    let clips = shapes.flat_map(|shape| &shape.clips).map(|clip| ("clip", clip.name.as_str()));
    let maps = scene
        .environment
        .iter()
        .flat_map(|e| std::iter::once(&e.map).chain(&e.others))
        .map(|map| ("map", map.name.as_str()));
    let place = Place::file(&scene.file);
    objects
        .chain(materials)
        .chain(lights)
        .chain(clips)
        .chain(maps)
        .try_for_each(|(what, name)| name::validate_made(what, name, &place))
}

/// The name of what is called as a file or folder is, whatever that is called: files are made by other rules
/// than ours.
pub(super) fn of_file(file: &OsStr) -> String {
    let name: String = plain(&file.to_string_lossy()).chars().take(MAX_CHARS).collect();
    // Bundles go into a folder of this name.
    let leads_elsewhere = name.chars().all(|c| c == '.');
    if leads_elsewhere { "scene".to_owned() } else { name }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_of_any_name_give_names() {
        for (file, expected) in [
            ("room", "room"),
            ("my r\u{f6}om.v2", "my r\u{f6}om.v2"),
            ("a\nb\u{1b}", r"a\nb\u{1b}"),
            ("..", "scene"),
            (".", "scene"),
            ("", "scene"),
            (".x", ".x"),
        ] {
            assert_eq!(of_file(OsStr::new(file)), expected);
        }
        assert_eq!(of_file(OsStr::new(&"x".repeat(250))), "x".repeat(MAX_CHARS));
    }
}
