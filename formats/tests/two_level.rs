//! The table of 4 × 4 bitmaps against its definition in whole numbers, and the two-level transform against
//! the plain one, bit for bit and by counting.

use relume_formats::basis::haar::{forward_cube, inverse_cube};
use relume_formats::basis::two_level::{BYTES, SIDE, two_level};
use relume_formats::kinds::HaarTable;
use std::cell::Cell;
use std::ops::{Add, Mul, Sub};

/// Four times the value of each function of n = 4 at each texel, as the documentation of the order has it.
fn basis() -> [[i32; 16]; 16] {
    let sign = |positive: bool| if positive { 1 } else { -1 };
    std::array::from_fn(|at| {
        std::array::from_fn(|texel| {
            let (x, y) = (texel % 4, texel / 4);
            match at {
                0 => 1,
                1 => sign(x < 2),
                2 => sign(y < 2),
                3 => sign((x < 2) == (y < 2)),
                _ => {
                    let (m, j, i) = (at / 4, at / 2 % 2, at % 2);
                    let (left, upper) = (x % 2 == 0, y % 2 == 0);
                    let inside = i32::from(x / 2 == i && y / 2 == j);
                    2 * inside * sign([left, upper, left == upper][m - 1])
                }
            }
        })
    })
}

#[test]
fn the_table_is_its_definition() {
    let (table, basis) = (HaarTable::bake(), basis());
    assert_eq!(table.coefficients().len(), 65_536 * 16);
    for bits in 0..=u16::MAX {
        let row = &table.coefficients()[usize::from(bits) * 16..][..16];
        assert_eq!(row, table.tile(bits));
        for (coefficient, function) in row.iter().zip(&basis) {
            let four_times: i32 =
                (0..16).filter(|texel| bits >> texel & 1 == 1).map(|texel| function[texel]).sum();
            assert_eq!(4.0 * coefficient, four_times as f32, "bitmap {bits}");
        }
    }
}

/// A bitmap of the texels for which `lit` (face, x, y) holds.
fn bitmap(lit: impl Fn(usize, usize, usize) -> bool) -> [u8; BYTES] {
    let mut bytes = [0; BYTES];
    for at in (0..BYTES * 8).filter(|at| lit(at / (SIDE * SIDE), at % SIDE, at / SIDE % SIDE)) {
        // Bits follow each other as texels do, eight to a byte.
        bytes[at / 8] |= 1 << (at % 8);
    }
    bytes
}

fn image(bitmap: &[u8; BYTES]) -> Vec<f32> {
    let texel = |at: usize| {
        let (face, y, x) = (at / (SIDE * SIDE), at / SIDE % SIDE, at % SIDE);
        f32::from((bitmap[(face * 32 + y) * 4 + x / 8] >> (x % 8)) & 1)
    };
    (0..6 * SIDE * SIDE).map(texel).collect()
}

fn assert_same(bitmap: &[u8; BYTES], table: &HaarTable, what: &str) {
    let image = image(bitmap);
    let mut plain = image.clone();
    forward_cube(&mut plain, SIDE);
    let mut ours = vec![f32::NAN; image.len()];
    two_level(bitmap, table, &mut ours);
    let bits = |values: &[f32]| values.iter().map(|v| v.to_bits()).collect::<Vec<_>>();
    assert_eq!(bits(&ours), bits(&plain), "{what}");
    // Nothing was rounded: the image comes back exactly.
    inverse_cube(&mut ours, SIDE);
    assert_eq!(ours, image, "{what}");
}

#[test]
fn two_levels_are_the_plain_transform_bit_for_bit() {
    let table = HaarTable::bake();
    assert_same(&[0; BYTES], &table, "nothing");
    assert_same(&[255; BYTES], &table, "everything");
    for texel in 0..BYTES * 8 {
        let mut one = [0; BYTES];
        one[texel / 8] = 1 << (texel % 8);
        assert_same(&one, &table, "one texel");
    }
    for period in [1, 2, 3, 4, 5, 8, 16] {
        assert_same(&bitmap(|_, x, y| (x / period + y / period) % 2 == 0), &table, "checkerboard");
        assert_same(&bitmap(|_, x, _| x / period % 2 == 0), &table, "columns");
        assert_same(&bitmap(|_, _, y| y / period % 2 == 0), &table, "rows");
        assert_same(&bitmap(|face, x, y| face != 3 && (x * x + y * y) > 100 * period), &table, "disc");
    }
    let mut state = 1u64;
    for round in 0..400 {
        let mut random = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 33) as u8
        };
        // Of one bit in two, in four, in eight, and the others.
        let byte = |random: &mut dyn FnMut() -> u8| (0..round % 4).fold(random(), |bits, _| bits & random());
        let mut bytes: [u8; BYTES] = std::array::from_fn(|_| byte(&mut random));
        if round % 8 >= 4 {
            bytes.iter_mut().for_each(|b| *b = !*b);
        }
        assert_same(&bytes, &table, "noise");
    }
}

thread_local! {
    static SUMS: Cell<u32> = const { Cell::new(0) };
    static PRODUCTS: Cell<u32> = const { Cell::new(0) };
}

/// A number that counts what is done to it.
#[derive(Clone, Copy, PartialEq, Debug)]
struct Counted(f32);

impl From<f32> for Counted {
    fn from(value: f32) -> Self {
        Self(value)
    }
}

impl Add for Counted {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        SUMS.set(SUMS.get() + 1);
        Self(self.0 + other.0)
    }
}

impl Sub for Counted {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        SUMS.set(SUMS.get() + 1);
        Self(self.0 - other.0)
    }
}

impl Mul for Counted {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        PRODUCTS.set(PRODUCTS.get() + 1);
        Self(self.0 * other.0)
    }
}

/// Additions and subtractions, and products, of `work`.
fn count(work: impl FnOnce()) -> [u32; 2] {
    let before = [SUMS.get(), PRODUCTS.get()];
    work();
    [SUMS.get() - before[0], PRODUCTS.get() - before[1]]
}

#[test]
fn two_levels_do_a_sixteenth_of_the_work() {
    let table = HaarTable::bake();
    let bits = bitmap(|face, x, y| (x * 7 + y * 13 + face) % 5 < 2);
    let mut plain: Vec<Counted> = image(&bits).into_iter().map(Counted).collect();
    let mut ours = vec![Counted(0.0); plain.len()];
    let plain_work = count(|| forward_cube(&mut plain, SIDE));
    let our_work = count(|| two_level(&bits, &table, &mut ours));
    assert_eq!(ours, plain);
    // Every 2 × 2 texels of every level take 8 sums and 4 halvings: (32² − 1)/3 = 341 such a face against (8²
    // − 1)/3 = 21, 1/16.2.
    assert_eq!(plain_work, [6 * 341 * 8, 6 * 341 * 4]);
    assert_eq!(our_work, [6 * 21 * 8, 6 * 21 * 4]);
}
