//! What a file or a bundle holds, once it has been checked: nothing is told of what no reader would accept.

pub(super) mod facts;
pub(super) mod file_bake;

use super::{info_text, kinds, verify};
use crate::inspected::Described;
use facts::{BundleInfo, FileInfo, SectionRow, Totals};
use file_bake::FileBake;
use relume_formats::container::{CONTAINER_VERSION, open};
use relume_formats::kinds::Manifest;
use relume_formats::{Error, Place, Result};
use serde::Serialize;
use std::collections::HashSet;
use std::path::Path;

/// Describes the `.relume` file or bundle folder at `path`: as aligned text, or as JSON that has every
/// section.
///
/// # Errors
/// Those of [`verify`].
pub fn info(path: &Path, json: bool) -> Result<String> {
    verify(path)?;
    if path.is_dir() {
        let bundle = bundle_info(path)?;
        return if json { to_json(&bundle, path) } else { Ok(info_text::bundle(&bundle)) };
    }
    let file = FileInfo { bake: FileBake::of(path)?, ..file_info(path)? };
    if json { to_json(&file, path) } else { Ok(info_text::file(&file)) }
}

fn to_json(value: &impl Serialize, path: &Path) -> Result<String> {
    serde_json::to_string_pretty(value)
        .map(|text| text + "\n")
        .map_err(|e| Error::invalid(&Place::file(path), e.to_string()))
}

fn bundle_info(folder: &Path) -> Result<BundleInfo> {
    let manifest = Manifest::read(folder)?;
    let mut files: Vec<FileInfo> = Vec::new();
    let mut told = HashSet::new();
    for entry in manifest.entries() {
        // Methods may share a file.
        if told.insert(&entry.file) {
            files.push(file_info(&folder.join(&entry.file))?);
        }
    }
    let sum = |of: fn(&Totals) -> u64| files.iter().map(|f| of(&f.totals)).sum::<u64>();
    let totals = Totals::new(
        files.iter().map(|f| f.totals.sections).sum(),
        sum(|t| t.bytes_on_disk),
        sum(|t| t.bytes_in_memory),
    );
    Ok(BundleInfo { kind: "bundle", folder: folder.display().to_string(), manifest, totals, files })
}

fn file_info(path: &Path) -> Result<FileInfo> {
    let place = Place::file(path);
    let bytes_on_disk = std::fs::metadata(path).map_err(|e| Error::io(&place, e))?.len();
    let header = open(path)?.header().clone();
    let Described { details, facts } = (kinds::find(header.kind, &place)?.describe)(path)?;
    let bytes_in_memory = header.sections.iter().map(|s| s.raw_bytes).sum();
    Ok(FileInfo {
        file: path.display().to_string(),
        kind: header.kind.name(),
        kind_version: header.kind_version,
        container_version: CONTAINER_VERSION,
        totals: Totals::new(header.sections.len(), bytes_on_disk, bytes_in_memory),
        details,
        facts,
        bake: None,
        sections: header.sections.iter().map(SectionRow::new).collect(),
    })
}

#[cfg(test)]
mod tests {
    use super::super::test_bundle::TestBundle;
    use super::*;
    use serde_json::Value;

    fn bundle() -> tempfile::TempDir {
        let folder = tempfile::tempdir().unwrap();
        TestBundle::new().write(folder.path());
        folder
    }

    fn json(path: &Path) -> Value {
        serde_json::from_str(&info(path, true).unwrap()).unwrap()
    }

