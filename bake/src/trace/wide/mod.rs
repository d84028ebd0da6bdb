//! A wide hierarchy over triangles, and rays through it.
//!
//! obvhs builds a binary tree; here it is made eight wide with whole boxes, of which a ray tests eight at once
//! with the vector instructions that the processor has, and so eight triangles of a leaf. All processors find
//! the same: boxes only leave out what cannot be hit, hits are the very numbers of [`ShearedRay`], and of hits
//! at the same distance the triangle with the lowest number counts.

mod boxes;
pub(super) mod lanes;
pub(super) mod leaves;
mod pages;
#[cfg(test)]
pub(super) mod tests;
pub(super) mod tree;

use super::triangle::{ShearedRay, TriangleHit};
use boxes::{BoxRay, Open};
use glam::Vec3A;
use lanes::{LANES, Lanes, Plain, distance_of, lanes_of};
use leaves::{LeafRay, Leaves, Met, coordinates};
use obvhs::bvh2::builder::build_bvh2;
use obvhs::{Boundable, BvhBuildParams};
use pages::Pages;
use std::cell::Cell;
use std::time::Duration;
use tree::{Child, Leaf, Node, Tree};

/// Triangles in a hierarchy.
#[derive(Debug)]
pub struct Wide {
    pub(super) nodes: Pages<Node>,
    coordinates: Pages<f32>,
    /// The number of each triangle as it was given, in the order of leaves.
    pub order: Vec<u32>,
    pub(super) kernel: Kernel,
    /// Room for what a ray keeps for later.
    room: usize,
}

/// The instructions that there are.
#[derive(Debug, Clone, Copy)]
pub(super) enum Kernel {
    Plain,
    #[cfg(target_arch = "x86_64")]
    V3(pulp::x86::V3),
    #[cfg(target_arch = "x86_64")]
    V4(pulp::x86::V4),
}

impl Kernel {
    pub(super) fn of_this_processor() -> Self {
        #[cfg(target_arch = "x86_64")]
        {
            if let Some(simd) = pulp::x86::V4::try_new() {
                return Self::V4(simd);
            }
            if let Some(simd) = pulp::x86::V3::try_new() {
                return Self::V3(simd);
            }
        }
        Self::Plain
    }
}

