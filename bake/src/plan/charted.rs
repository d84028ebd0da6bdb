//! What a chart of the scene says of each method, read from its chart.json.

use crate::chart::figures::{Chart, Point};
use serde::Serialize;
use std::collections::BTreeMap;
use std::path::Path;

/// The point of a method that comes nearest to the reference; of several, the one whose frames are fastest.
#[derive(Debug, Serialize)]
pub(super) struct BestPoint {
    /// Series and label.
    pub point: String,
    /// Relative L2 to path traced images, median and worst over the chart's states.
    pub relative_l2_median: f64,
    pub relative_l2_worst: f64,
    /// Of a frame.
    pub median_ms: f64,
    pub bytes_on_disk: u64,
    pub bake_seconds: f64,
    /// Day of the chart, and what drew its frames.
    pub date: String,
    pub adapter: String,
}

/// The best points of the chart in `folder`, by method; none if there is no chart.
pub(super) fn read(folder: &Path) -> BTreeMap<String, BestPoint> {
    let Ok(chart) = Chart::read(folder) else { return BTreeMap::new() };
    let mut best: BTreeMap<String, &Point> = BTreeMap::new();
    let key = |point: &Point| (point.errors.relative_l2.median, point.frame.median_ms);
    for point in &chart.points {
        let kept = best.entry(point.method.clone()).or_insert(point);
        if key(point) < key(kept) {
            *kept = point;
        }
    }
    best.into_iter().map(|(method, point)| (method, BestPoint::of(point, &chart))).collect()
}

impl BestPoint {
    fn of(point: &Point, chart: &Chart) -> Self {
        Self {
            point: format!("{}, {}", point.series, point.label),
            relative_l2_median: point.errors.relative_l2.median,
            relative_l2_worst: point.errors.relative_l2.worst,
            median_ms: point.frame.median_ms,
            bytes_on_disk: point.bytes_on_disk,
            bake_seconds: point.bake_seconds,
            date: chart.date.clone(),
            adapter: chart.adapter.clone(),
        }
    }
}
