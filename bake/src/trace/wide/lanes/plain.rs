use super::{LANES, Lanes, entry, lanes_of};

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
    type Mask = u32;

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

    fn lt(self, a: Self::F32, b: Self::F32) -> Self::Mask {
        mask(a, b, f32::lt)
    }

    fn le(self, a: Self::F32, b: Self::F32) -> Self::Mask {
        mask(a, b, f32::le)
    }

    fn or(self, a: Self::Mask, b: Self::Mask) -> Self::Mask {
        a | b
    }

    fn and(self, a: Self::Mask, b: Self::Mask) -> Self::Mask {
        a & b
    }

    fn bits(self, a: Self::Mask) -> u32 {
        a
    }

    fn packed(self, mask: u32, codes: &[u32; LANES]) -> [u32; LANES] {
        let mut packed = [0; LANES];
        for (to, lane) in packed.iter_mut().zip(lanes_of(mask)) {
            *to = codes[lane];
        }
        packed
    }

    fn sorted(self, mask: u32, distances: Self::F32, codes: &[u32; LANES]) -> [u64; 4] {
        let mut sorted = [0; 4];
        for (to, lane) in sorted.iter_mut().zip(lanes_of(mask)) {
            *to = entry(distances[lane], codes[lane]);
        }
        sorted.sort_unstable_by(|a, b| b.cmp(a));
        sorted
    }
}
