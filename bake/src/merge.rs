//! Bakes over many machines: what was asked of each, and the pieces of all brought together.

use crate::bundle::{FolderLock, PART, UNFINISHED};
use crate::error::{BakeError, Result};
use crate::methods::choice::Asked;
use crate::output::files;
use crate::stage::Share;
use crate::work_log::WorkLog;
use relume_formats::container::replace_file;
use relume_formats::{Error, Place, read_regular};
use relume_scenes::Scene;
use serde::{Deserialize, Serialize};
use std::ffi::OsStr;
use std::path::{Path, PathBuf};

/// More bytes than what a part was asked for takes.
const MAX_BYTES: u64 = 1 << 20;

/// What a part of a bake was asked for.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Part {
    /// The file of the scene, from the root on.
    pub scene: PathBuf,
    /// Names of the methods, in their order.
    pub methods: Vec<String>,
    /// Everything else.
    pub asked: Asked,
    /// Which pieces.
    pub share: Share,
    /// Whether all of them are there.
    pub done: bool,
}

impl Part {
    /// What is asked of `scene` here.
    pub fn new(scene: &Scene, methods: &[&str], asked: &Asked, share: Share) -> Self {
        let path = std::path::absolute(&scene.file).unwrap_or_else(|_| scene.file.clone());
        Self { scene: path, methods: methods.iter().map(|name| (*name).to_owned()).collect(), asked: *asked, share, done: false }
    }

    /// Writes it into the `folder` of the part.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn write(&self, folder: &Path) -> Result<()> {
        let path = folder.join(UNFINISHED).join(PART);
        let text = serde_json::to_string_pretty(self).map_err(|e| Error::invalid(&Place::file(&path), e.to_string()))?;
        Ok(replace_file(&path, (text + "\n").as_bytes())?)
    }

    /// What was asked in `folder`.
    fn read(folder: &Path) -> Result<Self> {
        let path = folder.join(UNFINISHED).join(PART);
        let place = Place::file(&path);
        if !path.exists() {
            let reason = "holds no part of a bake; make one with `bake run SCENE --pieces I/N -o DIR`";
            return Err(BakeError::invalid(&Place::file(folder), reason));
        }
        let bytes = read_regular(&path, MAX_BYTES, "; bake that part again")?;
        serde_json::from_slice(&bytes).map_err(|_| BakeError::invalid(&place, "is damaged or of another version; bake that part again"))
    }

    /// Whether the other is a part of the same bake.
    fn is_of(&self, other: &Self) -> bool {
        let whole = |part: &Self| Self { share: Share { number: 1, ..part.share }, done: true, ..part.clone() };
        whole(self) == whole(other)
    }
}

/// What the parts in `folders` were asked for: all parts of one bake, and each of them done.
///
/// # Errors
/// `Invalid` with the first that is missing, unfinished or of another bake.
pub fn expect_all(folders: &[PathBuf]) -> Result<Part> {
    let mut parts = folders.iter().map(|folder| Ok((folder, Part::read(folder)?))).collect::<Result<Vec<_>>>()?;
    parts.sort_by_key(|(_, part)| part.share.number);
    let Some((first, one)) = parts.first() else { return Err(BakeError::invalid(&Place::file("DIR"), "is missing; name the folders")) };
    for (folder, part) in &parts {
        let refuse = |reason: String| Err(BakeError::invalid(&Place::file(folder), reason));
        if !part.is_of(one) {
            return refuse(format!("is a part of another bake than {}; give parts of one scene with one set of options", first.display()));
        }
        let Share { number, of } = part.share;
        if !part.done {
            return refuse(format!("its pieces {number}/{of} are not finished; go on with --resume there"));
        }
        if let Some((other, _)) = parts.iter().find(|(other, two)| other != folder && two.share == part.share) {
            return refuse(format!("has the pieces {number}/{of}, as has {}; give each part once", other.display()));
        }
    }
    let of = one.share.of;
    match (1..=of)
        .zip(parts.iter().map(|(_, part)| Some(part.share.number)).chain(std::iter::repeat(None)))
        .find(|(n, got)| Some(*n) != *got)
    {
        Some((missing, _)) => {
            let reason =
                format!("the pieces {missing}/{of} are missing; bake them with --pieces {missing}/{of} and name their folder, too");
            Err(BakeError::invalid(&Place::file(first), reason))
        }
        None => Ok(one.clone()),
    }
}

/// Brings the pieces of `folders` together as the unfinished work of `output`, for a bake that goes on with them. Nobody else works in any of them
/// meanwhile.
///
/// # Errors
/// If a log cannot be read or written, or belongs to another bake.
pub fn gather(folders: &[PathBuf], output: &Path) -> Result<()> {
    let _lock = FolderLock::take(output)?;
    for folder in folders {
        let place = Place::file(folder);
        if std::fs::canonicalize(folder).ok() == std::fs::canonicalize(output).ok() {
            return Err(BakeError::invalid(&place, "is a part and cannot be the bundle, too; name another folder with -o"));
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
