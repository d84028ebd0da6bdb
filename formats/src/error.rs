//! One error type for everything read from or written to disk.

use crate::name::plain;
use crate::near::nearest_file;
use std::fmt;
use std::io;
use std::path::{Path, PathBuf};

/// Shorthand for results of this crate.
pub type Result<T> = std::result::Result<T, Error>;

/// Where in the outside world something went wrong.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Place {
    /// The file concerned.
    pub file: PathBuf,
    /// The part of it: a section name, or `line:column` of a text file.
    pub part: Option<String>,
}

impl Place {
    /// A whole file.
    pub fn file(file: impl AsRef<Path>) -> Self {
        Self { file: file.as_ref().to_path_buf(), part: None }
    }

    /// The same file, narrowed to one part of it.
    pub fn part(&self, part: impl Into<String>) -> Self {
        Self { file: self.file.clone(), part: Some(part.into()) }
    }
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        // Names in files may hold line breaks and terminal controls; a message is one line and cannot steer a
        // terminal.
        write!(f, "{}", plain(&self.file.display().to_string()))?;
        match &self.part {
            Some(part) => write!(f, ": {}", plain(part)),
            None => Ok(()),
        }
    }
}

/// What can go wrong with a file, named with its place; the text ends with a remedy where there is one.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The content breaks the rules of its format or asks for something impossible.
    #[error("{place}: {reason}")]
    Invalid {
        /// Where.
        place: Place,
        /// What is wrong and how to mend it.
        reason: String,
    },
    /// The content may be fine but is not something this version understands.
    #[error("{place}: {reason}")]
    Unsupported {
        /// Where.
        place: Place,
        /// What is not supported and what is.
        reason: String,
    },
    /// The operating system refused to give out what the user named.
    #[error("{place}: {source}")]
    Io {
        /// Where.
        place: Place,
        /// Why.
        source: io::Error,
    },
    /// The operating system refused to keep what the program made, or to give it back.
    #[error("{place}: {source}")]
    Output {
        /// Where.
        place: Place,
        /// Why.
        source: io::Error,
    },
}

impl Error {
    /// An [`Error::Invalid`].
    pub fn invalid(place: &Place, reason: impl Into<String>) -> Self {
        Self::Invalid { place: place.clone(), reason: plain(&reason.into()).into_owned() }
    }

    /// An [`Error::Unsupported`].
    pub fn unsupported(place: &Place, reason: impl Into<String>) -> Self {
        Self::Unsupported { place: place.clone(), reason: plain(&reason.into()).into_owned() }
    }

    /// An [`Error::Io`]. What the system says in its own terms is said in ours, with the file that was meant
    /// if the one named is not there.
    pub fn io(place: &Place, source: io::Error) -> Self {
        let of_kind = |reason: String| io::Error::new(source.kind(), reason);
        let source = match source.kind() {
            _ if source.raw_os_error().is_none() => source,
            io::ErrorKind::NotFound => {
                let meant = nearest_file(Path::new(""), &place.file)
                    .map(|file| format!("; did you mean `{file}`?"))
                    .unwrap_or_default();
                of_kind(format!("no such file or folder{meant}"))
            }
            io::ErrorKind::IsADirectory => of_kind("is a folder; name a file".to_owned()),
            io::ErrorKind::NotADirectory => of_kind("leads through a file; name a folder".to_owned()),
            io::ErrorKind::PermissionDenied => of_kind("permission denied".to_owned()),
            _ => source,
        };
        Self::Io { place: place.clone(), source }
    }

    /// An [`Error::Output`].
    pub fn output(place: &Place, source: io::Error) -> Self {
        Self::Output { place: place.clone(), source }
    }

    /// True if the fault lies in what the user gave (exit code 2) rather than in the run (exit code 1).
    pub fn is_bad_input(&self) -> bool {
        match self {
            Self::Invalid { .. } | Self::Unsupported { .. } => true,
            Self::Io { source, .. } => is_of_the_path(source),
            Self::Output { .. } => false,
        }
    }
}

