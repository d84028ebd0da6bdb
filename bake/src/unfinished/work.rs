//! Where methods work: the folder of what is not finished yet, the logs and the new files in it.

use super::names::{LOCK, SHARD, UNFINISHED, log_name};
use crate::error::{BakeError, Result};
use crate::job::Job;
use crate::output::{files, whole_name};
use crate::stage::{Share, Stage, Traced, fill, is_whole};
use crate::traced;
use crate::work_log::WorkLog;
use relume_formats::container::Stored;
use relume_formats::kinds::SphereSet;
use relume_formats::kinds::manifest::{FILE_NAME as MANIFEST, FileEntry, SphereSetEntry, is_plain_name};
use relume_formats::{Error, Place};
use std::collections::BTreeSet;
use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

/// What to do about work that an interrupted bake left.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Leftover {
    /// Refuse to touch it.
    Refuse,
    /// Go on with it.
    Resume,
    /// Throw it away, and finished work too.
    Discard,
}

/// Where a method works, and by what rules.
#[derive(Clone, Copy)]
pub struct Work<'a> {
    /// Folder of the bundle.
    pub(crate) folder: &'a Path,
    /// Folder for new files.
    pub(crate) unfinished: &'a Path,
    pub(crate) leftover: Leftover,
    /// Which pieces are made here.
    pub(crate) share: Share,
    /// The spheres of the objects that ask for some, in their order, once all are there.
    pub(crate) sphere_sets: Option<&'a [SphereSetEntry]>,
    /// What was traced so far by the method at work.
    pub(crate) traced: &'a Mutex<Traced>,
    /// Names of the stages that were run so far and whose logs are kept.
    pub(crate) kept: &'a Mutex<BTreeSet<String>>,
    /// For progress and interruption.
    pub job: &'a Job,
}

impl Work<'_> {
    /// Makes the pieces of `stage` that are missing and fall to this bake; returns their log, which an earlier
    /// bake may have kept, or `None` if others make some of them.
    ///
    /// # Errors
    /// If what an interrupted bake left belongs to another, a piece fails, or the user asks to stop; finished
    /// pieces stay in the log.
    pub fn run(&self, stage: &dyn Stage) -> Result<Option<WorkLog>> {
        let log = self.open_log(stage)?;
        let traced = fill(stage, &log, self.share, self.job)?;
        self.traced.lock().unwrap_or_else(PoisonError::into_inner).add(traced);
        if stage.keeps_log() {
            self.kept.lock().unwrap_or_else(PoisonError::into_inner).insert(stage.name());
        }
        Ok(is_whole(stage, &log).then_some(log))
    }

    /// The log of `stage`: with what an interrupted bake left, or whole as an earlier bake kept it, or empty.
    fn open_log(&self, stage: &dyn Stage) -> Result<WorkLog> {
        let path = self.unfinished.join(log_name(&stage.name()));
        if self.leftover != Leftover::Resume || !WorkLog::exists(&path) {
            // Parts bring their pieces in logs of their own.
            let may_reuse = self.leftover != Leftover::Discard && !self.share.is_part();
            let kept = may_reuse.then(|| traced::log(self.folder, stage)).flatten();
            return kept.map_or_else(|| Ok(WorkLog::create(&path, stage.key())?), Ok);
        }
        let reason = "holds an unfinished bake of another scene or other settings; remove this folder to drop that alone, or add --force to start all again";
        WorkLog::reopen(&path, stage.key())?
            .ok_or_else(|| BakeError::invalid(&Place::file(self.unfinished), reason))
    }

    /// What was traced since the last call.
    pub(crate) fn take_traced(&self) -> Traced {
        std::mem::take(&mut *self.traced.lock().unwrap_or_else(PoisonError::into_inner))
    }

    /// Moves the logs of the stages that were run, and are worth it, to those of the bundle.
    ///
    /// # Errors
    /// If one cannot be moved.
    pub(crate) fn keep_logs(&self) -> Result<()> {
        let kept = self.kept.lock().unwrap_or_else(PoisonError::into_inner);
        traced::keep(self.folder, self.unfinished, kept.iter())
    }

    /// Takes away what the bundle has kept of stages that were not run, but for the methods called `served`,
    /// whose finished files served again.
    pub(crate) fn tidy_kept(&self, served: &[&str]) {
        let kept = self.kept.lock().unwrap_or_else(PoisonError::into_inner);
        let is_served = |stage: &str| served.iter().any(|name| is_of_method(stage, name));
        traced::tidy(self.folder, |stage| kept.contains(stage) || is_served(stage));
    }

    /// The sphere sets of the objects that ask for some, in their order; `None` if others fit some of them.
    ///
    /// # Errors
    /// If one cannot be read back.
    pub fn sphere_sets(&self) -> Result<Option<Vec<SphereSet>>> {
        let read = |entry: &SphereSetEntry| {
            let file = &entry.file.file;
            // What is reused stands in the bundle already.
            let [new, old] = [self.unfinished, self.folder].map(|folder| folder.join(file));
            Ok(SphereSet::read_file(if new.exists() { &new } else { &old })?)
        };
        self.sphere_sets.map(|sets| sets.iter().map(read).collect()).transpose()
    }

    /// Writes a file of the bundle.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn write(&self, content: &impl Stored, file: &str) -> Result<FileEntry> {
        let _step = self.job.step("writing");
        write_entry(content, self.unfinished, file)
    }
}

