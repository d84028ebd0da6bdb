//! What spheres must cover, in pieces that each go to one sphere whole.
//!
//! A piece of the surface is given by its corners: balls are convex, so a ball that holds the corners holds
//! the piece, and a set of spheres that has taken every piece covers the surface, whatever its state. Pieces
//! begin large: branches of the triangle tree, which fall into triangles, which fall into halves. Only pieces
//! that a sphere must reach out for are ever split, so that there are few, and none too large.

use super::triangle_tree::TriangleTree;
use glam::DVec3;
use std::collections::BTreeSet;

/// Corners and pieces; both only ever grow.
#[derive(Debug)]
pub struct Pieces<'a> {
    surface: &'a TriangleTree,
    points: Vec<DVec3>,
    anchors: Vec<Option<Anchor>>,
    corners: Vec<u32>,
    /// Where each of `corners` is.
    places: Vec<DVec3>,
    pieces: Vec<Piece>,
}

/// How a point hangs on the surface: vertices and their weights.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Anchor {
    /// Vertex indices of [`TriangleTree::vertices`].
    pub vertices: [u32; 3],
    /// Weights, with sum 1.
    pub weights: [f64; 3],
}

#[derive(Debug, Clone, Copy)]
struct Piece {
    first: u32,
    count: u32,
    /// What it is a part of, and how many such parts there are.
    whole: Option<(u32, u32)>,
    /// The first of its parts and how many they are, once it has been split.
    parts: Option<(u32, u32)>,
    source: Source,
}

#[derive(Debug, Clone, Copy)]
enum Source {
    /// A branch of the tree, by its node.
    Branch(u32),
    /// A triangle within one of the tree's, by barycentric coordinates of its corners.
    Triangle { triangle: u32, weights: [DVec3; 3] },
    /// A point, or the corners of a void, within the solid.
    Inside,
}

impl<'a> Pieces<'a> {
    /// The surface in pieces of at most `size` across.
    pub fn new(surface: &'a TriangleTree, size: f64) -> Self {
        let points = surface.vertices.clone();
        let vertex = |v: u32| Some(Anchor { vertices: [v; 3], weights: [1.0, 0.0, 0.0] });
        let anchors = (0..points.len() as u32).map(vertex).collect();
        let mut pieces =
            Self { surface, points, anchors, corners: Vec::new(), places: Vec::new(), pieces: Vec::new() };
        if !surface.nodes.is_empty() {
            pieces.add_branch(0);
        }
        // Those that are split stay behind unused, which costs little.
        let mut whole: Vec<u32> = (0..pieces.pieces.len() as u32).collect();
        let mut small = Vec::new();
        while let Some(piece) = whole.pop() {
            if pieces.extent(piece) > size { whole.extend(pieces.split(piece)) } else { small.push(piece) }
        }
        let kept: Vec<(Vec<u32>, Source)> =
            small.iter().map(|p| (pieces.corners(*p).to_vec(), pieces.pieces[*p as usize].source)).collect();
        (pieces.pieces, pieces.corners, pieces.places) = (Vec::new(), Vec::new(), Vec::new());
        for (corners, source) in kept {
            pieces.add(&corners, source);
        }
        pieces
    }

    /// Number of pieces.
    pub fn len(&self) -> usize {
        self.pieces.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.pieces.is_empty()
    }

    /// The corners of a piece, as indices for [`Pieces::point`].
    pub fn corners(&self, piece: u32) -> &[u32] {
        let Piece { first, count, .. } = self.pieces[piece as usize];
        &self.corners[first as usize..(first + count) as usize]
    }

    /// Where a corner is.
    pub fn point(&self, corner: u32) -> DVec3 {
        self.points[corner as usize]
    }

    /// How a corner hangs on the surface; `None` for those within the solid.
    pub fn anchor(&self, corner: u32) -> Option<Anchor> {
        self.anchors[corner as usize]
    }

    /// Where the corners of a piece are.
    pub fn places(&self, piece: u32) -> &[DVec3] {
        let Piece { first, count, .. } = self.pieces[piece as usize];
        &self.places[first as usize..(first + count) as usize]
    }

    /// Squared distance of the farthest corner of a piece.
    pub fn farthest_squared(&self, piece: u32, from: DVec3) -> f64 {
        self.places(piece).iter().map(|p| p.distance_squared(from)).fold(0.0, f64::max)
    }

    /// Diagonal of the box around a piece.
    pub fn extent(&self, piece: u32) -> f64 {
        let grow = |(min, max): (DVec3, DVec3), corner: &u32| {
            (min.min(self.point(*corner)), max.max(self.point(*corner)))
        };
        let (min, max) = self.corners(piece).iter().fold((DVec3::INFINITY, DVec3::NEG_INFINITY), grow);
        (max - min).length()
    }

    /// All corners of some pieces.
    pub fn positions(&self, cluster: &[u32]) -> Vec<DVec3> {
        let mut corners: Vec<u32> = cluster.iter().flat_map(|p| self.corners(*p)).copied().collect();
        corners.sort_unstable();
        corners.dedup();
        corners.into_iter().map(|c| self.point(c)).collect()
    }

