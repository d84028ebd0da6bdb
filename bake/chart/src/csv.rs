//! `chart.csv`: the figures as a table, a row a point; units stand in the names of the columns.

use super::digits::rounded;
use super::figures::{CSV, Chart, ImageErrors, OverStates, Point};
use relume_formats::{Error, Place, Result};

/// The table. Errors have no unit: a relative L2 of 0.01 is 1 %.
///
/// # Errors
/// If a cell cannot be written, which does not happen in memory.
pub fn table(chart: &Chart) -> Result<Vec<u8>> {
    let failed = |e: String| Error::invalid(&Place::file(CSV), e);
    let mut writer = csv::Writer::from_writer(Vec::new());
    for (number, point) in chart.points.iter().enumerate() {
        let cells = cells(chart, point);
        if number == 0 {
            writer.write_record(cells.iter().map(|(name, _)| name)).map_err(|e| failed(e.to_string()))?;
        }
        writer.write_record(cells.iter().map(|(_, value)| value)).map_err(|e| failed(e.to_string()))?;
    }
    writer.into_inner().map_err(|e| failed(e.to_string()))
}

/// The cells of a row, each with the name of its column.
fn cells(chart: &Chart, point: &Point) -> Vec<(String, String)> {
    let text = |name: &str, value: &str| (name.to_owned(), value.to_owned());
    let number = |name: &str, value: f64| (name.to_owned(), significant(value));
    let settings: Vec<String> =
        point.settings.iter().map(|(name, value)| format!("{name}={value}")).collect();
    let mut cells = vec![
        text("scene", &chart.scene),
        text("method", &point.method),
        text("series", &point.series),
        text("label", &point.label),
    ];
    cells.push(("settings".to_owned(), settings.join(" ")));
    cells.extend(errors("", &point.errors));
    let frame = &point.frame;
    cells.extend([
        number("frame_median_ms", frame.median_ms),
        number("frame_p95_ms", frame.p95_ms),
        number("frame_ratio_to_baseline", frame.ratio),
        number("frame_ratio_low_95", frame.ratio_low),
        number("frame_ratio_high_95", frame.ratio_high),
    ]);
    cells.push(("disk_bytes".to_owned(), point.bytes_on_disk.to_string()));
    cells.push(("memory_bytes".to_owned(), point.bytes_in_memory.to_string()));
    cells.push(number("bake_s", point.bake_seconds));
    cells.extend(errors("noise_", &chart.noise));
    cells
}

fn errors(of: &str, errors: &ImageErrors) -> impl Iterator<Item = (String, String)> {
    let all = [
        ("relative_l2", errors.relative_l2),
        ("rel_mse", errors.rel_mse),
        ("flip", errors.flip),
        ("maximum_over_mean", errors.maximum),
    ];
    let of = of.to_owned();
    all.into_iter().flat_map(move |(name, OverStates { median, worst })| {
        [
            (format!("{of}{name}_median"), significant(median)),
            (format!("{of}{name}_worst"), significant(worst)),
        ]
    })
}

/// Six significant digits, without an exponent; `inf` if infinite.
fn significant(value: f64) -> String {
    rounded(value, 6).to_string()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_chart::chart;

    #[test]
    fn every_row_has_the_cells_of_the_header_and_comes_back() {
        let mut chart = chart();
        chart.points[0].label = "a, \"b\"".to_owned();
        chart.points[1].errors.relative_l2.worst = f64::INFINITY;
        let bytes = table(&chart).unwrap();
        // The reader refuses rows of another length than the header's.
        let mut reader = csv::Reader::from_reader(&bytes[..]);
        let header = reader.headers().unwrap().clone();
        let column = |name: &str| header.iter().position(|h| h == name).unwrap();
        let rows: Vec<csv::StringRecord> = reader.records().map(|row| row.unwrap()).collect();
        assert_eq!(rows.len(), chart.points.len());
        assert_eq!(&rows[0][column("label")], "a, \"b\"");
        assert_eq!(&rows[1][column("relative_l2_worst")], "inf");
        for (row, point) in rows.iter().zip(&chart.points) {
            let read = |name: &str| row[column(name)].parse::<f64>().unwrap();
            for (name, value) in [
                ("relative_l2_median", point.errors.relative_l2.median),
                ("flip_worst", point.errors.flip.worst),
                ("frame_median_ms", point.frame.median_ms),
                ("bake_s", point.bake_seconds),
                ("noise_relative_l2_median", chart.noise.relative_l2.median),
            ] {
                assert!((read(name) - value).abs() <= 5e-6 * value, "{name}");
            }
            assert_eq!(row[column("disk_bytes")], point.bytes_on_disk.to_string());
        }
    }

    #[test]
    fn six_digits() {
        for (value, text) in [
            (0.0, "0"),
            (1.0, "1"),
            (0.000_123_456_789, "0.000123457"),
            (9.999_999_9, "10"),
            (1_234_567.8, "1234570"),
            (f64::INFINITY, "inf"),
            (0.012_5, "0.0125"),
        ] {
            assert_eq!(significant(value), text);
        }
    }
}
