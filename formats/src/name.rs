//! Names of objects, materials, lights, clips, maps and animations come from other people's files and reach
//! file names, terminals and windows. What a name may be, how any text is printed so that it shows and does
//! nothing, and what files are called after names stands here and nowhere else.

use crate::error::{Error, Place, Result};
use crate::kinds::manifest::is_plain_name;
use std::borrow::Cow;

/// Longest name that somebody gives, characters.
pub const MAX_CHARS: usize = 128;
/// Longest name that is made of two, or of one and a number, characters. Readers take no longer ones.
pub const MAX_MADE_CHARS: usize = 2 * MAX_CHARS + 16;
/// Longest message, characters.
const MAX_LINE_CHARS: usize = 2000;
/// How much of a name that is too long messages show, characters.
const SHOWN_CHARS: usize = 40;

/// Fails unless `name` may be a name: 1 to [`MAX_CHARS`] characters, none of which moves a cursor, breaks a
/// line or turns the direction of text. `what` says whose name it is: "object", "material"; `place` is where
/// it stands.
///
/// # Errors
/// `Invalid`, with no more of the name than fits a line.
pub fn validate(what: &str, name: &str, place: &Place) -> Result<()> {
    refuse(what, name, fault(name), place)
}

/// As [`validate`], for a name that may have been made of two: `<object>/<material>`.
///
/// # Errors
/// As there.
pub fn validate_made(what: &str, name: &str, place: &Place) -> Result<()> {
    refuse(what, name, fault_above(name, MAX_MADE_CHARS), place)
}

fn refuse(what: &str, name: &str, fault: Option<String>, place: &Place) -> Result<()> {
    fault.map_or(Ok(()), |fault| Err(Error::invalid(place, format!("{what} `{}`: {fault}", shortened(name)))))
}

/// What is wrong with `name` as a name that somebody gives, and the remedy; `None` if it may be one.
pub fn fault(name: &str) -> Option<String> {
    fault_above(name, MAX_CHARS)
}

fn fault_above(name: &str, most: usize) -> Option<String> {
    if name.is_empty() {
        return Some(format!("its name is empty; give it one of 1 to {most} characters"));
    }
    // A byte more than the longest name can have ends the count: names may be as long as files.
    let is_long = name.len() > 4 * most || name.chars().count() > most;
    if is_long {
        return Some(format!("its name is longer than {most} characters; shorten it"));
    }
    let steering = name.chars().find(|c| steers(*c))?;
    Some(format!("its name has the control character {}; remove it", steering.escape_unicode()))
}

/// The beginning of a name that may be of any length.
pub fn shortened(name: &str) -> String {
    match name.char_indices().nth(SHOWN_CHARS) {
        Some((end, _)) => format!("{}…", &name[..end]),
        None => name.to_owned(),
    }
}

/// `text` as it may be printed: what would steer a terminal, break the line or not be seen stands there as an
/// escape such as `\u{1b}`.
pub fn plain(text: &str) -> Cow<'_, str> {
    if !text.chars().any(|c| steers(c) || is_invisible(c)) {
        return Cow::Borrowed(text);
    }
    let mut shown = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '\n' | '\r' | '\t' => shown.extend(c.escape_default()),
            c if steers(c) || is_invisible(c) => shown.extend(c.escape_unicode()),
            c => shown.push(c),
        }
    }
    Cow::Owned(shown)
}

/// A message of whatever length as one [`plain`] line; of one that nobody would read whole, the beginning and
/// the remedy at its end.
pub fn one_line(message: &str) -> String {
    let line = message.split_whitespace().collect::<Vec<_>>().join(" ");
    let line = plain(&line);
    let count = line.chars().count();
    if count <= MAX_LINE_CHARS {
        return line.into_owned();
    }
    let beginning = line.chars().take(MAX_LINE_CHARS * 3 / 4);
    let end = line.chars().skip(count - MAX_LINE_CHARS / 4);
    beginning.chain(" … ".chars()).chain(end).collect()
}

/// As [`plain`], for text of many lines that may hold JSON: breaks between lines stay, and escapes are those
/// of JSON, `\u001b`.
pub fn plain_lines(text: &str) -> Cow<'_, str> {
    let is_plain = |c: char| c == '\n' || !(steers(c) || is_invisible(c));
    if text.chars().all(is_plain) {
        return Cow::Borrowed(text);
    }
    let mut shown = String::with_capacity(text.len());
    for c in text.chars() {
        if is_plain(c) {
            shown.push(c);
        } else {
            c.encode_utf16(&mut [0; 2]).iter().for_each(|unit| shown.push_str(&format!("\\u{unit:04x}")));
        }
    }
    Cow::Owned(shown)
}

