//! Stored and loaded things in standard formats: `.npy` arrays, `.exr` images, `.ply` meshes, `.json` metadata.

mod basis;
mod images;
mod out;
mod ply;
mod scene;
mod shape;
mod sparse_transfer;
mod sphere_mesh;
mod sphere_set;
mod sphere_shadows;
mod stored;
mod table;
#[cfg(test)]
mod tests;
mod visibility_table;

pub use scene::export_scene;

use super::verify;
use out::Out;
use relume_formats::Result;
use relume_formats::container::{Kind, Stored, open};
use relume_formats::kinds::{
    BrdfBasis, Environment, HaarTable, Manifest, SparseTransfer, SphereSet, SphereShadows, StoredScene, Textures, TransferImages,
    VisibilityTable,
};
use relume_formats::shape::DeformingMesh;
use relume_formats::state::Animation;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// Exports the `.relume` file or bundle folder at `path` into the folder `out`, a bundle's files each into a folder of its own.
/// Existing files of the same names are replaced. Returns the files written.
///
/// # Errors
/// Those of [`verify`], and if something cannot be written.
pub fn export_file(path: &Path, out: &Path) -> Result<Vec<PathBuf>> {
    verify(path)?;
    if !path.is_dir() {
        return export_one(path, out);
    }
    let manifest = Manifest::read(path)?;
    let mut bundle = Out::new(out)?;
    bundle.json("bundle.json", &manifest)?;
    let mut written = bundle.written();
    // Methods may share a file.
    for file in manifest.entries().map(|e| e.file.as_str()).collect::<BTreeSet<_>>() {
        let name = file.strip_suffix(".relume").unwrap_or(file);
        written.extend(export_one(&path.join(file), &out.join(name))?);
    }
    Ok(written)
}

fn export_one(path: &Path, folder: &Path) -> Result<Vec<PathBuf>> {
    let kind = open(path)?.header().kind;
    let mut out = Out::new(folder)?;
    match kind {
        Kind::Scene => stored::scene(&StoredScene::read_file(path)?, &mut out)?,
        Kind::Animation => stored::animation(&<Animation as Stored>::read_file(path)?, &mut out)?,
        Kind::BrdfBasis => basis::export(&BrdfBasis::read_file(path)?, &mut out)?,
        Kind::TransferImages => images::export(&TransferImages::read_file(path)?, &mut out)?,
        Kind::HaarTable => table::export(&HaarTable::read_file(path)?, &mut out)?,
        Kind::Environment => stored::environment(&Environment::read_file(path)?, &mut out)?,
        Kind::Textures => stored::textures(&Textures::read_file(path)?, &mut out)?,
        Kind::SparseTransfer => {
            let bundle = path.parent().unwrap_or(Path::new(""));
            let scene = Manifest::read(bundle).ok().map(|m| StoredScene::read_file(&bundle.join(m.scene_file.file))).transpose()?;
            sparse_transfer::export(&SparseTransfer::read_file(path)?, scene.as_ref(), &mut out)?;
        }
        Kind::SphereSet => sphere_set::export(&SphereSet::read_file(path)?, &mut out)?,
        Kind::Shape => shape::export(&DeformingMesh::read_file(path)?, &mut out)?,
        Kind::SphereShadows => sphere_shadows::export(&SphereShadows::read_file(path)?, &mut out)?,
        Kind::VisibilityTable => visibility_table::export(&VisibilityTable::read_file(path)?, &mut out)?,
    }
    Ok(out.written())
}
