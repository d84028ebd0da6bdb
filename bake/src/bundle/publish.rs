//! From finished files to a bundle that plays, and what of an older bundle serves again.

use crate::error::{BakeError, Result};
use crate::job::note;
use crate::method::Method;
use crate::unfinished::{Leftover, Work};
use relume_formats::container::{self, Header};
use relume_formats::kinds::manifest::{self, FileEntry, Manifest, MethodEntry, content_hash};
use relume_formats::{Error, Place, read_regular};
use relume_scenes::Scene;
use std::collections::HashSet;
use std::path::Path;

/// The manifest of the bundle that `folder` holds already, if `scene` may replace it.
///
/// # Errors
/// `Invalid` if it is of another scene, or no bundle's, and nothing is to be thrown away.
pub(super) fn old_manifest(
    folder: &Path,
    unfinished: &Path,
    scene: &Scene,
    leftover: Leftover,
) -> Result<Option<Manifest>> {
    // A kill in the middle of publishing leaves the old manifest where publishing had put it aside.
    let Some(holder) =
        [folder, unfinished].into_iter().find(|folder| folder.join(manifest::FILE_NAME).exists())
    else {
        return Ok(None);
    };
    let read = Manifest::read(holder);
    let refuse = |what: String| {
        let reason = format!("holds {what}; add --force to replace it, or bake elsewhere with -o");
        Err(BakeError::invalid(&Place::file(folder), reason))
    };
    match read {
        read if leftover == Leftover::Discard => Ok(read.ok()),
        Ok(old) if old.scene != scene.name => refuse(format!("a bundle of scene `{}`", old.scene)),
        Ok(old) => Ok(Some(old)),
        Err(error @ Error::Unsupported { .. }) => {
            note(&format!("note: replaces a bundle of another version ({error})"));
            Ok(None)
        }
        Err(error) if error.is_bad_input() => {
            refuse(format!("a {} that is no bundle's ({error})", manifest::FILE_NAME))
        }
        Err(error) => Err(error.into()),
    }
}

/// The method's entry of a finished bundle if all that it `reads` of the scene and its settings are the same,
/// and its files are whole and of today's versions.
pub(super) fn reusable_entry(
    old: &Manifest,
    folder: &Path,
    reads: &str,
    method: &dyn Method,
) -> Option<MethodEntry> {
    let entry = old.methods.iter().find(|m| m.name == method.name())?;
    let mut asked = method.asked_for();
    for (name, chosen) in method.chosen().iter().filter_map(|name| entry.settings.get_key_value(*name)) {
        // Chosen by error then, and so it would be again.
        asked.entry(name.clone()).or_insert_with(|| chosen.clone());
    }
    let same = entry.reads == reads && entry.settings == asked;
    (same && entry.files.iter().all(|(_, file)| is_readable(file, folder))).then(|| entry.clone())
}

/// Whether the file is whole and of today's version.
pub(super) fn is_readable(file: &FileEntry, folder: &Path) -> bool {
    let whole = || {
        read_regular(&folder.join(&file.file), file.bytes, "")
            .is_ok_and(|bytes| content_hash(&bytes) == file.hash)
    };
    let current = |header: &Header| header.kind_version == header.kind.current_version();
    container::open(&folder.join(&file.file)).is_ok_and(|reader| current(reader.header())) && whole()
}

/// Moves the new files of `work` into place and names them in the manifest. The old manifest is put aside
/// before that, so nobody takes a mixture of old and new files for a bundle. Nothing is lost in between: the
/// logs, or the images that the old manifest names, are still there.
pub(super) fn publish(manifest: &Manifest, old: Option<&Manifest>, work: &Work<'_>) -> Result<()> {
    let Work { unfinished, folder, .. } = *work;
    let io = |path: &Path| {
        let place = Place::file(path);
        move |e| Error::output(&place, e)
    };
    let old_manifest = folder.join(manifest::FILE_NAME);
    manifest.validate(&Place::file(&old_manifest))?;
    // Logs first: from then on the next bake, whichever it is, finds what was traced and nothing unfinished.
    work.keep_logs()?;
    if old_manifest.exists() {
        std::fs::rename(&old_manifest, unfinished.join(manifest::FILE_NAME)).map_err(io(&old_manifest))?;
    }
    for entry in manifest.entries() {
        let (from, to) = (unfinished.join(&entry.file), folder.join(&entry.file));
        // What is reused stands there already.
        if from.exists() {
            std::fs::rename(&from, &to).map_err(io(&to))?;
        }
    }
    manifest.write(folder)?;
    let listed: HashSet<&str> = manifest.entries().map(|e| e.file.as_str()).collect();
    for stale in old.iter().flat_map(|old| old.entries()).filter(|e| !listed.contains(e.file.as_str())) {
        // Out of date but harmless: nothing names it any more.
        let _ = std::fs::remove_file(folder.join(&stale.file));
    }
    Ok(())
}