/// Beginning of what the logs of sphere sets are called. Any bake of the scene goes on with them.
const SPHERES: &str = "spheres-";

/// Whether a log belongs to a bake by the methods called `names`.
fn is_own_log(file: &str, names: &[&str]) -> bool {
    file.starts_with(SPHERES) || names.iter().any(|name| is_of_method(file, name))
}

/// Whether a stage, or a log, is one of the method called `name`.
pub(crate) fn is_of_method(stage: &str, name: &str) -> bool {
    stage.strip_prefix(name).is_some_and(|rest| rest.is_empty() || rest.starts_with(['.', '-']))
}

fn has_extension(path: &Path, extension: &str) -> bool {
    path.extension() == Some(OsStr::new(extension))
}

/// Whether the bundle in `folder` has unfinished work of the methods called `names`, or of sphere sets.
pub fn holds_work(folder: &Path, names: &[&str]) -> bool {
    let is_work = |(name, path): &(String, PathBuf)| {
        has_extension(path, "log") && is_own_log(name, names) && WorkLog::holds_pieces(path)
    };
    files(&folder.join(UNFINISHED)).iter().any(is_work)
}

/// Whether there is work on any stage of the method called `name`.
pub(crate) fn has_logs(unfinished: &Path, name: &str) -> bool {
    let is_log = |(file, path): &(String, PathBuf)| {
        has_extension(path, "log") && is_of_method(file, name) && WorkLog::exists(path)
    };
    files(unfinished).iter().any(is_log)
}

/// Whether there is work on the pieces of `stage`.
pub(crate) fn has_log(unfinished: &Path, stage: &str) -> bool {
    WorkLog::exists(&unfinished.join(log_name(stage)))
}

/// Takes away what a bake by the methods called `names` left in the folder of unfinished work. Work of other
/// methods stays, and what is not ours.
///
/// # Errors
/// If a file cannot be removed.
pub(crate) fn tidy(folder: &Path, names: &[&str]) -> Result<()> {
    let is_published = folder.join(MANIFEST).exists();
    for (name, path) in files(&folder.join(UNFINISHED)) {
        let is_ours = match path.extension().and_then(OsStr::to_str) {
            Some("log") => is_own_log(&name, names) || !WorkLog::holds_pieces(&path),
            Some("relume") => true,
            _ if name == SHARD => true,
            // An older bundle's, put aside: nothing to go back to as soon as there is a newer one.
            _ if name == MANIFEST => is_published,
            _ => whole_name(&name).is_some(),
        };
        if is_ours && name != LOCK {
            std::fs::remove_file(&path).map_err(|e| Error::output(&Place::file(&path), e))?;
        }
    }
    Ok(())
}

