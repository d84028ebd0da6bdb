//! Materials on the clipboard, as the lines that a state file has for them: they can be pasted on another
//! material, into a state file, or into a letter.

use super::editor::Editor;
use relume_formats::Place;
use relume_formats::name::plain;
use relume_formats::state::{MaterialState, State, parse_toml};

/// The selected material as text.
pub fn copied(editor: &Editor) -> Option<String> {
    let material = editor.selected()?;
    let leaves = MaterialState::from(editor.brdf(material));
    toml::to_string(&State { materials: [(material.name.clone(), leaves)].into(), ..State::default() }).ok()
}

/// Sets what `text` says: one material on the selected one, whatever the two are called; anything else as the
/// state that it is. Returns what was set.
///
/// # Errors
/// What is wrong with it, in a line. Then nothing has changed.
pub fn paste(text: &str, editor: &mut Editor) -> Result<String, String> {
    let place = Place::file("clipboard");
    let state: State = parse_toml(text, &place)
        .map_err(|_| "the clipboard holds no material and no state; Ctrl+C copies a material".to_owned())?;
    if state == State::default() {
        return Err("the clipboard is empty; Ctrl+C copies a material".to_owned());
    }
    let only = Some(&state.materials)
        .filter(|materials| materials.len() == 1)
        .and_then(|materials| materials.first_key_value());
    let rest = State { materials: Default::default(), ..state.clone() };
    match (only, editor.selected().cloned()) {
        (Some((name, leaves)), Some(selected)) if rest == State::default() => {
            selected.with(&editor.brdf(&selected), leaves, &place).map_err(|error| error.to_string())?;
            editor.edit(&selected.name, leaves);
            Ok(format!("pasted {} on {}", plain(name), plain(&selected.name)))
        }
        _ => {
            editor.take_state(&state, &place).map_err(|error| error.to_string())?;
            Ok("pasted a state".to_owned())
        }
    }
}
