//! What was meant by a path that leads to no bundle or file.

use super::common::BUNDLES;
use relume_bake::error::{BakeError, Result};
use relume_formats::Place;
use relume_formats::near::{nearest_file, what_there_is};
use std::path::Path;

/// Fails if nothing is at `path` though it is the name of a scene, or like one: its bundle is elsewhere, or
/// still to be baked.
pub(super) fn expect_no_scene(path: &Path) -> Result<()> {
    let Some(name) = path
        .to_str()
        .filter(|_| !path.exists() && path.components().count() == 1 && path.extension().is_none())
    else {
        return Ok(());
    };
    let refuse = |reason: String| Err(BakeError::invalid(&Place::file(path), reason));
    let bundle = Path::new(BUNDLES).join(name);
    if bundle.is_dir() {
        return refuse(format!("no such file or folder; did you mean `{}`?", bundle.display()));
    }
    // A misspelt bundle, or another file, says so itself.
    if nearest_file(Path::new(""), path).is_some() {
        return Ok(());
    }
    let names = relume_scenes::library().unwrap_or_default();
    if names.iter().any(|known| known == name) {
        return refuse(format!(
            "is a scene, not a bundle; bake it by `bake run {name}`, then name {}",
            bundle.display()
        ));
    }
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    refuse(format!("neither a file or folder nor a scene{}", what_there_is(name, &names)))
}
