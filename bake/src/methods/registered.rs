//! A method's line in the registry, and what its files are checked against.

use super::asked::Asked;
use crate::inspected::Inspected;
use crate::method::Method;
use relume_formats::bundle::{Maps, Objects, Settings};
use relume_formats::container::Kind;
use relume_formats::kinds::StoredScene;
use relume_formats::method::{Card, Materials, Variation};
use relume_scenes::{Scene, Vary};
use serde_json::Value;
use std::collections::BTreeMap;
use std::path::PathBuf;

/// An option of `bake run`, and whether the user gave it.
pub type OwnOption = (&'static str, fn(&Asked) -> bool);

/// Checks the files of a method, each of a kind, against what they must agree with; returns the maps that are
/// among them.
pub type Verify = fn(&Bundled<'_>, &[(Kind, PathBuf)]) -> relume_formats::Result<Maps>;

/// A method's line in the registry.
#[derive(Debug)]
pub struct Registered {
    /// What there is to say of it.
    pub card: &'static Card,
    /// Why it is the one to take where it is, for `bake plan`.
    pub why: &'static str,
    /// The option that is its own.
    pub options: &'static [OwnOption],
    /// The method with its settings for a scene.
    pub new: fn(&Asked, &Scene) -> Box<dyn Method>,
    /// What makes a bake with these settings more exact, for a warning.
    pub remedy: fn(&BTreeMap<String, Value>) -> String,
    /// Checks what must agree between its files and with the scene.
    pub verify: Verify,
    /// The kinds of files that are its own.
    pub inspected: &'static [Inspected],
}

impl Registered {
    /// Whether it lets vary all of `vary`.
    pub fn serves_all(&self, vary: &Vary) -> bool {
        self.card.lets_vary.includes(&variation(vary))
    }
}

/// What the files of a method must agree with.
pub struct Bundled<'a> {
    /// The scene.
    pub scene: &'a StoredScene,
    /// Its objects, with their sphere sets.
    pub objects: &'a Objects,
    /// What the manifest says of the method.
    pub settings: &'a Settings,
}

/// What `vary` asks of a method.
pub fn variation(vary: &Vary) -> Variation {
    let materials = match (vary.materials.is_empty(), vary.painted.is_empty()) {
        (true, _) => Materials::Fixed,
        (false, true) => Materials::Whole,
        (false, false) => Materials::Painted,
    };
    Variation { light: vary.light, view: vary.view, materials, shape: vary.shape, media: false }
}

/// What the method called `name`, which edits materials as wholes, leaves out of those that take textures.
pub(super) fn unpainted<'a>(scene: &'a Scene, name: &'a str) -> impl Iterator<Item = String> + 'a {
    let painted = scene.vary.painted.iter().filter_map(|index| scene.materials.get(*index));
    painted.map(move |material| {
        format!("[vary] painted: {name} edits `{}` as a whole, without textures", material.name)
    })
}

/// What to tell a user whose bake with `settings` is not exact enough: to ask for the `next` number of what
/// `setting` counts, `most` at most.
pub(super) fn more_of(
    settings: &BTreeMap<String, Value>,
    setting: &str,
    next: impl Fn(u64) -> u64,
    most: u64,
) -> String {
    match settings.get(setting).and_then(Value::as_u64) {
        Some(n) if n < most => format!("add --{setting} {}", next(n).min(most)),
        _ => "no more of them does better".to_owned(),
    }
}
