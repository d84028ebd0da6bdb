//! Which files of a bundle are played, and in which order.
//!
//! The scene comes first, then the animations, which are small, and without which not even the first frame is known, then the sphere sets, if the method
//! plays with them, then the files of the method in the order of the manifest, the one that arrives piece by piece last.

use super::throttle::{Pace, Throttle};
use crate::error::{Error, Result};
use crate::methods::{METHODS, Method};
use relume_formats::bundle::Settings;
use relume_formats::container::{Kind, Reader, open};
use relume_formats::kinds::manifest::{FILE_NAME, FileEntry, Manifest, MethodEntry};
use relume_formats::near::did_you_mean;
use relume_formats::{Error as FormatError, Place, open_regular};
use std::fs::File;
use std::path::{Path, PathBuf};

/// One file to play.
#[derive(Debug, Clone)]
pub struct Item {
    /// Where it is.
    pub path: PathBuf,
    /// What the manifest says it holds.
    pub kind: Kind,
    /// What the manifest calls that which it holds, or the object that it is of; `None` for files of a method.
    pub name: Option<String>,
    /// How long the manifest says it is.
    pub bytes: u64,
    /// Its hash, as the manifest has it.
    pub hash: String,
}

/// The files to play, in playback order.
#[derive(Clone)]
pub struct Playlist {
    /// The files.
    pub items: Vec<Item>,
    /// The method that plays them.
    pub method: Method,
    /// What the manifest says of the method's settings.
    pub settings: Settings,
    /// All methods of the bundle that are known.
    pub known: Vec<Method>,
}

impl Playlist {
    /// The playlist of the bundle in `folder`: for the method called `method`, or the first in the manifest that this player knows, with all
    /// animations, the one called `first` in front.
    pub fn of(folder: &Path, method: Option<&str>, first: Option<&str>) -> Result<Self> {
        let manifest = Manifest::read(folder)?;
        let place = Place::file(folder.join(FILE_NAME));
        let (method, entry) = choose(&manifest, method, folder)?;
        method.card.expect_files(&entry.files, &place.part(format!("method `{}`", entry.name)))?;
        let item = |kind, entry: &FileEntry| Item {
            path: folder.join(&entry.file),
            kind,
            name: None,
            bytes: entry.bytes,
            hash: entry.hash.clone(),
        };
        let named = |name: &str, kind, entry: &FileEntry| Item { name: Some(name.to_owned()), ..item(kind, entry) };
        let mut items = vec![named(&manifest.scene, Kind::Scene, &manifest.scene_file)];
        if let Some(name) = first {
            items.push(named(name, Kind::Animation, animation_entry(&manifest, name)?));
        }
        let others = manifest.animations.iter().filter(|(name, _)| Some(name.as_str()) != first);
        items.extend(others.map(|(name, entry)| named(name, Kind::Animation, entry)));
        if method.card.sphere_sets {
            let sets = manifest.sphere_sets.iter();
            items.extend(sets.map(|(object, set)| named(object, Kind::SphereSet, &set.file)));
        }
        for (kind, entry) in &entry.files {
            let kind = Kind::find(kind)
                .ok_or_else(|| FormatError::unsupported(&place, format!("kind `{kind}` is unknown to this player; use a newer one")))?;
            items.push(item(kind, entry));
        }
        let known = manifest.methods.iter().filter_map(|entry| Method::find(&entry.name)).collect();
        Ok(Self { items, method, settings: Settings::of(entry, &manifest, &place), known })
    }

    /// Length of the shortest prefix that shows anything: every small file, and the main one up to its first piece.
    pub fn least_bytes(&self) -> Result<u64> {
        let (mut start, mut needed) = (0, 0);
        for item in &self.items {
            needed = start + item.least_bytes(self.method)?;
            start += item.bytes;
        }
        Ok(needed)
    }
}

/// The method called `name`, which must be known, or the first that is.
fn choose<'a>(manifest: &'a Manifest, name: Option<&str>, folder: &Path) -> Result<(Method, &'a MethodEntry)> {
    let entries = match name {
        Some(name) => std::slice::from_ref(manifest.method(Some(name), folder)?),
        None => &manifest.methods,
    };
    entries.iter().find_map(|entry| Some((Method::find(&entry.name)?, entry))).ok_or_else(|| {
        let there: Vec<_> = entries.iter().map(|entry| format!("`{}`", entry.name)).collect();
        let known: Vec<_> = METHODS.iter().map(|method| method.card.name).collect();
        let reason = format!("method {} is unknown to this player, which plays {}", there.join(", "), known.join(", "));
        FormatError::unsupported(&Place::file(folder.join(FILE_NAME)), reason).into()
    })
}

fn animation_entry<'a>(manifest: &'a Manifest, name: &str) -> Result<&'a FileEntry> {
    manifest.animations.get(name).ok_or_else(|| {
        let there: Vec<_> = manifest.animations.keys().map(String::as_str).collect();
        let there = if there.is_empty() { "none".to_owned() } else { there.join(", ") };
        let meant = did_you_mean(name, manifest.animations.keys().map(String::as_str));
        Error::Usage(format!("no animation `{name}`; this bundle has: {there} (a file must end in .toml){meant}"))
    })
}

impl Item {
    /// Opens the file, which must be as long and of the kind that the manifest says.
    pub(super) fn open<'a>(&self, pace: &'a mut Pace) -> relume_formats::Result<Reader<Throttle<'a, File>>> {
        let place = Place::file(&self.path);
        let file = open_regular(&self.path)?;
        let length = file.metadata().map_err(|e| FormatError::io(&place, e))?.len();
        if length != self.bytes {
            let reason =
                format!("has {length} bytes where {FILE_NAME} says {}; it is cut short or of another bake, bake it again", self.bytes);
            return Err(FormatError::invalid(&place, reason));
        }
        let reader = Reader::new(Throttle::new(file, pace), length, place.clone())?;
        reader.header().expect_kind(self.kind, self.kind.current_version(), &place)?;
        if reader.header().sections.is_empty() {
            return Err(FormatError::invalid(&place, "holds no sections; bake it again"));
        }
        Ok(reader)
    }

    /// Fails unless the file, of which all has been read, is the one that the manifest lists.
    pub(super) fn expect_hash<R: std::io::Read>(&self, read: &Reader<Throttle<'_, R>>) -> relume_formats::Result<()> {
        if read.input().hash() == self.hash {
            return Ok(());
        }
        let reason = format!("its hash is not the one in {FILE_NAME}; the file was changed, bake it again");
        Err(FormatError::invalid(&Place::file(&self.path), reason))
    }

    fn least_bytes(&self, method: Method) -> Result<u64> {
        if Some(self.kind) != method.card.main() {
            return Ok(self.bytes);
        }
        let reader = open(&self.path)?;
        let last_needed = reader.header().sections.get(method.card.first_piece);
        Ok(last_needed.map_or(self.bytes, |info| info.offset + info.stored_bytes))
    }
}
