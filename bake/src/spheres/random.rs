//! Random numbers as functions of what they are for.

/// A number that looks random for each `x`: the finaliser of SplitMix64 (Steele et al. 2014).
pub fn hash(x: u64) -> u64 {
    let z = x.wrapping_add(0x9E37_79B9_7F4A_7C15);
    let z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    let z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    z ^ (z >> 31)
}

/// From 0 to below 1.
pub fn unit(x: u64) -> f64 {
    (hash(x) >> 11) as f64 / (1_u64 << 53) as f64
}
