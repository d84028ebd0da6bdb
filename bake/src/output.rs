//! Folders that the user wants things in.

use relume_formats::{Error, Place, Result};
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

/// Makes the folder at `path` if it is not there; whether it was not.
///
/// # Errors
/// `Invalid` if the path cannot be that of a folder, `Output` if the folder cannot be made.
pub fn create_folder(path: &Path) -> Result<bool> {
    let place = Place::file(path);
    let refuse = |reason: &str| Err(Error::invalid(&place, reason));
    if path.as_os_str().is_empty() {
        return Err(Error::invalid(&Place::file("--output"), "is empty; name a folder"));
    }
    match std::fs::metadata(path) {
        Ok(there) if there.is_dir() => return Ok(false),
        Ok(_) => return refuse("is a file where a folder is wanted; name another with -o"),
        Err(_) if path.is_symlink() => {
            return refuse("is a link that leads nowhere; remove it, or name another folder with -o");
        }
        Err(_) => {}
    }
    match std::fs::create_dir_all(path) {
        Ok(()) => Ok(true),
        Err(e)
            if [ErrorKind::NotADirectory, ErrorKind::InvalidFilename, ErrorKind::InvalidInput]
                .contains(&e.kind()) =>
        {
            refuse(&format!("cannot be a folder ({e}); name another with -o"))
        }
        Err(e) => Err(Error::output(&place, e)),
    }
}

/// Makes the folder of the file at `path`, and fails if the file could not be written there; better now than
/// after hours of work.
///
/// # Errors
/// Those of [`create_folder`]; `Invalid` if a folder is in the file's place, `Output` if nothing can be
/// written there.
pub fn expect_writable(path: &Path) -> Result<()> {
    let place = Place::file(path);
    if path.is_dir() {
        return Err(Error::invalid(&place, "is a folder where a file is wanted; name another with -o"));
    }
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
    folder.map(create_folder).transpose()?;
    let name = path.file_name();
    sweep_partial(folder.unwrap_or(Path::new(".")), |whole| name.is_some_and(|name| name == whole));
    if is_pipe(path) {
        return Err(Error::invalid(
            &place,
            "is a pipe or socket, which would be waited for; name a file with -o",
        ));
    }
    // Where a device stands, it is not for us to try.
    if path.exists() && !path.is_file() {
        return Ok(());
    }
    let tried = tempfile::NamedTempFile::new_in(folder.unwrap_or(Path::new(".")))
        .and_then(tempfile::NamedTempFile::close);
    tried.map_err(|e| Error::output(&place, e))
}

#[cfg(unix)]
fn is_pipe(path: &Path) -> bool {
    use std::os::unix::fs::FileTypeExt;
    std::fs::metadata(path).is_ok_and(|there| there.file_type().is_fifo() || there.file_type().is_socket())
}

#[cfg(not(unix))]
fn is_pipe(_: &Path) -> bool {
    false
}

/// Files in `folder` by name, for those whose name is text.
pub fn files(folder: &Path) -> Vec<(String, PathBuf)> {
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    entries.filter_map(|entry| Some((entry.file_name().into_string().ok()?, entry.path()))).collect()
}

/// Takes away what a kill in the middle of writing left of those files in `folder` that `is_ours`.
pub fn sweep_partial(folder: &Path, is_ours: impl Fn(&str) -> bool) {
    for (_, path) in files(folder).into_iter().filter(|(name, _)| whole_name(name).is_some_and(&is_ours)) {
        // In nobody's way if it cannot be removed.
        let _ = std::fs::remove_file(path);
    }
}

/// The name that a file was to have, if it is called as [`relume_formats::container::replace_file`] calls
/// what is not whole yet.
pub fn whole_name(name: &str) -> Option<&str> {
    let (whole, number) = name.rsplit_once(".partial-")?;
    (!number.is_empty() && number.chars().all(|c| c.is_ascii_digit())).then_some(whole)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_cannot_be_a_folder_is_refused_by_its_name() {
        let here = tempfile::tempdir().unwrap();
        let at = |name: &str| here.path().join(name);
        std::fs::write(at("file"), "").unwrap();
        for (path, reason) in [
            (Path::new("").to_owned(), "--output: is empty; name a folder"),
            (at("file"), "file: is a file where a folder is wanted"),
            (at("file/below"), "cannot be a folder"),
            (at(&"x".repeat(300)), "cannot be a folder"),
            (at("nul\0"), "cannot be a folder"),
        ] {
            let error = create_folder(&path).unwrap_err();
            assert!(error.is_bad_input() && error.to_string().contains(reason), "{error}");
        }
        assert!(create_folder(&at("new/folder")).unwrap() && at("new/folder").is_dir());
        assert!(!create_folder(&at("new/folder")).unwrap());
    }

    #[cfg(unix)]
    #[test]
    fn links_to_folders_are_folders_and_links_to_nothing_are_refused() {
        let here = tempfile::tempdir().unwrap();
        let [link, dangling] = ["link", "dangling"].map(|name| here.path().join(name));
        std::os::unix::fs::symlink(here.path(), &link).unwrap();
        std::os::unix::fs::symlink(here.path().join("gone"), &dangling).unwrap();
        assert!(!create_folder(&link).unwrap());
        let error = create_folder(&dangling).unwrap_err();
        assert!(error.is_bad_input() && error.to_string().contains("a link that leads nowhere"), "{error}");
    }

    #[test]
    fn whether_a_file_can_be_written_is_known_before_it_is_made() {
        let here = tempfile::tempdir().unwrap();
        let new = here.path().join("new");
        expect_writable(&new.join("image.exr")).unwrap();
        assert!(files(&new).is_empty(), "something is left of the trial");
        for file in
            ["image.exr.partial-12", "other.exr.partial-12", "image.exr.partial-", "image.exr.partial-1a"]
        {
            std::fs::write(new.join(file), "").unwrap();
        }
        expect_writable(&new.join("image.exr")).unwrap();
        assert_eq!(files(&new).len(), 3, "what a kill left of this file is gone");
        let error = expect_writable(here.path()).unwrap_err();
        assert!(
            error.is_bad_input() && error.to_string().contains("is a folder where a file is wanted"),
            "{error}"
        );
        #[cfg(unix)]
        {
            let socket = here.path().join("socket");
            let _listener = std::os::unix::net::UnixListener::bind(&socket).unwrap();
            let error = expect_writable(&socket).unwrap_err();
            assert!(error.is_bad_input() && error.to_string().contains("is a pipe or socket"), "{error}");
        }
    }
}
