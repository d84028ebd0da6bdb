//! Where scenes and their files are found.

use crate::starter::is_model;
use relume_formats::near::{nearest_file, what_there_is};
use relume_formats::{Error, Place, Result, has_extension, read_regular};
use std::io;
use std::path::{Component, Path, PathBuf};

/// Name of the file that makes a folder a scene.
const SCENE_FILE: &str = "scene.toml";
/// Where the library lies in the workspace.
const LIBRARY: &str = "scenes/library";
/// Where `make install` puts it, from the prefix.
const SHARE: &str = "share/relume";

/// Turns what a user typed into the path of a scene file: an existing `.toml` file, a folder that holds a
/// `scene.toml`, or the name of a scene in the library.
///
/// # Errors
/// `Io` (not found) for a path that leads nowhere, `Invalid` with the nearest name for a name that the
/// library lacks.
pub fn resolve(name_or_path: &str) -> Result<PathBuf> {
    resolve_in(name_or_path, &library_folder())
}

fn resolve_in(name_or_path: &str, library: &Path) -> Result<PathBuf> {
    let path = Path::new(name_or_path);
    if path.is_file() && has_extension(path, "toml") {
        return Ok(path.to_path_buf());
    }
    if path.join(SCENE_FILE).is_file() {
        return Ok(path.join(SCENE_FILE));
    }
    if is_model(path) && path.is_file() {
        let reason = format!(
            "is a model, not a scene; `bake new {} -o DIR` writes a first scene for it",
            path.display()
        );
        return Err(Error::invalid(&Place::file(path), reason));
    }
    if path.components().count() != 1 || has_extension(path, "toml") {
        let meant = nearest_file(Path::new(""), path)
            .map(|file| format!("did you mean `{file}`? Else "))
            .unwrap_or_default();
        let reason = format!(
            "no scene file here; {meant}give a .toml file, a folder with a {SCENE_FILE}, or a name in {LIBRARY}"
        );
        return Err(Error::io(&Place::file(path), io::Error::new(io::ErrorKind::NotFound, reason)));
    }
    let in_library = library.join(path).join(SCENE_FILE);
    if in_library.is_file() {
        return Ok(in_library);
    }
    if let Some(meant) = nearest_file(Path::new(""), path).filter(|meant| is_scene(Path::new(meant))) {
        return Err(Error::invalid(&Place::file(path), format!("no such scene; did you mean `{meant}`?")));
    }
    let names = library_names(library)?;
    Err(Error::invalid(
        &Place::file(path),
        format!(
            "no such scene{}",
            what_there_is(name_or_path, &names.iter().map(String::as_str).collect::<Vec<_>>())
        ),
    ))
}

fn is_scene(path: &Path) -> bool {
    has_extension(path, "toml") || path.join(SCENE_FILE).is_file()
}

/// Names of all scenes in the library, sorted.
///
/// # Errors
/// If there is no library.
pub fn library() -> Result<Vec<String>> {
    library_names(&library_folder())
}

