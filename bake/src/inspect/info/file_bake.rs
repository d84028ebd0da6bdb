//! What the manifest beside a method's main file says of the bake that the file came from.

use relume_formats::Result;
use relume_formats::kinds::Manifest;
use relume_formats::kinds::manifest::{FileEntry, MethodEntry};
use serde::Serialize;
use serde_json::Value;
use std::collections::BTreeMap;
use std::path::Path;

/// A manifest that lists a file.
#[derive(Debug, PartialEq, Serialize)]
#[serde(tag = "belongs", rename_all = "kebab-case")]
pub(in super::super) enum FileBake {
    /// The file is the one that it lists.
    Listed {
        /// Path of the bundle.
        manifest: String,
        method: String,
        settings: BTreeMap<String, Value>,
        errors: BTreeMap<String, f64>,
        measured_on: String,
    },
    /// It lists another file under this name.
    Stranger {
        /// Path of the bundle.
        manifest: String,
    },
}

impl FileBake {
    /// For the file at `path`; `None` if no manifest beside it names the file as that of a method, whose kind
    /// is called as the method.
    ///
    /// # Errors
    /// If the file cannot be read.
    pub fn of(path: &Path) -> Result<Option<Self>> {
        let folder = path.parent().unwrap_or(Path::new(""));
        let Ok(manifest) = Manifest::read(folder) else { return Ok(None) };
        let name = path.file_name().unwrap_or_default();
        let listed = |method: &MethodEntry| {
            let main =
                method.files.iter().find(|(kind, entry)| *kind == method.name && name == entry.file.as_str());
            main.map(|(_, entry)| (method.clone(), entry.clone()))
        };
        let found: Option<(MethodEntry, FileEntry)> = manifest.methods.iter().find_map(listed);
        let Some((method, entry)) = found else { return Ok(None) };
        let manifest = folder.join(relume_formats::kinds::manifest::FILE_NAME).display().to_string();
        let MethodEntry { name: method, settings, errors, measured_on, .. } = method;
        let listed = Self::Listed { manifest: manifest.clone(), method, settings, errors, measured_on };
        Ok(Some(if entry.expect_whole(folder).is_ok() { listed } else { Self::Stranger { manifest } }))
    }
}

#[cfg(test)]
mod tests {
    use crate::inspect::info;
    use crate::inspect::test_bundle::TestBundle;
    use relume_formats::container::Stored;
    use serde_json::{Value, json};

    #[test]
    fn the_main_file_of_a_bundle_tells_its_own_error_unless_it_was_exchanged() {
        let folder = tempfile::tempdir().unwrap();
        let mut bundle = TestBundle::new();
        bundle.write(folder.path());
        let path = folder.path().join("transfer-images.relume");
        let read = || serde_json::from_str::<Value>(&info(&path, true).unwrap()).unwrap();
        let bake = &read()["bake"];
        assert_eq!(
            (&bake["belongs"], &bake["method"], &bake["measured_on"]),
            (&json!("listed"), &json!("transfer-images"), &json!("16 states"))
        );
        assert_eq!(
            (&bake["errors"], &bake["settings"]),
            (&json!({ "relative_l2_median": 0.00125 }), &json!({ "samples": 16 }))
        );
        let text = info(&path, false).unwrap();
        assert!(
            text.contains("  errors      relative_l2_median 0.001250\n  measured    16 states\n"),
            "{text}"
        );
        let basis = info(&folder.path().join("brdf-basis.relume"), true).unwrap();
        assert!(!basis.contains("belongs"), "the error is not that of a basis: {basis}");

        bundle.images.images.swap(0, 1);
        bundle.images.write_file(&path).unwrap();
        assert_eq!(read()["bake"]["belongs"], "stranger");
        assert!(read()["bake"]["errors"].is_null());
        let text = info(&path, false).unwrap();
        assert!(
            text.contains("lists this file with another hash, so the two do not belong together")
                && !text.contains("0.00125"),
            "{text}"
        );

        std::fs::remove_file(folder.path().join("manifest.json")).unwrap();
        assert!(read()["bake"].is_null(), "a file alone is described all the same");
    }
}
