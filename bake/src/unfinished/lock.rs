//! One bake at a time in a folder: two would mix their files. The lock is the operating system's on a file
//! that says who holds it, so that it ends with the process however that ends.

use super::names::{LOCK, UNFINISHED};
use crate::error::{BakeError, Result};
use crate::output::create_folder;
use relume_formats::{Error, Place, read_regular};
use std::fs::{File, OpenOptions, TryLockError};
use std::io::{ErrorKind, Write as _};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};

/// How often another bake may end between two of our steps before that is no chance any more.
const ATTEMPTS: u32 = 1000;
/// More than any number of a process takes.
const MAX_BYTES: u64 = 64;

/// Numbers the locks of this process, so that no two of them say the same.
static TAKEN: AtomicU64 = AtomicU64::new(0);

/// A folder that this process alone works in, for as long as this lives.
#[derive(Debug)]
pub struct FolderLock {
    folder: PathBuf,
    /// Whether the folder was not there before.
    is_new: bool,
    /// Locked until it is closed.
    _file: File,
}

impl FolderLock {
    /// Takes the folder at `path`, which is made if it is not there.
    ///
    /// # Errors
    /// [`BakeError::Busy`] if another process works there; if it is no folder, or nothing can be written
    /// there.
    pub fn take(path: &Path) -> Result<Self> {
        let is_new = create_folder(path)?;
        for _ in 0..ATTEMPTS {
            if let Some(file) = try_take(path)? {
                return Ok(Self { folder: path.to_path_buf(), is_new, _file: file });
            }
        }
        Err(BakeError::Busy { folder: Place::file(path), process: String::new() })
    }
}

/// `None` if another process gave the lock up at the same time and took its file away.
fn try_take(folder: &Path) -> Result<Option<File>> {
    let unfinished = folder.join(UNFINISHED);
    let path = unfinished.join(LOCK);
    let place = Place::file(&path);
    if unfinished.is_symlink() {
        let reason = "is a link, so that work would be done and thrown away elsewhere; remove it";
        return Err(BakeError::invalid(&Place::file(&unfinished), reason));
    }
    create_folder(&unfinished)?;
    let mut file = match OpenOptions::new().read(true).write(true).create(true).truncate(false).open(&path) {
        Err(e) if e.kind() == ErrorKind::NotFound => return Ok(None),
        other => other.map_err(|e| Error::output(&place, e))?,
    };
    match file.try_lock() {
        Ok(()) => {}
        Err(TryLockError::WouldBlock) => {
            return Err(BakeError::Busy { folder: Place::file(folder), process: holder(&path) });
        }
        Err(TryLockError::Error(e)) => return Err(Error::output(&place, e).into()),
    }
    let ours = format!("{} {}", std::process::id(), TAKEN.fetch_add(1, Ordering::Relaxed));
    file.set_len(0).and_then(|()| file.write_all(ours.as_bytes())).map_err(|e| Error::output(&place, e))?;
    // What is locked may have lost its name before: only the file that others find there keeps them out.
    let is_the_one = read_regular(&path, MAX_BYTES, "").is_ok_and(|found| found == ours.as_bytes());
    Ok(is_the_one.then_some(file))
}

/// " (process 123)", if the lock tells.
fn holder(path: &Path) -> String {
    let text = read_regular(path, MAX_BYTES, "").ok().and_then(|bytes| String::from_utf8(bytes).ok());
    let number =
        text.as_deref().and_then(|text| text.split(' ').next()).and_then(|number| number.parse::<u32>().ok());
    number.map_or_else(String::new, |number| format!(" (process {number})"))
}

impl Drop for FolderLock {
    /// Takes away what the lock alone has brought; folders that hold anything stay.
    fn drop(&mut self) {
        let unfinished = self.folder.join(UNFINISHED);
        let _ = std::fs::remove_file(unfinished.join(LOCK));
        let _ = std::fs::remove_dir(unfinished);
        if self.is_new {
            let _ = std::fs::remove_dir(&self.folder);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::AtomicU32;

    #[test]
    fn one_has_the_folder_and_leaves_nothing_behind() {
        let here = tempfile::tempdir().unwrap();
        let folder = here.path().join("bundle");
        let lock = FolderLock::take(&folder).unwrap();
        let refused = FolderLock::take(&folder).unwrap_err();
        let expected = format!(
            "another bake is at work here (process {}); wait for it, or bake elsewhere with -o",
            std::process::id()
        );
        assert!(refused.to_string().ends_with(&expected) && refused.exit_code() == 1, "{refused}");
        drop(lock);
        assert!(!folder.exists(), "it was new and is empty");
        std::fs::create_dir_all(folder.join(UNFINISHED)).unwrap();
        std::fs::write(folder.join(UNFINISHED).join("a.log"), "work").unwrap();
        // What a killed bake leaves holds nobody up.
        std::fs::write(folder.join(UNFINISHED).join(LOCK), "1").unwrap();
        drop(FolderLock::take(&folder).unwrap());
        assert!(
            folder.join(UNFINISHED).join("a.log").exists() && !folder.join(UNFINISHED).join(LOCK).exists()
        );
    }

    /// Threads stand for processes: each opens the file anew, and locks belong to what was opened.
    #[test]
    fn many_that_come_and_go_never_have_it_together() {
        let here = tempfile::tempdir().unwrap();
        let (inside, taken) = (AtomicU32::new(0), AtomicU32::new(0));
        std::thread::scope(|scope| {
            for _ in 0..4 {
                scope.spawn(|| {
                    for _ in 0..500 {
                        let Ok(lock) = FolderLock::take(here.path()) else { continue };
                        assert_eq!(inside.fetch_add(1, Ordering::SeqCst), 0, "two at once");
                        taken.fetch_add(1, Ordering::SeqCst);
                        inside.fetch_sub(1, Ordering::SeqCst);
                        drop(lock);
                    }
                });
            }
        });
        assert!(taken.into_inner() >= 4);
    }

    #[cfg(unix)]
    #[test]
    fn a_folder_that_cannot_be_written_is_known_at_once() {
        let here = tempfile::tempdir().unwrap();
        let elsewhere = tempfile::tempdir().unwrap();
        std::os::unix::fs::symlink(elsewhere.path(), here.path().join(UNFINISHED)).unwrap();
        let error = FolderLock::take(here.path()).unwrap_err();
        assert!(error.exit_code() == 2 && error.to_string().contains("unfinished: is a link"), "{error}");
        assert!(elsewhere.path().read_dir().unwrap().next().is_none());
        std::fs::remove_file(here.path().join(UNFINISHED)).unwrap();
        std::fs::write(here.path().join(UNFINISHED), "no folder").unwrap();
        let error = FolderLock::take(here.path()).unwrap_err();
        assert!(error.to_string().contains("unfinished: is a file where a folder is wanted"), "{error}");
    }
}
