//! What glTF files name by URI: data within the text, and files in the folder of the file that names them or
//! below. Nothing else is opened.

use super::tidy_name;
use crate::library::read_bytes;
use base64::Engine;
use base64::alphabet::STANDARD;
use base64::engine::{DecodePaddingMode, GeneralPurpose, GeneralPurposeConfig};
use relume_formats::near::nearest_file;
use relume_formats::{Error, Place, Result};
use std::io;
use std::path::{Path, PathBuf};

/// The bytes behind `uri` in the file at `path`.
pub(super) fn read_uri(uri: &str, path: &Path, place: &Place) -> Result<Vec<u8>> {
    if let Some((_, data)) = uri.split_once(':').filter(|(scheme, _)| scheme.eq_ignore_ascii_case("data")) {
        return decode_data(data, place);
    }
    let file = beside(uri, path, place)?;
    read_bytes(&file).map_err(|error| match error {
        Error::Io { source, .. } => needed(&file, path, &source),
        other => other,
    })
}

/// A data URI without its scheme: a media type and parameters, which mean nothing here, then a comma and the
/// data.
fn decode_data(data: &str, place: &Place) -> Result<Vec<u8>> {
    let (kind, text) = data
        .split_once(',')
        .ok_or_else(|| Error::invalid(place, "a data URI without data; export the file again"))?;
    let decoded = percent_decoded(text);
    if !kind.rsplit(';').next().is_some_and(|last| last.trim().eq_ignore_ascii_case("base64")) {
        return Ok(decoded);
    }
    // The glTF file itself is of bounded size, and with it the text. Some programs leave out padding, break
    // lines, or use the alphabet for addresses.
    let standard = |byte: u8| match byte {
        b'-' => b'+',
        b'_' => b'/',
        other => other,
    };
    let text: Vec<u8> = decoded
        .into_iter()
        .filter(|byte| !byte.is_ascii_whitespace() && *byte != b'=')
        .map(standard)
        .collect();
    let config = GeneralPurposeConfig::new()
        .with_decode_padding_mode(DecodePaddingMode::Indifferent)
        .with_decode_allow_trailing_bits(true);
    GeneralPurpose::new(&STANDARD, config)
        .decode(text)
        .map_err(|e| Error::invalid(place, format!("broken base64 ({e}); export the file again")))
}

/// The file that `uri` names, which lies in the folder of `path` or below.
fn beside(uri: &str, path: &Path, place: &Place) -> Result<PathBuf> {
    let refuse = |reason: &str| Error::invalid(place, format!("names `{}`, {reason}", tidy_name(uri)));
    let outside =
        "which is not in the folder of the glTF file or below; put it there and name it by a relative path";
    let decoded =
        String::from_utf8(percent_decoded(uri)).map_err(|_| refuse("which is not UTF-8; rename the file"))?;
    if decoded.contains("://") && !decoded.to_ascii_lowercase().starts_with("file:") {
        return Err(refuse("which is not on this machine; download it and name it by a relative path"));
    }
    if decoded.contains('\0') || decoded.is_empty() {
        return Err(refuse("which is no file name; correct it"));
    }
    let absolute = decoded.starts_with(['/', '\\'])
        || decoded.split(['/', '\\']).next().is_some_and(|first| first.contains(':'));
    let mut inner = PathBuf::new();
    for part in decoded.split(['/', '\\']).filter(|part| !matches!(*part, "" | ".")) {
        if absolute || (part == ".." && !inner.pop()) {
            return Err(refuse(outside));
        }
        if part != ".." {
            inner.push(part);
        }
    }
    let folder =
        path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or_else(|| Path::new("."));
    let file = folder.join(inner);
    let unreadable = |e: io::Error| match e.kind() {
        io::ErrorKind::InvalidFilename => refuse("which is too long for a file name; rename the file"),
        _ => needed(&file, path, &e),
    };
    // Links are followed before anything is opened.
    let (whole, home) =
        (file.canonicalize().map_err(unreadable)?, folder.canonicalize().map_err(unreadable)?);
    if !whole.starts_with(home) {
        return Err(refuse(
            "a link to what is not in the folder of the glTF file or below; put a copy there",
        ));
    }
    Ok(file)
}

fn needed(file: &Path, path: &Path, error: &io::Error) -> Error {
    if error.kind() == io::ErrorKind::NotFound {
        let meant = nearest_file(Path::new(""), file)
            .map_or_else(|| "put it there".to_owned(), |meant| format!("did you mean `{meant}`?"));
        let reason = format!("no such file, but {} needs it; {meant}", path.display());
        return Error::io(&Place::file(file), io::Error::new(error.kind(), reason));
    }
    Error::io(
        &Place::file(file),
        io::Error::new(error.kind(), format!("{error}; {} needs it", path.display())),
    )
}

