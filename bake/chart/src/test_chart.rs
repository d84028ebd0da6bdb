//! A chart of made-up figures for tests: three methods, 25 points, some of them nearly on one spot.

use super::figures::{Chart, FrameTime, ImageErrors, OverStates, Picture, Point};

fn over(median: f64) -> OverStates {
    OverStates { median, worst: 2.5 * median }
}

fn errors(relative_l2: f64) -> ImageErrors {
    ImageErrors {
        relative_l2: over(relative_l2),
        rel_mse: over(relative_l2 * relative_l2),
        flip: over(0.4 * relative_l2),
        maximum: over(9.0 * relative_l2),
    }
}

fn point(method: &str, series: &str, label: &str, [error, ms, bytes, seconds]: [f64; 4]) -> Point {
    let frame = FrameTime {
        median_ms: ms,
        p95_ms: 1.3 * ms,
        ratio: ms / 3.0,
        ratio_low: ms / 3.1,
        ratio_high: ms / 2.9,
    };
    Point {
        method: method.to_owned(),
        series: series.to_owned(),
        label: label.to_owned(),
        settings: [("a".to_owned(), serde_json::json!(3)), ("b".to_owned(), serde_json::json!("x"))].into(),
        errors: errors(error),
        frame,
        bytes_on_disk: bytes as u64,
        bytes_in_memory: 2 * bytes as u64,
        bake_seconds: seconds,
    }
}

/// The chart.
pub(crate) fn chart() -> Chart {
    let mut points = Vec::new();
    for (k, bases) in [2, 3, 4, 5, 6, 8, 12, 16].into_iter().enumerate() {
        let n = f64::from(bases);
        // The error stops falling at 6 bases, so that the last points crowd.
        let error = 0.3 * (-0.9 * n.min(6.5)).exp() + 0.0021 / (1.0 + 0.01 * n);
        points.push(point(
            "transfer-images",
            "256 spp",
            &format!("{bases} bases"),
            [error, 1.0 + 0.06 * n, 6e5 * n, 41.0 + 0.2 * k as f64],
        ));
    }
    for (k, samples) in [16, 64, 1024].into_iter().enumerate() {
        let cost = f64::from(samples);
        points.push(point(
            "transfer-images",
            "8 bases",
            &format!("{samples} samples"),
            [0.03 / cost.sqrt() + 0.0012, 1.5, 4.4e6 + 3e4 * k as f64, 0.17 * cost],
        ));
    }
    for terms in [16, 32, 64, 128, 256, 512, 1024] {
        let n = f64::from(terms);
        points.push(point(
            "sparse-transfer",
            "8 bits",
            &format!("{terms} terms"),
            [0.4 / n.powf(0.75) + 0.004, 2.0 + 0.011 * n, 9e3 * n, 70.0],
        ));
    }
    for (k, spheres) in [32, 64, 96, 128].into_iter().enumerate() {
        let n = f64::from(spheres);
        points.push(point(
            "sphere-shadows",
            "level II",
            &format!("{spheres} spheres, II"),
            [0.2 / n.sqrt(), 5.0 + 0.1 * n, 3e6 + 40.0 * n, 12.0 + 3.0 * k as f64],
        ));
    }
    for (k, spheres) in [32, 64, 128].into_iter().enumerate() {
        let n = f64::from(spheres);
        points.push(point(
            "sphere-shadows",
            "level I",
            &format!("{spheres} spheres, I"),
            [0.21 / n.sqrt(), 4.6 + 0.08 * n, 3e6 + 40.0 * n, 12.0 + 3.0 * k as f64],
        ));
    }
    Chart {
        scene: "made-up".to_owned(),
        size: [256, 256],
        states: 16,
        reference_samples: 4096,
        reference_seconds: 312.5,
        noise: errors(0.0011),
        adapter: "llvmpipe (LLVM 19.1.7, 256 bits)".to_owned(),
        baseline: points[4].name(),
        picture: Picture { point: points[4].name(), factor: 20.0 },
        machine: "Some Processor @ 2.50GHz, 2 cores, 24 GiB".to_owned(),
        date: "2026-01-31".to_owned(),
        program: "bake 0.1.0".to_owned(),
        points,
    }
}
