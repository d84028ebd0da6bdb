//! The texels of a cube of 32 × 32 a face whose centres lie in a cap: what a sphere blocks (sphere shadows
//! §3.3), without the source's table of directions and radii, so neither is rounded.
//!
//! A texel belongs to the cap of a sphere of radius R at the offset v if its centre direction d has d·v ≥
//! C·|d|, C² = |v|² − R². On a face d = (s, t, 1) in the face's own frame, where v = (a, b, g): along a row,
//! with k = b·t + g, that is a·s + k ≥ C·√(s² + 1 + t²). As a cap is less than a hemisphere its cone is
//! convex, and what it has in common with a row is one interval. With q = C² − a² its ends are the roots (a·k
//! ± C·√(k² − q·(1 + t²)))/q. If q > 0 the row's direction lies outside the cone and the interval between the
//! roots counts, where k > 0; else the cone holds one end of the row, that of the sign of a. The root that
//! would lose its digits is taken from the product of both, (C²·(1 + t²) − k²)/q.
//!
//! The rows that a cap reaches on a face follow from the same formula with (b, g, R, g² − R²) for (a, k, C,
//! q).
//!
//! All is branch-free arithmetic on plain `f32`, without fused multiplications, so that the same code gives
//! the same bits in scalar and in vector form.

use super::cubemap::{FACES, FRAMES};
use super::two_level::{BYTES, SIDE};
use glam::Vec3;

/// Rows of a cube.
pub const ROWS: usize = FACES * SIDE;

/// A bitmap of 6 × 32 × 32 texels, a row each: texel (x, y) of `face` is bit x, lowest first, of row face·32
/// + y. In little-endian order these are the bytes of [`super::two_level`].
pub type Bitmap = [u32; ROWS];

/// The bytes of a bitmap in the order of [`super::two_level`].
pub fn bytes(bitmap: &Bitmap) -> [u8; BYTES] {
    let mut bytes = [0; BYTES];
    bytes.as_chunks_mut().0.iter_mut().zip(bitmap).for_each(|(to, row)| *to = row.to_le_bytes());
    bytes
}

/// The bitmap of bytes in the order of [`super::two_level`].
pub fn rows(bytes: &[u8; BYTES]) -> Bitmap {
    let mut bitmap = [0; ROWS];
    bitmap.iter_mut().zip(bytes.as_chunks().0).for_each(|(row, from)| *row = u32::from_le_bytes(*from));
    bitmap
}

/// Adds the texels whose centres are in the cap about the unit vector `direction` with the relative radius
/// `r` in 0..1, the sine of its half angle.
pub fn add_cap(bitmap: &mut Bitmap, direction: Vec3, r: f32) {
    add_cone(bitmap, direction, r, (1.0 - r) * (1.0 + r));
}

/// Adds the texels that a sphere of `radius` blocks whose centre is `offset` away; all of them if it holds
/// the origin.
pub fn add_sphere(bitmap: &mut Bitmap, offset: Vec3, radius: f32) {
    let c2 = tangent2(offset.to_array(), radius);
    if c2 > 0.0 { add_cone(bitmap, offset, radius, c2) } else { bitmap.fill(u32::MAX) }
}

/// The square of the distance at which rays from the origin touch a sphere; not above 0 if the sphere holds
/// the origin.
#[inline(always)]
pub(crate) fn tangent2([x, y, z]: [f32; 3], radius: f32) -> f32 {
    (x * x + y * y + z * z) - radius * radius
}

fn add_cone(bitmap: &mut Bitmap, axis: Vec3, radius: f32, c2: f32) {
    let (faces, _) = bitmap.as_chunks_mut::<SIDE>();
    for (face, rows) in faces.iter_mut().enumerate() {
        let local = FRAMES[face].map(|(k, sign)| sign * axis[k]);
        if may_reach(local, radius) {
            let [first, end] = row_range(local, radius, c2);
            let cone = FaceCone::new(local, c2);
            (first as usize..end as usize).for_each(|y| rows[y] |= cone.span(&ROW[y]));
        }
    }
}

/// Whether a sphere reaches into the pyramid over a face; sometimes it does and does not reach a texel.
#[inline(always)]
pub(crate) fn may_reach([a, b, g]: [f32; 3], radius: f32) -> bool {
    // The pyramid's sides are at 45°, so a centre outside of one is |a| − g over √2 away from it. A
    // thousandth more covers roundings.
    let reach = 1.416 * radius;
    (a.abs() - g <= reach) & (b.abs() - g <= reach)
}

