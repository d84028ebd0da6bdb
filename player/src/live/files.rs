//! Files that the user gives while a bundle is shown.

use super::{Live, Order, write_state};
use crate::environment::beside;
use crate::picture::nothing_yet;
use crate::ui::{Editor, Kept, Note};
use relume_formats::map_file::is_named_so;
use relume_formats::name::plain;
use relume_formats::state::{Animation, State, TrackValues, with_line};
use relume_formats::{Error as FormatError, Place, has_extension, read_regular};
use std::path::{Path, PathBuf};

/// Longest text that is read.
const MAX_TEXT_BYTES: u64 = 1 << 24;

impl Live {
    /// Takes a file for what its name and content say that it is: an environment map, which is added and
    /// lights the scene; a state, which is set as one edit; an animation, which is played. Returns what to
    /// say.
    ///
    /// # Errors
    /// What is wrong with it, in a line. Then nothing has changed.
    pub fn take_file(&mut self, path: &Path) -> Result<String, String> {
        let shown = path.display();
        if is_named_so(path) {
            let lit = self.shown.is_some() && self.send(Order::Light(path.to_owned()));
            return if lit {
                Ok(format!("reading {shown}"))
            } else {
                Err("there is nothing to light yet; wait for the first picture".to_owned())
            };
        }
        if !has_extension(path, "toml") {
            return Err(format!(
                "{shown}: give a bundle (its folder or manifest.json), a state or an animation (.toml), or an environment map (.exr, .hdr)"
            ));
        }
        let Some(shown) = &mut self.shown else { return Err(nothing_yet().to_string()) };
        match take_text(path, &mut shown.editor).map_err(|error| with_line(error).to_string())? {
            Taken::Whole(said) => Ok(said),
            Taken::Map(said, map) => {
                self.send(Order::Light(map));
                Ok(said)
            }
            Taken::Waits(animation, place, maps) => {
                let said = format!("reading the maps of {}", place.file.display());
                self.waiting.push_back((animation, place));
                self.send(Order::Maps(maps));
                Ok(said)
            }
        }
    }

    /// Sets what was set on another bake of the bundle, as far as it fits; if some of it does not, and is in no
    /// file yet, writes all of it into `folder`. Returns what to say.
    pub fn keep(&mut self, mut kept: Kept, folder: &Path) -> Note {
        let Some(shown) = &mut self.shown else { return Err(nothing_yet().to_string()) };
        let said = format!("{} as it was baked last", plain(&shown.editor.scene().name));
        let whole = (!kept.is_saved).then(|| kept.state.clone());
        // A map that cannot be read stays in the state, and does not fit.
        let map = map_from_outside(&mut kept.state, &shown.editor, &Place::file("edit")).unwrap_or_default();
        let lost = shown.editor.keep(kept);
        let scene = shown.editor.scene().name.clone();
        if let Some(map) = map {
            self.send(Order::Light(map));
        }
        if lost.is_empty() {
            return Ok(said);
        }
        let saved = whole.map(|state| match write_state(folder, &scene, &state) {
            Ok(path) => format!("; all is saved in {}", path.display()),
            Err(error) => format!("; {error}"),
        });
        // The names come first: a line shows no more than its beginning.
        Err(format!("no longer fits: {}{}", lost.join(", "), saved.unwrap_or_default()))
    }
}

/// The file of the map that `state`, which comes from `place`, names and the bundle does not have. It is taken
/// out of the state, for it lights the scene once it is added.
fn map_from_outside(
    state: &mut State,
    editor: &Editor,
    place: &Place,
) -> Result<Option<PathBuf>, FormatError> {
    let Some(light) = state.environment.as_mut().filter(|_| editor.scope().varies().environment) else {
        return Ok(None);
    };
    let Some(map) = light.map.as_ref().filter(|map| !editor.scope().maps.contains(map)) else {
        return Ok(None);
    };
    let Some(found) = beside(map, place)? else { return Ok(None) };
    light.map = None;
    Ok(Some(PathBuf::from(found.name)))
}

/// What became of a text.
enum Taken {
    /// All of it is set.
    Whole(String),
    /// All of it is set but the map in this file.
    Map(String, PathBuf),
    /// An animation, from this place, that names the maps in these files.
    Waits(Animation, Place, Vec<PathBuf>),
}

/// What to say of an animation from `place`.
pub(super) fn playing(place: &Place) -> String {
    format!("playing {}", place.file.display())
}

fn take_text(path: &Path, editor: &mut Editor) -> Result<Taken, FormatError> {
    let (place, shown) = (Place::file(path), path.display());
    let text =
        String::from_utf8_lossy(&read_regular(path, MAX_TEXT_BYTES, "give a smaller file")?).into_owned();
    // What is wrong with it is for the reader of one or the other to say.
    let is_animation = text
        .parse::<toml::Table>()
        .is_ok_and(|table| table.contains_key("key") || table.contains_key("duration_s"));
    if is_animation {
        let mut animation = Animation::read_file(path)?;
        let maps = maps_of_animation(&mut animation, editor, &place)?;
        if maps.is_empty() {
            editor.take_animation(animation, &place)?;
            return Ok(Taken::Whole(playing(&place)));
        }
        return Ok(Taken::Waits(animation, place, maps));
    }
    let mut state = State::read_file(path)?;
    let file = map_from_outside(&mut state, editor, &place)?;
    editor.take_state(&state, &place)?;
    let said = format!("set {shown}");
    Ok(match file {
        Some(map) => Taken::Map(said, map),
        None => Taken::Whole(said),
    })
}

/// The files of the maps that `animation`, which comes from `place`, names and the bundle does not have. It
/// calls them by their own names from then on.
fn maps_of_animation(
    animation: &mut Animation,
    editor: &Editor,
    place: &Place,
) -> Result<Vec<PathBuf>, FormatError> {
    let mut files = Vec::new();
    let varies = editor.scope().varies().environment;
    for track in animation.tracks.iter_mut().filter(|track| varies && track.leaf == ["environment", "map"]) {
        let TrackValues::Name(names) = &mut track.values else { continue };
        for name in names.iter_mut().filter(|name| !editor.scope().maps.contains(name)) {
            if let Some(found) = beside(name, place)? {
                files.push(PathBuf::from(&found.name));
                *name = found.name;
            }
        }
    }
    files.sort();
    files.dedup();
    Ok(files)
}
