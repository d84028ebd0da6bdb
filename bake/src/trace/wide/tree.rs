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
    const LEAF: u32 = 1 << 31;

    fn node(index: usize) -> Self {
        Self(index as u32)
    }

    fn leaf(index: usize) -> Self {
        Self(index as u32 | Self::LEAF)
    }

    /// From [`Child::code`].
    pub fn of(code: u32) -> Self {
        Self(code)
    }

    /// As a number.
    pub fn code(self) -> u32 {
        self.0
    }

    /// The number of the leaf, or else of the node.
    pub fn leaf_or_node(self) -> Result<usize, usize> {
        if self.0 & Self::LEAF != 0 { Ok((self.0 & !Self::LEAF) as usize) } else { Err(self.0 as usize) }
    }
}

/// Eight boxes and what is in them.
#[derive(Debug, Clone)]
#[repr(align(32))]
pub struct Node {
    /// Low ends and high ends along x, then y, then z; boxes that are empty end before they begin.
    pub ends: [[f32; LANES]; 6],
    /// What is in each.
    pub children: [Child; LANES],
}

impl Node {
    const EMPTY: Self = Self {
        ends: [
            [f32::MAX; LANES],
            [f32::MIN; LANES],
            [f32::MAX; LANES],
            [f32::MIN; LANES],
            [f32::MAX; LANES],
            [f32::MIN; LANES],
        ],
        children: [Child::NONE; LANES],
    };
}

/// The wide tree; its root is node 0.
#[derive(Debug, Default)]
pub struct Tree {
    /// The nodes; none if there are no triangles.
    pub nodes: Vec<Node>,
    /// The primitives of each leaf, at most eight.
    pub leaves: Vec<Vec<u32>>,
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
                    tree.leaves.push(primitives(binary, member));
                    Child::leaf(tree.leaves.len() - 1)
                } else {
                    tree.nodes.push(Node::EMPTY);
                    open.push((member, tree.nodes.len() - 1));
                    Child::node(tree.nodes.len() - 1)
                };
                let aabb = binary.nodes[member].aabb();
                let node = &mut tree.nodes[to];
                node.children[lane] = child;
                for axis in 0..3 {
                    node.ends[2 * axis][lane] = aabb.min[axis];
                    node.ends[2 * axis + 1][lane] = aabb.max[axis];
                }
            }
        }
        tree
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

fn primitives(binary: &Bvh2, node: usize) -> Vec<u32> {
    let (mut found, mut open) = (Vec::new(), vec![node]);
    while let Some(node) = open.pop() {
        let first = binary.nodes[node].first_index as usize;
        match binary.nodes[node].is_leaf() {
            true => found.push(binary.primitive_indices[first]),
            false => open.extend([first + 1, first]),
        }
    }
    found
}