/// Writes a file of a bundle into `folder`. What its readers would refuse is no file of a bundle.
///
/// # Errors
/// If it cannot be written, is called as no file may be, or would be refused.
pub(crate) fn write_entry<S: Stored>(content: &S, folder: &Path, file: &str) -> Result<FileEntry> {
    let path = folder.join(file);
    let place = Place::file(&path);
    if !is_plain_name(file) {
        return Err(BakeError::invalid(
            &place,
            "is no plain file name of a-z A-Z 0-9 . _ - and blanks; rename what it is called after",
        ));
    }
    // Its readers' own code checks the bytes before they are written.
    Ok(FileEntry::of(file, &content.write_file(&path)?))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::output::sweep_partial;
    use relume_formats::kinds::manifest::shape_file;
    use relume_formats::state::Animation;

    fn names(folder: &Path) -> Vec<String> {
        let mut names: Vec<String> = files(folder).into_iter().map(|(name, _)| name).collect();
        names.sort();
        names
    }

    #[test]
    fn what_a_bake_leaves_is_its_own_and_nothing_else() {
        let folder = tempfile::tempdir().unwrap();
        let unfinished = folder.path().join(UNFINISHED);
        std::fs::create_dir_all(unfinished.join("folder")).unwrap();
        // A key, and a piece of 4 bytes.
        let mut work = [0; 36];
        work[20] = 4;
        for file in [
            "a.log",
            "b.log",
            "spheres-x.log",
            "scene.relume",
            "scene.relume.partial-12",
            "lock",
            "manifest.json",
            "notes.txt",
        ] {
            std::fs::write(unfinished.join(file), work).unwrap();
        }
        std::fs::write(unfinished.join("empty.log"), [7; 3]).unwrap();
        assert!(
            holds_work(folder.path(), &["a"]) && holds_work(folder.path(), &[]),
            "the spheres are anybody's"
        );
        tidy(folder.path(), &["a"]).unwrap();
        // The manifest was put aside and is the only one.
        assert_eq!(names(&unfinished), ["b.log", "folder", "lock", "manifest.json", "notes.txt"]);
        assert!(!holds_work(folder.path(), &["a"]) && holds_work(folder.path(), &["b"]));
        std::fs::write(folder.path().join(MANIFEST), "{}").unwrap();
        std::fs::write(folder.path().join("manifest.json.partial-4711"), "{").unwrap();
        sweep_partial(folder.path(), |_| true);
        tidy(folder.path(), &["a", "b"]).unwrap();
        assert_eq!(
            (names(&unfinished), names(folder.path())),
            (
                vec!["folder".into(), "lock".into(), "notes.txt".into()],
                vec![MANIFEST.to_owned(), UNFINISHED.to_owned()]
            )
        );
    }

    #[test]
    fn files_are_written_inside_only_and_as_their_readers_take_them() {
        let folder = tempfile::tempdir().unwrap();
        let inner = folder.path().join("bundle");
        std::fs::create_dir_all(inner.join("shape-x")).unwrap();
        let text = "duration_s = 1.0\n[[key]]\nt_s = 0.0\nmaterials.a.shininess = 5.0\n";
        let mut animation = Animation::parse("a", text, &Place::file("a.toml")).unwrap();
        for file in ["shape-x/../../escaped.relume", "/tmp/escaped.relume", "..", "", "a/b.relume"] {
            let message = write_entry(&animation, &inner, file).unwrap_err().to_string();
            assert!(message.contains("is no plain file name"), "{message}");
        }
        write_entry(&animation, &inner, &shape_file("x/../../escaped")).unwrap();
        assert_eq!(names(folder.path()), ["bundle"]);
        animation.duration_s = -1.0;
        let error = write_entry(&animation, &inner, "a.relume").unwrap_err();
        assert!(error.exit_code() == 2 && error.to_string().contains("must be above 0"), "{error}");
    }
}
