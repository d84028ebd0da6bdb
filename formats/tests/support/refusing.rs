//! Values and files that must be refused.

use super::raw_file::{RawFile, RawSection};
use super::reading::refusal;
use relume_formats::container::{Kind, Stored};
use relume_formats::{Error, Place};

/// Refused when it is read, and not even written.
pub fn assert_refused<T: Stored>(value: &T, expected: &str) {
    assert_invalid(T::KIND, &value.to_bytes_unchecked(Place::file("a.relume")).unwrap(), expected);
    let unwritten = value.to_bytes(Place::file("a.relume")).unwrap_err().to_string();
    assert!(unwritten.contains(expected) && !unwritten.contains("damaged"), "`{expected}`: {unwritten}");
}

pub fn assert_invalid(kind: Kind, bytes: &[u8], expected: &str) {
    let error = refusal(kind, bytes);
    assert!(
        matches!(error, Error::Invalid { .. }) && error.to_string().contains(expected),
        "`{expected}`: {error}"
    );
}

/// A file with one section changed beyond what the types allow.
pub fn assert_forged_refused<T: Stored>(
    value: &T,
    section: &str,
    change: impl Fn(&mut RawSection),
    expected: &str,
) {
    let folder = tempfile::tempdir().unwrap();
    let mut file = RawFile::parse(&value.write_file(&folder.path().join("a.relume")).unwrap());
    change(file.sections.iter_mut().find(|s| s.name == section).unwrap());
    assert_invalid(T::KIND, &file.bytes(), expected);
}
