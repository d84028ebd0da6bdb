//! `manifest.json`: what a bundle holds, in order of playback preference, and what it was made from.
//!
//! It is read strictly: a key is there once and known, hashes are 32 digits 0-9 a-f, settings are those of
//! their method and of their type, errors are from 0 to [`MAX_ERROR`] and medians not above the worst. What
//! settings say of files, the files say too (`relume_formats::bundle`).
//!
//! Only what follows from the scene, the settings and the seed stands here; timings and machines go to
//! `report.json`.

mod figures;
mod json;

pub use figures::MAX_ERROR;

use super::names::{fault_of_name, fault_of_names};
use crate::container::replace_file;
use crate::error::{Error, Place, Result};
use crate::name::{file_of, plain, shortened};
use crate::near::{did_you_mean, nearest_file};
use crate::regular::open_regular;
use crate::state::read_text;
use serde::Serialize;
use std::collections::{BTreeMap, HashMap};
use std::io::Read as _;
use std::path::Path;
use xxhash_rust::xxh3::Xxh3;

/// Name of the manifest within a bundle.
pub const FILE_NAME: &str = "manifest.json";
/// The one manifest version there is so far.
pub const VERSION: u32 = 0;
/// Most characters of what says on which states errors were measured: a line of some 120.
pub const MAX_MEASURED_ON_CHARS: usize = 1000;

/// The manifest of a bundle.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Manifest {
    /// [`VERSION`].
    pub version: u32,
    /// Name of the scene.
    pub scene: String,
    /// xxh3-128 of everything of the scene that results depend on, hexadecimal.
    pub scene_hash: String,
    /// The file of kind `scene`.
    pub scene_file: FileEntry,
    /// The files of kind `animation`, by name of the animation.
    pub animations: BTreeMap<String, FileEntry>,
    /// The files of kind `sphere-set`, by name of the object; none unless the scene asks for some.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub sphere_sets: BTreeMap<String, SphereSetEntry>,
    /// The methods that can play this bundle, the preferred one first.
    pub methods: Vec<MethodEntry>,
}

/// One file of a bundle.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct FileEntry {
    /// File name within the bundle.
    pub file: String,
    /// Length in bytes.
    pub bytes: u64,
    /// xxh3-128 of the file, hexadecimal.
    pub hash: String,
}

/// The spheres of one object, in world space.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SphereSetEntry {
    /// The file of kind `sphere-set`.
    pub file: FileEntry,
    /// The settings that change results.
    pub settings: BTreeMap<String, serde_json::Value>,
}

/// One method's share of a bundle.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct MethodEntry {
    /// Name of the method.
    pub name: String,
    /// xxh3-128 of everything of the scene that these files and errors depend on, hexadecimal.
    pub reads: String,
    /// Its files in the order in which a player wants them, each with its kind.
    pub files: Vec<(String, FileEntry)>,
    /// The settings that change results.
    pub settings: BTreeMap<String, serde_json::Value>,
    /// Measured errors, by what was measured.
    pub errors: BTreeMap<String, f64>,
    /// On which states, where, and against what they were measured; empty in bundles that are too old to
    /// tell.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub measured_on: String,
}

impl FileEntry {
    /// The entry for `bytes` under the name `file`.
    pub fn of(file: &str, bytes: &[u8]) -> Self {
        Self { file: file.to_owned(), bytes: bytes.len() as u64, hash: content_hash(bytes) }
    }
}

/// xxh3-128 in hexadecimal.
pub fn content_hash(bytes: &[u8]) -> String {
    format!("{:032x}", xxhash_rust::xxh3::xxh3_128(bytes))
}

/// [`content_hash`] of what comes piece by piece.
#[derive(Clone, Default)]
pub struct ContentHash(Xxh3);

impl ContentHash {
    /// Adds the next bytes.
    pub fn update(&mut self, bytes: &[u8]) {
        self.0.update(bytes);
    }

    /// Of all bytes so far.
    pub fn text(&self) -> String {
        format!("{:032x}", self.0.digest128())
    }
}

/// `error` in opening the file at `place`, which a manifest lists: that it is not there has a cause of its
/// own.
pub fn of_listed(error: Error, place: &Place) -> Error {
    match error {
        Error::Io { source, .. } if source.kind() == std::io::ErrorKind::NotFound => {
            Error::invalid(place, "is missing although the manifest lists it; bake it again")
        }
        other => other,
    }
}

