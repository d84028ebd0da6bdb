//! What an earlier bake of the same scene came to, read from its bundle.

use relume_bake::methods::asked::Asked;
use relume_bake::methods::registered::Registered;
use relume_bake::report;
use relume_formats::kinds::Manifest;
use relume_formats::kinds::manifest::MethodEntry;
use relume_scenes::Scene;
use serde::Serialize;
use serde_json::{Map, Value};
use std::collections::BTreeMap;
use std::path::Path;

/// What a bundle tells of one of its methods.
#[derive(Debug, Serialize)]
pub(super) struct StoredFigures {
    /// The bundle.
    pub folder: String,
    /// Settings of that bake.
    pub settings: BTreeMap<String, Value>,
    /// As measured by it.
    pub errors: BTreeMap<String, f64>,
    /// The method's own files.
    pub bytes_on_disk: u64,
    /// `tracing_seconds`, `rays` and what else the report has; empty if it has nothing.
    pub tracing: Map<String, Value>,
    /// What a frame costs, as the report has it.
    pub frame: Option<Value>,
}

/// What a bundle tells.
#[derive(Debug, Default)]
pub(super) struct Stored {
    /// By name of the method.
    pub methods: BTreeMap<String, StoredFigures>,
    /// Why a bundle that is there tells nothing.
    pub unusable: Option<String>,
}

/// The figures of the bundle in `folder`, if there is one, of `scene` as it is now.
pub(super) fn read(folder: &Path, scene: &Scene) -> Stored {
    let unusable = |reason: String| Stored { unusable: Some(reason), ..Stored::default() };
    if !folder.exists() {
        return Stored::default();
    }
    let manifest = match Manifest::read(folder) {
        Ok(manifest) => manifest,
        Err(error) => return unusable(error.to_string()),
    };
    let asked = Asked::of_scene(scene);
    let serves = |entry: &&MethodEntry| {
        let method = Registered::find(&entry.name).map(|method| (method.new)(&asked, scene));
        method.is_some_and(|method| entry.reads == format!("{:032x}", method.reads(scene)))
    };
    if !manifest.methods.iter().any(|entry| serves(&entry)) {
        return unusable(format!(
            "{}: was baked from another state of the scene; `bake run` brings it up to date",
            folder.display()
        ));
    }
    let report = report::read(folder);
    let figures = |entry: &MethodEntry| {
        let part = |key: &str| report.get(key).and_then(|part| part.get(&entry.name)).cloned();
        StoredFigures {
            folder: folder.display().to_string(),
            settings: entry
                .settings
                .iter()
                .filter(|(name, _)| *name != "revision")
                .map(|(k, v)| (k.clone(), v.clone()))
                .collect(),
            errors: entry.errors.clone(),
            bytes_on_disk: entry.files.iter().map(|(_, file)| file.bytes).sum(),
            tracing: part("methods").and_then(|part| part.as_object().cloned()).unwrap_or_default(),
            frame: part(report::FRAME),
        }
    };
    Stored {
        methods: manifest
            .methods
            .iter()
            .filter(serves)
            .map(|entry| (entry.name.clone(), figures(entry)))
            .collect(),
        unusable: None,
    }
}
