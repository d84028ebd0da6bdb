//! A wide hierarchy over triangles, and rays through it.
//!
//! obvhs builds a binary tree; here it is made eight wide with whole boxes, of which a ray tests eight at once
//! with the vector instructions that the processor has, and so eight triangles of a leaf. All processors find
//! the same: boxes only leave out what cannot be hit, hits are the very numbers of [`ShearedRay`], and of hits
//! at the same distance the triangle with the lowest number counts.

pub(super) mod block;
pub(super) mod lanes;
#[cfg(test)]
pub(super) mod tests;
pub(super) mod tree;

use super::triangle::{ShearedRay, TriangleHit};
use block::{Block, BlockRay, Met};
use glam::Vec3A;
use lanes::{Lanes, Plain};
use obvhs::bvh2::builder::build_bvh2;
use obvhs::{Boundable, BvhBuildParams};
use smallvec::SmallVec;
use std::time::Duration;
use tree::{Child, Node, Tree};

/// Triangles in a hierarchy.
#[derive(Debug)]
pub struct Wide {
    pub(super) nodes: Vec<Node>,
    pub(super) blocks: Vec<Block>,
    pub(super) triangles: Vec<[Vec3A; 3]>,
    /// The number of each triangle as it was given, in the order of leaves.
    pub order: Vec<u32>,
    pub(super) kernel: Kernel,
}

/// The instructions that there are.
#[derive(Debug, Clone, Copy)]
pub(super) enum Kernel {
    Plain,
    #[cfg(target_arch = "x86_64")]
    V3(pulp::x86::V3),
}

impl Kernel {
    pub(super) fn of_this_processor() -> Self {
        #[cfg(target_arch = "x86_64")]
        if let Some(simd) = pulp::x86::V3::try_new() {
            return Self::V3(simd);
        }
        Self::Plain
    }
}

/// Components of a direction that are smaller count as so small, so that everything has an inverse.
const LEAST: f32 = 1.0 / (1u64 << 62) as f32;

/// What is yet to be visited: what it is, below the distance to its box. Distances are at least 0, and bits of
/// such numbers are in their order.
type Open = SmallVec<[u64; 64]>;

fn key(distance: f32, child: Child) -> u64 {
    u64::from(distance.to_bits()) << 32 | u64::from(child.code())
}

fn distance_of(key: u64) -> f32 {
    f32::from_bits((key >> 32) as u32)
}

impl Wide {
    /// Of `triangles` with `boxes` that hold them, larger by the rounding errors of a box test.
    pub fn new<T: Boundable>(triangles: &[[Vec3A; 3]], boxes: &[T]) -> Self {
        let asked = BvhBuildParams {
            pre_split: false,
            max_prims_per_leaf: 1,
            post_collapse_reinsertion_batch_ratio_multiplier: 0.0,
            ..BvhBuildParams::slow_build()
        };
        let tree = match triangles {
            [] => Tree::default(),
            _ => Tree::new(&build_bvh2(boxes, asked, &mut Duration::default())),
        };
        let order: Vec<u32> = tree.leaves.concat();
        let triangles: Vec<[Vec3A; 3]> = order.iter().map(|i| triangles[*i as usize]).collect();
        let mut first = 0;
        let block = |leaf: &Vec<u32>| {
            let block = Block::new(&triangles[first..first + leaf.len()], first as u32);
            first += leaf.len();
            block
        };
        Self {
            blocks: tree.leaves.iter().map(block).collect(),
            nodes: tree.nodes,
            order,
            triangles,
            kernel: Kernel::of_this_processor(),
        }
    }

    /// The triangles, in the order of leaves, as all numbers of triangles here are.
    pub fn triangles(&self) -> &[[Vec3A; 3]] {
        &self.triangles
    }

    /// The nearest triangle along the ray that `counts` where it is hit. `direction` must be a unit vector.
    pub fn nearest(
        &self,
        origin: Vec3A,
        direction: Vec3A,
        counts: impl Fn(u32, &TriangleHit) -> bool,
    ) -> Option<(u32, TriangleHit)> {
        match self.kernel {
            Kernel::Plain => self.nearest_by(Plain, origin, direction, counts),
            #[cfg(target_arch = "x86_64")]
            Kernel::V3(simd) => simd.run(
                #[inline(always)]
                || self.nearest_by(simd, origin, direction, counts),
            ),
        }
    }