    /// Adds a piece whose corners lie within the solid.
    pub fn add_inside(&mut self, points: &[DVec3]) -> u32 {
        let first = self.points.len() as u32;
        self.points.extend(points);
        self.anchors.resize(self.points.len(), None);
        let corners: Vec<u32> = (first..self.points.len() as u32).collect();
        self.add(&corners, Source::Inside)
    }

    /// The parts of a piece, which together are the piece; none if it cannot be split.
    pub fn split(&mut self, piece: u32) -> Vec<u32> {
        if let Some((first, count)) = self.pieces[piece as usize].parts {
            return (first..first + count).collect();
        }
        let parts = self.parts(piece);
        for part in &parts {
            self.pieces[*part as usize].whole = Some((piece, parts.len() as u32));
        }
        self.pieces[piece as usize].parts = parts.first().map(|first| (*first, parts.len() as u32));
        parts
    }

    /// A cluster, which is ascending, with parts put together where it has all parts of a piece that `may` be
    /// whole.
    pub fn merged(&self, cluster: &[u32], may: impl Fn(&Self, u32) -> bool) -> Vec<u32> {
        let mut left: BTreeSet<u32> = cluster.iter().copied().collect();
        let mut merged = Vec::new();
        // Wholes come before their parts, so that what is put together is met again.
        while let Some(piece) = left.pop_last() {
            let Some((whole, count)) = self.pieces[piece as usize].whole else {
                merged.push(piece);
                continue;
            };
            // Parts of one piece follow each other.
            let parts: Vec<u32> = left
                .range(piece.saturating_sub(count)..piece)
                .copied()
                .filter(|p| self.is_part(*p, whole))
                .collect();
            if parts.len() + 1 == count as usize && may(self, whole) {
                parts.iter().for_each(|p| _ = left.remove(p));
                left.insert(whole);
            } else {
                merged.push(piece);
            }
        }
        merged.reverse();
        merged
    }

    fn is_part(&self, piece: u32, whole: u32) -> bool {
        self.pieces[piece as usize].whole.is_some_and(|(of, _)| of == whole)
    }

    fn parts(&mut self, piece: u32) -> Vec<u32> {
        let Piece { first, source, .. } = self.pieces[piece as usize];
        match source {
            Source::Inside => Vec::new(),
            Source::Branch(index) => {
                let node = &self.surface.nodes[index as usize];
                match (node.second, node.range) {
                    (0, (first, last)) => (first..last).map(|t| self.add_triangle(t)).collect(),
                    (second, _) => vec![self.add_branch(index + 1), self.add_branch(second)],
                }
            }
            Source::Triangle { triangle, weights } => {
                let corners = [0, 1, 2].map(|i| self.corners[first as usize + i]);
                let longest = longest_edge(corners.map(|c| self.point(c)));
                let [p, q, r] = [longest, (longest + 1) % 3, (longest + 2) % 3];
                let middle = (weights[p] + weights[q]) / 2.0;
                let m = self.add_point(triangle, middle);
                let halves = [
                    ([corners[p], m, corners[r]], [weights[p], middle, weights[r]]),
                    ([m, corners[q], corners[r]], [middle, weights[q], weights[r]]),
                ];
                halves
                    .map(|(corners, weights)| self.add(&corners, Source::Triangle { triangle, weights }))
                    .to_vec()
            }
        }
    }

    fn add(&mut self, corners: &[u32], source: Source) -> u32 {
        let first = self.corners.len() as u32;
        self.corners.extend(corners);
        self.places.extend(corners.iter().map(|c| self.points[*c as usize]));
        self.pieces.push(Piece { first, count: corners.len() as u32, whole: None, parts: None, source });
        self.pieces.len() as u32 - 1
    }

    fn add_branch(&mut self, node: u32) -> u32 {
        let (first, last) = self.surface.nodes[node as usize].range;
        let mut corners = self.surface.triangles[first as usize..last as usize].concat();
        corners.sort_unstable();
        corners.dedup();
        self.add(&corners, Source::Branch(node))
    }

    fn add_triangle(&mut self, triangle: u32) -> u32 {
        let corners = self.surface.triangles[triangle as usize];
        self.add(&corners, Source::Triangle { triangle, weights: [DVec3::X, DVec3::Y, DVec3::Z] })
    }

    fn add_point(&mut self, triangle: u32, weights: DVec3) -> u32 {
        let vertices = self.surface.triangles[triangle as usize];
        let [a, b, c] = self.surface.corners(triangle as usize);
        self.points.push(weights.x * a + weights.y * b + weights.z * c);
        self.anchors.push(Some(Anchor { vertices, weights: weights.to_array() }));
        self.points.len() as u32 - 1
    }
}

/// Which edge is longest: from corner i to the next.
fn longest_edge(corners: [DVec3; 3]) -> usize {
    let length = |i: usize| corners[i].distance_squared(corners[(i + 1) % 3]);
    (0..3).max_by(|a, b| length(*a).total_cmp(&length(*b)).then(b.cmp(a))).unwrap_or(0)
}
