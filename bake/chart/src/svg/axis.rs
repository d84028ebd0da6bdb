//! A logarithmic axis: where a value lies, and which values are written beside it.

/// Mantissas of ticks, from few to many.
const LADDERS: [&[&str]; 5] = [
    &["1"],
    &["1", "3"],
    &["1", "2", "5"],
    &["1", "1.5", "2", "3", "4", "5", "7"],
    &["1", "1.2", "1.4", "1.6", "1.8", "2", "2.5", "3", "3.5", "4", "5", "6", "7", "8", "9"],
];
/// An axis spans at least this factor, so that two equal values are not blown up to a whole axis.
const LEAST_SPAN: f64 = 2.0;
/// Room at either end, in parts of the span.
const MARGIN: f64 = 0.07;

/// An axis of positive values.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LogAxis {
    /// Natural logarithms of the values at both ends.
    ends: [f64; 2],
    /// Coordinates of both ends in the picture.
    at: [f64; 2],
}

impl LogAxis {
    /// An axis from `at[0]` to `at[1]` that holds all of `values`, which are positive and finite.
    pub fn new(values: impl Iterator<Item = f64>, at: [f64; 2]) -> Self {
        let (low, high) = values
            .map(f64::ln)
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)));
        let (low, high) = if low <= high { (low, high) } else { (0.0, 0.0) };
        let (middle, half) =
            (0.5 * (low + high), 0.5 * (high - low).max(LEAST_SPAN.ln()) * (1.0 + 2.0 * MARGIN));
        Self { ends: [middle - half, middle + half], at }
    }

    /// The coordinate of `value`.
    pub fn place(&self, value: f64) -> f64 {
        let part = (value.ln() - self.ends[0]) / (self.ends[1] - self.ends[0]);
        self.at[0] + part * (self.at[1] - self.at[0])
    }

    /// Round values on the axis, in order: as many as fit up to `most`, which is at least 6; two or more.
    pub fn ticks(&self, most: usize) -> Vec<f64> {
        let ladders = LADDERS.iter().map(|mantissas| self.round_values(mantissas));
        let decades = self.round_values(LADDERS[0]);
        let mut ticks = ladders.rev().find(|ticks| ticks.len() <= most).unwrap_or(decades);
        // A span of very many decades gets every second one, or every third.
        let step = ticks.len().div_ceil(most.max(1)).max(1);
        let mut number = 0;
        ticks.retain(|_| {
            number += 1;
            (number - 1) % step == 0
        });
        ticks
    }

    fn round_values(&self, mantissas: &[&str]) -> Vec<f64> {
        let [from, to] = self.ends.map(|end| (end / std::f64::consts::LN_10).floor() as i32);
        let all = (from..=to).flat_map(|exponent| {
            mantissas.iter().filter_map(move |m| format!("{m}e{exponent}").parse::<f64>().ok())
        });
        all.filter(|v| (self.ends[0]..=self.ends[1]).contains(&v.ln())).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn axis(values: &[f64]) -> LogAxis {
        LogAxis::new(values.iter().copied(), [100.0, 500.0])
    }

    #[test]
    fn ends_and_middle_are_where_logarithms_put_them() {
        let axis = axis(&[1.0, 100.0]);
        assert!((axis.place(10.0) - 300.0).abs() < 1e-9);
        // Two decades take 1 / 1.14 of the 400 units.
        assert!((axis.place(100.0) - axis.place(1.0) - 400.0 / 1.14).abs() < 1e-9);
    }

    #[test]
    fn ticks_are_round_and_as_many_as_fit() {
        assert_eq!(axis(&[1.0, 100.0]).ticks(8), [1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0]);
        assert_eq!(axis(&[1e-3, 1e3]).ticks(8), [1e-3, 1e-2, 1e-1, 1.0, 10.0, 100.0, 1e3]);
        assert_eq!(axis(&[30.0, 30.0]).ticks(8), [25.0, 30.0, 35.0, 40.0]);
        assert!(axis(&[1e-30, 1e30]).ticks(8).len() <= 8);
        assert!(!axis(&[]).ticks(8).is_empty());
    }

    proptest! {
        #[test]
        fn every_value_and_tick_is_on_the_axis(values in prop::collection::vec(1e-6f64..1e9, 1..20), most in 6usize..12) {
            let axis = axis(&values);
            prop_assert!(values.iter().all(|v| (100.0..=500.0).contains(&axis.place(*v))));
            let ticks = axis.ticks(most);
            prop_assert!((2..=most).contains(&ticks.len()), "{:?}", ticks);
            prop_assert!(ticks.windows(2).all(|w| w[0] < w[1]));
            prop_assert!(ticks.iter().all(|v| (99.9..=500.1).contains(&axis.place(*v))));
        }
    }
}
