//! Which few of many are looked at.

/// `count` of the numbers below `all`, or all of these, spread by the golden section: evenly, but in step
/// with nothing.
pub fn spread(count: usize, all: usize) -> Vec<usize> {
    const GOLDEN: f64 = 0.618_033_988_749_894_9;
    if count >= all {
        return (0..all).collect();
    }
    let mut some: Vec<usize> =
        (0..count).map(|k| ((k as f64 * GOLDEN).fract() * all as f64) as usize).collect();
    some.sort_unstable();
    some.dedup();
    some
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_spread_evenly_and_none_is_there_twice() {
        for (count, all) in [(0, 0), (3, 2), (7, 7), (10, 1000), (96, 100), (256, 65_536)] {
            let some = spread(count, all);
            assert!(some.is_sorted_by(|a, b| a < b) && some.iter().all(|i| *i < all), "{count} of {all}");
            assert!(some.len() >= count.min(all) * 4 / 5, "{count} of {all}: {}", some.len());
            // Gaps between the first n multiples of the golden section, modulo 1, are at most its square
            // times the largest of the step before: below 2.7/n.
            let gaps = some.windows(2).map(|w| w[1] - w[0]);
            assert!(
                gaps.max().unwrap_or(0) as f64 <= 2.7 * all as f64 / count.max(1) as f64 + 1.0,
                "{count} of {all}"
            );
        }
    }
}
