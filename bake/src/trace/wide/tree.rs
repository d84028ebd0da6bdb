//! A binary hierarchy made eight wide: which of its nodes to keep, and where triangles lie together.
//!
//! The cheapest way is found exactly by dynamic programming over the binary tree (Ylitie, Karras, Laine 2017,
//! "Efficient Incoherent Ray Traversal on GPUs Through Compressed Wide BVHs", section 3.1).

use super::lanes::LANES;
use obvhs::bvh2::Bvh2;

/// What a ray pays to test the boxes of a node.
const NODE_COST: f32 = 1.0;
/// What it pays to test up to eight triangles.
const LEAF_COST: f32 = 1.2;

/// A node or leaf of the wide tree, or room for one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Child(u32);

impl Child {
    /// Nothing; its box is empty.
    pub const NONE: Self = Self(u32::MAX);

    fn node(index: usize) -> Self {
        Self(index as u32)
    }

    /// As nodes have it.
    pub fn of(code: u32) -> Self {
        Self(code)
    }

    /// The leaf, or else the number of the node.
    #[inline(always)]
    pub fn leaf_or_node(self) -> Result<Leaf, usize> {
        if self.0 & Leaf::MARK != 0 { Ok(Leaf(self.0)) } else { Err(self.0 as usize) }
    }
}

/// Up to eight triangles that follow one another.
#[derive(Debug, Clone, Copy)]
pub struct Leaf(u32);

impl Leaf {
    const MARK: u32 = 1 << 31;
    const FIRST_BITS: u32 = 28;

    fn new(first: usize, count: usize) -> Self {
        Self(Self::MARK | (count as u32 - 1) << Self::FIRST_BITS | first as u32)
    }

    /// The number of the first triangle.
    #[inline(always)]
    pub fn first(self) -> usize {
        (self.0 & ((1 << Self::FIRST_BITS) - 1)) as usize
    }

    /// How many there are, from 1 to 8.
    #[inline(always)]
    pub fn count(self) -> usize {
        (self.0 >> Self::FIRST_BITS) as usize % LANES + 1
    }
}

/// Eight boxes and what is in them.
#[derive(Debug, Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C, align(32))]
pub struct Node {
    /// Low ends and high ends along x, then y, then z; boxes that are empty end before they begin.
    pub ends: [[f32; LANES]; 6],
    /// What is in each, see [`Child::of`].
    pub codes: [u32; LANES],
}

impl Node {
    /// What is in it.
    pub fn children(&self) -> impl Iterator<Item = Child> + Clone {
        self.codes.iter().map(|code| Child::of(*code)).filter(|child| *child != Child::NONE)
    }

    const EMPTY: Self = Self {
        ends: [
            [f32::MAX; LANES],
            [f32::MIN; LANES],
            [f32::MAX; LANES],
            [f32::MIN; LANES],
            [f32::MAX; LANES],
            [f32::MIN; LANES],
        ],
        codes: [Child::NONE.0; LANES],
    };
}

/// The wide tree; its root is node 0.
#[derive(Debug, Default)]
pub struct Tree {
    /// The nodes; none if there are no triangles.
    pub nodes: Vec<Node>,
    /// The leaves; their primitives follow one another.
    pub leaves: Vec<Leaf>,
    /// The primitives, in the order of leaves.
    pub order: Vec<u32>,
}

/// How the cheapest forest of at most so many trees is made of a binary node.
#[derive(Clone, Copy, Default)]
struct Best {
    cost: f32,
    /// How many trees come of the left child; 0: as with one tree less.
    left: u8,
}

/// By the number of trees less one.
type Bests = [Best; LANES];

/// What a binary node is as one tree.
#[derive(Clone, Copy, Default)]
struct Plan {
    bests: Bests,
    primitives: u32,
    is_leaf: bool,
    /// Of the children of the wide node, how many come of the left child.
    left: u8,
}