thread_local! {
    /// What a ray keeps for later, from ray to ray.
    static OPEN: Cell<Vec<u64>> = const { Cell::new(Vec::new()) };
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
        let leaf = |leaf: &Leaf| {
            let order = &tree.order[leaf.first()..leaf.first() + leaf.count()];
            order.iter().map(|i| triangles[*i as usize]).collect()
        };
        Self {
            coordinates: Pages::new(&coordinates(tree.leaves.iter().map(leaf))),
            room: tree.most_open() + LANES,
            nodes: Pages::new(&tree.nodes),
            order: tree.order,
            kernel: Kernel::of_this_processor(),
        }
    }

    /// The nearest triangle along the ray that `counts` where it is hit. `direction` must be a unit vector.
    pub fn nearest(
        &self,
        origin: Vec3A,
        direction: Vec3A,
        counts: impl Fn(u32, &TriangleHit) -> bool,
    ) -> Option<Found> {
        let mut room = self.room();
        let open = &mut room[..];
        let found = match self.kernel {
            Kernel::Plain => self.nearest_by(Plain, open, origin, direction, counts),
            #[cfg(target_arch = "x86_64")]
            Kernel::V3(simd) => simd.run(
                #[inline(always)]
                || self.nearest_by(simd, open, origin, direction, counts),
            ),
            #[cfg(target_arch = "x86_64")]
            Kernel::V4(simd) => simd.run(
                #[inline(always)]
                || self.nearest_by(simd, open, origin, direction, counts),
            ),
        };
        OPEN.set(room);
        found
    }

    /// Whether any triangle that `counts` is hit along the unit vector `direction`, nearer than `distance`.
    pub fn occluded(
        &self,
        origin: Vec3A,
        direction: Vec3A,
        distance: f32,
        counts: impl Fn(u32, &TriangleHit) -> bool,
    ) -> bool {
        let mut room = self.room();
        let open = &mut room[..];
        let found = match self.kernel {
            Kernel::Plain => self.occluded_by(Plain, open, origin, direction, distance, counts),
            #[cfg(target_arch = "x86_64")]
            Kernel::V3(simd) => simd.run(
                #[inline(always)]
                || self.occluded_by(simd, open, origin, direction, distance, counts),
            ),
            #[cfg(target_arch = "x86_64")]
            Kernel::V4(simd) => simd.run(
                #[inline(always)]
                || self.occluded_by(simd, open, origin, direction, distance, counts),
            ),
        };
        OPEN.set(room);
        found
    }

    /// The triangles.
    #[inline(always)]
    pub(super) fn leaves(&self) -> Leaves<'_> {
        Leaves::new(self.coordinates.as_slice())
    }

    /// Memory for [`Open`], which this thread had before.
    #[inline(always)]
    fn room(&self) -> Vec<u64> {
        let mut room = OPEN.take();
        if room.len() < self.room {
            room.resize(self.room, 0);
        }
        room
    }

    #[inline(always)]
    fn nearest_by<L: Lanes>(
        &self,
        simd: L,
        open: &mut [u64],
        origin: Vec3A,
        direction: Vec3A,
        counts: impl Fn(u32, &TriangleHit) -> bool,
    ) -> Option<Found> {
        let (boxes, ray) = (BoxRay::new(simd, origin, direction), LeafRay::new(simd, origin, direction));
        let (nodes, leaves) = (self.nodes.as_slice(), self.leaves());
        let mut open = Open::new(open);
        let (mut nearest, mut farthest) = (None, f32::MAX);
        let mut next = (!nodes.is_empty()).then_some(0);
        while let Some(here) = next {
            next = match Child::of(here).leaf_or_node() {
                Err(node) => boxes.nearest(simd, &nodes[node], farthest, &mut open),
                Ok(leaf) => {
                    let met = ray.meet(simd, leaves, leaf, farthest);
                    for lane in lanes_of(met.hit | met.unclear) {
                        let number = (leaf.first() + lane) as u32;
                        let hit = self.hit(simd, (origin, direction), &met, leaf, lane);
                        let is_nearer = |hit: &TriangleHit| self.is_nearer(number, hit, nearest.as_ref());
                        if let Some(hit) = hit.filter(|hit| is_nearer(hit) && counts(number, hit)) {
                            farthest = hit.t;
                            nearest = Some(Found { hit, leaf, lane });
                        }
                    }
                    None
                }
            };
            while next.is_none()
                && let Some(last) = open.pop()
            {
                next = (distance_of(last) <= farthest).then_some(last as u32);
            }
        }
        nearest
    }

    #[inline(always)]
    fn occluded_by<L: Lanes>(
        &self,
        simd: L,
        open: &mut [u64],
        origin: Vec3A,
        direction: Vec3A,
        distance: f32,
        counts: impl Fn(u32, &TriangleHit) -> bool,
    ) -> bool {
        let (boxes, ray) = (BoxRay::new(simd, origin, direction), LeafRay::new(simd, origin, direction));
        let (nodes, leaves) = (self.nodes.as_slice(), self.leaves());
        let mut open = Open::new(bytemuck::cast_slice_mut(open));
        let mut next = (!nodes.is_empty()).then_some(0);
        while let Some(here) = next {
            next = match Child::of(here).leaf_or_node() {
                Err(node) => boxes.any(simd, &nodes[node], distance, &mut open),
                Ok(leaf) => {
                    let met = ray.meet(simd, leaves, leaf, distance);
                    for lane in lanes_of(met.hit | met.unclear) {
                        let number = (leaf.first() + lane) as u32;
                        let hit = self.hit(simd, (origin, direction), &met, leaf, lane);
                        if hit.is_some_and(|hit| hit.t < distance && counts(number, &hit)) {
                            return true;
                        }
                    }
                    None
                }
            };
            if next.is_none() {
                next = open.pop();
            }
        }
        false
    }

    /// Where the triangle of `lane` is hit.
    #[inline(always)]
    fn hit<L: Lanes>(
        &self,
        simd: L,
        ray: (Vec3A, Vec3A),
        met: &Met<L>,
        leaf: Leaf,
        lane: usize,
    ) -> Option<TriangleHit> {
        match met.unclear >> lane & 1 {
            0 => Some(met.hit(simd, lane)),
            _ => self.hit_exactly(ray, leaf, lane),
        }
    }

    /// Where an edge decides. Rare, so out of the way of what is not.
    #[cold]
    #[inline(never)]
    fn hit_exactly(
        &self,
        (origin, direction): (Vec3A, Vec3A),
        leaf: Leaf,
        lane: usize,
    ) -> Option<TriangleHit> {
        ShearedRay::new(origin, direction)
            .intersect(&self.leaves().corners(leaf).triangle(lane), f32::INFINITY)
    }

    /// Whether a hit comes before another one: of two at the same distance, the triangle that was given first.
    #[inline(always)]
    fn is_nearer(&self, number: u32, hit: &TriangleHit, than: Option<&Found>) -> bool {
        than.is_none_or(|than| {
            hit.t < than.hit.t
                || (hit.t == than.hit.t && self.order[number as usize] < self.order[than.number() as usize])
        })
    }

    /// The triangle that was found.
    #[inline(always)]
    pub fn triangle(&self, found: &Found) -> [Vec3A; 3] {
        self.leaves().corners(found.leaf).triangle(found.lane)
    }
}

/// A triangle that a ray meets.
#[derive(Debug, Clone, Copy)]
pub struct Found {
    /// Where it is met.
    pub hit: TriangleHit,
    /// The leaf of the triangle.
    pub(super) leaf: Leaf,
    /// Which of the leaf's it is.
    pub(super) lane: usize,
}

impl Found {
    /// The triangle's number, in the order of leaves.
    #[inline(always)]
    pub fn number(&self) -> u32 {
        (self.leaf.first() + self.lane) as u32
    }
}
