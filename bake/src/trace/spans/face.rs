//! A face of the cube: its own axes, and which of its texels boxes can hide.

use crate::trace::wide::lanes::{LANES, Lanes};
use crate::trace::wide::leaves::Corners;
use crate::trace::wide::tree::Node;
use glam::Vec3A;
use relume_formats::basis::cubemap::FRAMES;

/// Slack of bounds, texels: far more than what rounding does to them, see [`super`].
pub(super) const SLACK: f32 = 1.0 / 256.0;

/// Texels of a face: first and last column, first and last row.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Rect {
    pub columns: [u16; 2],
    pub rows: [u16; 2],
}

impl Rect {
    /// What of a span is in it: its first and its last column.
    #[inline(always)]
    pub fn columns_of(self, [from, to]: [i32; 2]) -> Option<[usize; 2]> {
        let [left, right] = self.columns.map(i32::from);
        let (from, to) = (from.max(left), to.min(right));
        (from <= to).then_some([from as usize, to as usize])
    }

    /// Whether a triangle with these bounds is worth looking for span by span.
    #[inline(always)]
    pub fn is_wide(self) -> bool {
        let [wide, high] = [self.columns, self.rows].map(|[first, last]| last - first);
        wide >= 2 * LANES as u16 || (wide >= LANES as u16 && high >= LANES as u16)
    }

    /// What is in both, if anything is.
    #[inline(always)]
    pub fn and(self, other: Self) -> Option<Self> {
        let both = |[a, b]: [u16; 2], [c, d]: [u16; 2]| [a.max(c), b.min(d)];
        let rect = Self { columns: both(self.columns, other.columns), rows: both(self.rows, other.rows) };
        let [columns, rows] = [rect.columns, rect.rows].map(|[first, last]| first <= last);
        (columns && rows).then_some(rect)
    }
}

/// A face around a point.
#[derive(Clone, Copy)]
pub(super) struct Face {
    /// Which of the six.
    pub number: usize,
    /// Texels along a side.
    pub size: usize,
    /// The point in the middle of the cube.
    pub origin: [f32; 3],
}

/// Rectangles of eight things.
pub(super) struct Rects {
    /// Which of them have texels.
    pub some: u32,
    columns: [[f32; LANES]; 2],
    rows: [[f32; LANES]; 2],
}

impl Rects {
    /// That of `lane`.
    #[inline(always)]
    pub fn of(&self, lane: usize) -> Rect {
        let [[left, right], [top, bottom]] = [&self.columns, &self.rows].map(|[a, b]| [a[lane], b[lane]]);
        Rect { columns: [left as u16, right as u16], rows: [top as u16, bottom as u16] }
    }
}

impl Face {
    /// All of it.
    pub fn rect(&self) -> Rect {
        let ends = [0, self.size as u16 - 1];
        Rect { columns: ends, rows: ends }
    }

    /// The first and the last row of `rect`, rows of all faces counted.
    #[inline(always)]
    pub fn rows(&self, rect: Rect) -> [usize; 2] {
        rect.rows.map(|y| self.number * self.size + usize::from(y))
    }

    /// The axes of the world across and along rays of this face, in the order of `ShearedRay::shear`.
    #[inline(always)]
    pub fn sheared(&self) -> [usize; 3] {
        let along = self.number / 2;
        [(along + 1) % 3, (along + 2) % 3, along]
    }

    /// Of a corner of eight triangles, in axes of the world, where it is on the axes of the face.
    #[inline(always)]
    pub fn seen<L: Lanes>(&self, simd: L, corners: &Corners, corner: usize) -> [L::F32; 3] {
        let [x, y, z] = FRAMES[self.number];
        let at = |axis: usize| corners.of(corner, axis);
        [self.on(simd, x, at(x.0)), self.on(simd, y, at(y.0)), self.on(simd, z, at(z.0))]
    }

    /// A direction of the world on the axes of the face.
    pub fn turned(&self, direction: Vec3A) -> [f32; 3] {
        FRAMES[self.number].map(|(axis, sign)| sign * direction[axis])
    }