/// First row that a cap may reach on a face, and the one behind the last, 0..=32; none if the first is not
/// below.
#[inline(always)]
pub(crate) fn row_range([a, b, g]: [f32; 3], radius: f32, c2: f32) -> [u32; 2] {
    let q = c2 - a * a;
    let (p, root) = (g * g - radius * radius, radius * at_least(q, 0.0).sqrt());
    let [low, high] = interval(b, g, root, p, 1.0 / p, q - g * g);
    // If the cone holds the row's direction it reaches every row.
    let [low, high] = [if q > 0.0 { low } else { -FAR }, if q > 0.0 { high } else { FAR }];
    // Rows are within rounding of the ends; a hundredth of a row is far more than roundings are.
    [edge(low - 0.01 / 16.0), edge(high + 0.01 / 16.0)]
}

/// Place of a row on its face.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Row {
    /// Of its texels' centres.
    t: f32,
    /// 1 + t².
    e: f32,
}

/// The rows of a face.
pub(crate) const ROW: [Row; SIDE] = {
    let mut rows = [Row { t: 0.0, e: 1.0 }; SIDE];
    let mut y = 0;
    while y < SIDE {
        let t = (2 * y + 1) as f32 / SIDE as f32 - 1.0;
        rows[y] = Row { t, e: 1.0 + t * t };
        y += 1;
    }
    rows
};

/// A cone as a face sees it: what all rows need.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct FaceCone {
    pub(crate) a: f32,
    pub(crate) b: f32,
    pub(crate) g: f32,
    pub(crate) c: f32,
    pub(crate) c2: f32,
    pub(crate) q: f32,
    pub(crate) one_over_q: f32,
}

impl FaceCone {
    /// The cone about (`a`, `b`, `g`) whose tangents have the squared length `c2`.
    #[inline(always)]
    pub(crate) fn new([a, b, g]: [f32; 3], c2: f32) -> Self {
        let q = c2 - a * a;
        Self { a, b, g, c: c2.sqrt(), c2, q, one_over_q: 1.0 / q }
    }

    /// The texels of a row whose centres the cone holds, a bit each.
    #[inline(always)]
    pub(crate) fn span(&self, row: &Row) -> u32 {
        let k = self.b * row.t + self.g;
        let square = k * k;
        let inside = square - self.q * row.e;
        let [low, high] = interval(
            self.a,
            k,
            self.c * at_least(inside, 0.0).sqrt(),
            self.q,
            self.one_over_q,
            self.c2 * row.e - square,
        );
        let mask = from(edge(low)) & !from(edge(high));
        if inside >= 0.0 { mask } else { 0 }
    }
}

/// Beyond every texel.
const FAR: f32 = 4.0;

/// Where a·s + k ≥ C·√(s² + e): between (a·k ± `root`)/q, `conjugate` being q times the product of these; an
/// empty interval may have any ends that are not in order, or none on the face.
#[inline(always)]
fn interval(a: f32, k: f32, root: f32, q: f32, one_over_q: f32, conjugate: f32) -> [f32; 2] {
    // For a ≥ 0, to be mirrored otherwise.
    let ak = a.abs() * k;
    let ahead = k > 0.0;
    let (up, down) = (if ahead { conjugate } else { ak - root }, if ahead { ak + root } else { q });
    let near = up / down;
    let far = if q > 0.0 { (ak + root) * one_over_q } else { FAR };
    let empty = (q > 0.0) & !ahead;
    let (near, far) = (if empty { FAR } else { near }, if empty { FAR } else { far });
    let [mirrored, low_is_near] = [[-far, -near], [near, far]];
    if a < 0.0 { mirrored } else { low_is_near }
}

/// How many of the 32 texel centres along a line lie below `s`, to rounding.
#[inline(always)]
pub(crate) fn edge(s: f32) -> u32 {
    let below = at_least(16.0 * s + 16.0, 0.0);
    whole(if below < SIDE as f32 { below } else { SIDE as f32 })
}

/// The whole number nearest to `x`, which is 0 to 2²³.
#[inline(always)]
pub(crate) fn whole(x: f32) -> u32 {
    // The last bits of a float of this size are whole numbers, and adding it rounds to the nearest: a
    // conversion that vector units have.
    const WHOLE: f32 = (1 << 23) as f32;
    (x + WHOLE).to_bits() - WHOLE.to_bits()
}

/// The larger of both, `least` for no number: one instruction, which `f32::max` is not.
#[inline(always)]
fn at_least(x: f32, least: f32) -> f32 {
    if x > least { x } else { least }
}