impl Tree {
    /// Of a binary tree whose leaves have one primitive each.
    pub fn new(binary: &Bvh2) -> Self {
        let mut tree = Self::default();
        if binary.nodes.is_empty() {
            return tree;
        }
        let plans = plans(binary);
        tree.nodes.push(Node::EMPTY);
        // Binary nodes that become a wide one, and its number. The root does, whatever it costs.
        let mut open = vec![(0, 0)];
        while let Some((from, to)) = open.pop() {
            let mut members = Vec::with_capacity(LANES);
            match binary.nodes[from].is_leaf() {
                true => members.push(from),
                false => split(binary, &plans, from, LANES, plans[from].left, &mut members),
            }
            for (lane, member) in members.into_iter().enumerate() {
                let child = if plans[member].is_leaf {
                    let first = tree.order.len();
                    add_primitives(binary, member, &mut tree.order);
                    let leaf = Leaf::new(first, tree.order.len() - first);
                    tree.leaves.push(leaf);
                    Child(leaf.0)
                } else {
                    tree.nodes.push(Node::EMPTY);
                    open.push((member, tree.nodes.len() - 1));
                    Child::node(tree.nodes.len() - 1)
                };
                let aabb = binary.nodes[member].aabb();
                let node = &mut tree.nodes[to];
                node.codes[lane] = child.0;
                for axis in 0..3 {
                    node.ends[2 * axis][lane] = aabb.min[axis];
                    node.ends[2 * axis + 1][lane] = aabb.max[axis];
                }
            }
        }
        tree
    }

    /// How many nodes and leaves of it a ray may have to keep for later at most.
    pub fn most_open(&self) -> usize {
        let mut most = vec![0; self.nodes.len()];
        // Children come after their parents.
        for (number, node) in self.nodes.iter().enumerate().rev() {
            let children = node.children();
            let below = children.clone().filter_map(|child| child.leaf_or_node().err());
            most[number] = children.count() + below.map(|child| most[child]).max().unwrap_or(0);
        }
        most.first().copied().unwrap_or(0)
    }
}

/// For each binary node.
fn plans(binary: &Bvh2) -> Vec<Plan> {
    let mut plans = vec![Plan::default(); binary.nodes.len()];
    // Parents before their children.
    let mut order = vec![0];
    let mut next = 0;
    while let Some(&node) = order.get(next) {
        next += 1;
        if !binary.nodes[node].is_leaf() {
            let first = binary.nodes[node].first_index as usize;
            order.extend([first, first + 1]);
        }
    }
    for &node in order.iter().rev() {
        let area = binary.nodes[node].aabb().half_area();
        plans[node] = if binary.nodes[node].is_leaf() {
            let best = Best { cost: area * LEAF_COST, left: 0 };
            Plan { bests: [best; LANES], primitives: 1, is_leaf: true, left: 0 }
        } else {
            let first = binary.nodes[node].first_index as usize;
            plan(&plans[first], &plans[first + 1], area)
        };
    }
    plans
}

fn plan(left: &Plan, right: &Plan, area: f32) -> Plan {
    // The cheapest forest of exactly so many trees or fewer, at least one of each child.
    let shared = |trees: usize| {
        let cost = |of_left: usize| Best {
            cost: left.bests[of_left - 1].cost + right.bests[trees - of_left - 1].cost,
            left: of_left as u8,
        };
        (1..trees).map(cost).min_by(|a, b| a.cost.total_cmp(&b.cost)).unwrap_or_default()
    };
    let primitives = left.primitives + right.primitives;
    let children = shared(LANES);
    let as_node = area * NODE_COST + children.cost;
    let as_leaf = if primitives as usize <= LANES { area * LEAF_COST } else { f32::INFINITY };
    let is_leaf = as_leaf <= as_node;
    let mut bests = [Best { cost: as_leaf.min(as_node), left: 0 }; LANES];
    for trees in 2..=LANES {
        let before = Best { left: 0, ..bests[trees - 2] };
        let split = shared(trees);
        bests[trees - 1] = if split.cost < before.cost { split } else { before };
    }
    Plan { bests, primitives, is_leaf, left: children.left }
}

/// Adds the roots of the cheapest forest of at most `trees` trees below `node`, of which the left child has
/// `of_left`; 0: as with fewer.
fn split(binary: &Bvh2, plans: &[Plan], node: usize, trees: usize, of_left: u8, roots: &mut Vec<usize>) {
    let first = binary.nodes[node].first_index as usize;
    for (child, trees) in [(first, usize::from(of_left)), (first + 1, trees - usize::from(of_left))] {
        let fewer = (1..=trees).rev().find(|trees| plans[child].bests[trees - 1].left > 0);
        match fewer {
            Some(trees) => split(binary, plans, child, trees, plans[child].bests[trees - 1].left, roots),
            None => roots.push(child),
        }
    }
}

fn add_primitives(binary: &Bvh2, node: usize, order: &mut Vec<u32>) {
    let mut open = vec![node];
    while let Some(node) = open.pop() {
        let first = binary.nodes[node].first_index as usize;
        match binary.nodes[node].is_leaf() {
            true => order.push(binary.primitive_indices[first]),
            false => open.extend([first + 1, first]),
        }
    }
}
