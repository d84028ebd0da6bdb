//! Which bake of a bundle is played, and whether another one has taken its place on disk.

use crate::error::Result;
use relume_formats::kinds::manifest::{FILE_NAME, Manifest};
use relume_formats::{Error as FormatError, Place};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::SystemTime;

/// One bake of a bundle: its folder, and its manifest, which names every file by its hash.
#[derive(Debug, Clone)]
pub struct Edition {
    folder: PathBuf,
    manifest: Arc<Manifest>,
}

impl Edition {
    /// The bake that `folder` holds now.
    ///
    /// # Errors
    /// Those of [`Manifest::read`].
    pub fn read(folder: &Path) -> Result<Self> {
        Ok(Self { folder: folder.to_owned(), manifest: Arc::new(Manifest::read(folder)?) })
    }

    /// Its manifest.
    pub fn manifest(&self) -> &Manifest {
        &self.manifest
    }

    /// The file of the manifest.
    pub fn place(&self) -> Place {
        Place::file(self.folder.join(FILE_NAME))
    }

    /// What shows without reading that the manifest may have been replaced: when it was written, and its
    /// length. `None` if it is not there.
    pub(crate) fn stamp(&self) -> Option<(SystemTime, u64)> {
        let metadata = self.folder.join(FILE_NAME).metadata().ok()?;
        Some((metadata.modified().ok()?, metadata.len()))
    }

    /// Whether another bake is in its place. A bundle that is gone, or that cannot be read, is none.
    pub fn is_replaced(&self) -> bool {
        match Manifest::read(&self.folder) {
            Ok(now) => now != *self.manifest,
            Err(error) => matches!(error, FormatError::Unsupported { .. }),
        }
    }

    /// Fails unless this bake is still there. A file that was opened before is then one of its own: bakes
    /// exchange files only while the manifest is away.
    pub(super) fn expect_there(&self) -> relume_formats::Result<()> {
        if Manifest::read(&self.folder).is_ok_and(|now| now == *self.manifest) {
            return Ok(());
        }
        let reason = "is another one by now: the bundle was baked again while it was read; play it again";
        Err(FormatError::invalid(&self.place(), reason))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::support::Bundle;

    #[test]
    fn another_bake_is_told_from_the_same_one_written_again() {
        let bundle = Bundle::write(true);
        let edition = Edition::read(bundle.folder()).unwrap();
        bundle.manifest.write(bundle.folder()).unwrap();
        assert!(!edition.is_replaced(), "the same bytes");
        edition.expect_there().unwrap();
        let mut other = bundle.manifest.clone();
        other.scene_hash = "1".repeat(32);
        other.write(bundle.folder()).unwrap();
        assert!(edition.is_replaced());
        assert!(edition.expect_there().unwrap_err().to_string().contains("baked again while it was read"));
        std::fs::remove_file(bundle.folder().join(FILE_NAME)).unwrap();
        assert!(!edition.is_replaced() && edition.stamp().is_none(), "gone, and not replaced");
        edition.expect_there().unwrap_err();
    }
}
