//! TOML read strictly: one-line errors that name line and column and suggest what was meant.

use crate::error::{Error, Place, Result};
use crate::regular::read_regular;
use serde::de::DeserializeOwned;
use std::path::Path;

/// A scene, state or animation has no reason to be larger.
const MAX_TEXT_BYTES: u64 = 16 << 20;

/// Reads a text file of bounded size.
pub fn read_text(path: &Path) -> Result<String> {
    let place = Place::file(path);
    let bytes = read_regular(path, MAX_TEXT_BYTES, "a text file is expected here")?;
    String::from_utf8(bytes)
        .map_err(|e| Error::invalid(&place, format!("not a text file (byte {} is not UTF-8)", e.utf8_error().valid_up_to())))
}

/// Parses `text`; unknown keys are errors if the type denies them.
pub fn parse<T: DeserializeOwned>(text: &str, place: &Place) -> Result<T> {
    toml::from_str(text).map_err(|e| {
        let at = e.span().map_or_else(|| place.clone(), |span| place.part(line_and_column(text, span.start)));
        Error::invalid(&at, one_line(e.message()))
    })
}

fn line_and_column(text: &str, offset: usize) -> String {
    let before = text.get(..offset).unwrap_or(text);
    let line = before.matches('\n').count() + 1;
    let column = before.chars().rev().take_while(|c| *c != '\n').count() + 1;
    format!("line {line}, column {column}")
}

/// serde's message on one line, with a suggestion if it complains of an unknown name.
fn one_line(message: &str) -> String {
    let flat = message.split_whitespace().collect::<Vec<_>>().join(" ");
    if !flat.starts_with("unknown ") {
        return flat;
    }
    let mut quoted = flat.split('`').skip(1).step_by(2);
    let Some(given) = quoted.next() else { return flat };
    let nearest = quoted.map(|name| (strsim::damerau_levenshtein(given, name), name)).min();
    match nearest {
        Some((distance, name)) if distance <= 1 + given.len() / 3 => format!("{flat}; did you mean `{name}`?"),
        _ => flat,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::state::State;

    #[test]
    fn unknown_key_names_line_column_and_suggests() {
        let text = "[materials.bunny]\nkd = [0.1, 0.1, 0.1]\nshinines = 3.0\n";
        let message = parse::<State>(text, &Place::file("s.toml")).unwrap_err().to_string();
        assert!(message.starts_with("s.toml: line 3, column 1: unknown field `shinines`"), "{message}");
        assert!(message.ends_with("did you mean `shininess`?"), "{message}");
        assert!(!message.contains('\n'));
    }
}
