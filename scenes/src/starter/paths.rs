//! The files that a first scene stands between: the model, and the scene file that names it.

use relume_formats::has_extension;
use relume_formats::near::nearest_file;
use relume_formats::{Error, Place, Result};
use std::io::{Error as IoError, ErrorKind};
use std::path::{Component, Path, PathBuf};

/// The kinds of file that hold a model.
const KINDS: [&str; 5] = ["glb", "gltf", "obj", "ply", "off"];

/// True if `path` is called as a file that holds a model.
pub fn is_model(path: &Path) -> bool {
    KINDS.iter().any(|kind| has_extension(path, kind))
}

/// What to call the scene of the model in `file`: as the file, but as its folder if it is called only
/// `scene`, as downloads are.
pub fn name_of(file: &Path) -> String {
    let stem = file.file_stem().filter(|stem| !stem.eq_ignore_ascii_case("scene"));
    let folder = || file.parent().and_then(Path::file_name);
    let name = stem.or_else(folder).map(|name| name.to_string_lossy().into_owned());
    name.filter(|name| !name.eq_ignore_ascii_case("scene")).unwrap_or_else(|| "model".to_owned())
}

/// Fails unless a model may be read at `file`.
pub(super) fn expect_model(file: &Path) -> Result<()> {
    let place = Place::file(file);
    if !file.exists() {
        let meant = nearest_file(Path::new(""), file)
            .map(|meant| format!("; did you mean `{meant}`?"))
            .unwrap_or_default();
        return Err(Error::io(&place, IoError::new(ErrorKind::NotFound, format!("no such file{meant}"))));
    }
    if !is_model(file) || !file.is_file() {
        let reason = "is no model; name a .glb, .gltf, .obj, .ply or .off file";
        return Err(Error::unsupported(&place, reason));
    }
    Ok(())
}

/// The path of `file` from the folder of `scene_file`, with `/` between its parts and one part at least that
/// is no name of a folder, so that it is never taken for one of the library's assets.
pub(super) fn relative(file: &Path, scene_file: &Path) -> Result<String> {
    let [file_folder, from] = [absolute_folder(file)?, absolute_folder(scene_file)?];
    let name = file.file_name().map(PathBuf::from).unwrap_or_default();
    let shared = file_folder.components().zip(from.components()).take_while(|(a, b)| a == b).count();
    let up = from.components().skip(shared).map(|_| Component::ParentDir);
    let up = if from.components().count() == shared { vec![Component::CurDir] } else { up.collect() };
    let parts = up.into_iter().chain(file_folder.components().skip(shared)).chain(name.components());
    let place = Place::file(file);
    let part = |part: Component<'_>| part.as_os_str().to_str().map(str::to_owned);
    let parts: Option<Vec<String>> = parts.map(part).collect();
    let refuse = || {
        Error::invalid(
            &place,
            "its path is no text that a scene file could hold; rename the file or its folders",
        )
    };
    Ok(parts.ok_or_else(refuse)?.join("/"))
}

/// The folder of `file`, from the root and without links. Of it, only what is there can hold links.
fn absolute_folder(file: &Path) -> Result<PathBuf> {
    let there = file.ancestors().skip(1).find(|folder| folder.as_os_str().is_empty() || folder.exists());
    let there = there.unwrap_or(Path::new(""));
    let new = file.parent().and_then(|folder| folder.strip_prefix(there).ok()).unwrap_or(Path::new(""));
    let there = if there.as_os_str().is_empty() { Path::new(".") } else { there };
    Ok(there.canonicalize().map_err(|e| Error::io(&Place::file(there), e))?.join(new))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scenes_are_called_as_their_models() {
        for (file, name) in [
            ("chair.glb", "chair"),
            ("a/chair.v2.obj", "chair.v2"),
            ("vintage-chair/scene.gltf", "vintage-chair"),
            ("scene.gltf", "model"),
            ("scene/Scene.glb", "model"),
        ] {
            assert_eq!(name_of(Path::new(file)), name, "{file}");
        }
    }

    #[test]
    fn paths_lead_from_the_scene_to_the_model() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        for name in ["a/b", "a/c/d", "assets"] {
            std::fs::create_dir_all(at(name)).unwrap();
        }
        for (file, scene, expected) in [
            ("m.glb", "scene.toml", "./m.glb"),
            ("a/b/m.glb", "a/b/scene.toml", "./m.glb"),
            ("assets/m.glb", "scene.toml", "./assets/m.glb"),
            ("m.glb", "a/b/scene.toml", "../../m.glb"),
            ("a/b/m.glb", "a/c/d/scene.toml", "../../b/m.glb"),
            ("a/./b/../b/m.glb", "a/scene.toml", "./b/m.glb"),
            ("m.glb", "a/new/deep/scene.toml", "../../../m.glb"),
        ] {
            assert_eq!(relative(&at(file), &at(scene)).unwrap(), expected);
        }
    }
}