/// All bits from the `first` on, which is at most 32.
#[inline(always)]
pub(crate) fn from(first: u32) -> u32 {
    u32::MAX.checked_shl(first).unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::basis::test_bitmaps::{bit, centres};
    use glam::DVec3;
    use proptest::prelude::*;

    /// Compares with the test of every texel in f64; rounding may decide those within `tolerance` of the
    /// limit.
    fn check(bitmap: &Bitmap, centres: &[DVec3], axis: DVec3, limit: f64, tolerance: f64) {
        for (texel, d) in centres.iter().enumerate() {
            let beyond = d.dot(axis) - limit;
            assert!(
                beyond.abs() < tolerance || bit(bitmap, texel) == (beyond > 0.0),
                "texel {texel} is {beyond} beyond the limit {limit} about {axis}"
            );
        }
    }

    fn check_cap(centres: &[DVec3], direction: Vec3, r: f32) {
        let mut bitmap = [0; ROWS];
        add_cap(&mut bitmap, direction, r);
        let limit = ((1.0 - f64::from(r)) * (1.0 + f64::from(r))).sqrt();
        check(&bitmap, centres, direction.as_dvec3(), limit, 1e-6);
    }

    /// Axes, edges and corners of the cube, texel centres and borders, and others near them.
    fn special_directions() -> Vec<Vec3> {
        let places = [-1.0, -0.968_75, -0.5, -1e-4, 0.0, 1e-7, 0.031_25, 0.999_999, 1.0];
        let cube = places
            .iter()
            .flat_map(|x| places.iter().flat_map(|y| places.iter().map(|z| Vec3::new(*x, *y, *z))));
        cube.filter(|v| v.abs().max_element() > 0.9).map(Vec3::normalize).collect()
    }

    #[test]
    fn caps_are_those_of_the_definition() {
        let centres = centres();
        for v in special_directions() {
            for r in [
                1e-6,
                1e-3,
                0.02,
                0.05,
                0.1,
                0.3,
                0.5,
                std::f32::consts::FRAC_1_SQRT_2,
                0.8,
                0.95,
                0.999,
                0.999_999,
            ] {
                check_cap(&centres, v, r);
            }
        }
    }

    #[test]
    fn spheres_hold_back_what_is_behind_them() {
        let centres = centres();
        for (offset, radius) in [
            (Vec3::new(3.0, -1.0, 0.5), 2.9),
            (Vec3::new(300.0, 200.0, -500.0), 70.0),
            (Vec3::new(1e-3, 2e-3, 0.0), 5e-4),
        ] {
            let mut bitmap = [0; ROWS];
            add_sphere(&mut bitmap, offset, radius);
            let (v, r) = (offset.as_dvec3().normalize(), f64::from(radius) / offset.as_dvec3().length());
            check(&bitmap, &centres, v, (1.0 - r * r).sqrt(), 1e-6);
        }
        for radius in [1.0, 1.5] {
            let mut bitmap = [0; ROWS];
            add_sphere(&mut bitmap, Vec3::Y, radius);
            assert_eq!(bitmap, [u32::MAX; ROWS], "inside");
        }
    }

    #[test]
    fn a_cap_is_added_to_what_there_is() {
        let mut bitmap: Bitmap = std::array::from_fn(|row| 0x1001 << (row % 16));
        let before = bitmap;
        let mut alone = [0; ROWS];
        add_cap(&mut bitmap, Vec3::new(0.6, 0.0, 0.8), 0.4);
        add_cap(&mut alone, Vec3::new(0.6, 0.0, 0.8), 0.4);
        assert_eq!(bitmap, std::array::from_fn(|row| before[row] | alone[row]));
        assert_eq!(rows(&bytes(&bitmap)), bitmap);
        assert_eq!(
            bytes(&bitmap)[4 * 37 + 1] >> 3 & 1,
            (bitmap[37] >> 11 & 1) as u8,
            "texel 11 of row 5 of the second face"
        );
    }

    /// A row that the bounds leave out has no texel in the cap even to rounding: so it makes no difference
    /// how many rows are looked at.
    #[test]
    fn bounds_leave_no_texel_out() {
        for v in special_directions() {
            for r in [1e-6, 1e-3, 0.05, 0.3, 0.7, 0.95, 0.999_999] {
                let mut bounded = [0; ROWS];
                add_cap(&mut bounded, v, r);
                let c2 = (1.0 - r) * (1.0 + r);
                let all: Bitmap = std::array::from_fn(|row| {
                    FaceCone::new(FRAMES[row / SIDE].map(|(k, sign)| sign * v[k]), c2).span(&ROW[row % SIDE])
                });
                assert_eq!(bounded, all, "{v} {r}");
            }
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(400))]
        #[test]
        fn any_cap_is_that_of_the_definition(x in -1.0f32..1.0, y in -1.0f32..1.0, z in -1.0f32..1.0, r in 0.0f32..1.0, small in 0u32..6) {
            let v = Vec3::new(x, y, z);
            prop_assume!(v.length() > 0.01 && r > 0.0);
            // Towards 0 and towards 1 in turn.
            let r = if small % 2 == 0 { r.powi(small as i32 + 1) } else { (1.0 - r.powi(small as i32)).min(0.999_999) };
            prop_assume!(r > 0.0);
            check_cap(&centres(), v.normalize(), r);
        }
    }
}
