//! The text form of [`super::info`]: facts in two columns, sections as a table.

use super::info::facts::{BundleInfo, FileInfo, SectionRow, Totals, ratio};
use super::info::file_bake::FileBake;
use crate::inspected::Facts;
use crate::inspected::words::{grouped, list};
use relume_formats::name::plain;
use serde_json::Value;
use std::collections::BTreeMap;

/// Longer tables show this many rows and the sum of the others.
const MOST_ROWS: usize = 12;
/// Rows shown of a longer table.
const ROWS_SHOWN: usize = 8;

/// The text for one file.
pub(super) fn file(info: &FileInfo) -> String {
    let mut facts = vec![
        (
            "kind",
            format!(
                "{} version {}, container version {}",
                info.kind, info.kind_version, info.container_version
            ),
        ),
        ("bytes", totals(&info.totals)),
    ];
    facts.extend(info.facts.iter().cloned());
    info.bake.iter().for_each(|bake| facts.extend(of_bake(bake)));
    format!("{}\n{}\n{}", plain(&info.file), lines(&facts), table(&info.sections))
}

/// The text for a bundle: what it is, then every file.
pub(super) fn bundle(info: &BundleInfo) -> String {
    let manifest = &info.manifest;
    let mut facts = vec![
        ("kind", "bundle".to_owned()),
        ("scene", format!("{}, hash {}", manifest.scene, manifest.scene_hash)),
        ("bytes", format!("{} in {} files", totals(&info.totals), info.files.len())),
    ];
    for method in &manifest.methods {
        facts.push(("method", method.name.clone()));
        facts.push(("  settings", settings(&method.settings)));
        facts.push(("  errors", errors(&method.errors)));
        if !method.measured_on.is_empty() {
            facts.push(("  measured", method.measured_on.clone()));
        }
    }
    if !manifest.animations.is_empty() {
        facts.push(("animations", list(manifest.animations.keys().cloned())));
    }
    for (object, set) in &manifest.sphere_sets {
        facts.push(("spheres", object.clone()));
        facts.push(("  settings", settings(&set.settings)));
    }
    let files: Vec<String> = info.files.iter().map(file).collect();
    format!("{}\n{}\n{}", plain(&info.folder), lines(&facts), files.join("\n"))
}

/// What the manifest beside a file says of it.
fn of_bake(bake: &FileBake) -> Facts {
    match bake {
        FileBake::Stranger { manifest } => {
            let reason = "lists this file with another hash, so the two do not belong together; its settings and errors are left out";
            vec![("manifest", format!("{manifest} {reason}"))]
        }
        FileBake::Listed { manifest, settings: of_method, errors: measured, measured_on, .. } => {
            let mut facts = vec![
                ("manifest", manifest.clone()),
                ("settings", settings(of_method)),
                ("errors", errors(measured)),
            ];
            facts.extend((!measured_on.is_empty()).then(|| ("measured", measured_on.clone())));
            facts
        }
    }
}

fn settings(settings: &BTreeMap<String, Value>) -> String {
    list(settings.iter().map(|(name, value)| format!("{name} {value}")))
}

fn errors(errors: &BTreeMap<String, f64>) -> String {
    if errors.is_empty() {
        return "none, for nothing that was compared is lit".to_owned();
    }
    list(errors.iter().map(|(name, value)| format!("{name} {value:.6}")))
}

fn totals(totals: &Totals) -> String {
    format!(
        "{} on disk, {} in memory, ratio {:.2}",
        grouped(totals.bytes_on_disk),
        grouped(totals.bytes_in_memory),
        totals.ratio
    )
}

/// A line a fact, whatever the names in it do elsewhere.
fn lines(facts: &[(&str, String)]) -> String {
    facts.iter().map(|(name, value)| format!("  {name:<11} {}\n", plain(value))).collect()
}

/// Names to the left, numbers to the right.
fn table(sections: &[SectionRow]) -> String {
    let shown = if sections.len() > MOST_ROWS { ROWS_SHOWN } else { sections.len() };
    let (first, others) = sections.split_at(shown);
    let mut rows =
        vec![["section", "element", "shape", "codec", "stored", "raw", "ratio"].map(str::to_owned)];
    rows.extend(first.iter().map(|s| {
        [
            plain(&s.name).into_owned(),
            s.element.to_owned(),
            shape(&s.shape),
            s.codec.to_owned(),
            grouped(s.stored_bytes),
            grouped(s.raw_bytes),
            format!("{:.2}", s.ratio),
        ]
    }));
    if !others.is_empty() {
        rows.push(sum(format!("… {} more", others.len()), others));
    }
    rows.push(sum("total".to_owned(), sections));
    let widths: [usize; 7] =
        std::array::from_fn(|column| rows.iter().map(|row| row[column].chars().count()).max().unwrap_or(0));
    rows.iter().map(|row| aligned(row, &widths)).collect()
}

fn sum(name: String, sections: &[SectionRow]) -> [String; 7] {
    let stored = sections.iter().map(|s| s.stored_bytes).sum();
    let raw = sections.iter().map(|s| s.raw_bytes).sum();
    let blank = String::new;
    [name, blank(), blank(), blank(), grouped(stored), grouped(raw), format!("{:.2}", ratio(raw, stored))]
}

fn aligned(row: &[String; 7], widths: &[usize; 7]) -> String {
    let mut line = String::from(" ");
    for (column, (cell, &width)) in row.iter().zip(widths).enumerate() {
        line += &if column < 4 { format!(" {cell:<width$} ") } else { format!(" {cell:>width$} ") };
    }
    line.trim_end().to_owned() + "\n"
}

fn shape(shape: &[u64]) -> String {
    shape.iter().map(u64::to_string).collect::<Vec<_>>().join(" × ")
}
