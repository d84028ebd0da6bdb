//! `report.json`: how long things took, and on what machine. It stands beside what was made, outside every
//! hash.

use relume_formats::container::replace_file;
use relume_formats::{Error, Place, Result, read_regular};
use serde_json::{Map, Value, json};
use std::path::Path;

/// Name of the report within a folder.
pub(crate) const FILE_NAME: &str = "report.json";
/// No report is longer.
const MAX_BYTES: u64 = 16 << 20;
/// The key under which sphere sets are reported, each by the name of its file.
pub const SPHERES: &str = "spheres";
/// The key under which frame costs are reported, each by the name of its method.
pub const FRAME: &str = "frame";

/// What every report tells: wall-clock seconds, threads, machine, program.
pub fn facts(seconds: f64) -> Map<String, Value> {
    let facts = [
        ("seconds", json!(seconds)),
        ("threads", json!(rayon::current_num_threads())),
        ("machine", json!(format!("{} {}", std::env::consts::OS, std::env::consts::ARCH))),
        ("program", json!(concat!("bake ", env!("CARGO_PKG_VERSION")))),
    ];
    facts.into_iter().map(|(name, value)| (name.to_owned(), value)).collect()
}

/// The report of `folder`; empty if it has none.
pub fn read(folder: &Path) -> Map<String, Value> {
    read_regular(&folder.join(FILE_NAME), MAX_BYTES, "")
        .ok()
        .and_then(|bytes| serde_json::from_slice(&bytes).ok())
        .unwrap_or_default()
}

/// Puts `new` into the report of `folder`, over what it holds under the same keys; [`SPHERES`] are replaced
/// one by one. What is there but no report is replaced.
///
/// # Errors
/// If the report cannot be written.
pub fn merge(folder: &Path, new: Map<String, Value>) -> Result<()> {
    let path = folder.join(FILE_NAME);
    if path.exists() && !path.is_file() {
        return Err(Error::invalid(
            &Place::file(&path),
            "not a regular file, which the report is to replace; remove it",
        ));
    }
    let mut report = read(folder);
    for (key, value) in new {
        match (report.get_mut(&key), value) {
            (Some(Value::Object(old)), Value::Object(sets)) if key == SPHERES => old.extend(sets),
            (_, value) => drop(report.insert(key, value)),
        }
    }
    let text = serde_json::to_string_pretty(&report)
        .map_err(|e| Error::invalid(&Place::file(&path), e.to_string()))?;
    replace_file(&path, (text + "\n").as_bytes())
}

/// Wall-clock seconds of the last bake into `folder`, if its report tells.
pub fn seconds(folder: &Path) -> Option<f64> {
    read(folder).get("seconds")?.as_f64()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sets(name: &str, seconds: f64) -> Map<String, Value> {
        Map::from_iter([(SPHERES.to_owned(), json!({ name: { "seconds": seconds } }))])
    }

    #[test]
    fn what_is_there_is_kept_unless_it_is_told_anew() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join(FILE_NAME);
        std::fs::write(&path, r#"{ "seconds": 5.0, "methods": { "a": 1 } }"#).unwrap();
        merge(folder.path(), sets("one", 1.0)).unwrap();
        merge(folder.path(), sets("two", 2.0)).unwrap();
        merge(folder.path(), sets("one", 3.0)).unwrap();
        merge(folder.path(), Map::from_iter([("methods".to_owned(), json!({ "b": 2 }))])).unwrap();
        let expected = json!({ "seconds": 5.0, "methods": { "b": 2 }, "spheres": { "one": { "seconds": 3.0 }, "two": { "seconds": 2.0 } } });
        assert_eq!(Value::Object(read(folder.path())), expected);
    }

    #[test]
    fn what_is_no_report_is_replaced() {
        let folder = tempfile::tempdir().unwrap();
        for text in ["no JSON {", "[1, 2]", "{ \"spheres\": 3 }"] {
            std::fs::write(folder.path().join(FILE_NAME), text).unwrap();
            merge(folder.path(), sets("one", 1.0)).unwrap();
            assert_eq!(
                Value::Object(read(folder.path())),
                json!({ "spheres": { "one": { "seconds": 1.0 } } }),
                "{text}"
            );
        }
    }
}
