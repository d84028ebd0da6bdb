//! One triangle before eight texels of a row: the test of `ShearedRay` on all eight rays at once.

use super::rays::Eight;
use crate::trace::triangle::TriangleHit;
use crate::trace::wide::Found;
use crate::trace::wide::lanes::Lanes;
use crate::trace::wide::leaves::Corners;
use crate::trace::wide::tree::Leaf;

/// A triangle as rays from one point through a face take it.
#[derive(Clone, Copy)]
pub(super) struct Seen<L: Lanes> {
    /// By corner, in the axes of `ShearedRay::shear`.
    corners: [[L::F32; 3]; 3],
    /// The leaf that it is of.
    pub leaf: Leaf,
    /// Which of the leaf's it is.
    pub lane: usize,
}

/// What eight rays meet.
pub(super) struct Met<L: Lanes> {
    /// Rays that hit the triangle.
    pub hit: u32,
    /// Rays that only `ShearedRay` can decide on, for they pass an edge as closely as numbers tell.
    pub unclear: u32,
    /// Distances along the rays.
    pub distances: L::F32,
    weights: [L::F32; 2],
    leaf: Leaf,
    lane: usize,
}

impl<L: Lanes> Met<L> {
    /// What the ray of `lane` finds.
    #[inline(always)]
    pub fn found(&self, simd: L, lane: usize) -> Found {
        let [v, w] = self.weights;
        let [t, v, w] = [simd.store(self.distances)[lane], simd.store(v)[lane], simd.store(w)[lane]];
        Found { hit: TriangleHit { t, barycentric: [v, w] }, leaf: self.leaf, lane: self.lane }
    }
}

impl<L: Lanes> Seen<L> {
    /// The triangle of `lane` of a leaf with these corners, from `origin`, whose axes are in the order of `axes`.
    #[inline(always)]
    pub fn new(
        simd: L,
        (leaf, corners): (Leaf, &Corners),
        lane: usize,
        origin: [f32; 3],
        axes: [usize; 3],
    ) -> Self {
        let of = (lane, origin, axes);
        let corners =
            [corner(simd, corners, 0, of), corner(simd, corners, 1, of), corner(simd, corners, 2, of)];
        Self { corners, leaf, lane }
    }

    /// Its number, in the order of leaves.
    #[inline(always)]
    pub fn number(&self) -> u32 {
        (self.leaf.first() + self.lane) as u32
    }

    /// What the rays of `eight` meet of it; the very numbers of `ShearedRay::intersect`.
    #[inline(always)]
    pub fn meet(&self, simd: L, eight: &Eight) -> Option<Met<L>> {
        let across = [simd.load(&eight.across[0]), simd.load(&eight.across[1])];
        let [a, b, c] = self.corners;
        let ([ax, ay], [bx, by], [cx, cy]) =
            (project(simd, a, across), project(simd, b, across), project(simd, c, across));
        let u = simd.sub(simd.mul(cx, by), simd.mul(cy, bx));
        let v = simd.sub(simd.mul(ax, cy), simd.mul(ay, cx));
        let w = simd.sub(simd.mul(bx, ay), simd.mul(by, ax));
        let zero = simd.splat(0.0);
        let (least, most) = (simd.min(simd.min(u, v), w), simd.max(simd.max(u, v), w));
        let may_be = simd.bits(simd.or(simd.le(zero, least), simd.le(most, zero)));
        if may_be == 0 {
            return None;
        }
        let clear = simd.or(simd.lt(zero, least), simd.lt(most, zero));
        let along = simd.load(&eight.along);
        let [az, bz, cz] = [simd.mul(a[2], along), simd.mul(b[2], along), simd.mul(c[2], along)];
        let scale = simd.div(simd.splat(1.0), simd.add(simd.add(u, v), w));
        let sum = simd.add(simd.add(simd.mul(u, az), simd.mul(v, bz)), simd.mul(w, cz));
        let distances = simd.mul(sum, scale);
        let reached = simd.and(simd.lt(zero, distances), simd.lt(distances, simd.splat(f32::INFINITY)));
        Some(Met {
            hit: simd.bits(simd.and(clear, reached)),
            unclear: may_be & !simd.bits(clear),
            distances,
            weights: [simd.mul(v, scale), simd.mul(w, scale)],
            leaf: self.leaf,
            lane: self.lane,
        })
    }
}

/// The corner of `lane` from `origin`, in the order of `axes`.
#[inline(always)]
fn corner<L: Lanes>(
    simd: L,
    corners: &Corners,
    corner: usize,
    (lane, origin, [x, y, z]): (usize, [f32; 3], [usize; 3]),
) -> [L::F32; 3] {
    [
        simd.splat(corners.of(corner, x)[lane] - origin[x]),
        simd.splat(corners.of(corner, y)[lane] - origin[y]),
        simd.splat(corners.of(corner, z)[lane] - origin[z]),
    ]
}

/// Where eight rays see a corner, across them.
#[inline(always)]
fn project<L: Lanes>(simd: L, [x, y, z]: [L::F32; 3], across: [L::F32; 2]) -> [L::F32; 2] {
    [simd.add(x, simd.mul(z, across[0])), simd.add(y, simd.mul(z, across[1]))]
}
