//! Where methods work: the folder of what is not finished yet, the logs and the new files in it.

use super::{Leftover, SphereSetSummary};
use super::{UNFINISHED, lock};
use crate::error::{BakeError, Result};
use crate::job::Job;
use crate::work_log::WorkLog;
use relume_formats::container::Stored;
use relume_formats::kinds::SphereSet;
use relume_formats::kinds::manifest::{FILE_NAME as MANIFEST, FileEntry, is_plain_name};
use relume_formats::{Error, Place};
use std::ffi::OsStr;
use std::path::{Path, PathBuf};

/// Where a method works, and by what rules.
#[derive(Clone, Copy)]
pub struct Work<'a> {
    /// Folder of the bundle.
    pub(super) folder: &'a Path,
    /// Folder for new files.
    pub(super) unfinished: &'a Path,
    pub(super) leftover: Leftover,
    /// Hash of the scene.
    pub(super) hash: u128,
    /// The spheres of the objects that ask for some, in their order.
    pub(super) sphere_sets: &'a [SphereSetSummary],
    /// For progress and interruption.
    pub job: &'a Job,
}

impl Work<'_> {
    /// The log of `method`, empty or with what an interrupted bake left. `key` tells everything besides the scene that its pieces depend on.
    ///
    /// # Errors
    /// If what is there belongs to another bake, or the file cannot be opened.
    pub fn open_log(&self, method: &str, key: &str) -> Result<WorkLog> {
        let path = self.unfinished.join(log_name(method));
        let key = xxhash_rust::xxh3::xxh3_128(format!("{:032x} {key}", self.hash).as_bytes());
        if self.leftover != Leftover::Resume || !WorkLog::exists(&path) {
            return Ok(WorkLog::create(&path, key)?);
        }
        let reason = "holds an unfinished bake of another scene or other settings; add --force to start again";
        WorkLog::reopen(&path, key)?.ok_or_else(|| BakeError::invalid(&Place::file(self.unfinished), reason))
    }

    /// The sphere sets of the objects that ask for some, in their order.
    ///
    /// # Errors
    /// If one cannot be read back.
    pub fn sphere_sets(&self) -> Result<Vec<SphereSet>> {
        let read = |summary: &SphereSetSummary| {
            let file = &summary.entry.file.file;
            // What is reused stands in the bundle already.
            let [new, old] = [self.unfinished, self.folder].map(|folder| folder.join(file));
            Ok(SphereSet::read_file(if new.exists() { &new } else { &old })?)
        };
        self.sphere_sets.iter().map(read).collect()
    }

    /// Writes a file of the bundle.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn write(&self, content: &impl Stored, file: &str) -> Result<FileEntry> {
        write_entry(content, self.unfinished, file)
    }
}

/// Beginning of what the logs of sphere sets are called. Any bake of the scene goes on with them.
const SPHERES: &str = "spheres-";

/// Name of the log of finished pieces of a method, or of whatever else is called so.
pub(super) fn log_name(of: &str) -> String {
    format!("{of}.log")
}

/// Whether a log belongs to a bake by the methods called `names`.
fn is_own_log(file: &str, names: &[&str]) -> bool {
    file.starts_with(SPHERES) || names.iter().any(|name| log_name(name) == file)
}

/// Files in `folder` by name, for those whose name is text.
fn files(folder: &Path) -> Vec<(String, PathBuf)> {
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    entries.filter_map(|entry| Some((entry.file_name().into_string().ok()?, entry.path()))).collect()
}

fn has_extension(path: &Path, extension: &str) -> bool {
    path.extension() == Some(OsStr::new(extension))
}

/// Whether the bundle in `folder` has unfinished work of the methods called `names`, or of sphere sets.
pub(super) fn holds_work(folder: &Path, names: &[&str]) -> bool {
    let is_work = |(name, path): &(String, PathBuf)| has_extension(path, "log") && is_own_log(name, names) && WorkLog::exists(path);
    files(&folder.join(UNFINISHED)).iter().any(is_work)
}

/// Takes away what a bake by the methods called `names` left in the folder of unfinished work. Work of other methods stays, and what is not ours.
///
/// # Errors
/// If a file cannot be removed.
pub(super) fn tidy(folder: &Path, names: &[&str]) -> Result<()> {
    let is_published = folder.join(MANIFEST).exists();
    for (name, path) in files(&folder.join(UNFINISHED)) {
        let is_ours = match path.extension().and_then(OsStr::to_str) {
            Some("log") => is_own_log(&name, names) || !WorkLog::exists(&path),
            Some("relume") => true,
            // An older bundle's, put aside: nothing to go back to as soon as there is a newer one.
            _ if name == MANIFEST => is_published,
            _ => is_partial(&name),
        };
        if is_ours && name != lock::FILE_NAME {
            std::fs::remove_file(&path).map_err(|e| Error::output(&Place::file(&path), e))?;
        }
    }
    Ok(())
}

/// Takes away what a kill in the middle of writing left beside the files of the bundle in `folder`.
pub(super) fn sweep_partial(folder: &Path) {
    for (_, path) in files(folder).into_iter().filter(|(name, _)| is_partial(name)) {
        // In nobody's way if it cannot be removed.
        let _ = std::fs::remove_file(path);
    }
}

/// Whether a file is called as [`relume_formats::container::replace_file`] calls what is not whole yet.
fn is_partial(name: &str) -> bool {
    let number = name.rsplit_once(".partial-").map(|(_, number)| number);
    number.is_some_and(|number| !number.is_empty() && number.chars().all(|c| c.is_ascii_digit()))
}

/// Writes a file of a bundle into `folder`, and reads it back: what its readers would refuse is no file of a bundle.
///
/// # Errors
/// If it cannot be written, is called as no file may be, or would be refused.
pub(super) fn write_entry<S: Stored>(content: &S, folder: &Path, file: &str) -> Result<FileEntry> {
    let path = folder.join(file);
    let place = Place::file(&path);
    if !is_plain_name(file) {
        return Err(BakeError::invalid(&place, "is no plain file name of a-z A-Z 0-9 . _ - and blanks; rename what it is called after"));
    }
    let bytes = content.write_file(&path)?;
    match S::read_file(&path) {
        Ok(_) => Ok(FileEntry::of(file, &bytes)),
        Err(error) if error.is_bad_input() => {
            Err(BakeError::invalid(&place, format!("its readers would refuse it ({error}); change what of the scene it says")))
        }
        Err(error) => Err(error.into()),
    }
}