impl FileEntry {
    /// Fails unless the file in `folder` is there, as long as listed, and with the listed hash.
    pub fn expect_whole(&self, folder: &Path) -> Result<()> {
        let place = Place::file(folder.join(&self.file));
        let io = |e| Error::io(&place, e);
        let mut file = open_regular(&place.file).map_err(|error| of_listed(error, &place))?;
        let length = file.metadata().map_err(io)?.len();
        if length != self.bytes {
            return Err(Error::invalid(
                &place,
                format!("{length} bytes, the manifest lists {}; bake it again", self.bytes),
            ));
        }
        let (mut hash, mut buffer) = (ContentHash::default(), vec![0; 1 << 16]);
        loop {
            match file.read(&mut buffer).map_err(io)? {
                0 => break,
                read => hash.update(buffer.get(..read).unwrap_or_default()),
            }
        }
        if hash.text() != self.hash {
            return Err(Error::invalid(
                &place,
                "its hash is not the one in the manifest; the file was changed, bake it again",
            ));
        }
        Ok(())
    }
}

/// What a bundle calls the sphere set of `object`.
pub fn sphere_set_file(object: &str) -> String {
    file_of("spheres", object, "relume")
}

/// What a bundle calls the shape of `object`.
pub fn shape_file(object: &str) -> String {
    file_of("shape", object, "relume")
}

/// Whether a file may be called so: nothing that leads out of the folder, on any system.
pub fn is_plain_name(name: &str) -> bool {
    let plain = |c: char| c.is_ascii_alphanumeric() || "._- ".contains(c);
    !name.is_empty() && name.len() <= 200 && !name.starts_with('.') && name.chars().all(plain)
}

/// The error of a manifest that is not as a bake writes it.
fn damaged(place: &Place, fault: &str) -> Error {
    Error::invalid(place, format!("{fault}; copy the bundle again, or bake it again"))
}

impl Manifest {
    /// Reads the manifest of the bundle in `folder`.
    pub fn read(folder: &Path) -> Result<Self> {
        let path = folder.join(FILE_NAME);
        let place = Place::file(&path);
        let text = match read_text(&path) {
            Err(Error::Io { source, .. }) if source.kind() == std::io::ErrorKind::NotFound => {
                if let Some(meant) = nearest_file(Path::new(""), folder) {
                    return Err(Error::invalid(
                        &Place::file(folder),
                        format!("no such folder; did you mean `{meant}`?"),
                    ));
                }
                if folder.join("unfinished/shard.json").is_file() {
                    let reason = "holds a part of a bake, and no bundle; make one of all parts by `bake merge DIR... -o BUNDLE`";
                    return Err(Error::invalid(&Place::file(folder), reason));
                }
                if folder.join("unfinished").is_dir() {
                    let reason = "holds a bake that was interrupted, and no bundle yet; go on with it by --resume of `bake run`";
                    return Err(Error::invalid(&Place::file(folder), reason));
                }
                return Err(Error::invalid(
                    &Place::file(folder),
                    format!(
                        "holds no bundle (no {FILE_NAME}); make one with `bake run SCENE -o {}`",
                        folder.display()
                    ),
                ));
            }
            other => other?,
        };
        Self::parse(&text, &place)
    }

    /// The manifest in `text`, which stands at `place`.
    pub fn parse(text: &str, place: &Place) -> Result<Self> {
        // Older or newer manifests may differ in any field but this one.
        let value: serde_json::Value = json::parse(text).map_err(|fault| damaged(place, &fault))?;
        match value.get("version").and_then(serde_json::Value::as_u64) {
            Some(v) if v == u64::from(VERSION) => {}
            Some(v) => {
                return Err(Error::unsupported(
                    place,
                    format!("manifest version {v}, this program reads version {VERSION}; bake it again"),
                ));
            }
            None => return Err(damaged(place, "has no version")),
        }
        let manifest: Self = json::manifest(value).map_err(|fault| damaged(place, &fault))?;
        manifest.validate(place)?;
        Ok(manifest)
    }

