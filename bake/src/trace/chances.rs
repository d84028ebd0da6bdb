//! Choosing by chance: running sums over what there is to choose.

/// How many different numbers in [0, 1) samples have.
const GRAINS: f64 = 16_777_216.0;
/// A share that is chosen by one of them at least.
pub const LEAST_SHARE: f64 = 2.0 / GRAINS;

/// Running sums of `weights`, as shares of their sum; they end in 1. Without any weight, all have the same.
///
/// They are as fine as numbers that have chosen nothing yet, so that of these a share is exactly the chance.
pub fn running_share(weights: &[f64]) -> Vec<f32> {
    let total: f64 = weights.iter().sum();
    let even = 1.0 / weights.len() as f64;
    let mut sum = 0.0;
    let mut cdf: Vec<f32> = weights
        .iter()
        .map(|w| {
            sum += if total > 0.0 { w / total } else { even };
            (sum * GRAINS).round() as f32 / GRAINS as f32
        })
        .collect();
    if let Some(last) = cdf.last_mut() {
        *last = 1.0;
    }
    cdf
}

/// The chance of number `index`.
pub fn share(cdf: &[f32], index: usize) -> f32 {
    cdf[index] - if index == 0 { 0.0 } else { cdf[index - 1] }
}

/// The interval of `cdf` that `u` in [0, 1) falls in and where within it, both ends excluded from intervals
/// of no width.
pub fn pick(cdf: &[f32], u: f32) -> (usize, f32) {
    let index = cdf.partition_point(|c| *c <= u).min(cdf.len() - 1);
    let start = if index == 0 { 0.0 } else { cdf[index - 1] };
    (index, ((u - start) / (cdf[index] - start)).clamp(0.0, 1.0))
}
