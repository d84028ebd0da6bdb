//! Non-linear approximation: the few coefficients that matter most (sphere shadows §3.4).
//!
//! What matters is |coefficient| × weight. With weight 1 the kept terms are the largest, which leaves the least squared error. Weighted with the area of its
//! support a term counts by the largest error that it can leave under light of a given brightness, so that low frequencies come first.

use super::haar::support;
use std::cmp::Reverse;

/// Index and value of the `k` coefficients of largest |coefficient| × `weight`(index), most important first; of equals the one of lower index. Coefficients
/// that are 0 are never kept, so there may be fewer. `weight` must not be negative. O(N + k log k).
pub fn largest(coefficients: &[f32], k: usize, weight: impl Fn(usize) -> f32) -> Vec<(u32, f32)> {
    // Bits of positive floats are ordered as the floats are; with the index behind them every key is different.
    let key = |(index, value): (usize, &f32)| {
        let importance = value.abs() * weight(index);
        (importance > 0.0).then_some(Reverse((u64::from(importance.to_bits()) << 32) | u64::from(!(index as u32))))
    };
    let mut keys: Vec<Reverse<u64>> = coefficients.iter().enumerate().filter_map(key).collect();
    if k == 0 {
        return Vec::new();
    }
    if k < keys.len() {
        keys.select_nth_unstable(k - 1);
        keys.truncate(k);
    }
    keys.sort_unstable();
    keys.into_iter().map(|Reverse(key)| !(key as u32)).filter_map(|index| Some((index, *coefficients.get(index as usize)?))).collect()
}

/// The weight of choosing by size alone.
pub fn by_size(_index: usize) -> f32 {
    1.0
}

/// The weight of choosing by size × area, on faces of `n` × `n`: the number of texels of the support.
pub fn by_area(n: usize) -> impl Fn(usize) -> f32 {
    move |index| support(index, n) as f32
}
