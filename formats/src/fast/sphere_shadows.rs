//! Method `sphere-shadows` for many receivers: the same radiance as [`crate::evaluate::sphere_shadows`]
//! gives.
//!
//! * Receivers go in groups of 16, a lane each: caps ([`caps`]) and triangles ([`triangles`]) are added to all of
//!   their bitmaps at once, row by row. Only rows that one reaches for one of them are looked at, so receivers that follow each
//!   other should be near each other: [`order`] makes them so.
//! * With light and lobe given, the product is linear in the visibility, whatever terms and levels are kept.
//!   So both are folded once per change of the light into one weight per lobe and tile ([`fold`]), and a
//!   receiver's radiance is the sum of its tiles' visible texels times these ([`sum`]). The second level of
//!   visibility enters at the few tiles where light has kept terms of it.
//! * A blend of lobes is the blend of their sums.

mod caps;
mod fold;
mod sum;
mod triangles;

use crate::basis::cap::{Bitmap, ROWS};
use crate::evaluate::sphere_shadows::{Casters, Function, Levels, Receiver, Spheres};
use crate::kinds::HaarTable;
use crate::state::Rgb;
use caps::{Group, Rows};
use glam::Vec3;
use pulp::{Arch, Simd, WithSimd};
use rayon::prelude::*;
use triangles::Block;

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
    pub fn radiance(&self, receivers: &[Receiver], casters: &Casters, table: &HaarTable, out: &mut [Rgb]) {
        let (sets, blocks) = (&casters.spheres, Block::of_all(&casters.triangles));
        receivers.par_chunks(LANES).zip(out.par_chunks_mut(LANES)).for_each(|(receivers, out)| {
            self.arch.dispatch(Task { receivers, sets, blocks: &blocks, table, weights: &self.weights, out });
        });
    }
}

/// What is blocked of each receiver's view, as [`crate::evaluate::sphere_shadows::blocked`] says.
pub fn bitmaps(receivers: &[Receiver], casters: &Casters) -> Vec<Bitmap> {
    let (sets, blocks, arch) = (&casters.spheres, Block::of_all(&casters.triangles), Arch::new());
    let mut bitmaps = vec![[0; ROWS]; receivers.len()];
    receivers.par_chunks(LANES).zip(bitmaps.par_chunks_mut(LANES)).for_each(|(receivers, out)| {
        let rows = arch.dispatch(Blocking { receivers, sets, blocks: &blocks });
        for (lane, bitmap) in out.iter_mut().enumerate() {
            *bitmap = rows.each_ref().map(|row| row[lane]);
        }
    });
    bitmaps
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

/// What is blocked of each receiver's view.
#[inline(always)]
fn blocked(receivers: &[Receiver], sets: &[Spheres], blocks: &[Block]) -> Rows {
    let mut rows = [[0; LANES]; ROWS];
    let group = Group::new(receivers);
    triangles::add(&mut rows, &group, blocks);
    caps::add(&mut rows, &group, receivers, sets);
    rows
}

/// What is done for a group.
struct Task<'a> {
    receivers: &'a [Receiver],
    sets: &'a [Spheres],
    blocks: &'a [Block],
    table: &'a HaarTable,
    weights: &'a fold::Weights,
    out: &'a mut [Rgb],
}

impl WithSimd for Task<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let rows = blocked(self.receivers, self.sets, self.blocks);
        sum::radiance(&rows, self.receivers, self.weights, self.table, self.out);
    }
}

/// What is blocked of a group's view, alone.
struct Blocking<'a> {
    receivers: &'a [Receiver],
    sets: &'a [Spheres],
    blocks: &'a [Block],
}

impl WithSimd for Blocking<'_> {
    type Output = Rows;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> Rows {
        blocked(self.receivers, self.sets, self.blocks)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    use crate::basis::diffuse::{self, blend};
    use crate::evaluate::sphere_shadows::{self, Own, Sides, Triangle, blocked, neighbours};

    /// Spheres of two objects and meshes of two others around the origin, and receivers among them, of which
    /// those that follow each other are near each other or, `scattered`, are not.
    fn scene(scattered: bool) -> (Casters, Vec<Receiver>) {
        let mut state = 5u64;
        let mut random = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 40) as f32 / (1 << 23) as f32 - 1.0
        };
        let spheres = [40, 25].map(|count| {
            let now: Vec<[f32; 4]> =
                (0..count).map(|_| [random(), random(), random(), 0.2 + 0.15 * random()]).collect();
            Spheres { neighbours: neighbours(&now), now }
        });
        let triangle = |k: u32| {
            let corner: [f32; 3] = std::array::from_fn(|_| 1.5 * random());
            // Large and small ones, and some that are only a line.
            let size = if k.is_multiple_of(9) { 1.0 } else { 0.2 };
            let corners = [0, 1, 2]
                .map(|c| corner.map(|x| x + if k % 13 == 5 { 0.1 * c as f32 } else { size * random() }));
            let [a, b, c] = corners.map(Vec3::from);
            let normal = (b - a).cross(c - a);
            let both = |height| Sides { above: height, below: height };
            let sides = match k % 2 {
                0 => [both(0.05), both(1e-6)],
                _ => {
                    [Sides { above: 0.1, below: f32::INFINITY }, Sides { above: f32::INFINITY, below: 1e-6 }]
                }
            };
            Triangle { corners, normal: (normal / normal.length()).to_array(), object: 2 + k % 2, sides }
        };
        let triangles = (0..50).map(triangle).collect();
        let receiver = |k: u32| {
            let normal = Vec3::new(random(), random(), random()).normalize();
            let own = (k % 4).checked_sub(2).map(|set| Own { set, sphere: k % 25 });
            let place = 2.0 * Vec3::new(random(), random(), random());
            Receiver {
                position: if scattered {
                    place
                } else {
                    Vec3::new(0.01 * k as f32 - 1.0, 0.3, 0.1) + 0.02 * place
                },
                normal,
                lobes: blend(normal),
                object: k % 4,
                own,
            }
        };
        (Casters { spheres: spheres.into(), triangles }, (0..200).map(receiver).collect())
    }

    #[test]
    fn bitmaps_are_the_same_bit_for_bit() {
        for scattered in [false, true] {
            let (casters, receivers) = scene(scattered);
            let without = Casters { spheres: Vec::new(), ..casters.clone() };
            for casters in [&casters, &without] {
                let mut kinds = [0; 3];
                // The last group is not full.
                assert_ne!(receivers.len() % LANES, 0);
                for (receiver, fast) in receivers.iter().zip(bitmaps(&receivers, casters)) {
                    let bitmap = blocked(receiver, casters);
                    assert_eq!(fast, bitmap, "{receiver:?}");
                    let ones: u32 = bitmap.iter().map(|row| row.count_ones()).sum();
                    kinds[if ones == 0 { 0 } else { 1 + usize::from(ones == 6144) }] += 1;
                }
                assert!(kinds[1] > 100, "most see a part: {kinds:?}");
            }
        }
    }

    #[test]
    fn all_processors_get_the_same() {
        let (casters, receivers) = scene(true);
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
                shading.radiance(&receivers, &casters, &table, &mut out);
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
