//! Stored and loaded things in standard formats: `.npy` arrays, `.exr` images, `.ply` meshes, `.json`
//! metadata.

mod scene;
#[cfg(test)]
mod tests;

pub use scene::export_scene;

use super::{kinds, verify};
use crate::inspected::out::Out;
use relume_formats::container::open;
use relume_formats::kinds::Manifest;
use relume_formats::{Place, Result};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// Exports the `.relume` file or bundle folder at `path` into the folder `out`, a bundle's files each into a
/// folder of its own. Existing files of the same names are replaced. Returns the files written.
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
    (kinds::find(kind, &Place::file(path))?.export)(path, &mut out)?;
    Ok(out.written())
}