/// A usage error in words that say what to write: of numbers that the standard library cannot read, and of
/// what was meant.
pub fn in_plain_words(message: &str) -> String {
    let (what, meant) =
        match message.split_once(" tip: ").map(|(what, tip)| (what, tip.split_once(" exists: "))) {
            Some((what, Some((_, meant)))) => (what, format!("; did you mean {meant}?")),
            _ => (message, String::new()),
        };
    [
        ("invalid digit found in string", "a whole number is expected"),
        ("invalid float literal", "a number such as 0.01 is expected, with a decimal point"),
        ("cannot parse integer from empty string", "a whole number is expected"),
        ("cannot parse float from empty string", "a number is expected"),
        ("number too large to fit in target type", "a smaller number is expected"),
    ]
    .iter()
    .fold(format!("{what}{meant}"), |message, (theirs, ours)| message.replace(theirs, ours))
}

/// Whether a path leads to nothing that can be read, rather than reading having failed.
fn is_of_the_path(error: &io::Error) -> bool {
    use io::ErrorKind::{
        InvalidFilename, InvalidInput, IsADirectory, NotADirectory, NotFound, PermissionDenied,
    };
    let by_kind = [NotFound, IsADirectory, NotADirectory, PermissionDenied, InvalidFilename, InvalidInput]
        .contains(&error.kind());
    by_kind || leads_in_circles(error)
}

/// Whether links lead to each other; the standard library has no stable kind for it.
fn leads_in_circles(error: &io::Error) -> bool {
    cfg!(unix) && error.raw_os_error() == Some(ELOOP)
}

#[cfg(unix)]
const ELOOP: i32 = libc::ELOOP;
#[cfg(not(unix))]
const ELOOP: i32 = 0;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn usage_errors_say_what_to_write() {
        for (theirs, ours) in [
            (
                "unexpected argument '--x' found tip: a similar argument exists: '--y'",
                "unexpected argument '--x' found; did you mean '--y'?",
            ),
            (
                "invalid value 'a' for '--n <N>': invalid digit found in string",
                "invalid value 'a' for '--n <N>': a whole number is expected",
            ),
            (
                "unexpected argument tip: to pass '-a' as a value, use '-- -a'",
                "unexpected argument tip: to pass '-a' as a value, use '-- -a'",
            ),
        ] {
            assert_eq!(in_plain_words(theirs), ours);
        }
    }

    #[test]
    fn files_that_are_not_there_are_told_in_plain_words() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("Sky.exr"), "").unwrap();
        for (name, expected) in [
            (
                "sky.exr",
                format!(
                    "no such file or folder; did you mean `{}`?",
                    folder.path().join("Sky.exr").display()
                ),
            ),
            ("", "is a folder; name a file".to_owned()),
        ] {
            let path = folder.path().join(name);
            let error = Error::io(&Place::file(&path), std::fs::read(&path).unwrap_err());
            assert_eq!(error.to_string(), format!("{}: {expected}", path.display()));
            assert!(error.is_bad_input());
        }
    }

    #[test]
    fn a_message_is_one_line_whatever_files_and_their_content_are_called() {
        let place = Place::file("a\nb.toml").part("key `c\rd`");
        for error in [
            Error::invalid(&place, "material `päper\n\u{1b}[2J` is bad"),
            Error::unsupported(&place, "material `päper\n\u{1b}[2J` is bad"),
        ] {
            assert_eq!(error.to_string(), r"a\nb.toml: key `c\rd`: material `päper\n\u{1b}[2J` is bad");
        }
    }

    #[test]
    fn what_cannot_be_read_is_the_users_fault_and_what_cannot_be_written_is_not() {
        let place = Place::file("x");
        for kind in [io::ErrorKind::NotFound, io::ErrorKind::PermissionDenied, io::ErrorKind::InvalidInput] {
            assert!(Error::io(&place, kind.into()).is_bad_input());
            assert!(!Error::output(&place, kind.into()).is_bad_input());
        }
        for kind in
            [io::ErrorKind::StorageFull, io::ErrorKind::ReadOnlyFilesystem, io::ErrorKind::OutOfMemory]
        {
            assert!(!Error::io(&place, kind.into()).is_bad_input());
        }
    }
}
