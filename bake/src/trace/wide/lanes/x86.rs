use super::{LANES, Lanes};
use pulp::x86::{V3, V4};
use pulp::{cast, f32x8, m32x8};
use std::arch::x86_64::{__m128i, __m256i};

/// For each mask the numbers of its lanes, a byte each, and then bytes above 127.
static LANES_OF: [u64; 1 << LANES] = {
    let mut table = [u64::MAX; 1 << LANES];
    let mut mask = 0;
    while mask < table.len() {
        let (mut lane, mut at) = (0, 0);
        while lane < LANES {
            if mask >> lane & 1 == 1 {
                table[mask] = table[mask] & !(0xFF << (8 * at)) | (lane as u64) << (8 * at);
                at += 1;
            }
            lane += 1;
        }
        mask += 1;
    }
    table
};

/// What AVX2 and AVX-512 have in common.
macro_rules! common {
    () => {
        type F32 = f32x8;

        #[inline(always)]
        fn run<T>(self, work: impl FnOnce() -> T) -> T {
            self.vectorize(work)
        }

        #[inline(always)]
        fn load(self, from: &[f32; LANES]) -> Self::F32 {
            cast(*from)
        }

        #[inline(always)]
        fn store(self, a: Self::F32) -> [f32; LANES] {
            cast(a)
        }

        #[inline(always)]
        fn splat(self, a: f32) -> Self::F32 {
            self.splat_f32x8(a)
        }

        #[inline(always)]
        fn add(self, a: Self::F32, b: Self::F32) -> Self::F32 {
            cast(self.avx._mm256_add_ps(cast(a), cast(b)))
        }

        #[inline(always)]
        fn sub(self, a: Self::F32, b: Self::F32) -> Self::F32 {
            cast(self.avx._mm256_sub_ps(cast(a), cast(b)))
        }

        #[inline(always)]
        fn mul(self, a: Self::F32, b: Self::F32) -> Self::F32 {
            cast(self.avx._mm256_mul_ps(cast(a), cast(b)))
        }

        #[inline(always)]
        fn div(self, a: Self::F32, b: Self::F32) -> Self::F32 {
            cast(self.avx._mm256_div_ps(cast(a), cast(b)))
        }

        #[inline(always)]
        fn mul_sub(self, a: Self::F32, b: Self::F32, c: Self::F32) -> Self::F32 {
            cast(self.fma._mm256_fmsub_ps(cast(a), cast(b), cast(c)))
        }

        #[inline(always)]
        fn min(self, a: Self::F32, b: Self::F32) -> Self::F32 {
            cast(self.avx._mm256_min_ps(cast(a), cast(b)))
        }

        #[inline(always)]
        fn max(self, a: Self::F32, b: Self::F32) -> Self::F32 {
            cast(self.avx._mm256_max_ps(cast(a), cast(b)))
        }

        #[inline(always)]
        fn floor(self, a: Self::F32) -> Self::F32 {
            cast(self.avx._mm256_floor_ps(cast(a)))
        }

        #[inline(always)]
        fn sorted(self, mask: u32, distances: Self::F32, codes: &[u32; LANES]) -> [u64; 4] {
            let avx2 = self.avx2;
            // The lane in place of the lowest bits: what sorts distances sorts codes.
            let bits = avx2._mm256_and_si256(cast(distances), self.avx._mm256_set1_epi32(-8));
            let lanes = avx2._mm256_or_si256(bits, self.avx._mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7));
            let sorted = sort(&self, self.avx._mm256_castsi256_si128(self.first(mask, lanes)));
            let codes =
                avx2._mm256_permutevar8x32_epi32(cast(*codes), self.avx._mm256_castsi128_si256(sorted));
            let codes = self.avx._mm256_castsi256_si128(codes);
            let bits = self.sse2._mm_and_si128(sorted, self.sse2._mm_set1_epi32(-8));
            let halves =
                [self.sse2._mm_unpacklo_epi32(codes, bits), self.sse2._mm_unpackhi_epi32(codes, bits)];
            cast(halves)
        }
    };
}

/// AVX2 and fused multiplications.
impl Lanes for V3 {
    type Mask = m32x8;

