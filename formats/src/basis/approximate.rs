//! Non-linear approximation: the few coefficients that matter most (sphere shadows §3.4).
//!
//! What matters is |coefficient| × weight. With weight 1 the kept terms are the largest, which leaves the
//! least squared error. Weighted with the area of their supports, terms of low frequency come first, which
//! matter more under the light of most maps. Which is better depends on the light.

use super::haar::support;
use std::cmp::Reverse;

/// Index and value of the `k` coefficients of largest |coefficient| × `weight`(index), most important first;
/// of equals the one of lower index. Coefficients that are 0 are never kept, so there may be fewer. `weight`
/// must not be negative. O(N + k log k).
pub fn largest(coefficients: &[f32], k: usize, weight: impl Fn(usize) -> f32) -> Vec<(u32, f32)> {
    if k == 0 {
        return Vec::new();
    }
    let mut keys: Vec<Reverse<u64>> = Vec::with_capacity(coefficients.len().min(k.saturating_mul(2)));
    let mut least = Reverse(0);
    for (index, value) in coefficients.iter().enumerate() {
        let importance = value.abs() * weight(index);
        // Bits of positive floats are ordered as the floats are; with the index behind them every key is
        // different.
        let key = Reverse((u64::from(importance.to_bits()) << 32) | u64::from(!(index as u32)));
        if importance > 0.0 && key < least {
            keys.push(key);
            // Thinned out now and then, so that most of the rest need no more than the comparison.
            if keys.len() == k.saturating_mul(2) {
                least = *keys.select_nth_unstable(k - 1).1;
                keys.truncate(k);
            }
        }
    }
    keys.sort_unstable();
    keys.truncate(k);
    keys.into_iter()
        .map(|Reverse(key)| !(key as u32))
        .filter_map(|index| Some((index, *coefficients.get(index as usize)?)))
        .collect()
}

/// The weight of choosing by size alone.
pub fn by_size(_index: usize) -> f32 {
    1.0
}

/// The weight of choosing by size × area, on faces of `n` × `n`: the number of texels of the support.
pub fn by_area(n: usize) -> impl Fn(usize) -> f32 {
    move |index| support(index, n) as f32
}
