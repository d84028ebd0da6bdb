//! A binary tree over triangles with what sums over whole branches need: boxes, area vectors and moments.
//!
//! Balls, winding numbers and nearest points all walk this tree; each can settle a branch without looking at
//! its triangles.

use glam::DVec3;

/// Most triangles of a leaf.
const LEAF: usize = 4;

/// Triangles by their corners, and a tree over them.
#[derive(Debug, Clone)]
pub struct TriangleTree {
    /// Vertex positions.
    pub vertices: Vec<DVec3>,
    /// Vertex indices, in the order of the leaves.
    pub triangles: Vec<[u32; 3]>,
    /// Unit normal and area of each triangle; the normal is zero where there is no area.
    pub planes: Vec<(DVec3, f64)>,
    /// The root is node 0; a branch's first child follows it.
    pub nodes: Vec<Node>,
}

/// A branch or leaf.
#[derive(Debug, Clone)]
pub struct Node {
    /// Least corner of the box around its triangles.
    pub min: DVec3,
    /// Greatest corner of it.
    pub max: DVec3,
    /// Sum of the triangles' area vectors: area times unit normal.
    pub area_vector: DVec3,
    /// Sum of area vector · corner: three times the signed volume of the cones from the origin.
    pub moment: f64,
    /// Mean of the triangles' centres, weighted by area.
    pub centre: DVec3,
    /// Distance of the farthest vertex from `centre`.
    pub radius: f64,
    /// Its triangles, as a range of [`TriangleTree::triangles`].
    pub range: (u32, u32),
    /// Index of the second child; 0 for a leaf.
    pub second: u32,
}

impl Node {
    /// Squared distance of `point` from the box.
    pub fn nearest_squared(&self, point: DVec3) -> f64 {
        (point - point.clamp(self.min, self.max)).length_squared()
    }

    /// Squared distance of `point` from the box's farthest corner.
    pub fn farthest_squared(&self, point: DVec3) -> f64 {
        (point - self.min).abs().max((point - self.max).abs()).length_squared()
    }
}

impl TriangleTree {
    /// Builds the tree; triangles change their order, vertices do not.
    pub fn new(vertices: Vec<DVec3>, mut triangles: Vec<[u32; 3]>) -> Self {
        let mut nodes = Vec::with_capacity(triangles.len().max(1));
        if !triangles.is_empty() {
            let count = triangles.len();
            build(&vertices, &mut triangles, (0, count), &mut nodes);
        }
        let plane = |t: &[u32; 3]| {
            let [a, b, c] = t.map(|v| vertices[v as usize]);
            let vector = (b - a).cross(c - a) / 2.0;
            (vector.normalize_or_zero(), vector.length())
        };
        let planes = triangles.iter().map(plane).collect();
        Self { vertices, triangles, planes, nodes }
    }

    /// The corners of a triangle.
    pub fn corners(&self, triangle: usize) -> [DVec3; 3] {
        self.triangles[triangle].map(|v| self.vertices[v as usize])
    }

    /// Visits nodes from the root; `descend` says whether a branch's children are visited too, and sees
    /// leaves as well.
    pub fn walk(&self, mut descend: impl FnMut(&Node) -> bool) {
        let mut stack = [0_u32; 96];
        let mut depth = usize::from(!self.nodes.is_empty());
        while depth > 0 {
            depth -= 1;
            let index = stack[depth];
            let node = &self.nodes[index as usize];
            if descend(node) && node.second != 0 {
                stack[depth] = node.second;
                stack[depth + 1] = index + 1;
                depth += 2;
            }
        }
    }
}

fn build(
    vertices: &[DVec3],
    triangles: &mut [[u32; 3]],
    (first, last): (usize, usize),
    nodes: &mut Vec<Node>,
) {
    let index = nodes.len();
    nodes.push(summary(vertices, &triangles[first..last], (first as u32, last as u32)));
    if last - first <= LEAF {
        return;
    }
    // Halves by number keep the depth below 32, so that a fixed stack serves every walk.
    let extent = nodes[index].max - nodes[index].min;
    let axis = extent.max_position();
    let centre = |t: &[u32; 3]| t.iter().map(|v| vertices[*v as usize][axis]).sum::<f64>();
    let middle = (last - first) / 2;
    triangles[first..last]
        .select_nth_unstable_by(middle, |a, b| centre(a).total_cmp(&centre(b)).then(a.cmp(b)));
    build(vertices, triangles, (first, first + middle), nodes);
    nodes[index].second = nodes.len() as u32;
    build(vertices, triangles, (first + middle, last), nodes);
}

fn summary(vertices: &[DVec3], triangles: &[[u32; 3]], range: (u32, u32)) -> Node {
    let (mut min, mut max) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    let (mut area_vector, mut moment) = (DVec3::ZERO, 0.0);
    let (mut weighted, mut area) = (DVec3::ZERO, 0.0);
    for triangle in triangles {
        let [a, b, c] = triangle.map(|v| vertices[v as usize]);
        min = min.min(a).min(b).min(c);
        max = max.max(a).max(b).max(c);
        let vector = (b - a).cross(c - a) / 2.0;
        area_vector += vector;
        moment += vector.dot(a);
        weighted += (a + b + c) / 3.0 * vector.length();
        area += vector.length();
    }
    let centre = if area > 0.0 { weighted / area } else { (min + max) / 2.0 };
    let distance = |v: &u32| (vertices[*v as usize] - centre).length();
    let radius = triangles.as_flattened().iter().map(distance).fold(0.0, f64::max);
    Node { min, max, area_vector, moment, centre, radius, range, second: 0 }
}
