//! Eight numbers at once: what the traversal needs of a processor's vector instructions, and the same without
//! any.

/// Numbers side by side.
pub const LANES: usize = 8;

/// Instructions on eight numbers. All give the same bits but for [`Lanes::mul_sub`], which may round once or
/// twice. Masks have lane 0 in their lowest bit.
pub trait Lanes: Copy {
    /// Eight numbers.
    type F32: Copy;

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
    /// The smaller; either if one is no number.
    fn min(self, a: Self::F32, b: Self::F32) -> Self::F32;
    /// The larger; either if one is no number.
    fn max(self, a: Self::F32, b: Self::F32) -> Self::F32;
    /// The largest whole numbers that are not larger.
    fn floor(self, a: Self::F32) -> Self::F32;
    /// Where a < b.
    fn lt(self, a: Self::F32, b: Self::F32) -> u32;
    /// Where a ≤ b.
    fn le(self, a: Self::F32, b: Self::F32) -> u32;
    /// Where a = b.
    fn eq(self, a: Self::F32, b: Self::F32) -> u32;
}

/// Plain numbers, which the compiler may put side by side as far as any processor of its target can.
#[derive(Debug, Clone, Copy)]
pub struct Plain;

fn each(a: [f32; LANES], b: [f32; LANES], f: impl Fn(f32, f32) -> f32) -> [f32; LANES] {
    std::array::from_fn(|k| f(a[k], b[k]))
}

fn mask(a: [f32; LANES], b: [f32; LANES], f: impl Fn(&f32, &f32) -> bool) -> u32 {
    (0..LANES).fold(0, |mask, k| mask | u32::from(f(&a[k], &b[k])) << k)
}

impl Lanes for Plain {
    type F32 = [f32; LANES];

    fn run<T>(self, work: impl FnOnce() -> T) -> T {
        work()
    }

    fn load(self, from: &[f32; LANES]) -> Self::F32 {
        *from
    }

    fn store(self, a: Self::F32) -> [f32; LANES] {
        a
    }

    fn splat(self, a: f32) -> Self::F32 {
        [a; LANES]
    }

    fn add(self, a: Self::F32, b: Self::F32) -> Self::F32 {
        each(a, b, |a, b| a + b)
    }

    fn sub(self, a: Self::F32, b: Self::F32) -> Self::F32 {
        each(a, b, |a, b| a - b)
    }

    fn mul(self, a: Self::F32, b: Self::F32) -> Self::F32 {
        each(a, b, |a, b| a * b)
    }

    fn div(self, a: Self::F32, b: Self::F32) -> Self::F32 {
        each(a, b, |a, b| a / b)
    }

    fn mul_sub(self, a: Self::F32, b: Self::F32, c: Self::F32) -> Self::F32 {
        self.sub(self.mul(a, b), c)
    }

    fn min(self, a: Self::F32, b: Self::F32) -> Self::F32 {
        each(a, b, |a, b| if a < b { a } else { b })
    }

    fn max(self, a: Self::F32, b: Self::F32) -> Self::F32 {
        each(a, b, |a, b| if a > b { a } else { b })
    }

    fn floor(self, a: Self::F32) -> Self::F32 {
        a.map(f32::floor)
    }

    fn lt(self, a: Self::F32, b: Self::F32) -> u32 {
        mask(a, b, f32::lt)
    }

    fn le(self, a: Self::F32, b: Self::F32) -> u32 {
        mask(a, b, f32::le)
    }

    fn eq(self, a: Self::F32, b: Self::F32) -> u32 {
        mask(a, b, f32::eq)
    }
}

#[cfg(target_arch = "x86_64")]
mod x86 {
    use super::{LANES, Lanes};
    use pulp::x86::V3;
    use pulp::{cast, f32x8, m32x8};

    /// AVX2 and fused multiplications.
    impl Lanes for V3 {
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
            self.mul_sub_f32x8(a, b, c)
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
        fn lt(self, a: Self::F32, b: Self::F32) -> u32 {
            bits(self, self.cmp_lt_f32x8(a, b))
        }

        #[inline(always)]
        fn le(self, a: Self::F32, b: Self::F32) -> u32 {
            bits(self, self.cmp_le_f32x8(a, b))
        }

        #[inline(always)]
        fn eq(self, a: Self::F32, b: Self::F32) -> u32 {
            bits(self, self.cmp_eq_f32x8(a, b))
        }
    }

    #[inline(always)]
    fn bits(simd: V3, mask: m32x8) -> u32 {
        simd.avx._mm256_movemask_ps(cast(mask)) as u32
    }
}
