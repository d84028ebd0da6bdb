//! What stands before the texels of a cube around a point, without a ray for each.
//!
//! Seen from the point a triangle covers some texels of each row of a face. They are looked for, instead of
//! texels being asked one by one: the hierarchy is gone through from near to far for each face, what is below
//! the horizon or before texels that are decided already is left out with all that is in it, and of what is
//! left each triangle is tested against the texels around it only, eight of a row at once.
//!
//! The answers are those of rays through the texels, bit for bit. Bounds on a face only leave out what no ray
//! can hit: boxes have been made larger by some 64 ε of the scene's extent (ε = 2⁻²⁴), the projection of a
//! corner in the test of a triangle is off by at most 7 ε of its distance, and with its corners no farther
//! beside the face than [`BESIDE`] times their distance from the point along its axis, that is less than
//! [`SLACK`] of a texel of a face of up to 1,024². What is left is decided by the very numbers of
//! [`ShearedRay`].

mod edges;
mod face;
mod film;
mod rays;
mod set;
#[cfg(test)]
mod tests;
mod triangle;

pub use rays::TexelRays;
pub use set::TexelSet;

use super::triangle::{ShearedRay, TriangleHit};
use super::wide::lanes::{LANES, Lanes, Plain, lanes_of};
use super::wide::leaves::{Corners, LeafRay};
use super::wide::tree::{Child, Leaf, Node};
use super::wide::{Found, Kernel, Wide};
use edges::Edges;
use face::{Face, Rect};
use film::{Film, Nearest, Place};
use glam::Vec3A;
use relume_formats::basis::cubemap::FACES;
use set::mask;
use triangle::Seen;

/// So few texels are looked for in a leaf one by one.
const FEW: usize = 4;

/// How far beside a face the corners of a triangle may be whose bounds on it count; 1 is its border.
const BESIDE: f32 = 16.0;

/// Rays from one point.
#[derive(Clone, Copy)]
pub struct Eye<'a> {
    /// Where they start.
    pub origin: Vec3A,
    /// Normal of a plane through the point below which no ray goes, if there is one.
    pub horizon: Option<Vec3A>,
    /// Their directions.
    pub rays: &'a TexelRays,
    /// Texels of a coarser cube outside of which no ray goes, if that is known.
    pub within: Option<&'a TexelSet>,
}

/// What is yet to be visited.
struct Open {
    near: f32,
    child: Child,
    rect: Rect,
}

impl Wide {
    /// Leaves of `texels` those before which no triangle that `counts` stands. Only triangles that `may_not`
    /// are asked whether they count where they are hit.
    pub fn see(
        &self,
        eye: Eye<'_>,
        texels: &mut TexelSet,
        may_not: impl Fn(u32) -> bool,
        counts: impl Fn(u32, &TriangleHit) -> bool,
    ) {
        self.look(&Look { wide: self, eye, may_not, counts }, texels);
    }

    /// For each texel, if it is in `asked`, the nearest triangle behind it that `counts`; see
    /// [`Wide::see`].
    pub fn nearest_of_texels(
        &self,
        eye: Eye<'_>,
        asked: &TexelSet,
        may_not: impl Fn(u32) -> bool,
        counts: impl Fn(u32, &TriangleHit) -> bool,
    ) -> Vec<Option<Found>> {
        let mut film = Nearest::new(asked, eye.rays, &self.order);
        self.look(&Look { wide: self, eye, may_not, counts }, &mut film);
        film.into_found()
    }

    fn look<M, C>(&self, look: &Look<'_, M, C>, film: &mut impl Film)
    where
        M: Fn(u32) -> bool,
        C: Fn(u32, &TriangleHit) -> bool,
    {
        match self.kernel {
            Kernel::Plain => look.look(Plain, film),
            #[cfg(target_arch = "x86_64")]
            Kernel::V3(simd) => simd.run(
                #[inline(always)]
                || look.look(simd, film),
            ),
            #[cfg(target_arch = "x86_64")]
            Kernel::V4(simd) => simd.run(
                #[inline(always)]
                || look.look(simd, film),
            ),
        }
    }
}

/// A look at what is around a point.
struct Look<'a, M, C> {
    wide: &'a Wide,
    eye: Eye<'a>,
    may_not: M,
    counts: C,
}

