//! Bakes over many machines: the pieces of all brought together.

use crate::error::{BakeError, Result};
use crate::output::files;
use crate::shard::Shard;
use crate::stage::Share;
use crate::unfinished::FolderLock;
use crate::unfinished::names::UNFINISHED;
use crate::work_log::WorkLog;
use relume_formats::Place;
use std::ffi::OsStr;
use std::path::{Path, PathBuf};

/// What the shards in `folders` were asked for: all shards of one bake, and each of them done.
///
/// # Errors
/// `Invalid` with the first that is missing, unfinished or of another bake.
pub fn expect_all(folders: &[PathBuf]) -> Result<Shard> {
    let mut shards =
        folders.iter().map(|folder| Ok((folder, Shard::read(folder)?))).collect::<Result<Vec<_>>>()?;
    shards.sort_by_key(|(_, shard)| shard.share.number);
    let Some((first, one)) = shards.first() else {
        return Err(BakeError::invalid(&Place::file("DIR"), "is missing; name the folders"));
    };
    for (folder, shard) in &shards {
        let refuse = |reason: String| Err(BakeError::invalid(&Place::file(folder), reason));
        if !shard.is_of(one) {
            return refuse(format!(
                "is a part of another bake than {}; give parts of one scene with one set of options",
                first.display()
            ));
        }
        let Share { number, of } = shard.share;
        if !shard.done {
            return refuse(format!("its pieces {number}/{of} are not finished; go on with --resume there"));
        }
        // The very entry, not its path: one folder may be named twice.
        if let Some((other, _)) =
            shards.iter().find(|(other, two)| !std::ptr::eq(*other, *folder) && two.share == shard.share)
        {
            return refuse(format!(
                "has the pieces {number}/{of}, as has {}; give each part once",
                other.display()
            ));
        }
    }
    let of = one.share.of;
    match (1..=of)
        .zip(shards.iter().map(|(_, shard)| Some(shard.share.number)).chain(std::iter::repeat(None)))
        .find(|(n, got)| Some(*n) != *got)
    {
        Some((missing, _)) => {
            let reason = format!(
                "the pieces {missing}/{of} are missing; bake them with --pieces {missing}/{of} and name their folder, too"
            );
            Err(BakeError::invalid(&Place::file(first), reason))
        }
        // Where the scene is on this machine, of all the places where parts were baked from.
        None => Ok(shards
            .iter()
            .map(|(_, shard)| shard)
            .find(|shard| Path::new(&shard.scene).exists())
            .unwrap_or(one)
            .clone()),
    }
}

/// Brings the pieces of `folders` together as the unfinished work of `output`, for a bake that goes on with
/// them. Nobody else works in any of them meanwhile.
///
/// # Errors
/// If a log cannot be read or written, or belongs to another bake.
pub fn gather(folders: &[PathBuf], output: &Path) -> Result<()> {
    let _lock = FolderLock::take(output)?;
    for folder in folders {
        let place = Place::file(folder);
        if std::fs::canonicalize(folder).ok() == std::fs::canonicalize(output).ok() {
            return Err(BakeError::invalid(
                &place,
                "is a part and cannot be the bundle, too; name another folder with -o",
            ));
        }
        let _lock = FolderLock::take(folder)?;
        for (name, path) in files(&folder.join(UNFINISHED)) {
            if path.extension() == Some(OsStr::new("log")) && WorkLog::holds_pieces(&path) {
                WorkLog::absorb(&output.join(UNFINISHED).join(name), &path)?;
            }
        }
    }
    Ok(())
}
