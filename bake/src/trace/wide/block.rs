//! Up to eight triangles side by side, and the test of [`ShearedRay`] on all of them at once.

use super::lanes::{LANES, Lanes};
use crate::trace::triangle::{ShearedRay, TriangleHit};
use glam::Vec3A;

/// The triangles of a leaf.
#[derive(Debug, Clone)]
#[repr(align(32))]
pub struct Block {
    /// By corner, then axis; no numbers where there is no triangle.
    pub corners: [[[f32; LANES]; 3]; 3],
    /// Number of the first one in the order of leaves.
    pub first: u32,
}

/// A ray as blocks take it.
#[derive(Debug, Clone, Copy)]
pub struct BlockRay<L: Lanes> {
    origin: [L::F32; 3],
    /// Of the shear: what the ray's longest axis adds to the others, and its inverse length along it.
    shear: [L::F32; 2],
    along: L::F32,
    /// The other axes, and the longest.
    axes: [usize; 3],
}

/// What a ray may meet in a block.
#[derive(Debug, Clone, Copy)]
pub struct Met {
    /// Triangles that are hit.
    pub hit: u32,
    /// Triangles that only [`ShearedRay`] can decide on, for the ray passes an edge as closely as numbers tell.
    pub unclear: u32,
    distances: [f32; LANES],
    weights: [[f32; LANES]; 2],
}

impl Met {
    /// Where triangle number `lane` is hit.
    pub fn hit(&self, lane: usize) -> TriangleHit {
        TriangleHit { t: self.distances[lane], barycentric: self.weights.map(|weights| weights[lane]) }
    }
}

impl Block {
    /// Of at most eight triangles, of which `first` is the number of the first.
    pub fn new(triangles: &[[Vec3A; 3]], first: u32) -> Self {
        let mut corners = [[[f32::NAN; LANES]; 3]; 3];
        for (lane, triangle) in triangles.iter().enumerate() {
            for (corner, position) in corners.iter_mut().zip(triangle) {
                for (axis, values) in corner.iter_mut().enumerate() {
                    values[lane] = position[axis];
                }
            }
        }
        Self { corners, first }
    }
}

impl<L: Lanes> BlockRay<L> {
    /// The ray from `origin`, sheared as `ray`.
    #[inline(always)]
    pub fn new(simd: L, origin: Vec3A, ray: &ShearedRay) -> Self {
        Self::of_shear(simd, origin, ray.shear())
    }

    /// The ray from `origin` of this [`ShearedRay::shear`].
    #[inline(always)]
    pub fn of_shear(
        simd: L,
        origin: Vec3A,
        (axes, [shear_x, shear_y], along): ([usize; 3], [f32; 2], f32),
    ) -> Self {
        Self {
            origin: [simd.splat(origin.x), simd.splat(origin.y), simd.splat(origin.z)],
            shear: [simd.splat(shear_x), simd.splat(shear_y)],
            along: simd.splat(along),
            axes,
        }
    }

    /// What the ray meets nearer than, or at, `farthest`; the very numbers of [`ShearedRay::intersect`].
    #[inline(always)]
    pub fn meet(&self, simd: L, block: &Block, farthest: f32) -> Met {
        let [[ax, ay, az], [bx, by, bz], [cx, cy, cz]] = [
            self.project(simd, &block.corners[0]),
            self.project(simd, &block.corners[1]),
            self.project(simd, &block.corners[2]),
        ];
        let u = simd.sub(simd.mul(cx, by), simd.mul(cy, bx));
        let v = simd.sub(simd.mul(ax, cy), simd.mul(ay, cx));
        let w = simd.sub(simd.mul(bx, ay), simd.mul(by, ax));
        let zero = simd.splat(0.0);
        let edge = simd.eq(u, zero) | simd.eq(v, zero) | simd.eq(w, zero);
        let below = simd.lt(u, zero) | simd.lt(v, zero) | simd.lt(w, zero);
        let above = simd.lt(zero, u) | simd.lt(zero, v) | simd.lt(zero, w);
        let determinant = simd.add(simd.add(u, v), w);
        let scale = simd.div(simd.splat(1.0), determinant);
        let sum = simd.add(simd.add(simd.mul(u, az), simd.mul(v, bz)), simd.mul(w, cz));
        let t = simd.mul(sum, scale);
        let reached = simd.lt(zero, t) & simd.le(t, simd.splat(farthest));
        Met {
            hit: !(below & above) & !edge & reached,
            unclear: edge,
            distances: simd.store(t),
            weights: [simd.store(simd.mul(v, scale)), simd.store(simd.mul(w, scale))],
        }
    }

    /// Corners as the ray sees them: across it, and along it in units of its length.
    #[inline(always)]
    fn project(&self, simd: L, corner: &[[f32; LANES]; 3]) -> [L::F32; 3] {
        let [x, y, z] = self.axes;
        let along = simd.sub(simd.load(&corner[z]), self.origin[z]);
        let across_x = simd.sub(simd.load(&corner[x]), self.origin[x]);
        let across_y = simd.sub(simd.load(&corner[y]), self.origin[y]);
        [
            simd.add(across_x, simd.mul(along, self.shear[0])),
            simd.add(across_y, simd.mul(along, self.shear[1])),
            simd.mul(along, self.along),
        ]
    }
}
