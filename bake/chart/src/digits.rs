//! Numbers as people read them.

/// `value` rounded to `digits` significant digits.
pub(crate) fn rounded(value: f64, digits: usize) -> f64 {
    format!("{value:.*e}", digits.saturating_sub(1)).parse().unwrap_or(value)
}

/// Milliseconds: `200 µs`, `5 ms`, `2 s`.
pub(crate) fn milliseconds(value: f64) -> String {
    with_unit(value, &[(1e-3, "µs"), (1.0, "ms"), (1e3, "s")])
}

/// Seconds: `50 ms`, `20 s`, `1000 s`.
pub(crate) fn seconds(value: f64) -> String {
    with_unit(value, &[(1e-3, "ms"), (1.0, "s")])
}

/// Bytes in decimal units: `500 B`, `2 kB`, `1.5 MB`.
pub(crate) fn bytes(value: f64) -> String {
    with_unit(value, &[(1.0, "B"), (1e3, "kB"), (1e6, "MB"), (1e9, "GB")])
}

/// A part of one as a percentage: `0.5 %`.
pub(crate) fn percent(value: f64) -> String {
    with_unit(100.0 * value, &[(1.0, "%")])
}

/// Three significant digits in the largest of `units`, smallest first, that is not above the value.
fn with_unit(value: f64, units: &[(f64, &str)]) -> String {
    if value == f64::INFINITY {
        return "infinite".to_owned();
    }
    let value = rounded(value, 3);
    let fitting = units.iter().rfind(|(size, _)| value >= *size).or(units.first());
    let (size, name) = fitting.copied().unwrap_or((1.0, ""));
    format!("{} {name}", rounded(value / size, 3))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn three_digits_in_the_unit_that_fits() {
        assert_eq!(
            [0.2, 5.0, 999.9, 2000.0, 0.0].map(milliseconds),
            ["200 µs", "5 ms", "1 s", "2 s", "0 µs"]
        );
        assert_eq!([0.05, 20.0, 1234.0].map(seconds), ["50 ms", "20 s", "1230 s"]);
        assert_eq!(
            [1.0, 999.0, 1536.0, 3.14159e7, 2e9].map(bytes),
            ["1 B", "999 B", "1.54 kB", "31.4 MB", "2 GB"]
        );
        assert_eq!(
            [0.000_050_04, 0.5, 3.0, f64::INFINITY].map(percent),
            ["0.005 %", "50 %", "300 %", "infinite"]
        );
    }
}