fn library_names(library: &Path) -> Result<Vec<String>> {
    let folders = std::fs::read_dir(library).map_err(|e| Error::io(&Place::file(library), e))?;
    let scenes = folders.filter_map(io::Result::ok).filter(|folder| folder.path().join(SCENE_FILE).is_file());
    let mut names: Vec<String> =
        scenes.map(|folder| folder.file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    Ok(names)
}

/// `scenes/library` in the current folder or above it, else where the program is installed, else the one that
/// the program was built from.
fn library_folder() -> PathBuf {
    let here = std::env::current_dir().unwrap_or_default();
    let program = std::env::current_exe().and_then(|program| program.canonicalize()).unwrap_or_default();
    let found = library_above(&here).or_else(|| library_of(&program));
    found.unwrap_or_else(|| Path::new(env!("CARGO_MANIFEST_DIR")).join("library"))
}

fn library_above(folder: &Path) -> Option<PathBuf> {
    folder.ancestors().map(|folder| folder.join(LIBRARY)).find(|folder| folder.is_dir())
}

/// The library of an installed program: above it, as in a workspace that was moved, or in `share/relume`
/// beside its `bin`.
fn library_of(program: &Path) -> Option<PathBuf> {
    let folder = program.parent()?;
    let shared =
        folder.parent().map(|prefix| prefix.join(SHARE).join(LIBRARY)).filter(|folder| folder.is_dir());
    shared.or_else(|| library_above(folder))
}

/// The folder above `scenes/library` if the scene in `folder` lies there.
fn workspace_root(folder: &Path) -> Option<PathBuf> {
    let folder = folder.canonicalize().ok()?;
    let library = folder.parent()?;
    library.ends_with(LIBRARY).then(|| library.ancestors().nth(2).map(Path::to_path_buf))?
}

/// The path that `name` stands for in a scene file in `folder`: relative to the folder, but `assets/…` of a
/// library scene is relative to the workspace, and of any other scene to the folder or else to the current
/// directory.
pub(crate) fn locate(folder: &Path, name: &str) -> PathBuf {
    let whole = folder.join(name);
    let beside = Some(tidy(&whole)).filter(|short| short.exists()).unwrap_or(whole);
    if !name.starts_with("assets/") {
        return beside;
    }
    match workspace_root(folder) {
        Some(root) => root.join(name),
        None if beside.exists() => beside,
        None => PathBuf::from(name),
    }
}

/// `path` without folders that it only enters to leave again, as messages name it. Links are not left so: what
/// is above them is not what is above the folder that they lead to.
fn tidy(path: &Path) -> PathBuf {
    let mut short = PathBuf::new();
    for part in path.components() {
        let is_name = matches!(short.components().next_back(), Some(Component::Normal(_)));
        if part == Component::ParentDir && is_name && !short.is_symlink() {
            short.pop();
        } else if part != Component::CurDir {
            short.push(part);
        }
    }
    short
}

/// Fails with a remedy if there is no file at `path`, which `name` stands for. `place` is where it was named.
pub(crate) fn expect_file(path: &Path, name: &str, place: &Place) -> Result<()> {
    if path.is_file() {
        return Ok(());
    }
    if path.exists() {
        let what = if path.is_dir() { "a folder; name a file in it" } else { "not a regular file; name one" };
        return Err(Error::invalid(place, format!("`{name}` is {what}")));
    }
    let folder = path.ancestors().nth(Path::new(name).components().count()).unwrap_or(Path::new(""));
    let remedy = match nearest_file(folder, Path::new(name)) {
        _ if name.starts_with("assets/") => "run `make assets` to fetch it".to_owned(),
        Some(meant) => format!("did you mean `{meant}`?"),
        None => "correct the path or add the file".to_owned(),
    };
    Err(Error::io(
        place,
        io::Error::new(io::ErrorKind::NotFound, format!("no such file: `{name}`; {remedy}")),
    ))
}

/// Largest file of a scene that is read whole.
const MAX_FILE_BYTES: u64 = 1 << 30;

/// Reads a file of bounded size.
pub(crate) fn read_bytes(path: &Path) -> Result<Vec<u8>> {
    read_regular(path, MAX_FILE_BYTES, "split or simplify it")
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    fn library() -> tempfile::TempDir {
        let root = tempfile::tempdir().unwrap();
        for name in ["bunny-room", "cornell-knot"] {
            fs::create_dir_all(root.path().join("scenes/library").join(name)).unwrap();
            fs::write(root.path().join("scenes/library").join(name).join(SCENE_FILE), "").unwrap();
        }
        fs::create_dir(root.path().join("scenes/library/empty")).unwrap();
        root
    }

    #[test]
    fn paths_are_told_without_detours_but_links_are_followed() {
        let root = tempfile::tempdir().unwrap();
        let at = |name: &str| root.path().join(name);
        fs::create_dir_all(at("baked/deep")).unwrap();
        fs::write(at("chair.glb"), "").unwrap();
        fs::write(at("baked/chair.glb"), "").unwrap();
        assert_eq!(locate(&at("baked"), "../chair.glb"), at("chair.glb"));
        assert_eq!(locate(&at("baked/deep"), ".././../chair.glb"), at("chair.glb"));
        assert_eq!(locate(&at("baked"), "./chair.glb"), at("baked/chair.glb"));
        assert_eq!(locate(&at("not-yet/there"), "../../chair.glb"), at("chair.glb"));
        assert_eq!(locate(&at("baked"), "../no.glb"), at("baked/../no.glb"), "as it was written");
        assert_eq!(locate(Path::new(""), "../chair.glb"), Path::new("../chair.glb"));
        #[cfg(unix)]
        {
            std::os::unix::fs::symlink(at("baked/deep"), at("link")).unwrap();
            assert_eq!(
                locate(&at("link"), "../chair.glb"),
                at("link/../chair.glb"),
                "that is baked/chair.glb"
            );
        }
    }

    #[test]
    fn files_folders_and_names_resolve() {
        let root = library();
        let library = root.path().join("scenes/library");
        let file = library.join("bunny-room/scene.toml");
        assert_eq!(resolve_in("bunny-room", &library).unwrap(), file);
        assert_eq!(resolve_in(file.to_str().unwrap(), &library).unwrap(), file);
        assert_eq!(resolve_in(library.join("bunny-room").to_str().unwrap(), &library).unwrap(), file);
    }

    #[test]
    fn unknown_names_list_the_library_and_suggest() {
        let root = library();
        let message = resolve_in("buny-room", &root.path().join("scenes/library")).unwrap_err().to_string();
        assert!(
            message.ends_with(
                "no such scene; did you mean `bunny-room`? There are: `bunny-room`, `cornell-knot`"
            ),
            "{message}"
        );
        let error = resolve_in("nowhere/scene.toml", root.path()).unwrap_err();
        assert!(
            error.is_bad_input() && error.to_string().starts_with("nowhere/scene.toml: no scene file here"),
            "{error}"
        );
    }

    #[test]
    fn the_library_of_the_build_is_found() {
        assert!(resolve("cornell-knot").unwrap().ends_with("scenes/library/cornell-knot/scene.toml"));
    }

    #[test]
    fn an_installed_program_finds_its_library() {
        let root = tempfile::tempdir().unwrap();
        let at = |name: &str| root.path().join(name);
        for folder in [
            "usr/bin",
            "usr/share/relume/scenes/library",
            "work/target/release",
            "work/scenes/library",
            "alone",
        ] {
            fs::create_dir_all(at(folder)).unwrap();
        }
        assert_eq!(library_of(&at("usr/bin/bake")), Some(at("usr/share/relume/scenes/library")));
        assert_eq!(library_of(&at("work/target/release/bake")), Some(at("work/scenes/library")));
        assert_eq!(library_of(&at("alone/bake")), None);
    }

    #[test]
    fn assets_are_found_from_the_workspace_or_the_scene() {
        let root = library();
        let scene = root.path().join("scenes/library/bunny-room");
        assert_eq!(locate(&scene, "mesh.obj"), scene.join("mesh.obj"));
        assert_eq!(
            locate(&scene, "assets/mesh.obj"),
            root.path().canonicalize().unwrap().join("assets/mesh.obj")
        );
        // Outside the library: beside the scene if it is there, else from the current directory.
        let outside = root.path().join("elsewhere");
        fs::create_dir_all(outside.join("assets")).unwrap();
        assert_eq!(locate(&outside, "assets/mesh.obj"), Path::new("assets/mesh.obj"));
        fs::write(outside.join("assets/mesh.obj"), "").unwrap();
        assert_eq!(locate(&outside, "assets/mesh.obj"), outside.join("assets/mesh.obj"));
    }
}
