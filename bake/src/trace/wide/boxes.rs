//! A ray through the boxes of nodes, and what it has yet to visit.

use super::lanes::{LANES, Lanes, entry, lanes_of};
use super::tree::Node;
use glam::Vec3A;

/// Components of a direction that are smaller count as so small, so that everything has an inverse.
const LEAST: f32 = 1.0 / (1u64 << 62) as f32;

/// How many entries [`Lanes::sorted`] sorts.
const SORTED: usize = 4;

/// What is yet to be visited, the next last, in memory that is large enough for it and eight more.
#[derive(Debug)]
pub struct Open<'a, T> {
    room: &'a mut [T],
    count: usize,
}

impl<'a, T: Copy> Open<'a, T> {
    /// Nothing.
    #[inline(always)]
    pub fn new(room: &'a mut [T]) -> Self {
        Self { room, count: 0 }
    }

    /// The next.
    #[inline(always)]
    pub fn pop(&mut self) -> Option<T> {
        self.count = self.count.checked_sub(1)?;
        self.room.get(self.count).copied()
    }

    /// Adds the first `count` of `new`.
    #[inline(always)]
    fn extend<const ROOM: usize>(&mut self, new: [T; ROOM], count: usize) {
        // All of them, for that is one instruction.
        if let Some(to) = self.room.get_mut(self.count..).and_then(<[T]>::first_chunk_mut) {
            *to = new;
        }
        self.count += count;
    }
}

/// A ray as boxes take it.
#[derive(Clone, Copy)]
pub struct BoxRay<L: Lanes> {
    /// 1 / direction, and origin / direction.
    inverse: [L::F32; 3],
    start: [L::F32; 3],
    /// Which of the six ends of a box the ray meets first, by axis.
    near: [usize; 3],
}

/// One over a component of a direction.
#[inline(always)]
fn inverse(component: f32) -> f32 {
    1.0 / if component.abs() < LEAST { LEAST } else { component }
}

impl<L: Lanes> BoxRay<L> {
    /// The ray from `origin` along `direction`.
    #[inline(always)]
    pub fn new(simd: L, origin: Vec3A, direction: Vec3A) -> Self {
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
        (simd.bits(simd.le(enters, leaves)), enters)
    }

    /// At what distance the ray meets one of the ends of all boxes, which are across `axis`.
    #[inline(always)]
    fn at(&self, simd: L, node: &Node, axis: usize, end: usize) -> L::F32 {
        simd.mul_sub(simd.load(&node.ends[end]), self.inverse[axis], self.start[axis])
    }

    /// The nearest of what the ray meets of `node`; all else is yet to be visited, the nearest last.
    #[inline(always)]
    pub fn nearest(&self, simd: L, node: &Node, farthest: f32, open: &mut Open<u64>) -> Option<u32> {
        let (hit, enters) = self.meet(simd, node, farthest);
        if hit == 0 {
            return None;
        }
        let others = hit & (hit - 1);
        if others == 0 {
            return Some(node.codes[hit.trailing_zeros() as usize % LANES]);
        }
        let distances = simd.store(enters);
        if others & (others - 1) == 0 {
            let (one, other) =
                (hit.trailing_zeros() as usize % LANES, others.trailing_zeros() as usize % LANES);
            let (one, other) =
                (entry(distances[one], node.codes[one]), entry(distances[other], node.codes[other]));
            open.extend([one.max(other)], 1);
            return Some(one.min(other) as u32);
        }
        let count = hit.count_ones() as usize;
        if count <= SORTED {
            open.extend(simd.sorted(hit, enters, &node.codes), count);
        } else {
            open.extend(sorted(hit, &distances, &node.codes), count);
        }
        open.pop().map(|nearest| nearest as u32)
    }

    /// Something that the ray meets of `node`; all else is yet to be visited.
    #[inline(always)]
    pub fn any(&self, simd: L, node: &Node, farthest: f32, open: &mut Open<u32>) -> Option<u32> {
        let (hit, _) = self.meet(simd, node, farthest);
        let others = hit & hit.wrapping_sub(1);
        if others != 0 {
            open.extend(simd.packed(others, &node.codes), others.count_ones() as usize);
        }
        (hit != 0).then(|| node.codes[hit.trailing_zeros() as usize % LANES])
    }
}

/// What [`Lanes::sorted`] gives, of many. Rare, so out of the way of what is not.
#[cold]
#[inline(never)]
fn sorted(mask: u32, distances: &[f32; LANES], codes: &[u32; LANES]) -> [u64; LANES] {
    let mut entries = [0; LANES];
    for (to, lane) in entries.iter_mut().zip(lanes_of(mask)) {
        *to = entry(distances[lane], codes[lane]);
    }
    entries.sort_unstable_by(|a, b| b.cmp(a));
    entries
}
