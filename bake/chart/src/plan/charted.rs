//! What a chart of the scene says of each method, read from its chart.json.

use crate::figures::{Chart, Point};
use serde::Serialize;
use std::collections::BTreeMap;
use std::path::Path;

/// How much larger than the least an error may be and count as equal.
const EQUAL: f64 = 1.05;

/// The point of a method that comes nearest to the reference; of those as near as makes no difference, the
/// one whose frames are fastest.
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
    let mut methods: BTreeMap<&str, Vec<&Point>> = BTreeMap::new();
    chart.points.iter().for_each(|point| methods.entry(&point.method).or_default().push(point));
    let best = methods
        .into_iter()
        .filter_map(|(method, points)| Some((method.to_owned(), BestPoint::of(nearest(&points)?, &chart))));
    best.collect()
}

fn nearest<'a>(points: &[&'a Point]) -> Option<&'a Point> {
    let error = |point: &Point| point.errors.relative_l2.median;
    let least = points.iter().map(|point| error(point)).fold(f64::INFINITY, f64::min);
    let near = points.iter().copied().filter(|point| error(point) <= EQUAL * least);
    near.min_by(|a, b| a.frame.median_ms.total_cmp(&b.frame.median_ms))
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_makes_no_difference_is_not_paid_for() {
        let mut points = crate::test_chart::chart().points;
        points.truncate(4);
        for (point, (error, ms)) in
            points.iter_mut().zip([(0.0260, 90.0), (0.0258, 600.0), (0.0272, 10.0), (0.0259, 100.0)])
        {
            (point.errors.relative_l2.median, point.frame.median_ms) = (error, ms);
        }
        let points: Vec<&Point> = points.iter().collect();
        assert_eq!(
            nearest(&points).map(|point| point.frame.median_ms),
            Some(90.0),
            "within a twentieth of the least, 0.0271"
        );
        assert!(nearest(&[]).is_none());
    }
}