    common!();

    #[inline(always)]
    fn lt(self, a: Self::F32, b: Self::F32) -> Self::Mask {
        self.cmp_lt_f32x8(a, b)
    }

    #[inline(always)]
    fn le(self, a: Self::F32, b: Self::F32) -> Self::Mask {
        self.cmp_le_f32x8(a, b)
    }

    #[inline(always)]
    fn or(self, a: Self::Mask, b: Self::Mask) -> Self::Mask {
        cast(self.avx._mm256_or_ps(cast(a), cast(b)))
    }

    #[inline(always)]
    fn and(self, a: Self::Mask, b: Self::Mask) -> Self::Mask {
        cast(self.avx._mm256_and_ps(cast(a), cast(b)))
    }

    #[inline(always)]
    fn bits(self, a: Self::Mask) -> u32 {
        self.avx._mm256_movemask_ps(cast(a)) as u32
    }

    #[inline(always)]
    fn packed(self, mask: u32, codes: &[u32; LANES]) -> [u32; LANES] {
        cast(self.first(mask, cast(*codes)))
    }
}

/// AVX-512 on eight lanes.
impl Lanes for V4 {
    type Mask = u8;

    common!();

    #[inline(always)]
    fn lt(self, a: Self::F32, b: Self::F32) -> Self::Mask {
        self.avx512f._mm256_cmp_ps_mask::<{ std::arch::x86_64::_CMP_LT_OQ }>(cast(a), cast(b))
    }

    #[inline(always)]
    fn le(self, a: Self::F32, b: Self::F32) -> Self::Mask {
        self.avx512f._mm256_cmp_ps_mask::<{ std::arch::x86_64::_CMP_LE_OQ }>(cast(a), cast(b))
    }

    #[inline(always)]
    fn or(self, a: Self::Mask, b: Self::Mask) -> Self::Mask {
        a | b
    }

    #[inline(always)]
    fn and(self, a: Self::Mask, b: Self::Mask) -> Self::Mask {
        a & b
    }

    #[inline(always)]
    fn bits(self, a: Self::Mask) -> u32 {
        u32::from(a)
    }

    #[inline(always)]
    fn packed(self, mask: u32, codes: &[u32; LANES]) -> [u32; LANES] {
        cast(self.first(mask, cast(*codes)))
    }
}

trait First {
    /// Lanes of `mask` first, and then zeros.
    fn first(self, mask: u32, a: __m256i) -> __m256i;
}

impl First for V3 {
    #[inline(always)]
    fn first(self, mask: u32, a: __m256i) -> __m256i {
        let lanes: __m128i = cast([LANES_OF[mask as usize & 0xFF], 0]);
        let lanes = self.avx2._mm256_cvtepi8_epi32(lanes);
        let none = self.avx2._mm256_srai_epi32::<31>(lanes);
        self.avx2._mm256_andnot_si256(none, self.avx2._mm256_permutevar8x32_epi32(a, lanes))
    }
}

impl First for V4 {
    #[inline(always)]
    fn first(self, mask: u32, a: __m256i) -> __m256i {
        self.avx512f._mm256_maskz_compress_epi32(mask as u8, a)
    }
}

/// The largest first.
#[inline(always)]
fn sort(simd: &V3, a: __m128i) -> __m128i {
    let (sse2, sse4, avx2) = (simd.sse2, simd.sse4_1, simd.avx2);
    let swapped = sse2._mm_shuffle_epi32::<0b10_11_00_01>(a);
    let a = avx2._mm_blend_epi32::<0b1010>(sse4._mm_max_epu32(a, swapped), sse4._mm_min_epu32(a, swapped));
    let swapped = sse2._mm_shuffle_epi32::<0b00_01_10_11>(a);
    let a = avx2._mm_blend_epi32::<0b1100>(sse4._mm_max_epu32(a, swapped), sse4._mm_min_epu32(a, swapped));
    let swapped = sse2._mm_shuffle_epi32::<0b10_11_00_01>(a);
    avx2._mm_blend_epi32::<0b1010>(sse4._mm_max_epu32(a, swapped), sse4._mm_min_epu32(a, swapped))
}
