//! Files that never replace others: the first free number goes into the name.

use crate::error::Result;
use relume_formats::container::replace_file;
use relume_formats::{Error, Place};
use std::fs::OpenOptions;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

/// Most files of one name; looking for a free number must end some time.
const MOST: u32 = 9999;

/// Writes `bytes` to `<folder>/<name>-0001.<extension>`, or under the first higher number that is free.
/// Returns the path.
///
/// Characters of `name` that mean something to file systems or shells become `_`.
pub fn write_numbered(folder: &Path, name: &str, extension: &str, bytes: &[u8]) -> Result<PathBuf> {
    let name = plain(name);
    for number in 1..=MOST {
        let path = folder.join(format!("{name}-{number:04}.{extension}"));
        // Claims the name, so that another player in the same folder takes the next one.
        match OpenOptions::new().write(true).create_new(true).open(&path) {
            Err(error) if error.kind() == ErrorKind::AlreadyExists => {}
            Err(error) => return Err(Error::output(&Place::file(&path), error).into()),
            Ok(_) => return fill(&path, bytes).map(|()| path),
        }
    }
    let reason = format!("{MOST} files of this name are there; move some of them away");
    Err(Error::invalid(&Place::file(folder.join(format!("{name}-{MOST}.{extension}"))), reason).into())
}

fn fill(path: &Path, bytes: &[u8]) -> Result<()> {
    replace_file(path, bytes).map_err(|error| {
        // Whatever goes wrong here, the first error tells more.
        let _ = std::fs::remove_file(path);
        error.into()
    })
}

fn plain(name: &str) -> String {
    let kept: String = name
        .chars()
        .take(100)
        .map(|c| if c.is_ascii_alphanumeric() || "._-".contains(c) { c } else { '_' })
        .collect();
    if kept.is_empty() || kept.starts_with('.') { format!("scene{kept}") } else { kept }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_is_ever_replaced() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        std::fs::write(at("s-0001.png"), "old").unwrap();
        std::fs::write(at("s-0003.png"), "old").unwrap();
        let names = ["s-0002.png", "s-0004.png", "s-0005.png"];
        for name in names {
            assert_eq!(write_numbered(folder.path(), "s", "png", b"new").unwrap(), at(name));
        }
        assert_eq!(write_numbered(folder.path(), "s", "exr", b"new").unwrap(), at("s-0001.exr"));
        for (name, expected) in
            [("s-0001.png", "old"), ("s-0003.png", "old"), ("s-0004.png", "new"), ("s-0001.exr", "new")]
        {
            assert_eq!(std::fs::read_to_string(at(name)).unwrap(), expected);
        }
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 6, "and nothing else is left behind");
    }

    #[test]
    fn names_stay_in_the_folder() {
        for (name, expected) in [
            ("../../etc/x", "scene.._.._etc_x"),
            ("", "scene"),
            ("a b\0ü", "a_b__"),
            ("cornell-knot", "cornell-knot"),
        ] {
            assert_eq!(plain(name), expected);
        }
    }

    #[test]
    fn a_folder_that_is_gone_is_named() {
        let folder = tempfile::tempdir().unwrap().path().join("gone");
        let error = write_numbered(&folder, "s", "png", b"").unwrap_err();
        assert!(error.to_string().contains("gone") && error.to_string().contains("s-0001.png"), "{error}");
    }
}
