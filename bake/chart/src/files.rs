//! The files of a chart but its picture.

use crate::figures::{CSV, Chart, JSON, SVG};
use crate::{csv, svg};
use relume_formats::container::replace_file;
use relume_formats::{Error, Place, Result};
use std::path::Path;

/// Writes `chart` as chart.csv, chart.svg and, last, chart.json into `folder`, each whole or not at all.
///
/// # Errors
/// If a figure is no number, a text too long, or a file cannot be written.
pub fn write(chart: &Chart, folder: &Path) -> Result<()> {
    let path = folder.join(JSON);
    let place = Place::file(&path);
    chart.validate(&place)?;
    let json = serde_json::to_string_pretty(chart).map_err(|e| Error::invalid(&place, e.to_string()))?;
    replace_file(&folder.join(CSV), &csv::table(chart)?)?;
    replace_file(&folder.join(SVG), svg::draw(chart)?.as_bytes())?;
    replace_file(&path, (json + "\n").as_bytes())
}
