//! Bits, such as what rays saw, as bytes.

/// `bits`, eight to a byte, the first in the lowest place; what is left of the last byte is 0.
pub fn pack(bits: &[bool]) -> Vec<u8> {
    let byte = |eight: &[bool]| (0..).zip(eight).fold(0, |byte, (place, bit)| byte | u8::from(*bit) << place);
    bits.chunks(8).map(byte).collect()
}

/// Reads packed bits one after the other, as many as the reader turns out to need.
#[derive(Debug, Clone)]
pub struct BitReader<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl<'a> BitReader<'a> {
    /// From the first bit on.
    pub fn new(bytes: &'a [u8]) -> Self {
        Self { bytes, at: 0 }
    }

    /// The next bit; behind the last byte, 0.
    pub fn take(&mut self) -> bool {
        let byte = self.bytes.get(self.at / 8).copied().unwrap_or(0);
        let bit = byte >> (self.at % 8) & 1 == 1;
        self.at += 1;
        bit
    }

    /// Whether the bits that were taken are all that [`pack`] had made these bytes of, as far as that can be
    /// told.
    pub fn is_at_end(&self) -> bool {
        self.at.div_ceil(8) == self.bytes.len()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Bits of any density: the `shift`-th of a counter's hash, ANDed with as many more as make it rare.
    fn random(count: usize, seed: u64, rare: u32) -> Vec<bool> {
        let mut state = seed;
        let mut word = || {
            state = state.wrapping_mul(0x5851_f42d_4c95_7f2d).wrapping_add(0x1405_7b7e_f767_814f);
            state >> 33
        };
        (0..count).map(|_| (0..=rare).all(|_| word() % 3 != 0)).collect()
    }

    #[test]
    fn any_bits_come_back() {
        for count in (0..40).chain([1000, 24_576]) {
            for seed in 0..4 {
                let bits = random(count, seed, seed as u32 * 3);
                let bytes = pack(&bits);
                assert_eq!(bytes.len(), count.div_ceil(8));
                let mut reader = BitReader::new(&bytes);
                for bit in &bits {
                    assert_eq!(reader.take(), *bit);
                }
                assert!(reader.is_at_end());
                assert!((count..8 * bytes.len()).all(|_| !reader.take()), "what fills up is 0");
            }
        }
    }

    #[test]
    fn too_many_and_too_few_are_told() {
        let bytes = pack(&[true; 17]);
        let mut reader = BitReader::new(&bytes);
        assert!((0..16).all(|_| reader.take()) && !reader.is_at_end());
        assert!(reader.take() && reader.is_at_end());
        assert!((0..9).all(|_| !reader.take()) && !reader.is_at_end());
    }
}
