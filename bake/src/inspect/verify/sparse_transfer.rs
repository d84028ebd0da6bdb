//! What must agree between the files of the method sparse-transfer.

use super::sound;
use relume_formats::container::{Kind, Stored};
use relume_formats::kinds::manifest::MethodEntry;
use relume_formats::kinds::{Environment, SparseTransfer, StoredScene, Textures};
use relume_formats::{Error, Place, Result};
use std::path::Path;

/// Checks the files of `method`; returns a line for each, and the names of the environment maps.
pub(super) fn verify(method: &MethodEntry, scene: &StoredScene, folder: &Path, place: &Place) -> Result<(String, Vec<String>)> {
    expect_order(method, place)?;
    let mut lines = String::new();
    let mut maps = Vec::new();
    for (kind, entry) in &method.files {
        let place = Place::file(folder.join(&entry.file));
        let refuse = |reason: String| Err(Error::invalid(&place, format!("{reason}; bake it again")));
        if kind == Kind::Environment.name() {
            maps.push(Environment::read_file(&place.file)?.name);
        } else if kind == Kind::Textures.name() {
            Textures::read_file(&place.file)?.expect_scene(scene.positions.len(), scene.meta.materials.len(), &place)?;
        } else {
            let rows = SparseTransfer::read_file(&place.file)?.meta.vertices as usize;
            if rows != scene.positions.len() {
                return refuse(format!("{rows} rows, the scene has {} vertices", scene.positions.len()));
            }
        }
        lines += &sound(&place.file)?;
    }
    super::expect_maps(&maps, scene, place)?;
    Ok((lines, maps))
}

/// A player needs light and textures before the first rows.
fn expect_order(method: &MethodEntry, place: &Place) -> Result<()> {
    let kinds: Vec<&str> = method.files.iter().map(|(kind, _)| kind.as_str()).collect();
    let environments = kinds.iter().take_while(|kind| **kind == Kind::Environment.name()).count();
    let rest = &kinds[environments..];
    let (textures, rows) = (Kind::Textures.name(), Kind::SparseTransfer.name());
    if environments == 0 || !(*rest == [rows] || *rest == [textures, rows]) {
        let reason = format!("its files are not environments, perhaps {textures}, and {rows}, in this order; bake it again");
        return Err(Error::invalid(place, reason));
    }
    Ok(())
}
