//! Logs of stages that are done, kept in a folder of the bundle that was made of them: a further environment
//! map or other terms then trace nothing. No manifest names them and no player reads them; without them a bake
//! takes longer and makes the same bytes.

use crate::error::{BakeError, Result};
use crate::output::{create_folder, files};
use crate::stage::Stage;
use crate::unfinished::names::{log_name, stage_of};
use crate::work_log::WorkLog;
use relume_formats::{Error, Place};
use std::path::{Path, PathBuf};

/// The folder, within that of the bundle.
const TRACED: &str = "traced";

/// Where the logs of the bundle in `folder` are.
pub(crate) fn folder_of(folder: &Path) -> PathBuf {
    folder.join(TRACED)
}

/// Fails if anything but a folder stands where the logs of the bundle in `folder` go; better now than after
/// hours of tracing.
pub(crate) fn expect_folder(folder: &Path) -> Result<()> {
    let path = folder_of(folder);
    let refuse = |reason: &str| Err(BakeError::invalid(&Place::file(&path), reason));
    match path {
        _ if path.is_symlink() => refuse("is a link, so that logs would be kept elsewhere; remove it"),
        _ if path.exists() && !path.is_dir() => {
            refuse("is a file where a bake keeps a folder; move it away, or bake elsewhere with -o")
        }
        _ => Ok(()),
    }
}

/// The log that an earlier bake into `folder` has kept of `stage`, if it is of this very work, has all pieces
/// and each of them is whole. Nothing is ever added to it.
pub(crate) fn log(folder: &Path, stage: &dyn Stage) -> Option<WorkLog> {
    let log = WorkLog::read_only(&folder_of(folder).join(log_name(&stage.name())), stage.key())?;
    (stage.keeps_log() && log.has_all(stage.pieces())).then_some(log)
}

/// Moves the finished logs of `stages` out of `unfinished` to those of the bundle in `folder`, in the place of
/// older ones. After each move both a bake that goes on and one that begins find all that was traced.
pub(crate) fn keep<'a>(
    folder: &Path,
    unfinished: &Path,
    stages: impl IntoIterator<Item = &'a String>,
) -> Result<()> {
    for stage in stages {
        let (from, to) = (unfinished.join(log_name(stage)), folder_of(folder).join(log_name(stage)));
        // What was kept before and served again is there already.
        if from.exists() {
            create_folder(&folder_of(folder))?;
            std::fs::rename(&from, &to).map_err(|e| Error::output(&Place::file(&to), e))?;
        }
    }
    Ok(())
}

/// Takes away the logs of the bundle in `folder` that are of no stage that `is_current`, and the folder if
/// nothing is left in it.
pub(crate) fn tidy(folder: &Path, is_current: impl Fn(&str) -> bool) {
    for (name, path) in files(&folder_of(folder)) {
        if stage_of(&name).is_some_and(|stage| !is_current(stage)) {
            // Out of date but harmless: its key says of what it is.
            let _ = std::fs::remove_file(path);
        }
    }
    let _ = std::fs::remove_dir(folder_of(folder));
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Pieces that say their number, under a key.
    struct Numbers {
        key: u128,
        pieces: u32,
        is_kept: bool,
    }

    impl Stage for Numbers {
        fn name(&self) -> String {
            "numbers".to_owned()
        }

        fn label(&self) -> Option<&'static str> {
            None
        }

        fn key(&self) -> u128 {
            self.key
        }

        fn pieces(&self) -> u32 {
            self.pieces
        }

        fn piece(&self, number: u32) -> Result<Vec<u8>> {
            Ok(vec![number as u8; 5 + number as usize])
        }

        fn keeps_log(&self) -> bool {
            self.is_kept
        }
    }

    const NUMBERS: Numbers = Numbers { key: 7, pieces: 3, is_kept: true };

    /// A bundle's folder with a whole log of `NUMBERS`.
    fn kept() -> tempfile::TempDir {
        let folder = tempfile::tempdir().unwrap();
        let unfinished = folder.path().join("unfinished");
        std::fs::create_dir(&unfinished).unwrap();
        let made = WorkLog::create(&unfinished.join("numbers.log"), NUMBERS.key).unwrap();
        [2, 0, 1].into_iter().for_each(|n| made.append(n, &NUMBERS.piece(n).unwrap()).unwrap());
        keep(folder.path(), &unfinished, &["numbers".to_owned(), "not there".to_owned()]).unwrap();
        assert!(files(&unfinished).is_empty());
        folder
    }

    #[test]
    fn a_log_serves_if_it_is_the_very_one_and_whole() {
        let folder = kept();
        let found = log(folder.path(), &NUMBERS).unwrap();
        (0..3).for_each(|n| assert_eq!(found.read(n).unwrap(), NUMBERS.piece(n).unwrap()));
        assert!(found.append(3, &[1]).is_err(), "nothing is added");
        for other in [
            Numbers { key: 8, ..NUMBERS },
            Numbers { pieces: 4, ..NUMBERS },
            Numbers { is_kept: false, ..NUMBERS },
        ] {
            assert!(log(folder.path(), &other).is_none());
        }
        let path = folder_of(folder.path()).join("numbers.log");
        let whole = std::fs::read(&path).unwrap();
        for at in 0..whole.len() {
            let mut damaged = whole.clone();
            damaged[at] ^= 1 << (at % 8);
            std::fs::write(&path, &damaged).unwrap();
            assert!(log(folder.path(), &NUMBERS).is_none(), "byte {at}");
            std::fs::write(&path, &whole[..at]).unwrap();
            assert!(log(folder.path(), &NUMBERS).is_none(), "cut at {at}");
        }
        std::fs::write(&path, &whole).unwrap();
        assert!(log(folder.path(), &NUMBERS).is_some());
        std::fs::remove_file(&path).unwrap();
        assert!(log(folder.path(), &NUMBERS).is_none());
    }

    #[test]
    fn what_is_out_of_date_goes_and_what_is_not_ours_stays() {
        let folder = kept();
        let here = folder_of(folder.path());
        std::fs::write(here.join("notes.txt"), "").unwrap();
        std::fs::write(here.join("old.log"), "").unwrap();
        tidy(folder.path(), |stage| stage == "numbers");
        assert!(here.join("numbers.log").exists() && !here.join("old.log").exists());
        tidy(folder.path(), |_| false);
        assert!(!here.join("numbers.log").exists() && here.join("notes.txt").exists());
        std::fs::remove_file(here.join("notes.txt")).unwrap();
        tidy(folder.path(), |_| false);
        assert!(!here.exists());
        tidy(folder.path(), |_| false);
    }
}