/// Undoes `%20` and its like; whatever is no such escape stays.
fn percent_decoded(uri: &str) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(uri.len());
    let mut rest = uri.as_bytes();
    while let Some((first, after)) = rest.split_first() {
        let hex = after.get(..2).filter(|hex| *first == b'%' && hex.iter().all(u8::is_ascii_hexdigit));
        let escaped = hex.and_then(|h| u8::from_str_radix(std::str::from_utf8(h).ok()?, 16).ok());
        bytes.push(escaped.unwrap_or(*first));
        rest = if escaped.is_some() { after.get(2..).unwrap_or_default() } else { after };
    }
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_support::Scratch;

    fn read(uri: &str, scratch: &Scratch) -> Result<Vec<u8>> {
        let path = scratch.path("in/t.gltf");
        read_uri(uri, &path, &Place::file(&path).part("buffer 0"))
    }

    #[test]
    fn data_is_decoded_however_it_is_written() {
        let scratch = Scratch::scene("");
        for uri in [
            "data:;base64,+/8BAg==",
            "data:application/octet-stream;base64,+/8BAg",
            "data:text/plain;charset=utf-8;base64,+/8BAg==",
            "DATA:;BASE64,-_8BAg",
            "data:;base64,%2B%2F8BAg%3D%3D",
            "data:;base64,+/8B\nAg==",
            "data:application/octet-stream,%FB%FF%01%02",
        ] {
            assert_eq!(read(uri, &scratch).unwrap(), [0xFB, 0xFF, 1, 2], "{uri}");
        }
        for (uri, part) in [
            ("data:;base64,A", "broken base64"),
            ("data:;base64,Ä", "broken base64"),
            ("data:;base64", "without data"),
        ] {
            assert!(read(uri, &scratch).unwrap_err().to_string().contains(part), "{uri}");
        }
    }

    #[test]
    fn files_in_the_folder_and_below_are_read_and_no_others() {
        let scratch = Scratch::scene("");
        for (name, content) in [
            ("in/a b.bin", "near"),
            ("in/sub/b.bin", "below"),
            ("secret.bin", "secret"),
            ("inside.bin", "secret"),
        ] {
            scratch.write(name, content);
        }
        for (uri, content) in [
            ("a%20b.bin", "near"),
            ("./a b.bin", "near"),
            ("sub/b.bin", "below"),
            ("sub\\b.bin", "below"),
            ("sub//../sub/./b.bin", "below"),
        ] {
            assert_eq!(read(uri, &scratch).unwrap(), content.as_bytes(), "{uri}");
        }
        let absolute = scratch.path("secret.bin");
        let long = format!("{}.bin", "x".repeat(5000));
        for uri in [
            "../secret.bin",
            "sub/../../secret.bin",
            "%2e%2e/secret.bin",
            "%2E%2E%2Fsecret.bin",
            "..\\secret.bin",
            "..%5Csecret.bin",
            absolute.to_str().unwrap(),
            &format!("file://{}", absolute.display()),
            "file:secret.bin",
            "FILE:///etc/passwd",
            "C:\\secret.bin",
            "\\\\server\\share\\secret.bin",
            "/etc/passwd",
            "../inside.bin",
            "a%20b.bin%00.png",
            "",
            "%FF.bin",
            "https://example.org/a.bin",
            long.as_str(),
        ] {
            let error = read(uri, &scratch).unwrap_err();
            let message = error.to_string();
            assert!(
                matches!(error, Error::Invalid { .. })
                    && message.contains("buffer 0: names `")
                    && message.len() < 600,
                "{uri}: {message}"
            );
        }
        let message = read("gone.bin", &scratch).unwrap_err().to_string();
        assert!(
            message.contains("gone.bin: ") && message.ends_with("t.gltf needs it; put it there"),
            "{message}"
        );
    }

    #[cfg(unix)]
    #[test]
    fn links_are_followed_within_the_folder_only() {
        use std::os::unix::fs::symlink;
        let scratch = Scratch::scene("");
        scratch.write("in/a.bin", "near");
        scratch.write("secret.bin", "secret");
        let folder = scratch.path("in");
        symlink("a.bin", folder.join("good.bin")).unwrap();
        symlink("../secret.bin", folder.join("bad.bin")).unwrap();
        symlink("..", folder.join("up")).unwrap();
        assert_eq!(read("good.bin", &scratch).unwrap(), b"near");
        for uri in ["bad.bin", "up/secret.bin"] {
            let message = read(uri, &scratch).unwrap_err().to_string();
            assert!(
                message.contains(&format!("names `{uri}`, a link to what is not in the folder")),
                "{message}"
            );
        }
    }
}
