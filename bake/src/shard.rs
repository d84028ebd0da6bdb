//! A shard of a bake: what one of many machines was asked for.

use crate::error::{BakeError, Result};
use crate::methods::asked::Asked;
use crate::scene_hash::scene_hash;
use crate::stage::Share;
use crate::unfinished::names::{SHARD, UNFINISHED};
use relume_formats::container::replace_file;
use relume_formats::kinds::manifest::FILE_NAME as MANIFEST;
use relume_formats::{Error, Place, read_regular};
use relume_scenes::Scene;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

/// More bytes than what a shard was asked for takes.
const MAX_BYTES: u64 = 1 << 20;

/// What a shard of a bake was asked for.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Shard {
    /// The file of the scene, from the root on.
    pub scene: PathBuf,
    /// [`scene_hash`] of the scene, hexadecimal.
    pub scene_hash: String,
    /// Names of the methods, in their order.
    pub methods: Vec<String>,
    /// Everything else.
    pub asked: Asked,
    /// Which pieces.
    pub share: Share,
    /// Whether all of them are there.
    pub done: bool,
}

impl Shard {
    /// What is asked of `scene` here.
    pub fn new(scene: &Scene, methods: &[&str], asked: &Asked, share: Share) -> Self {
        let path = std::path::absolute(&scene.file).unwrap_or_else(|_| scene.file.clone());
        let (scene_hash, methods) =
            (hash_text(scene), methods.iter().map(|name| (*name).to_owned()).collect());
        Self { scene: path, scene_hash, methods, asked: *asked, share, done: false }
    }

    /// Writes it into the `folder` of the shard.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn write(&self, folder: &Path) -> Result<()> {
        let path = folder.join(UNFINISHED).join(SHARD);
        let text = serde_json::to_string_pretty(self)
            .map_err(|e| Error::invalid(&Place::file(&path), e.to_string()))?;
        Ok(replace_file(&path, (text + "\n").as_bytes())?)
    }

    /// Fails unless `scene`, which was read again, is as it was when the pieces were made.
    ///
    /// # Errors
    /// `Invalid` with the remedy.
    pub fn expect_scene(&self, scene: &Scene) -> Result<()> {
        if hash_text(scene) == self.scene_hash {
            return Ok(());
        }
        let reason = "has changed since its parts were baked; restore it, or bake the parts again";
        Err(BakeError::invalid(&Place::file(&scene.file), reason))
    }

    /// Fails if `folder` is that of a bundle or of other pieces: each shard has a folder of its own.
    ///
    /// # Errors
    /// `Invalid` with the remedy.
    pub(crate) fn expect_own(&self, folder: &Path) -> Result<()> {
        if folder.join(MANIFEST).exists() {
            return Err(BakeError::invalid(
                &Place::file(folder),
                "holds a bundle; give each part a folder of its own with -o",
            ));
        }
        let Ok(other) = Self::read(folder) else { return Ok(()) };
        if other.share == self.share {
            return Ok(());
        }
        let Share { number, of } = other.share;
        let reason = format!("holds the pieces {number}/{of}; give each part a folder of its own with -o");
        Err(BakeError::invalid(&Place::file(folder), reason))
    }

    /// What was asked in `folder`.
    ///
    /// # Errors
    /// If nothing was, or what says so is damaged.
    pub(crate) fn read(folder: &Path) -> Result<Self> {
        let path = folder.join(UNFINISHED).join(SHARD);
        let place = Place::file(&path);
        if !path.exists() {
            let reason = "holds no part of a bake; make one with `bake run SCENE --pieces I/N -o DIR`";
            return Err(BakeError::invalid(&Place::file(folder), reason));
        }
        let bytes = read_regular(&path, MAX_BYTES, "; bake that part again")?;
        serde_json::from_slice(&bytes)
            .map_err(|_| BakeError::invalid(&place, "is damaged or of another version; bake that part again"))
    }

    /// Whether the other is a shard of the same bake, wherever its machine has the scene.
    pub(crate) fn is_of(&self, other: &Self) -> bool {
        let (share, scene) = (|shard: &Self| Share { number: 1, ..shard.share }, &other.scene);
        let whole =
            |shard: &Self| Self { share: share(shard), done: true, scene: scene.clone(), ..shard.clone() };
        whole(self) == whole(other)
    }
}

fn hash_text(scene: &Scene) -> String {
    format!("{:032x}", scene_hash(scene))
}
