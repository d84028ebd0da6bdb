//! What two charts of a scene say differently.
//!
//! Errors and bytes follow from the scene and the seeds, so they should not differ at all. Times do; a time
//! ratio differs if it lies outside of the interval that was printed for it.

use crate::figures::{Chart, ImageErrors, Point};

/// Lines that say what in `after` is not as in `before`, or the one that nothing is.
pub fn between(before: &Chart, after: &Chart) -> Vec<String> {
    let mut lines = conditions(before, after);
    lines.extend(
        errors(&before.noise, &after.noise).map(|change| format!("noise of the reference: {change}")),
    );
    for point in &after.points {
        match before.points.iter().find(|old| old.name() == point.name()) {
            None => lines.push(format!("{}: new point", point.name())),
            Some(old) => lines.extend(
                of_point(old, point, before.baseline == after.baseline)
                    .map(|change| format!("{}: {change}", point.name())),
            ),
        }
    }
    let gone = before.points.iter().filter(|old| after.points.iter().all(|point| point.name() != old.name()));
    lines.extend(gone.map(|old| format!("{}: no longer there", old.name())));
    if lines.is_empty() {
        lines.push("all figures as before, time ratios within their intervals".to_owned());
    }
    lines
}

/// Under what it was measured.
fn conditions(before: &Chart, after: &Chart) -> Vec<String> {
    let told = |chart: &Chart| {
        [
            ("size", format!("{}×{}", chart.size[0], chart.size[1])),
            ("states", chart.states.to_string()),
            ("samples of the reference", chart.reference_samples.to_string()),
            ("adapter", chart.adapter.clone()),
            ("machine", chart.machine.clone()),
            ("program", chart.program.clone()),
            ("baseline of the time ratios", chart.baseline.clone()),
        ]
    };
    let pairs = told(before).into_iter().zip(told(after));
    pairs
        .filter(|(old, new)| old.1 != new.1)
        .map(|((name, old), (_, new))| format!("{name}: {new}, was {old}"))
        .collect()
}

fn of_point<'a>(
    before: &'a Point,
    after: &'a Point,
    one_baseline: bool,
) -> impl Iterator<Item = String> + 'a {
    let bytes = [
        ("bytes on disk", before.bytes_on_disk, after.bytes_on_disk),
        ("bytes in memory", before.bytes_in_memory, after.bytes_in_memory),
    ];
    let bytes = bytes
        .into_iter()
        .filter(|(_, old, new)| old != new)
        .map(|(name, old, new)| format!("{name} {new}, were {old}"));
    let settings = (before.settings != after.settings).then(|| "other settings".to_owned());
    settings.into_iter().chain(errors(&before.errors, &after.errors)).chain(bytes).chain(ratio(
        before,
        after,
        one_baseline,
    ))
}

fn ratio(before: &Point, after: &Point, one_baseline: bool) -> Option<String> {
    let (old, new) = (&before.frame, after.frame.ratio);
    let outside = one_baseline && !(old.ratio_low..=old.ratio_high).contains(&new);
    outside.then(|| format!("frame time ratio {new:.4}, outside {:.4}..{:.4}", old.ratio_low, old.ratio_high))
}

/// The figures that differ at all, in full.
fn errors<'a>(before: &'a ImageErrors, after: &'a ImageErrors) -> impl Iterator<Item = String> + use<'a> {
    let told = |e: &ImageErrors| {
        [("relative L2", e.relative_l2), ("relMSE", e.rel_mse), ("FLIP", e.flip), ("maximum", e.maximum)]
    };
    let pairs = told(before).into_iter().zip(told(after));
    pairs.flat_map(|((name, old), (_, new))| {
        let both = [("median", old.median, new.median), ("worst", old.worst, new.worst)];
        both.into_iter()
            .filter(|(_, old, new)| old != new)
            .map(move |(which, old, new)| format!("{name}, {which} {new}, was {old}"))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_chart::chart;

    fn after(change: impl FnOnce(&mut Chart)) -> Vec<String> {
        let mut changed = chart();
        change(&mut changed);
        between(&chart(), &changed)
    }

    #[test]
    fn a_time_within_its_interval_and_another_day_are_no_change() {
        let lines = after(|c| {
            c.points[3].frame.ratio = c.points[3].frame.ratio_high;
            c.points[3].frame.median_ms *= 3.0;
            c.points[3].bake_seconds *= 2.0;
            c.date = "2027-01-01".to_owned();
        });
        assert_eq!(lines, ["all figures as before, time ratios within their intervals"]);
    }

    #[test]
    fn the_last_bit_of_an_error_is_a_change() {
        let lines = after(|c| c.points[3].errors.flip.worst = c.points[3].errors.flip.worst.next_up());
        assert_eq!(lines.len(), 1);
        assert!(lines[0].starts_with("transfer-images, 256 spp, 5 bases: FLIP, worst "), "{lines:?}");
        let lines = after(|c| c.noise.rel_mse.median = f64::INFINITY);
        assert!(lines[0].starts_with("noise of the reference: relMSE, median inf, was "), "{lines:?}");
    }

    #[test]
    fn bytes_ratios_points_and_conditions_are_told() {
        let lines = after(|c| {
            c.points[0].bytes_in_memory = 5;
            c.points[1].frame.ratio = 9.0;
            c.points[2].label = "another".to_owned();
            c.adapter = "a GPU".to_owned();
        });
        let expected = [
            "adapter: a GPU, was llvmpipe (LLVM 19.1.7, 256 bits)",
            "transfer-images, 256 spp, 2 bases: bytes in memory 5, were 2400000",
            "transfer-images, 256 spp, 3 bases: frame time ratio 9.0000, outside 0.3806..0.4069",
            "transfer-images, 256 spp, another: new point",
            "transfer-images, 256 spp, 4 bases: no longer there",
        ];
        assert_eq!(lines, expected);
    }

    #[test]
    fn ratios_to_another_baseline_are_not_compared() {
        let lines = after(|c| {
            c.points[1].frame.ratio = 9.0;
            c.baseline = c.points[0].name();
        });
        assert_eq!(
            lines,
            [
                "baseline of the time ratios: transfer-images, 256 spp, 2 bases, was transfer-images, 256 spp, 6 bases"
            ]
        );
    }
}
