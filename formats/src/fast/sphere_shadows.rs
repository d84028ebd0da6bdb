//! Method `sphere-shadows` for many receivers: the same radiance as [`crate::evaluate::sphere_shadows`]
//! gives.
//!
//! * Receivers go in groups of 16, a lane each: caps are added to all of their bitmaps at once, row by row
//!   ([`caps`]). Only rows that the cap reaches for one of them are looked at, so receivers that follow each
//!   other should be near each other: [`order`] makes them so.
//! * With light and lobe given, the product is linear in the visibility, whatever terms and levels are kept.
//!   So both are folded once per change of the light into one weight per lobe and tile ([`fold`]), and a
//!   receiver's radiance is the sum of its tiles' visible texels times these ([`sum`]). The second level of
//!   visibility enters at the few tiles where light has kept terms of it.
//! * A blend of lobes is the blend of their sums.

mod caps;
mod fold;
mod sum;

use crate::evaluate::sphere_shadows::{Function, Levels, Receiver, Spheres};
use crate::kinds::HaarTable;
use crate::state::Rgb;
use glam::Vec3;
use pulp::{Arch, Simd, WithSimd};
use rayon::prelude::*;

/// Receivers of a group.
const LANES: usize = 16;

/// One value for each receiver of a group.
type Lanes<T> = [T; LANES];

/// Light and lobes, folded.
#[derive(Debug)]
pub struct Shading {
    weights: fold::Weights,
    arch: Arch,
}

impl Shading {
    /// Folds `light` into each of `lobes`; to be done anew when either changes.
    pub fn new(lobes: &[Function], light: &[Function; 3], levels: Levels) -> Self {
        Self { weights: fold::Weights::new(lobes, light, levels), arch: Arch::new() }
    }

    /// Linear radiance that a white diffuse surface shows at each receiver, W/(sr·m²), to `out`.
    ///
    /// # Panics
    /// If a receiver has a lobe that was not given.
    pub fn radiance(&self, receivers: &[Receiver], sets: &[Spheres], table: &HaarTable, out: &mut [Rgb]) {
        receivers.par_chunks(LANES).zip(out.par_chunks_mut(LANES)).for_each(|(receivers, out)| {
            self.arch.dispatch(Group { receivers, sets, table, weights: &self.weights, out });
        });
    }
}

/// The indices of `positions` in an order in which those that follow each other are near each other: along
/// the Z-curve through their bounding box (Morton 1966). Receivers may be given in any order, but in this one
/// a frame takes less time.
pub fn order(positions: &[Vec3]) -> Vec<u32> {
    let (low, high) =
        positions.iter().fold((Vec3::MAX, Vec3::MIN), |(low, high), p| (low.min(*p), high.max(*p)));
    // One scale for all axes, so that cells are cubes. What is no number falls somewhere legal.
    let scale = f32::from(1u16 << 10) / (high - low).max_element();
    let code = |index: &u32| {
        let cell = (positions[*index as usize] - low) * scale;
        (0..3).fold(0, |code, axis| code | spread((cell[axis] as u32).min(1023)) << axis)
    };
    let mut order: Vec<u32> = (0..positions.len() as u32).collect();
    order.sort_by_cached_key(code);
    order
}

/// The ten bits of a number, each followed by two that are 0.
fn spread(mut bits: u32) -> u32 {
    for (shift, mask) in [(16, 0x0300_00FF), (8, 0x0300_F00F), (4, 0x030C_30C3), (2, 0x0924_9249)] {
        bits = (bits | bits << shift) & mask;
    }
    bits
}

/// What is done for a group.
struct Group<'a> {
    receivers: &'a [Receiver],
    sets: &'a [Spheres],
    table: &'a HaarTable,
    weights: &'a fold::Weights,
    out: &'a mut [Rgb],
}

impl WithSimd for Group<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let rows = caps::blocked(self.receivers, self.sets);
        sum::radiance(&rows, self.receivers, self.weights, self.table, self.out);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    use crate::basis::diffuse::{self, blend};
    use crate::evaluate::sphere_shadows::{self, Own, blocked, neighbours};

    /// Spheres of two objects around the origin, and receivers among them.
    fn scene() -> (Vec<Spheres>, Vec<Receiver>) {
        let mut state = 5u64;
        let mut random = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 40) as f32 / (1 << 23) as f32 - 1.0
        };
        let sets = [40, 25].map(|count| {
            let now: Vec<[f32; 4]> =
                (0..count).map(|_| [random(), random(), random(), 0.2 + 0.15 * random()]).collect();
            Spheres { neighbours: neighbours(&now), now }
        });
        let receiver = |k: u32| {
            let normal = Vec3::new(random(), random(), random()).normalize();
            let own = (k % 3).checked_sub(1).map(|set| Own { set, sphere: k % 25 });
            Receiver {
                position: 2.0 * Vec3::new(random(), random(), random()),
                normal,
                lobes: blend(normal),
                own,
            }
        };
        (sets.into(), (0..200).map(receiver).collect())
    }

    #[test]
    fn bitmaps_are_the_same_bit_for_bit() {
        let (sets, receivers) = scene();
        let mut kinds = [0; 3];
        for group in receivers.chunks(LANES - 3) {
            let rows = caps::blocked(group, &sets);
            for (lane, receiver) in group.iter().enumerate() {
                let bitmap = blocked(receiver, &sets);
                assert_eq!(rows.map(|row| row[lane]), bitmap, "{receiver:?}");
                let ones: u32 = bitmap.iter().map(|row| row.count_ones()).sum();
                kinds[if ones == 0 { 0 } else { 1 + usize::from(ones == 6144) }] += 1;
            }
        }
        assert!(kinds.iter().all(|count| *count > 2), "some see all, some a part, some nothing: {kinds:?}");
    }

    #[test]
    fn all_processors_get_the_same() {
        let (sets, receivers) = scene();
        let lobes: Vec<Function> = (0..diffuse::NODES)
            .map(|node| sphere_shadows::lobe(diffuse::lobe(diffuse::grid_normal(node)), Some(100)))
            .collect();
        let light = sphere_shadows::light(
            std::array::from_fn(|c| (0..6144).map(|i| ((i * 37 + c) % 101) as f32 - 30.0).collect()),
            Some(100),
        );
        let table = HaarTable::bake();
        for levels in [Levels::One, Levels::Two, Levels::All] {
            let best = Shading::new(&lobes, &light, levels);
            let plain = Shading { weights: fold::Weights::new(&lobes, &light, levels), arch: Arch::Scalar };
            let [a, b] = [best, plain].map(|shading| {
                let mut out = vec![[f32::NAN; 3]; receivers.len()];
                shading.radiance(&receivers, &sets, &table, &mut out);
                out
            });
            assert_eq!(a, b, "the same operations in the same order");
        }
    }

    #[test]
    fn the_order_is_that_of_the_curve() {
        assert_eq!([0, 1, 2, 3, 1023].map(spread), [0, 1, 8, 9, 0x0924_9249]);
        let square: Vec<Vec3> = (0..16).map(|k| Vec3::new((k % 4) as f32, (k / 4) as f32, 0.0)).collect();
        assert_eq!(order(&square), [0, 1, 4, 5, 2, 3, 6, 7, 8, 9, 12, 13, 10, 11, 14, 15]);
        assert!(order(&[]).is_empty());
        let mut strange = order(&[Vec3::NAN, Vec3::ZERO, Vec3::splat(f32::INFINITY), Vec3::ZERO]);
        strange.sort_unstable();
        assert_eq!(strange, [0, 1, 2, 3]);
    }
}