    #[test]
    fn json_of_a_file_is_complete() {
        let folder = bundle();
        let path = folder.path().join("transfer-images.relume");
        let value = json(&path);
        let length = std::fs::metadata(&path).unwrap().len();
        assert_eq!(
            (&value["kind"], &value["kind_version"], &value["container_version"]),
            (&"transfer-images".into(), &0.into(), &0.into())
        );
        assert_eq!(value["totals"]["bytes_on_disk"], length);
        // Head, and 3 bases × 8 first reflections; grey are 2 glossy bases × (direct, 2 materials × 2 glossy
        // bases).
        let sections = value["sections"].as_array().unwrap();
        assert_eq!(sections.len(), 5 + 24);
        let details = &value["details"];
        assert_eq!((&details["rgb_images"], &details["single_channel_images"]), (&14.into(), &10.into()));
        let classes: Vec<_> = details["classes"]
            .as_array()
            .unwrap()
            .iter()
            .map(|c| (c["material"].as_str(), c["fragments"].as_u64()))
            .collect();
        assert_eq!(classes, [(Some("../knot"), Some(2)), (Some("floor"), Some(2)), (None, Some(4))]);

        let number = |section: &Value, name: &str| section[name].as_u64().unwrap();
        let raw: u64 = sections.iter().map(|s| number(s, "raw_bytes")).sum();
        assert_eq!(value["totals"]["bytes_in_memory"], raw);
        let last = sections.last().unwrap();
        assert_eq!(number(last, "offset") + number(last, "stored_bytes"), length, "sections cover the file");
        let pixels = &sections[1];
        assert_eq!(
            (&pixels["name"], &pixels["element"], &pixels["shape"][0]),
            (&"fragments/pixel".into(), &"u32".into(), &8.into())
        );
        assert_eq!((number(pixels, "raw_bytes"), &pixels["codec"]), (32, &"zstd-planes".into()));
        assert_eq!(pixels["ratio"].as_f64().unwrap(), 32.0 / number(pixels, "stored_bytes") as f64);
    }

    #[test]
    fn json_of_a_bundle_has_manifest_and_every_file() {
        let folder = bundle();
        let value = json(folder.path());
        assert_eq!((&value["kind"], &value["manifest"]["scene"]), (&"bundle".into(), &"test room".into()));
        assert_eq!(value["manifest"]["methods"][0]["errors"]["relative_l2_median"], 0.00125);
        let files = value["files"].as_array().unwrap();
        let kinds: Vec<_> = files.iter().map(|f| f["kind"].as_str().unwrap()).collect();
        assert_eq!(kinds, ["scene", "animation", "brdf-basis", "transfer-images"]);
        let sum: u64 = files.iter().map(|f| f["totals"]["bytes_on_disk"].as_u64().unwrap()).sum();
        assert_eq!(value["totals"]["bytes_on_disk"], sum);
        let basis = &files[2]["details"];
        assert_eq!(
            (&basis["bases"], &basis["nodes"], &basis["error_at_samples"]["worst"]),
            (&3.into(), &3.into(), &0.002.into())
        );
        assert_eq!(info(folder.path(), true).unwrap(), info(folder.path(), true).unwrap());
    }

    #[test]
    fn text_is_aligned_and_sums_up_long_lists() {
        let folder = bundle();
        let text = info(&folder.path().join("transfer-images.relume"), false).unwrap();
        assert!(text.contains("  images      14 RGB, 10 single-channel\n"), "{text}");
        assert!(text.contains("  fragments   8: ../knot 2, floor 2, (fixed) 4\n"), "{text}");
        let table: Vec<&str> = text.lines().skip_while(|l| !l.trim_start().starts_with("section")).collect();
        // Heading, 8 sections, the other 21 of 29, the total; all as wide, for the last column is aligned to
        // the right.
        assert_eq!(table.len(), 1 + 8 + 1 + 1, "{text}");
        assert!(table[9].contains("… 21 more"), "{text}");
        assert!(table.iter().all(|line| line.chars().count() == table[0].chars().count()), "{text}");
    }

    #[test]
    fn text_of_a_bundle_tells_settings_and_errors() {
        let folder = bundle();
        let text = info(folder.path(), false).unwrap();
        for part in [
            "  scene       test room, hash 0123456789abcdef0123456789abcdef\n",
            "    settings  samples 16\n",
            "    errors    relative_l2_median 0.001250\n",
            "    measured  16 states\n",
            "  animations  glow\n",
            "  error       0.1000 % mean, 0.2000 % worst at 7 at the samples\n",
            "  varies      ../knot, floor\n",
            "  tracks      materials.../knot.kd (2 keys), materials.../knot.shininess (1 key)\n",
        ] {
            assert!(text.contains(part), "`{part}` is not in\n{text}");
        }
    }

    #[test]
    fn what_is_no_bundle_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        assert!(info(folder.path(), false).unwrap_err().to_string().contains("holds no bundle"));
        let path = folder.path().join("a.relume");
        std::fs::write(&path, b"text").unwrap();
        assert!(info(&path, true).unwrap_err().is_bad_input());
    }
}