    /// Whether any triangle that `counts` is hit along the unit vector `direction`, nearer than `distance`.
    pub fn occluded(
        &self,
        origin: Vec3A,
        direction: Vec3A,
        distance: f32,
        counts: impl Fn(u32, &TriangleHit) -> bool,
    ) -> bool {
        match self.kernel {
            Kernel::Plain => self.occluded_by(Plain, origin, direction, distance, counts),
            #[cfg(target_arch = "x86_64")]
            Kernel::V3(simd) => simd.run(
                #[inline(always)]
                || self.occluded_by(simd, origin, direction, distance, counts),
            ),
        }
    }

    #[inline(always)]
    fn nearest_by<L: Lanes>(
        &self,
        simd: L,
        origin: Vec3A,
        direction: Vec3A,
        counts: impl Fn(u32, &TriangleHit) -> bool,
    ) -> Option<(u32, TriangleHit)> {
        let sheared = ShearedRay::new(origin, direction);
        let (boxes, ray) = (BoxRay::new(simd, origin, direction), BlockRay::new(simd, origin, &sheared));
        let mut nearest: Option<(u32, TriangleHit)> = None;
        let mut farthest = f32::MAX;
        let mut open = Open::new();
        let mut next = (!self.nodes.is_empty()).then_some(key(0.0, Child::of(0)));
        while let Some(here) = next {
            next = match Child::of(here as u32).leaf_or_node() {
                Err(node) => boxes.open(simd, &self.nodes[node], farthest, &mut open),
                Ok(leaf) => {
                    let block = &self.blocks[leaf];
                    let met = ray.meet(simd, block, farthest);
                    for lane in lanes_of(met.hit | met.unclear) {
                        let number = block.first + lane as u32;
                        let hit = self.hit(&sheared, &met, number, lane);
                        let is_nearer = |hit: &TriangleHit| self.is_nearer(number, hit, nearest.as_ref());
                        if let Some(hit) = hit.filter(|hit| is_nearer(hit) && counts(number, hit)) {
                            farthest = hit.t;
                            nearest = Some((number, hit));
                        }
                    }
                    None
                }
            };
            while next.is_none()
                && let Some(last) = open.pop()
            {
                next = (distance_of(last) <= farthest).then_some(last);
            }
        }
        nearest
    }

    #[inline(always)]
    fn occluded_by<L: Lanes>(
        &self,
        simd: L,
        origin: Vec3A,
        direction: Vec3A,
        distance: f32,
        counts: impl Fn(u32, &TriangleHit) -> bool,
    ) -> bool {
        let sheared = ShearedRay::new(origin, direction);
        let (boxes, ray) = (BoxRay::new(simd, origin, direction), BlockRay::new(simd, origin, &sheared));
        let mut open: SmallVec<[u32; 64]> = SmallVec::new();
        if !self.nodes.is_empty() {
            open.push(0);
        }
        while let Some(next) = open.pop() {
            match Child::of(next).leaf_or_node() {
                Err(node) => {
                    let node = &self.nodes[node];
                    let (hit, _) = boxes.meet(simd, node, distance);
                    open.extend(lanes_of(hit).map(|lane| node.children[lane].code()));
                }
                Ok(leaf) => {
                    let block = &self.blocks[leaf];
                    let met = ray.meet(simd, block, distance);
                    for lane in lanes_of(met.hit | met.unclear) {
                        let number = block.first + lane as u32;
                        let hit = self.hit(&sheared, &met, number, lane);
                        if hit.is_some_and(|hit| hit.t < distance && counts(number, &hit)) {
                            return true;
                        }
                    }
                }
            }
        }
        false
    }

    /// Where triangle `number`, which is that of `lane`, is hit.
    #[inline(always)]
    fn hit(&self, ray: &ShearedRay, met: &Met, number: u32, lane: usize) -> Option<TriangleHit> {
        match met.unclear >> lane & 1 {
            0 => Some(met.hit(lane)),
            _ => self.hit_exactly(ray, number),
        }
    }

