//! Which files of a bundle are played, and in which order.
//!
//! The scene comes first, then the animations, which are small, and without which not even the first frame is
//! known, then the sphere sets, if the method plays with them, then the files of the method in the order of
//! the manifest, the one that arrives piece by piece last.

use crate::error::{Error, Result};
use crate::methods::{METHODS, Method};
use relume_formats::bundle::Settings;
use relume_formats::container::Kind;
use relume_formats::kinds::manifest::{FileEntry, Manifest, MethodEntry};
use relume_formats::near::did_you_mean;
use relume_formats::{Error as FormatError, Place};

/// One file to play.
#[derive(Debug, Clone)]
pub struct Item {
    /// Its name within the bundle.
    pub file: String,
    /// Where it is, beside the manifest.
    pub place: Place,
    /// What the manifest says it holds.
    pub kind: Kind,
    /// What the manifest calls that which it holds, or the object that it is of; `None` for files of a
    /// method.
    pub name: Option<String>,
    /// How long the manifest says it is.
    pub bytes: u64,
    /// Its hash, as the manifest has it.
    pub hash: String,
}

/// The files to play, in playback order.
#[derive(Debug, Clone)]
pub struct Playlist {
    /// The files.
    pub items: Vec<Item>,
    /// The method that plays them.
    pub method: Method,
    /// What the manifest says of the method's settings.
    pub settings: Settings,
    /// All methods of the bundle that are known.
    pub known: Vec<Method>,
    /// Where the manifest is.
    pub place: Place,
    /// Whether the first animation is the one to play.
    pub plays_first: bool,
}

impl Playlist {
    /// The playlist of the bundle whose `manifest` stands at `place`: for the method called `method`, or the
    /// first in the manifest that this player knows, with all animations, the one called `first` in front.
    ///
    /// # Errors
    /// If there is no such method or animation, or the manifest lists files that this player cannot use.
    pub fn of(manifest: &Manifest, place: &Place, method: Option<&str>, first: Option<&str>) -> Result<Self> {
        let (method, entry) = choose(manifest, method, place)?;
        method.card.expect_files(&entry.files, &place.part(format!("method `{}`", entry.name)))?;
        let item = |kind, entry: &FileEntry| Item {
            place: Place::file(place.file.with_file_name(&entry.file)),
            file: entry.file.clone(),
            kind,
            name: None,
            bytes: entry.bytes,
            hash: entry.hash.clone(),
        };
        let named =
            |name: &str, kind, entry: &FileEntry| Item { name: Some(name.to_owned()), ..item(kind, entry) };
        let mut items = vec![named(&manifest.scene, Kind::Scene, &manifest.scene_file)];
        if let Some(name) = first {
            items.push(named(name, Kind::Animation, animation_entry(manifest, name)?));
        }
        let others = manifest.animations.iter().filter(|(name, _)| Some(name.as_str()) != first);
        items.extend(others.map(|(name, entry)| named(name, Kind::Animation, entry)));
        if method.card.sphere_sets {
            let sets = manifest.sphere_sets.iter();
            items.extend(sets.map(|(object, set)| named(object, Kind::SphereSet, &set.file)));
        }
        for (kind, entry) in &entry.files {
            let kind = Kind::find(kind).ok_or_else(|| {
                FormatError::unsupported(
                    place,
                    format!("kind `{kind}` is unknown to this player; use a newer one"),
                )
            })?;
            items.push(item(kind, entry));
        }
        let known = manifest.methods.iter().filter_map(|entry| Method::find(&entry.name)).collect();
        let settings = Settings::of(entry, manifest, place);
        Ok(Self { items, method, settings, known, place: place.clone(), plays_first: first.is_some() })
    }

    /// Number of animations among the files.
    pub(crate) fn animations(&self) -> usize {
        self.items.iter().filter(|item| item.kind == Kind::Animation).count()
    }
}

/// The method called `name`, which must be known, or the first that is.
fn choose<'a>(
    manifest: &'a Manifest,
    name: Option<&str>,
    place: &Place,
) -> Result<(Method, &'a MethodEntry)> {
    let entries = match name {
        Some(name) => std::slice::from_ref(manifest.method(Some(name), place)?),
        None => &manifest.methods,
    };
    entries.iter().find_map(|entry| Some((Method::find(&entry.name)?, entry))).ok_or_else(|| {
        let there: Vec<_> = entries.iter().map(|entry| format!("`{}`", entry.name)).collect();
        let known: Vec<_> = METHODS.iter().map(|method| method.card.name).collect();
        let reason = format!(
            "method {} is unknown to this player, which plays {}",
            there.join(", "),
            known.join(", ")
        );
        FormatError::unsupported(place, reason).into()
    })
}

fn animation_entry<'a>(manifest: &'a Manifest, name: &str) -> Result<&'a FileEntry> {
    manifest.animations.get(name).ok_or_else(|| {
        let there: Vec<_> = manifest.animations.keys().map(String::as_str).collect();
        let there = if there.is_empty() { "none".to_owned() } else { there.join(", ") };
        let meant = did_you_mean(name, manifest.animations.keys().map(String::as_str));
        Error::Request(format!(
            "no animation `{name}`; this bundle has: {there} (a file must end in .toml){meant}"
        ))
    })
}
