//! `animations/*.toml` beside the scene file.

use super::validate_varying;
use crate::scene::Scene;
use relume_formats::has_extension;
use relume_formats::kinds::manifest::is_plain_name;
use relume_formats::name;
use relume_formats::state::Animation;
use relume_formats::{Error, Place, Result};
use std::io;
use std::path::{Path, PathBuf};

/// Every animation, sorted by name, each checked against the scene.
pub(super) fn read_all(scene: &Scene, scene_folder: &Path) -> Result<Vec<Animation>> {
    let read = |path: PathBuf| {
        let animation = Animation::read_file(&path)?;
        check(&animation, scene, &Place::file(&path))?;
        Ok(animation)
    };
    files(&scene_folder.join("animations"))?.into_iter().map(read).collect()
}

fn files(folder: &Path) -> Result<Vec<PathBuf>> {
    if !folder.is_dir() {
        return Ok(Vec::new());
    }
    let fail = |e: io::Error| Error::io(&Place::file(folder), e);
    let entries: Vec<_> = std::fs::read_dir(folder).and_then(Iterator::collect).map_err(fail)?;
    let mut files: Vec<PathBuf> = entries.into_iter().map(|entry: std::fs::DirEntry| entry.path()).collect();
    // Names that begin with a point are those of editors and of other systems' leftovers.
    let is_hidden =
        |path: &Path| path.file_name().is_some_and(|name| name.as_encoded_bytes().starts_with(b"."));
    files.retain(|path| has_extension(path, "toml") && !is_hidden(path));
    files.sort();
    Ok(files)
}

/// Checks the name, of which a file name will be made, and the states at all keys.
fn check(animation: &Animation, scene: &Scene, place: &Place) -> Result<()> {
    if !is_plain_name(&animation.name) || name::fault(&animation.name).is_some() {
        let reason = format!(
            "the name of an animation has only a-z A-Z 0-9 . _ - and blanks, at most {}; rename the file",
            name::MAX_CHARS
        );
        return Err(Error::invalid(place, reason));
    }
    for time_s in animation.key_times_s() {
        if let Err(error) = check_at(animation, time_s, scene, place) {
            return Err(blamed(animation, time_s, scene, place).unwrap_or(error));
        }
    }
    Ok(())
}

/// Checks the state at `time_s`.
fn check_at(animation: &Animation, time_s: f32, scene: &Scene, place: &Place) -> Result<()> {
    let state = animation.sample(time_s).map_err(|e| Error::invalid(place, e))?;
    let place = place.part(format!("at {time_s} s"));
    validate_varying(&scene.vary, &scene.with_state(&state, &place)?.materials, &place)
}

/// The error of the state at `time_s`, told at the key that makes it illegal: before its first key a leaf has
/// that key's value already, and between two it is on its way to the second.
fn blamed(animation: &Animation, time_s: f32, scene: &Scene, place: &Place) -> Option<Error> {
    let first = |count: usize| Animation { tracks: animation.tracks[..count].to_vec(), ..animation.clone() };
    // Without any leaf the state is the scene's own, which is legal; with all it is not.
    let (mut legal, mut illegal) = (0, animation.tracks.len());
    while illegal - legal > 1 {
        let middle = legal.midpoint(illegal);
        *(if check_at(&first(middle), time_s, scene, place).is_ok() { &mut legal } else { &mut illegal }) =
            middle;
    }
    let times_s = &animation.tracks.get(legal)?.times_s;
    let after = times_s.partition_point(|t| *t <= time_s);
    let around = times_s.get(after.saturating_sub(1)..(after + 1).min(times_s.len()))?;
    around.iter().find_map(|t| check_at(animation, *t, scene, place).err())
}