    /// Where an edge decides. Rare, so out of the way of what is not.
    #[cold]
    #[inline(never)]
    fn hit_exactly(&self, ray: &ShearedRay, number: u32) -> Option<TriangleHit> {
        ray.intersect(&self.triangles[number as usize], f32::INFINITY)
    }

    /// Whether a hit comes before another one: of two at the same distance, the triangle that was given first.
    #[inline(always)]
    fn is_nearer(&self, number: u32, hit: &TriangleHit, than: Option<&(u32, TriangleHit)>) -> bool {
        than.is_none_or(|(other, than)| {
            hit.t < than.t || (hit.t == than.t && self.order[number as usize] < self.order[*other as usize])
        })
    }
}

/// The set lanes of a mask, the lowest first.
#[inline(always)]
pub(super) fn lanes_of(mut mask: u32) -> impl Iterator<Item = usize> {
    std::iter::from_fn(
        #[inline(always)]
        move || {
            let lane = mask.trailing_zeros() as usize;
            let found = (mask != 0).then_some(lane);
            mask &= mask.wrapping_sub(1);
            found
        },
    )
}

/// One over a component of a direction.
#[inline(always)]
fn inverse(component: f32) -> f32 {
    1.0 / if component.abs() < LEAST { LEAST } else { component }
}

/// A ray as boxes take it.
#[derive(Clone, Copy)]
struct BoxRay<L: Lanes> {
    /// 1 / direction, and origin / direction.
    inverse: [L::F32; 3],
    start: [L::F32; 3],
    /// Which of the six ends of a box the ray meets first, by axis.
    near: [usize; 3],
}

impl<L: Lanes> BoxRay<L> {
    #[inline(always)]
    fn new(simd: L, origin: Vec3A, direction: Vec3A) -> Self {
        let (x, y, z) = (inverse(direction.x), inverse(direction.y), inverse(direction.z));
        Self {
            inverse: [simd.splat(x), simd.splat(y), simd.splat(z)],
            start: [simd.splat(origin.x * x), simd.splat(origin.y * y), simd.splat(origin.z * z)],
            near: [usize::from(x < 0.0), 2 + usize::from(y < 0.0), 4 + usize::from(z < 0.0)],
        }
    }

    /// Which boxes of `node` the ray meets within `farthest`, and at what distance it enters them.
    #[inline(always)]
    fn meet(&self, simd: L, node: &Node, farthest: f32) -> (u32, L::F32) {
        let [x, y, z] = self.near;
        let enters = simd.max(
            simd.max(self.at(simd, node, 0, x), self.at(simd, node, 1, y)),
            simd.max(self.at(simd, node, 2, z), simd.splat(0.0)),
        );
        let leaves = simd.min(
            simd.min(self.at(simd, node, 0, x ^ 1), self.at(simd, node, 1, y ^ 1)),
            simd.min(self.at(simd, node, 2, z ^ 1), simd.splat(farthest)),
        );
        (simd.le(enters, leaves), enters)
    }

    /// At what distance the ray meets one of the ends of all boxes, which are across `axis`.
    #[inline(always)]
    fn at(&self, simd: L, node: &Node, axis: usize, end: usize) -> L::F32 {
        simd.mul_sub(simd.load(&node.ends[end]), self.inverse[axis], self.start[axis])
    }

    /// The nearest of what the ray meets of `node`; all else is yet to be visited, the nearest last.
    #[inline(always)]
    fn open(&self, simd: L, node: &Node, farthest: f32, open: &mut Open) -> Option<u64> {
        let (hit, enters) = self.meet(simd, node, farthest);
        let distances = simd.store(enters);
        let mut lanes = lanes_of(hit).map(|lane| key(distances[lane], node.children[lane]));
        let first = lanes.next()?;
        let Some(second) = lanes.next() else { return Some(first) };
        let mut nearest = first.min(second);
        let base = open.len();
        open.push(first.max(second));
        for new in lanes {
            let farther = nearest.max(new);
            nearest = nearest.min(new);
            // The farthest first.
            let mut at = open.len();
            open.push(farther);
            while at > base && open[at - 1] < farther {
                open[at] = open[at - 1];
                at -= 1;
            }
            open[at] = farther;
        }
        Some(nearest)
    }
}
