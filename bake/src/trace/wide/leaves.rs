//! Triangles as leaves have them, up to eight side by side, and the test of [`ShearedRay`] on all of a leaf at
//! once.

use super::lanes::{LANES, Lanes};
use super::tree::Leaf;
use crate::trace::triangle::TriangleHit;
use glam::Vec3A;

/// Coordinates of three corners.
const COORDINATES: usize = 9;
/// As many numbers as a leaf may have, and as all its loads together read.
const ROOM: usize = COORDINATES * LANES;

/// The triangles of all leaves.
#[derive(Debug, Clone, Copy)]
pub struct Leaves<'a> {
    coordinates: &'a [f32],
}

/// The axes after each axis.
const NEXT: [usize; 4] = [1, 2, 0, 1];

/// A ray as leaves take it.
#[derive(Debug, Clone, Copy)]
pub struct LeafRay<L: Lanes> {
    origin: [L::F32; 3],
    /// Of the shear: what the ray's longest axis adds to the others, and its inverse length along it.
    shear: [L::F32; 2],
    along: L::F32,
    /// The other axes, and the longest.
    axes: [usize; 3],
}

/// What a ray may meet in a leaf.
#[derive(Debug, Clone, Copy)]
pub struct Met<L: Lanes> {
    /// Triangles that are hit.
    pub hit: u32,
    /// Triangles that only [`ShearedRay`] can decide on, for the ray passes an edge as closely as numbers tell.
    pub unclear: u32,
    distances: L::F32,
    weights: [L::F32; 2],
}

impl<L: Lanes> Met<L> {
    /// Where triangle number `lane` is hit.
    #[inline(always)]
    pub fn hit(&self, simd: L, lane: usize) -> TriangleHit {
        let [v, w] = self.weights;
        let [t, v, w] = [simd.store(self.distances)[lane], simd.store(v)[lane], simd.store(w)[lane]];
        TriangleHit { t, barycentric: [v, w] }
    }
}

/// The triangles of leaves in memory: leaf by leaf without gaps, for each axis and corner as many numbers as there are
/// triangles. Memory limits large scenes, and leaves are rarely full. At the end zeros, so that eight numbers can be
/// read anywhere.
pub fn coordinates(leaves: impl Iterator<Item = Vec<[Vec3A; 3]>>) -> Vec<f32> {
    let mut coordinates = Vec::new();
    for triangles in leaves {
        for axis in 0..3 {
            for corner in 0..3 {
                coordinates.extend(triangles.iter().map(|triangle| triangle[corner][axis]));
            }
        }
    }
    coordinates.extend([0.0; ROOM]);
    coordinates
}

impl<'a> Leaves<'a> {
    /// Of [`coordinates`].
    pub fn new(coordinates: &'a [f32]) -> Self {
        Self { coordinates }
    }

    /// The corners of a leaf's triangles.
    #[inline(always)]
    pub fn corners(&self, leaf: Leaf) -> Corners<'a> {
        let coordinates = self.coordinates.get(COORDINATES * leaf.first()..);
        let coordinates = coordinates.and_then(|coordinates| coordinates.first_chunk());
        Corners { coordinates: coordinates.unwrap_or(&[0.0; ROOM]), count: leaf.count() }
    }
}

/// The corners of up to eight triangles.
#[derive(Debug, Clone, Copy)]
pub struct Corners<'a> {
    /// Those of the leaf, and what comes after them.
    coordinates: &'a [f32; ROOM],
    count: usize,
}

impl Corners<'_> {
    /// A coordinate of one corner of all triangles; whatever where there is no triangle.
    #[inline(always)]
    pub fn of(&self, corner: usize, axis: usize) -> &[f32; LANES] {
        let numbers = self.coordinates.get((3 * axis + corner) * self.count..);
        numbers.and_then(|numbers| numbers.first_chunk()).unwrap_or(&[0.0; LANES])
    }

    /// One triangle.
    pub fn triangle(&self, lane: usize) -> [Vec3A; 3] {
        let corner = |corner| Vec3A::from_array([0, 1, 2].map(|axis| self.of(corner, axis)[lane]));
        [corner(0), corner(1), corner(2)]
    }
}