/// What the file of the `kind` of thing that belongs to `owner` is called: `shape-knot.relume`. Whatever the
/// owner is called, it is a plain file name: where the owner's is none, other characters become `_` and a
/// hash of all of them keeps two files apart.
pub fn file_of(kind: &str, owner: &str, extension: &str) -> String {
    let file = format!("{kind}-{owner}.{extension}");
    if is_plain_name(&file) {
        return file;
    }
    let plain = |c: char| if c.is_ascii_alphanumeric() || "._-".contains(c) { c } else { '_' };
    let start: String = owner.chars().take(SHOWN_CHARS).map(plain).collect();
    format!("{kind}-{start}-{:016x}.{extension}", xxhash_rust::xxh3::xxh3_64(owner.as_bytes()))
}

/// Control characters, breaks of lines, and what turns the direction of text.
pub(crate) fn steers(c: char) -> bool {
    c.is_control()
        || matches!(c, '\u{61c}' | '\u{200e}' | '\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2066}'..='\u{2069}')
}

/// Whether `c` shows where it stands and does nothing else; what does not is escaped by [`plain`], and left
/// out of names that other programs give.
pub fn shows(c: char) -> bool {
    !(steers(c) || is_invisible(c))
}

/// What takes no room, so that two names look the same.
fn is_invisible(c: char) -> bool {
    matches!(
        c,
        '\u{ad}' | '\u{180e}' | '\u{200b}'..='\u{200d}' | '\u{2060}'..='\u{2065}' | '\u{206a}'..='\u{206f}' | '\u{feff}' | '\u{fff9}'..='\u{fffb}' | '\u{e0000}'..='\u{e007f}'
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    const HOSTILE: [&str; 8] =
        ["a\nb", "\u{1b}[2J", "\u{9b}31m", "a\u{202e}b", "\u{2066}x", "a\u{2028}b", "bell\u{7}", "nul\0"];

    #[test]
    fn names_that_steer_or_never_end_are_refused() {
        let place = Place::file("scene.toml");
        for name in HOSTILE {
            let message = validate("object", name, &place).unwrap_err().to_string();
            assert!(
                message.starts_with("scene.toml: object `") && message.contains("control character \\u{"),
                "{message}"
            );
            assert_eq!(plain(&message), message, "the message itself is plain");
        }
        for name in [
            "bunny",
            "Möbel/Stuhl 3",
            "椅子",
            "👩\u{200d}🚀",
            "../x",
            &"x".repeat(MAX_CHARS),
            &"椅".repeat(MAX_CHARS),
        ] {
            validate("object", name, &place).unwrap();
        }
        let long = validate("light", &"y".repeat(300_000), &place).unwrap_err().to_string();
        assert_eq!(
            long,
            format!(
                "scene.toml: light `{}…`: its name is longer than 128 characters; shorten it",
                "y".repeat(40)
            )
        );
        let longer = "x".repeat(MAX_CHARS + 1);
        assert!(fault(&longer).is_some());
        let two = format!("{}/{}-2", &longer[1..], &longer[1..]);
        validate_made("object", &two, &place).unwrap();
        assert!(validate_made("object", &format!("{two}{longer}"), &place).is_err());
        assert!(fault("").unwrap().contains("empty"));
    }

    #[test]
    fn text_is_printed_so_that_it_does_nothing() {
        for text in HOSTILE {
            assert!(!plain(text).chars().any(steers), "{text:?}");
            assert!(!plain_lines(text).chars().any(|c| c != '\n' && steers(c)), "{text:?}");
        }
        assert_eq!(
            plain("tab\tline\nescape \u{1b}[2J bidi \u{202e} none\u{200b}"),
            r"tab\tline\nescape \u{1b}[2J bidi \u{202e} none\u{200b}"
        );
        assert_eq!(plain("Möbel 椅子"), "Möbel 椅子");
        assert_eq!(one_line("a\n  b\u{1b}c"), r"a b\u{1b}c");
        let long = one_line(&format!("scene.toml: unknown key `{}`; remove it", "k".repeat(1_000_000)));
        assert!(
            long.chars().count() <= 2003
                && long.starts_with("scene.toml: unknown key `kkk")
                && long.ends_with("kkk`; remove it")
        );
        assert_eq!(plain_lines("{\"a\":\n\"\u{9b}\u{e0041}\"}"), "{\"a\":\n\"\\u009b\\udb40\\udc41\"}");
        let json: serde_json::Value = serde_json::from_str(&plain_lines("\"\u{9b}\u{e0041}x\"")).unwrap();
        assert_eq!(json, "\u{9b}\u{e0041}x", "JSON means what it meant");
    }

    #[test]
    fn files_are_called_plainly_whatever_their_owner_is_called() {
        assert_eq!(file_of("shape", "torus knot.2", "relume"), "shape-torus knot.2.relume");
        let long = "x".repeat(300_000);
        let mut seen = std::collections::BTreeSet::new();
        for owner in ["../../etc/x", "..", "a/b", "a\\b", "a\nb", "é", "è", "🦊", "", &long, &long[1..]] {
            let file = file_of("shape", owner, "relume");
            assert!(is_plain_name(&file) && !file.contains(['/', '\\']), "{file}");
            assert!(seen.insert(file.clone()), "{file} twice");
        }
    }
}