impl<M: Fn(u32) -> bool, C: Fn(u32, &TriangleHit) -> bool> Look<'_, M, C> {
    #[inline(always)]
    fn look<L: Lanes>(&self, simd: L, film: &mut impl Film) {
        let nodes = self.wide.nodes.as_slice();
        if nodes.is_empty() {
            return;
        }
        let mut open = Vec::with_capacity(64);
        for number in 0..FACES {
            let face = Face { number, size: self.eye.rays.face_size(), origin: self.eye.origin.to_array() };
            open.push(Open { near: 0.0, child: Child::of(0), rect: face.rect() });
            while let Some(Open { child, rect, near }) = open.pop() {
                if !self.is_open(&face, rect, near, film) {
                    continue;
                }
                match child.leaf_or_node() {
                    Err(node) => self.open(simd, &face, &nodes[node], rect, &mut open),
                    Ok(leaf) => self.leaf(simd, &face, leaf, rect, film),
                }
            }
        }
    }

    /// Whether what is in `rect`, no nearer than `near`, may leave anything on `film`.
    #[inline(always)]
    fn is_open(&self, face: &Face, rect: Rect, near: f32, film: &impl Film) -> bool {
        let is_within = self.eye.within.is_none_or(|within| {
            let (size, fine) = (within.face_size(), face.size);
            let [first, last] = rect.rows.map(|y| face.number * size + usize::from(y) * size / fine);
            within.any(first..=last, rect.columns.map(|x| usize::from(x) * size / fine))
        });
        is_within && film.takes(near, face.rows(rect), rect.columns.map(usize::from))
    }

    /// Puts what is in `node` on the stack, the nearest last.
    #[inline(always)]
    fn open<L: Lanes>(&self, simd: L, face: &Face, node: &Node, within: Rect, open: &mut Vec<Open>) {
        let (rects, near) = face.boxes(simd, node);
        let base = open.len();
        for lane in lanes_of(rects.some & self.above(simd, node)) {
            let Some(rect) = rects.of(lane).and(within) else { continue };
            let new = Open { near: near[lane], child: Child::of(node.codes[lane]), rect };
            let at = open[base..].iter().rposition(|other| other.near >= new.near);
            open.insert(at.map_or(base, |at| base + at + 1), new);
        }
    }

    /// Which boxes of `node` reach above the horizon.
    #[inline(always)]
    fn above<L: Lanes>(&self, simd: L, node: &Node) -> u32 {
        let Some(normal) = self.eye.horizon.map(|normal| normal.to_array()) else { return u32::MAX };
        let origin = self.eye.origin.to_array();
        let mut highest = simd.splat(0.0);
        for axis in 0..3 {
            let end = simd.load(&node.ends[2 * axis + usize::from(normal[axis] > 0.0)]);
            let from_origin = simd.sub(end, simd.splat(origin[axis]));
            highest = simd.add(highest, simd.mul(from_origin, simd.splat(normal[axis])));
        }
        simd.bits(simd.lt(simd.splat(0.0), highest))
    }

    /// Leaves on `film` what the triangles of `leaf` cover of `rect`.
    #[inline(always)]
    fn leaf<L: Lanes>(&self, simd: L, face: &Face, leaf: Leaf, rect: Rect, film: &mut impl Film) {
        let [first, last] = face.rows(rect);
        let mut few = [(0, 0); FEW];
        if let Some(count) = film.open().few(first..=last, rect.columns.map(usize::from), &mut few) {
            return few.into_iter().take(count).for_each(|texel| self.texel(simd, leaf, texel, film));
        }
        let corners = self.wide.leaves().corners(leaf);
        let bounds = Bounds::new(simd, face, &corners, leaf.count());
        for lane in lanes_of(bounds.some) {
            let Some(rect) = bounds.of(lane, rect) else { continue };
            let seen = Seen::new(simd, (leaf, &corners), lane, face.origin, face.sheared());
            match rect.is_wide().then(|| Edges::new(face, &corners, lane)).flatten() {
                Some(edges) => {
                    let is_in_front = bounds.in_front >> lane & 1 == 1;
                    self.spans(simd, face, &seen, (&edges, is_in_front), rect, film);
                }
                None => {
                    let [first, last] = face.rows(rect);
                    for row in first..=last {
                        self.row(simd, &seen, row, rect.columns.map(usize::from), film);
                    }
                }
            }
        }
    }

    /// Leaves on `film` what is hit of `leaf` through the texel at (row, x).
    #[inline(always)]
    fn texel<L: Lanes>(&self, simd: L, leaf: Leaf, (row, x): (usize, usize), film: &mut impl Film) {
        let direction = self.eye.rays.directions()[row * self.eye.rays.face_size() + x];
        let met =
            LeafRay::new(simd, self.eye.origin, direction).meet(simd, self.wide.leaves(), leaf, f32::MAX);
        for lane in lanes_of(met.hit | met.unclear) {
            let hit = match met.unclear >> lane & 1 {
                0 => Some(met.hit(simd, lane)),
                _ => self.hit(leaf, lane, (row, x)),
            };
            self.leave(hit.map(|hit| Found { hit, leaf, lane }), (row, x), film);
        }
    }

    /// Leaves on `film` what was found behind the texel at (row, x), if it counts.
    #[inline(always)]
    fn leave(&self, found: Option<Found>, (row, x): (usize, usize), film: &mut impl Film) {
        let counts = |found: &Found| {
            let number = found.number();
            !(self.may_not)(number) || (self.counts)(number, &found.hit)
        };
        if let Some(found) = found.filter(counts) {
            film.hit((row, x / 64), x % 64, found);
        }
    }

    /// Leaves on `film` what a wide triangle covers of `rect`, span by span; what is surely inside without a
    /// test if the triangle is in front of the face as a whole, and hits are not asked for.
    #[inline(always)]
    fn spans<L: Lanes, F: Film>(
        &self,
        simd: L,
        face: &Face,
        triangle: &Seen<L>,
        (edges, is_in_front): (&Edges, bool),
        rect: Rect,
        film: &mut F,
    ) {
        let is_whole = F::KEEPS_NO_HITS && is_in_front && !(self.may_not)(triangle.number());
        let [top, bottom] = rect.rows.map(usize::from);
        for first in (top..=bottom).step_by(LANES) {
            let spans = edges.spans(simd, face, first);
            for y in first..=bottom.min(first + LANES - 1) {
                let row = face.number * face.size + y;
                if is_whole && let Some(columns) = rect.columns_of(spans.is(y - first)) {
                    film.covered(row, columns);
                }
                if let Some(columns) = rect.columns_of(spans.may_be(y - first)) {
                    self.row(simd, triangle, row, columns, film);
                }
            }
        }
    }

    /// Leaves on `film` what a triangle covers of `columns` of `row`.
    #[inline(always)]
    fn row<L: Lanes>(
        &self,
        simd: L,
        triangle: &Seen<L>,
        row: usize,
        columns: [usize; 2],
        film: &mut impl Film,
    ) {
        for word in columns[0] / 64..=columns[1] / 64 {
            let mut open = film.open().word(row, word) & mask(word, columns);
            while open != 0 {
                let first = open.trailing_zeros() & !(LANES as u32 - 1);
                let asked = (open >> first & 0xff) as u32;
                open &= !(0xff << first);
                let rays = self.eye.rays.eight(row, word * 64 + first as usize);
                let Some(met) = triangle.meet(simd, rays) else { continue };
                let (hit, unclear) = (met.hit & asked, met.unclear & asked);
                if unclear != 0 {
                    self.one_by_one(triangle, (row, word), first, unclear, film);
                }
                if hit != 0 && (self.may_not)(triangle.number()) {
                    self.one_by_one(triangle, (row, word), first, hit, film);
                } else if hit != 0 {
                    film.hits(simd, (row, word), first, hit, &met);
                }
            }
        }
    }

    /// Leaves on `film` where the rays of `lanes`, from texel `first` of a word on, hit a triangle that counts
    /// there.
    #[cold]
    #[inline(never)]
    fn one_by_one<L: Lanes>(
        &self,
        triangle: &Seen<L>,
        (row, word): Place,
        first: u32,
        lanes: u32,
        film: &mut impl Film,
    ) {
        let (leaf, lane) = (triangle.leaf, triangle.lane);
        for x in lanes_of(lanes).map(|texel| 64 * word + first as usize + texel) {
            let hit = self.hit(leaf, lane, (row, x));
            self.leave(hit.map(|hit| Found { hit, leaf, lane }), (row, x), film);
        }
    }

    /// Where the ray through the texel at (row, x) hits a triangle.
    #[inline(never)]
    fn hit(&self, leaf: Leaf, lane: usize, (row, x): (usize, usize)) -> Option<TriangleHit> {
        let rays = self.eye.rays;
        let ray = ShearedRay::new(self.eye.origin, rays.directions()[row * rays.face_size() + x]);
        ray.intersect(&self.wide.leaves().corners(leaf).triangle(lane), f32::INFINITY)
    }
}

