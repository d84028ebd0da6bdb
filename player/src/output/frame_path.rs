//! File names with a frame number in them, in the style of printf.

use std::path::PathBuf;
use std::str::FromStr;

/// A file name with at most one `%d` or `%0Nd` in it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FramePath {
    before: String,
    /// Least number of digits, and what follows the number; `None` for a plain file name.
    number: Option<(usize, String)>,
}

impl FramePath {
    /// Whether names of different frames differ.
    pub fn is_numbered(&self) -> bool {
        self.number.is_some()
    }

    /// The path of frame `index`.
    pub fn of(&self, index: usize) -> PathBuf {
        PathBuf::from(match &self.number {
            None => self.before.clone(),
            Some((digits, after)) => format!("{}{index:0digits$}{after}", self.before),
        })
    }
}

impl FromStr for FramePath {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let refuse = || Err(format!("`{text}` needs exactly one %d or %0Nd (such as %04d) and no other %"));
        if text.is_empty() {
            return Err("the file name is empty".to_owned());
        }
        let Some((before, rest)) = text.split_once('%') else {
            return Ok(Self { before: text.to_owned(), number: None });
        };
        let Some((digits, after)) = rest.split_once('d') else { return refuse() };
        let digits = match digits.strip_prefix('0') {
            None if digits.is_empty() => 1,
            // `parse` alone would take a sign.
            Some(width) if width.bytes().all(|b| b.is_ascii_digit()) => match width.parse() {
                Ok(n @ 1..=20) => n,
                _ => return refuse(),
            },
            _ => return refuse(),
        };
        if after.contains('%') {
            return refuse();
        }
        Ok(Self { before: before.to_owned(), number: Some((digits, after.to_owned())) })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn name(pattern: &str, index: usize) -> String {
        pattern.parse::<FramePath>().unwrap().of(index).to_string_lossy().into_owned()
    }

    #[test]
    fn numbers_replace_the_pattern() {
        assert_eq!(name("out/%04d.png", 7), "out/0007.png");
        assert_eq!(name("out/f%d.exr", 120), "out/f120.exr");
        assert_eq!(name("%02d", 12345), "12345");
        assert_eq!(name("plain.png", 0), "plain.png");
        assert!(!"plain.png".parse::<FramePath>().unwrap().is_numbered());
    }

    #[test]
    fn other_patterns_are_refused() {
        for pattern in [
            "",
            "%d-%d.png",
            "%s.png",
            "%4d.png",
            "100%.png",
            "%0d.png",
            "%099d.png",
            "%%d.png",
            "%04d%%.png",
            "%-4d",
            "%0+4d",
        ] {
            assert!(pattern.parse::<FramePath>().is_err(), "{pattern}");
        }
    }
}
