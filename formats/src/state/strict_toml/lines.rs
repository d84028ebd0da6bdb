//! The line of a file that a message speaks of.
//!
//! What a scene, state or animation says is checked long after its text was parsed, by code that knows names
//! and keys but no lines. A message names them too, so the line is found again when there is something to
//! complain of, and not before.

use super::{document, line_and_column, read_text};
use crate::error::{Error, Place};
use crate::name::{plain, shortened};
use std::path::Path;
use toml::Spanned;
use toml::de::DeValue;

/// Longest file in which lines are sought.
const MAX_BYTES: usize = 1 << 20;

/// `error` with the line of the TOML file it names, if it tells none yet and speaks of a key or name in it.
pub fn with_line(error: Error) -> Error {
    let located = |place: Place, reason: &str| {
        line_of(&place, reason).map_or_else(|| place.clone(), |line| at_line(&place, &line))
    };
    match error {
        Error::Invalid { place, reason } => Error::Invalid { place: located(place, &reason), reason },
        Error::Unsupported { place, reason } => Error::Unsupported { place: located(place, &reason), reason },
        Error::Io { place, source } => Error::Io { place: located(place, &source.to_string()), source },
        other @ Error::Output { .. } => other,
    }
}

fn at_line(place: &Place, line: &str) -> Place {
    place.part(place.part.as_ref().map_or_else(|| line.to_owned(), |part| format!("{line}: {part}")))
}

fn line_of(place: &Place, reason: &str) -> Option<String> {
    let known = place.part.as_ref().is_some_and(|part| part.starts_with("line "));
    // What is no plain file cannot be read twice.
    if known || !is_toml(&place.file) || !place.file.is_file() {
        return None;
    }
    let text = read_text(&place.file).ok().filter(|text| text.len() <= MAX_BYTES)?;
    let root = document(&text, place).ok()?;
    // What there is instead is no part of what is wrong.
    let wrong = ["; did you mean ", "; there are: ", "; this bundle has: "]
        .iter()
        .fold(reason, |wrong, end| wrong.split(end).next().unwrap_or(wrong));
    let message = format!("{}: {wrong}", place.part.as_deref().unwrap_or_default());
    let at = offset_of(&root, &message)?;
    line_and_column(&text, at).split(',').next().map(str::to_owned)
}

fn is_toml(path: &Path) -> bool {
    path.extension().is_some_and(|extension| extension == "toml")
}

/// The deepest key that `message` speaks of together with all tables around it, a quoted one before others;
/// else one whose value it quotes.
fn offset_of(root: &Spanned<DeValue<'_>>, message: &str) -> Option<usize> {
    let mut found = Found { message, by_value: false, best: None };
    found.seek(root, 0);
    if found.best.is_none() {
        found.by_value = true;
        found.seek(root, 0);
    }
    found.best.map(|(_, at)| at)
}

struct Found<'m> {
    message: &'m str,
    /// Whether tables count that the message does not speak of, for the sake of the values in them.
    by_value: bool,
    /// How well it fits, and where it is.
    best: Option<(usize, usize)>,
}

impl Found<'_> {
    /// Looks into `value`, which lies `depth` keys deep.
    fn seek(&mut self, value: &Spanned<DeValue<'_>>, depth: usize) {
        let DeValue::Table(table) = value.get_ref() else { return };
        for (key, value) in table.iter() {
            let (name, at) = (key.get_ref().as_ref(), key.span().start);
            let spoken = self.speaks_of(name) && !self.by_value;
            let members = value
                .get_ref()
                .as_array()
                .filter(|list| list.iter().all(|member| member.get_ref().is_table()));
            match members {
                Some(members) if spoken || name == "key" || self.by_value => {
                    for (index, member) in members.iter().enumerate() {
                        if self.by_value {
                            self.seek(member, depth + 2);
                        } else if self.names(index, member.get_ref()) {
                            // Quoted, as against a word that may be the key of something else.
                            self.note(member.span().start, 2 * depth + 5);
                            self.seek(member, depth + 2);
                        }
                    }
                }
                None if spoken || self.by_value || self.quotes_value(name, value.get_ref()) => {
                    let quoted = self.quotes(name)
                        || self.quotes_value(name, value.get_ref())
                        || self.quotes_one_of(value.get_ref());
                    if !self.by_value || self.quotes_value(name, value.get_ref()) {
                        self.note(at, 2 * depth + 2 + usize::from(quoted));
                    }
                    self.seek(value, depth + 1);
                }
                // A list that the message speaks of is named by its key.
                None if self.quotes_one_of(value.get_ref()) => self.note(at, 2 * depth + 3),
                _ => {}
            }
        }
    }

    /// Remembers the best so far, the first in the file of equals: tables are walked by name.
    fn note(&mut self, at: usize, fit: usize) {
        if self.best.is_none_or(|(best, first)| fit > best || (fit == best && at < first)) {
            self.best = Some((fit, at));
        }
    }

    /// Whether the message names member number `index` of a list: by its name or, in an animation, by its
    /// number or time.
    fn names(&self, index: usize, member: &DeValue<'_>) -> bool {
        let time_s = || match member.get("t_s").map(Spanned::get_ref) {
            Some(DeValue::Float(t)) => t.as_str().parse::<f32>().ok(),
            Some(DeValue::Integer(t)) => t.as_str().parse::<f32>().ok(),
            _ => None,
        };
        match member.get("name").and_then(|name| name.get_ref().as_str()) {
            Some(name) => self.quotes(name),
            None if self.message.contains("[[key]] number") => {
                self.message.contains(&format!("[[key]] number {} ", index + 1))
            }
            None => time_s().is_some_and(|t| self.message.contains(&format!("at {t} s"))),
        }
    }

    /// Whether the message quotes the value of `key`. By its name a member of a list was found already.
    fn quotes_value(&self, key: &str, value: &DeValue<'_>) -> bool {
        key != "name" && value.as_str().is_some_and(|text| self.quotes(text))
    }

    /// Whether the message quotes a text of a list.
    fn quotes_one_of(&self, value: &DeValue<'_>) -> bool {
        let texts = value.as_array().into_iter().flat_map(|list| list.iter());
        texts.filter_map(|text| text.get_ref().as_str()).any(|text| self.quotes(text))
    }

    /// Of a long name some messages show the beginning, and of what steers terminals an escape.
    fn quotes(&self, name: &str) -> bool {
        let short = shortened(name);
        [name, &plain(name), &plain(&short)].iter().any(|shown| self.message.contains(&format!("`{shown}`")))
    }

    /// Whether `key` is a word of the message, in the singular or plural too; a name of one letter must be
    /// quoted, for it may be an article.
    fn speaks_of(&self, key: &str) -> bool {
        let singular = key.strip_suffix('s').filter(|word| word.len() > 2).map(str::to_owned);
        let forms = [Some(key.to_owned()), singular, Some(format!("{key}s"))];
        forms.iter().flatten().any(|word| if key.len() < 2 { self.quotes(key) } else { self.has_word(word) })
    }

    fn has_word(&self, word: &str) -> bool {
        let ends = |c: Option<char>| c.is_none_or(|c| !(c.is_alphanumeric() || c == '_'));
        self.message.match_indices(word).any(|(at, _)| {
            let (before, after) = (
                self.message.get(..at).unwrap_or_default(),
                self.message.get(at + word.len()..).unwrap_or_default(),
            );
            ends(before.chars().next_back()) && ends(after.chars().next())
        })
    }
}
