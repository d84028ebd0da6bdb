//! What a user is told of a bundle that another of the same scene is about to replace.

use crate::method::Method;
use relume_formats::container::Stored;
use relume_formats::kinds::StoredScene;
use relume_formats::kinds::manifest::{Manifest, MethodEntry};
use serde_json::Value;
use std::path::Path;

/// A line that says how the bundle `old` in `folder` differs from what is asked for now; `None` if it does
/// not.
pub(super) fn notice(
    old: &Manifest,
    folder: &Path,
    hash: u128,
    methods: &[Box<dyn Method>],
    size: [u32; 2],
) -> Option<String> {
    let film = StoredScene::read_file(&folder.join(&old.scene_file.file)).ok().map(|stored| stored.meta.size);
    let mut differences: Vec<String> =
        film.filter(|old| *old != size).iter().map(|[w, h]| format!("a film of {w}x{h}")).collect();
    if old.scene_hash != format!("{hash:032x}") {
        differences.push("another state of the scene".to_owned());
    }
    for entry in &old.methods {
        match methods.iter().find(|method| method.name() == entry.name) {
            None => differences.push(format!("{}, which is not baked now", entry.name)),
            Some(method) => differences.extend(settings_that_differ(entry, method.as_ref())),
        }
    }
    (!differences.is_empty()).then(|| {
        let (folder, differences) = (folder.display(), differences.join("; "));
        format!("note: will replace the bundle in {folder}, of {differences}; Ctrl-C keeps it as it is")
    })
}

fn settings_that_differ(entry: &MethodEntry, method: &dyn Method) -> Option<String> {
    let asked = method.asked_for();
    let differs = |(name, value): &(&String, &Value)| asked.get(*name).is_some_and(|asked| asked != *value);
    // The film is told of before.
    let told = entry
        .settings
        .iter()
        .filter(|(name, _)| !["revision", "size"].contains(&name.as_str()))
        .filter(differs);
    let list: Vec<String> = told.map(|(name, value)| format!("{name} {value}")).collect();
    (!list.is_empty()).then(|| format!("{} with {}", entry.name, list.join(", ")))
}
