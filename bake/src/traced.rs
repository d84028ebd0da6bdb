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
