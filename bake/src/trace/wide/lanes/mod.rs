//! Eight numbers at once: what the traversal needs of a processor's vector instructions, and the same without
//! any.

mod plain;
#[cfg(target_arch = "x86_64")]
mod x86;

pub use plain::Plain;

/// Numbers side by side.
pub const LANES: usize = 8;

/// Instructions on eight numbers. All give the same bits but for [`Lanes::mul_sub`], which may round once or
/// twice, and for the order of [`Lanes::sorted`] and [`Lanes::packed`].
pub trait Lanes: Copy {
    /// Eight numbers.
    type F32: Copy;
    /// Some of eight lanes.
    type Mask: Copy;

    /// Runs `work` compiled for these instructions.
    fn run<T>(self, work: impl FnOnce() -> T) -> T;
    /// Numbers from memory.
    fn load(self, from: &[f32; LANES]) -> Self::F32;
    /// Numbers to memory.
    fn store(self, a: Self::F32) -> [f32; LANES];
    /// One number in all lanes.
    fn splat(self, a: f32) -> Self::F32;
    /// a + b.
    fn add(self, a: Self::F32, b: Self::F32) -> Self::F32;
    /// a − b.
    fn sub(self, a: Self::F32, b: Self::F32) -> Self::F32;
    /// a·b.
    fn mul(self, a: Self::F32, b: Self::F32) -> Self::F32;
    /// a/b.
    fn div(self, a: Self::F32, b: Self::F32) -> Self::F32;
    /// a·b − c.
    fn mul_sub(self, a: Self::F32, b: Self::F32, c: Self::F32) -> Self::F32;
    /// The smaller; b if one is no number.
    fn min(self, a: Self::F32, b: Self::F32) -> Self::F32;
    /// The larger; b if one is no number.
    fn max(self, a: Self::F32, b: Self::F32) -> Self::F32;
    /// The largest whole numbers that are not larger.
    fn floor(self, a: Self::F32) -> Self::F32;
    /// Where a < b.
    fn lt(self, a: Self::F32, b: Self::F32) -> Self::Mask;
    /// Where a ≤ b.
    fn le(self, a: Self::F32, b: Self::F32) -> Self::Mask;
    /// Lanes of either.
    fn or(self, a: Self::Mask, b: Self::Mask) -> Self::Mask;
    /// Lanes of both.
    fn and(self, a: Self::Mask, b: Self::Mask) -> Self::Mask;
    /// With lane 0 in the lowest bit.
    fn bits(self, a: Self::Mask) -> u32;
    /// The codes of the lanes in `mask` first, whatever comes after them.
    fn packed(self, mask: u32, codes: &[u32; LANES]) -> [u32; LANES];
    /// [`entry`] of each lane in `mask`, which are at most four, the farthest first; whatever comes after them.
    fn sorted(self, mask: u32, distances: Self::F32, codes: &[u32; LANES]) -> [u64; 4];
}

/// A code below its distance, which is at least 0, so that the bits of entries are in their order. The distance may
/// be less by the number of a lane in its lowest bits.
pub fn entry(distance: f32, code: u32) -> u64 {
    u64::from(distance.to_bits() & !(LANES as u32 - 1)) << 32 | u64::from(code)
}

/// The distance of an [`entry`].
pub fn distance_of(entry: u64) -> f32 {
    f32::from_bits((entry >> 32) as u32)
}

/// The set lanes of a mask, the lowest first.
#[inline(always)]
pub fn lanes_of(mut mask: u32) -> impl Iterator<Item = usize> {
    std::iter::from_fn(
        #[inline(always)]
        move || {
            let lane = mask.trailing_zeros() as usize;
            let found = (mask != 0).then_some(lane);
            mask &= mask.wrapping_sub(1);
            found
        },
    )
}