    /// Checks what readers rely on: plain names, files that are each of one thing, lengths that can be added
    /// up, methods, and errors that JSON can hold.
    pub fn validate(&self, place: &Place) -> Result<()> {
        let refuse = |reason: String| Err(Error::invalid(place, format!("{reason}; bake it again")));
        if let Some(entry) = self.entries().find(|e| !is_plain_name(&e.file)) {
            return refuse(format!(
                "`{}` is no plain file name of a-z A-Z 0-9 . _ - and blanks",
                entry.file.escape_default()
            ));
        }
        if self.entries().try_fold(0u64, |sum, e| sum.checked_add(e.bytes)).is_none() {
            return refuse("the files are longer than any disk".to_owned());
        }
        if self.methods.is_empty() {
            return refuse("lists no method".to_owned());
        }
        let fault = self
            .fault_of_names()
            .or_else(|| self.fault_of_hashes())
            .or_else(|| self.fault_of_files())
            .or_else(|| self.methods.iter().find_map(figures::fault_of_method))
            .or_else(|| self.sphere_sets.iter().find_map(figures::fault_of_sphere_set));
        fault.map_or(Ok(()), refuse)
    }

    fn fault_of_hashes(&self) -> Option<String> {
        let hashes = [("scene_hash", &self.scene_hash)]
            .into_iter()
            .chain(self.entries().map(|entry| (entry.file.as_str(), &entry.hash)));
        let mut wrong = hashes.filter(|(_, hash)| !figures::is_hash(hash));
        wrong.next().map(|(what, hash)| {
            format!("the hash `{}` of `{what}` is not 32 digits 0-9 a-f", plain(&shortened(hash)))
        })
    }

    fn fault_of_names(&self) -> Option<String> {
        fault_of_name("the scene", &self.scene)
            .or_else(|| self.animations.keys().find_map(|name| fault_of_name("an animation", name)))
            .or_else(|| self.sphere_sets.keys().find_map(|name| fault_of_name("an object", name)))
            .or_else(|| fault_of_names("methods", self.methods.iter().map(|method| method.name.as_str())))
    }

    /// Methods may share a file, which must then be the same for all; besides, each stands for one thing.
    fn fault_of_files(&self) -> Option<String> {
        let mut listed: HashMap<&str, (&FileEntry, usize)> = HashMap::new();
        let shared = [&self.scene_file]
            .into_iter()
            .chain(self.animations.values())
            .chain(self.sphere_sets.values().map(|set| &set.file));
        let of_methods = self
            .methods
            .iter()
            .zip(1..)
            .flat_map(|(method, user)| method.files.iter().map(move |(_, entry)| (entry, user)));
        shared.map(|entry| (entry, 0)).chain(of_methods).find_map(|(entry, user)| {
            match listed.insert(&entry.file, (entry, user)) {
                Some((other, _)) if other != entry => {
                    Some(format!("`{}` is listed twice, with different lengths or hashes", entry.file))
                }
                Some((_, other)) if other == user || other == 0 => {
                    Some(format!("`{}` is listed twice", entry.file))
                }
                _ => None,
            }
        })
    }

    /// Writes the manifest into `folder`, last of all files: a bundle without one is unfinished.
    pub fn write(&self, folder: &Path) -> Result<()> {
        let path = folder.join(FILE_NAME);
        self.validate(&Place::file(&path))?;
        let mut text = serde_json::to_string_pretty(self)
            .map_err(|e| Error::invalid(&Place::file(&path), e.to_string()))?;
        text.push('\n');
        replace_file(&path, text.as_bytes())
    }

    /// Every file of the bundle.
    pub fn entries(&self) -> impl Iterator<Item = &FileEntry> {
        let methods = self.methods.iter().flat_map(|m| m.files.iter().map(|(_, entry)| entry));
        let sphere_sets = self.sphere_sets.values().map(|set| &set.file);
        [&self.scene_file].into_iter().chain(self.animations.values()).chain(sphere_sets).chain(methods)
    }

    /// The entry of `method`, or the preferred one; the manifest stands at `place`.
    pub fn method(&self, name: Option<&str>, place: &Place) -> Result<&MethodEntry> {
        let found = match name {
            None => self.methods.first(),
            Some(name) => self.methods.iter().find(|m| m.name == name),
        };
        found.ok_or_else(|| {
            let there: Vec<_> = self.methods.iter().map(|m| m.name.as_str()).collect();
            let name = name.unwrap_or("any");
            Error::invalid(
                place,
                format!(
                    "no method `{name}`; this bundle has: {}{}",
                    there.join(", "),
                    did_you_mean(name, there.iter().copied())
                ),
            )
        })
    }
}
