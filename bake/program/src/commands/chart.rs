//! `bake chart`.

use super::common::{SAME_COMMAND, load, start_threads};
use crate::cli::ChartArgs;
use relume_bake::error::Result;
use relume_bake::job::{Job, watch_signals};
use relume_chart::chart::{self, FOLDER};
use relume_chart::figures::{Chart, Point};
use std::path::Path;

/// `bake chart`.
pub fn chart(args: &ChartArgs) -> Result<String> {
    watch_signals()?;
    start_threads(args.threads)?;
    let scene = load(&args.scene)?;
    let methods: Vec<&str> = args.method.iter().map(|method| method.card.name).collect();
    let folder = args.output.clone().unwrap_or_else(|| Path::new(FOLDER).join(&scene.name));
    let chart = chart::run(&scene, &methods, &folder, &Job::new(args.progress));
    let chart = chart.map_err(|e| e.kept(chart::holds_work(&folder), SAME_COMMAND))?;
    Ok(describe(&chart, &folder))
}

/// A line a point, and where to look.
fn describe(chart: &Chart, folder: &Path) -> String {
    let mut text = format!(
        "{}: {} states against {} paths a pixel, whose own noise is {:.3} %; frames on {}\n",
        chart.scene,
        chart.states,
        chart.reference_samples,
        100.0 * chart.noise.relative_l2.median,
        chart.adapter
    );
    let line = |point: &Point| {
        let (errors, frame) = (&point.errors, &point.frame);
        format!(
            "{:<16} {:<14} {:<32} error {:>7.3} % (worst {:>7.3} %), FLIP {:.4}, {:>8.2} ms ({:.2} times, {:.2} to {:.2}), {:>7.1} MB, baked in {:.0} s\n",
            point.method,
            point.series,
            point.label,
            100.0 * errors.relative_l2.median,
            100.0 * errors.relative_l2.worst,
            errors.flip.median,
            frame.median_ms,
            frame.ratio,
            frame.ratio_low,
            frame.ratio_high,
            point.bytes_on_disk as f64 / 1e6,
            point.bake_seconds
        )
    };
    text += &chart.points.iter().map(line).collect::<String>();
    text + &format!("look at {}\n", folder.join("chart.svg").display())
}
