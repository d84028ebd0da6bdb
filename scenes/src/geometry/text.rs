//! Text as programs of all systems write it: byte order marks, line ends, comments, numbers. Bytes that are
//! not ASCII stand in names and comments only, so that nothing here asks for UTF-8.

use relume_formats::{Error, Place, Result};

/// `bytes` without the mark that some programs put before UTF-8.
///
/// # Errors
/// `Unsupported` for text of two bytes a letter, with or without a mark.
pub(super) fn unmarked<'a>(bytes: &'a [u8], place: &Place) -> Result<&'a [u8]> {
    match bytes {
        [0xFF, 0xFE, ..] | [0xFE, 0xFF, ..] | [0, b'!'..=b'~', ..] | [b'!'..=b'~', 0, ..] => {
            Err(Error::unsupported(place, "UTF-16 text; save it as ASCII or UTF-8"))
        }
        _ => Ok(bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(bytes)),
    }
}

/// Lines that end in LF, CR LF or CR, numbered from 1.
#[derive(Clone)]
pub(super) struct Lines<'a> {
    /// What has not been read.
    pub rest: &'a [u8],
    number: usize,
}

impl<'a> Lines<'a> {
    pub fn new(text: &'a [u8]) -> Self {
        Self { rest: text, number: 0 }
    }
}

impl<'a> Iterator for Lines<'a> {
    type Item = (usize, &'a [u8]);

    fn next(&mut self) -> Option<Self::Item> {
        if self.rest.is_empty() {
            return None;
        }
        let end = self.rest.iter().position(|b| matches!(b, b'\n' | b'\r')).unwrap_or(self.rest.len());
        let (line, rest) = self.rest.split_at(end);
        self.rest = rest.strip_prefix(b"\r\n").unwrap_or(rest.get(1..).unwrap_or_default());
        self.number += 1;
        Some((self.number, line))
    }
}

/// What of a line comes before its comment. The `#` of `1.#QNAN`, as Microsoft's libraries print what is no
/// number, begins none.
pub(super) fn without_comment(line: &[u8]) -> &[u8] {
    let begins = |at: &usize| line[*at] == b'#' && !line[..*at].ends_with(b".");
    (0..line.len()).find(begins).map_or(line, |at| &line[..at])
}

/// The words of a line. A file that DOS ended has a mark of its own there.
pub(super) fn words(line: &[u8]) -> impl Iterator<Item = &[u8]> + Clone {
    line.split(is_blank).filter(|word| !word.is_empty())
}

/// Takes the first word off `line`.
pub(super) fn next_word<'a>(line: &mut &'a [u8]) -> Option<&'a [u8]> {
    let start = line.iter().position(|b| !is_blank(b))?;
    let word = line[start..].split(is_blank).next()?;
    *line = &line[start + word.len()..];
    Some(word)
}

fn is_blank(byte: &u8) -> bool {
    byte.is_ascii_whitespace() || matches!(byte, 0x0B | 0x1A | 0)
}

/// A number; one that is none by the name that Microsoft's libraries give it, too.
pub(super) fn number(word: &[u8]) -> Option<f64> {
    let text = std::str::from_utf8(word).ok()?;
    let parsed = text.parse().ok();
    parsed.or_else(|| (text.contains(".#") || text.to_ascii_lowercase().contains("nan(")).then_some(f64::NAN))
}

/// A word of a file in a message: one line, whatever is in it, and not long.
pub(super) fn quoted(word: &[u8]) -> String {
    let start = String::from_utf8_lossy(word.get(..40).unwrap_or(word)).into_owned();
    format!("`{}`", start.escape_debug())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_end_as_any_system_ends_them() {
        let lines: Vec<_> = Lines::new(b"a\nb\r\n\rc\r\r\nd").collect();
        let expected: [(usize, &[u8]); 6] = [(1, b"a"), (2, b"b"), (3, b""), (4, b"c"), (5, b""), (6, b"d")];
        assert_eq!(lines, expected);
    }

    #[test]
    fn comments_and_words() {
        for (line, expected) in
            [("v 1 2#3", "v 1 2"), ("# all", ""), ("v 1.#QNAN 2 # x", "v 1.#QNAN 2 "), ("v", "v")]
        {
            assert_eq!(without_comment(line.as_bytes()), expected.as_bytes());
        }
        assert_eq!(words(b" a\tb \x1a").collect::<Vec<_>>(), [b"a", b"b"]);
        let mut line = b" a\tb ".as_slice();
        assert_eq!(
            [next_word(&mut line), next_word(&mut line), next_word(&mut line)],
            [Some(b"a".as_slice()), Some(b"b"), None]
        );
        assert_eq!(quoted(b"a\x1b[2J\xE9"), "`a\\u{1b}[2J\u{FFFD}`");
    }

    #[test]
    fn numbers_are_those_of_any_program() {
        let expected =
            [("1e-3", 0.001), ("1.", 1.0), (".5", 0.5), ("+2", 2.0), ("-1.5E+2", -150.0), ("1e99", 1e99)];
        assert!(expected.iter().all(|(text, value)| number(text.as_bytes()) == Some(*value)));
        assert!(
            ["nan", "-nan", "NaN", "-1.#IND", "1.#QNAN", "-nan(ind)"]
                .iter()
                .all(|t| number(t.as_bytes()).unwrap().is_nan())
        );
        assert_eq!(number(b"-inf"), Some(f64::NEG_INFINITY));
        assert!(
            ["", "1,5", "x", "1d3", "0x10", "1.5.2", "\u{FF11}"]
                .iter()
                .all(|t| number(t.as_bytes()).is_none())
        );
    }

    #[test]
    fn marks_are_skipped_or_refused() {
        let place = Place::file("t.obj");
        assert_eq!(unmarked(b"\xEF\xBB\xBFv 0", &place).unwrap(), b"v 0");
        assert_eq!(unmarked(b"v 0", &place).unwrap(), b"v 0");
        for text in [b"\xFF\xFEv\0".as_slice(), b"\xFE\xFF\0v", b"v\0 \0", b"\0v\0 "] {
            assert!(
                unmarked(text, &place)
                    .unwrap_err()
                    .to_string()
                    .contains("UTF-16 text; save it as ASCII or UTF-8")
            );
        }
    }
}