    /// Of a corner of eight triangles that of `lane`, on the axes of the face.
    #[inline(always)]
    pub fn at(&self, corners: &Corners, corner: usize, lane: usize) -> [f32; 3] {
        let [x, y, z] = FRAMES[self.number];
        let at = |(axis, sign): (usize, f32)| sign * (corners.of(corner, axis)[lane] - self.origin[axis]);
        [at(x), at(y), at(z)]
    }

    /// Eight coordinates along an axis of the world, as one of the face's has them.
    #[inline(always)]
    fn on<L: Lanes>(&self, simd: L, (axis, sign): (usize, f32), at: &[f32; LANES]) -> L::F32 {
        simd.mul(simd.sub(simd.load(at), simd.splat(self.origin[axis])), simd.splat(sign))
    }

    /// Low and high ends of the boxes of `node` along an axis of the face.
    #[inline(always)]
    fn ends<L: Lanes>(&self, simd: L, axis: (usize, f32), node: &Node) -> [L::F32; 2] {
        let low = 2 * axis.0 + usize::from(axis.1 < 0.0);
        [self.on(simd, axis, &node.ends[low]), self.on(simd, axis, &node.ends[low ^ 1])]
    }

    /// The texels that boxes of `node` may hide, and how near each box comes, along the axis of the face.
    #[inline(always)]
    pub fn boxes<L: Lanes>(&self, simd: L, node: &Node) -> (Rects, [f32; LANES]) {
        let [x, y, z] = FRAMES[self.number];
        let [x, y] = [self.ends(simd, x, node), self.ends(simd, y, node)];
        let [near, far] = self.ends(simd, z, node);
        // A box around or beside the point ends nowhere before the border of the face.
        let (one, least) = (simd.splat(1.0), simd.splat(f32::MIN_POSITIVE));
        let inverse = [simd.div(one, simd.max(near, least)), simd.div(one, simd.max(far, least))];
        let (x, y) = (spread(simd, x, inverse), spread(simd, y, inverse));
        let rects = self.rects(simd, x, y, simd.bits(simd.lt(simd.splat(0.0), far)));
        (rects, simd.store(simd.max(near, simd.splat(0.0))))
    }

    /// The texels whose middles are in the given parts of the face, from −1 to 1 across and down it, of those
    /// of eight things that are `some`.
    #[inline(always)]
    pub fn rects<L: Lanes>(&self, simd: L, x: [L::F32; 2], y: [L::F32; 2], some: u32) -> Rects {
        let (columns, meets_columns) = self.texels(simd, x);
        let (rows, meets_rows) = self.texels(simd, y);
        Rects { some: some & meets_columns & meets_rows, columns, rows }
    }

    /// The first and the last texel whose middle is between `least` and `most`, and where there is any.
    #[inline(always)]
    fn texels<L: Lanes>(&self, simd: L, [least, most]: [L::F32; 2]) -> ([[f32; LANES]; 2], u32) {
        let half = 0.5 * self.size as f32;
        let (zero, last, scale) = (simd.splat(0.0), simd.splat(self.size as f32 - 1.0), simd.splat(half));
        // The middle of texel k is at k.
        let from = simd.sub(simd.mul(least, scale), simd.splat(SLACK + 0.5 - half));
        let to = simd.add(simd.mul(most, scale), simd.splat(SLACK - 0.5 + half));
        let meets = simd.and(simd.le(zero, to), simd.le(from, last));
        // Up to the next whole number, by leaving out what comes behind the point.
        let up = simd.add(from, simd.splat(1.0));
        let first = simd.floor(simd.min(simd.max(up, zero), last));
        let end = simd.floor(simd.min(simd.max(to, zero), last));
        ([simd.store(first), simd.store(end)], simd.bits(simd.and(meets, simd.le(first, end))))
    }
}

/// Where what is between `low` and `high` on an axis, and between the inverses of distances `near` and `far`,
/// is on a face.
#[inline(always)]
fn spread<L: Lanes>(simd: L, [low, high]: [L::F32; 2], [near, far]: [L::F32; 2]) -> [L::F32; 2] {
    [simd.min(simd.mul(low, near), simd.mul(low, far)), simd.max(simd.mul(high, near), simd.mul(high, far))]
}