impl<L: Lanes> LeafRay<L> {
    /// The ray from `origin`, sheared as [`ShearedRay`] does.
    #[inline(always)]
    pub fn new(simd: L, origin: Vec3A, direction: Vec3A) -> Self {
        let size = direction.abs();
        // Without branches, which rays without order would take at random.
        let is_x = (size.x >= size.y) & (size.x >= size.z);
        let z = usize::from(!is_x) << usize::from(size.y < size.z);
        let (x, y) = (NEXT[z], NEXT[z + 1]);
        let (from, way) = (origin.to_array(), direction.to_array());
        let along = 1.0 / way[z];
        Self {
            origin: [simd.splat(from[x]), simd.splat(from[y]), simd.splat(from[z])],
            shear: [simd.splat(0.0 - way[x] * along), simd.splat(0.0 - way[y] * along)],
            along: simd.splat(along),
            axes: [x, y, z],
        }
    }

    /// What the ray meets nearer than, or at, `farthest`; the very numbers of [`ShearedRay::intersect`].
    #[inline(always)]
    pub fn meet(&self, simd: L, leaves: Leaves, leaf: Leaf, farthest: f32) -> Met<L> {
        let corners = leaves.corners(leaf);
        let [ax, ay, az] = self.project(simd, &corners, 0);
        let [bx, by, bz] = self.project(simd, &corners, 1);
        let [cx, cy, cz] = self.project(simd, &corners, 2);
        let u = simd.sub(simd.mul(cx, by), simd.mul(cy, bx));
        let v = simd.sub(simd.mul(ax, cy), simd.mul(ay, cx));
        let w = simd.sub(simd.mul(bx, ay), simd.mul(by, ax));
        let zero = simd.splat(0.0);
        let (least, most) = (simd.min(simd.min(u, v), w), simd.max(simd.max(u, v), w));
        let inside = simd.or(simd.lt(zero, least), simd.lt(most, zero));
        let inside_or_edge = simd.or(simd.le(zero, least), simd.le(most, zero));
        let there = u32::MAX >> (u32::BITS - corners.count as u32);
        let candidates = simd.bits(inside_or_edge) & there;
        if candidates == 0 {
            return Met { hit: 0, unclear: 0, distances: zero, weights: [zero, zero] };
        }
        let determinant = simd.add(simd.add(u, v), w);
        let scale = simd.div(simd.splat(1.0), determinant);
        let sum = simd.add(simd.add(simd.mul(u, az), simd.mul(v, bz)), simd.mul(w, cz));
        let t = simd.mul(sum, scale);
        let reached = simd.and(simd.lt(zero, t), simd.le(t, simd.splat(farthest)));
        Met {
            hit: simd.bits(simd.and(inside, reached)) & there,
            unclear: candidates & !simd.bits(inside),
            distances: t,
            weights: [simd.mul(v, scale), simd.mul(w, scale)],
        }
    }

    /// Corners as the ray sees them: across it, and along it in units of its length.
    #[inline(always)]
    fn project(&self, simd: L, corners: &Corners, corner: usize) -> [L::F32; 3] {
        let [x, y, z] = self.axes;
        let along = simd.sub(simd.load(corners.of(corner, z)), self.origin[2]);
        let across_x = simd.sub(simd.load(corners.of(corner, x)), self.origin[0]);
        let across_y = simd.sub(simd.load(corners.of(corner, y)), self.origin[1]);
        [
            simd.add(across_x, simd.mul(along, self.shear[0])),
            simd.add(across_y, simd.mul(along, self.shear[1])),
            simd.mul(along, self.along),
        ]
    }
}