/// Where the triangles of a leaf are on a face.
struct Bounds {
    rects: face::Rects,
    /// Triangles that may cover something.
    some: u32,
    /// Triangles whose bounds count.
    in_front: u32,
}

impl Bounds {
    #[inline(always)]
    fn new<L: Lanes>(simd: L, face: &Face, corners: &Corners, count: usize) -> Self {
        let (a, b, c) =
            (face.seen(simd, corners, 0), face.seen(simd, corners, 1), face.seen(simd, corners, 2));
        let (zero, one) = (simd.splat(0.0), simd.splat(1.0));
        let inverse = [simd.div(one, a[2]), simd.div(one, b[2]), simd.div(one, c[2])];
        let (x, y) = (across(simd, [a[0], b[0], c[0]], inverse), across(simd, [a[1], b[1], c[1]], inverse));
        let nearest = simd.min(simd.min(a[2], b[2]), c[2]);
        let farthest = simd.max(simd.max(a[2], b[2]), c[2]);
        let beside = simd.max(simd.max(x[1], y[1]), simd.max(simd.sub(zero, x[0]), simd.sub(zero, y[0])));
        let there = u32::MAX >> (u32::BITS - count as u32);
        let in_front = simd.and(simd.lt(zero, nearest), simd.lt(beside, simd.splat(BESIDE)));
        let in_front = simd.bits(in_front) & there;
        let reaches = simd.bits(simd.lt(zero, farthest)) & there;
        let rects = face.rects(simd, x, y, in_front);
        Self { some: rects.some | (reaches & !in_front), rects, in_front }
    }

    /// The texels of `within` that the triangle of `lane` may cover.
    #[inline(always)]
    fn of(&self, lane: usize, within: Rect) -> Option<Rect> {
        if self.in_front >> lane & 1 == 1 { self.rects.of(lane).and(within) } else { Some(within) }
    }
}

/// The least and the most of the places where three corners are on an axis of a face, from their inverse
/// distances.
#[inline(always)]
fn across<L: Lanes>(simd: L, [a, b, c]: [L::F32; 3], inverse: [L::F32; 3]) -> [L::F32; 2] {
    let [a, b, c] = [simd.mul(a, inverse[0]), simd.mul(b, inverse[1]), simd.mul(c, inverse[2])];
    [simd.min(simd.min(a, b), c), simd.max(simd.max(a, b), c)]
}
