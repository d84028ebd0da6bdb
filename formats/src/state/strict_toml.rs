//! TOML read strictly: one-line errors that name line, column and key in the file's own words, and suggest
//! what was meant.

mod hints;
mod lines;
mod reader;
mod unserved;

pub use lines::with_line;

use crate::error::{Error, Place, Result};
use crate::regular::read_regular;
use reader::{Fault, Reader};
use serde::de::DeserializeOwned;
use std::path::Path;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// A scene, state or animation has no reason to be larger.
const MAX_TEXT_BYTES: u64 = 16 << 20;

/// Reads a text file of bounded size, without the byte order mark that some editors put before it.
pub fn read_text(path: &Path) -> Result<String> {
    let place = Place::file(path);
    let bytes = read_regular(path, MAX_TEXT_BYTES, "a text file is expected here")?;
    if bytes.starts_with(&[0xff, 0xfe]) || bytes.starts_with(&[0xfe, 0xff]) || bytes.starts_with(&[b'[', 0]) {
        return Err(Error::invalid(&place, "not a text file of UTF-8, but of UTF-16; save it as UTF-8"));
    }
    let text =
        String::from_utf8(bytes).map_err(|e| not_utf8(e.as_bytes(), e.utf8_error().valid_up_to(), &place))?;
    Ok(text.strip_prefix('\u{feff}').map(str::to_owned).unwrap_or(text))
}

fn not_utf8(bytes: &[u8], at: usize, place: &Place) -> Error {
    let before = String::from_utf8_lossy(bytes.get(..at).unwrap_or_default());
    let byte = bytes.get(at).copied().unwrap_or_default();
    if before.contains('\0') || byte < 0x20 {
        return Error::invalid(place, format!("not a text file (byte {at} is not UTF-8)"));
    }
    let place = place.part(line_and_column(&before, before.len()));
    Error::invalid(
        &place,
        format!(
            "not a text file of UTF-8: byte 0x{byte:02X} belongs to another encoding, such as Latin-1; save it as UTF-8"
        ),
    )
}

/// Parses `text`; unknown keys are errors if the type denies them.
pub fn parse<T: DeserializeOwned>(text: &str, place: &Place) -> Result<T> {
    let root = document(text, place)?;
    T::deserialize(Reader::of_document(&root)).map_err(|fault| error(text, &fault, place))
}

/// The file as a tree of values, each with where it stands.
fn document<'t>(text: &'t str, place: &Place) -> Result<Spanned<DeValue<'t>>> {
    let root = DeTable::parse(text).map_err(|e| {
        let span = e.span().unwrap_or_default();
        let (at, reason) = hints::of_syntax(text, &span, e.message());
        Error::invalid(&place.part(line_and_column(text, at)), reason)
    })?;
    Ok(Spanned::new(root.span(), DeValue::Table(root.into_inner())))
}

fn error(text: &str, fault: &Fault, place: &Place) -> Error {
    let at = fault
        .span
        .as_ref()
        .map_or_else(|| place.clone(), |span| place.part(line_and_column(text, span.start)));
    Error::invalid(&at, fault.to_string())
}

fn line_and_column(text: &str, offset: usize) -> String {
    let before = text.get(..offset).unwrap_or(text);
    let line = before.matches('\n').count() + 1;
    let column = before.chars().rev().take_while(|c| *c != '\n').count() + 1;
    format!("line {line}, column {column}")
}

#[cfg(test)]
mod tests;
