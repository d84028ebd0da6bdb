//! Opening what somebody else names: files only. A pipe would be waited for, a device may never end.

use crate::error::{Error, Place, Result};
use std::fs::{File, OpenOptions};
use std::io::Read;
use std::path::Path;

/// Opens the file at `path` for reading.
///
/// # Errors
/// `Io` if it is not there or cannot be read, `Invalid` if it is a folder, pipe, socket or device.
pub fn open_regular(path: &Path) -> Result<File> {
    let place = Place::file(path);
    let io = |e| Error::io(&place, e);
    // To open a device may do something already, so it is looked at first; and once more when it is open, for
    // it may be another thing by now.
    expect_regular(&std::fs::metadata(path).map_err(io)?, &place)?;
    let mut options = OpenOptions::new();
    options.read(true);
    #[cfg(unix)]
    std::os::unix::fs::OpenOptionsExt::custom_flags(&mut options, libc::O_NONBLOCK);
    let file = options.open(path).map_err(io)?;
    expect_regular(&file.metadata().map_err(io)?, &place)?;
    Ok(file)
}

/// Reads the file at `path` whole.
///
/// # Errors
/// Those of [`open_regular`], and `Invalid` if it is longer than `most` bytes; `remedy` says what to do then.
pub fn read_regular(path: &Path, most: u64, remedy: &str) -> Result<Vec<u8>> {
    let place = Place::file(path);
    let mut bytes = Vec::new();
    // Some files call themselves empty and never end, so the cap is on what is read.
    open_regular(path)?
        .take(most.saturating_add(1))
        .read_to_end(&mut bytes)
        .map_err(|e| Error::io(&place, e))?;
    if bytes.len() as u64 > most {
        return Err(Error::invalid(&place, format!("longer than {most} bytes; {remedy}")));
    }
    Ok(bytes)
}

/// True if the extension of `path` is `extension` in any case.
pub fn has_extension(path: &Path, extension: &str) -> bool {
    path.extension().is_some_and(|e| e.eq_ignore_ascii_case(extension))
}

fn expect_regular(metadata: &std::fs::Metadata, place: &Place) -> Result<()> {
    if metadata.is_file() {
        return Ok(());
    }
    let what = if metadata.is_dir() { "a folder" } else { "a pipe, socket or device" };
    Err(Error::invalid(place, format!("not a regular file but {what}; give a file")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_are_read_and_nothing_else() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("file");
        std::fs::write(&file, b"1234").unwrap();
        assert_eq!(read_regular(&file, 4, "").unwrap(), b"1234");
        let message = read_regular(&file, 3, "cut it").unwrap_err().to_string();
        assert!(message.ends_with("longer than 3 bytes; cut it"), "{message}");
        assert!(
            open_regular(folder.path()).unwrap_err().to_string().contains("not a regular file but a folder")
        );
        assert!(open_regular(&folder.path().join("gone")).unwrap_err().is_bad_input());
    }

    #[cfg(unix)]
    #[test]
    fn pipes_sockets_and_devices_are_refused_at_once() {
        let folder = tempfile::tempdir().unwrap();
        let [pipe, socket, link, looped] =
            ["pipe", "socket", "link", "loop"].map(|name| folder.path().join(name));
        assert!(std::process::Command::new("mkfifo").arg(&pipe).status().unwrap().success());
        let _listener = std::os::unix::net::UnixListener::bind(&socket).unwrap();
        std::os::unix::fs::symlink(&pipe, &link).unwrap();
        std::os::unix::fs::symlink(&looped, &looped).unwrap();
        for path in [&pipe, &socket, &link, Path::new("/dev/zero"), Path::new("/dev/null")] {
            let error = open_regular(path).unwrap_err();
            assert!(
                error.is_bad_input()
                    && error.to_string().contains("not a regular file but a pipe, socket or device"),
                "{error}"
            );
        }
        assert!(open_regular(&looped).unwrap_err().is_bad_input());
        assert!(open_regular(Path::new("a\0b")).unwrap_err().is_bad_input());
        assert!(open_regular(Path::new(&"x".repeat(5000))).unwrap_err().is_bad_input());
    }
}
