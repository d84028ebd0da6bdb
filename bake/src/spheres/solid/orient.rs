//! Turns triangles so that neighbours agree and parts face outwards.

use super::super::triangle_tree::TriangleTree;
use glam::DVec3;
use relume_formats::counts::counted;

/// Points of a part that must lie in another for it to count as within.
const PROBES: usize = 16;

/// A triangle's use of an edge.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Side {
    /// The edge, lower vertex first.
    edge: [u32; 2],
    triangle: u32,
    /// Whether the triangle runs it from the lower vertex.
    forward: bool,
}

/// All uses, those of an edge in a row.
fn sides(triangles: &[[u32; 3]]) -> Vec<Side> {
    let of = |(triangle, t): (u32, &[u32; 3])| {
        [[t[0], t[1]], [t[1], t[2]], [t[2], t[0]]].map(|[a, b]| Side {
            edge: [a.min(b), a.max(b)],
            triangle,
            forward: a < b,
        })
    };
    let mut sides: Vec<Side> = (0..).zip(triangles).flat_map(of).collect();
    sides.sort_unstable();
    sides
}

/// Whether each edge is run as often one way as the other.
pub fn is_closed(triangles: &[[u32; 3]]) -> bool {
    let balance = |uses: &[Side]| uses.iter().map(|s| if s.forward { 1_i64 } else { -1 }).sum::<i64>();
    sides(triangles).chunk_by(|a, b| a.edge == b.edge).all(|uses| balance(uses) == 0)
}

/// Makes triangles across edges of two agree, each part with the majority of its own; then turns parts that
/// face inwards and are no cavities, and all open parts together if they face inwards on the whole.
pub fn orient(vertices: &[DVec3], triangles: &mut [[u32; 3]], notes: &mut Vec<String>) {
    let parts = agree(triangles, notes);
    let (closed, open): (Vec<_>, Vec<_>) =
        parts.into_iter().partition(|part| is_closed(&pick(triangles, part)));
    let mut inverted = inverted_closed(vertices, triangles, &closed);
    let open: Vec<u32> = open.concat();
    if faces_inwards(vertices, &pick(triangles, &open)) {
        inverted.push(open);
    }
    if !inverted.is_empty() {
        notes.push(format!(
            "turned {} of {}, which faced inwards",
            counted(inverted.len(), "part", "parts"),
            counted(inverted.iter().map(Vec::len).sum(), "triangle", "triangles")
        ));
    }
    inverted.concat().into_iter().for_each(|t| triangles[t as usize].swap(1, 2));
}

fn pick(triangles: &[[u32; 3]], part: &[u32]) -> Vec<[u32; 3]> {
    part.iter().map(|t| triangles[*t as usize]).collect()
}

/// Turns triangles that disagree with the majority of their part; gives the parts.
fn agree(triangles: &mut [[u32; 3]], notes: &mut Vec<String>) -> Vec<Vec<u32>> {
    let neighbours = neighbours(triangles);
    let mut turned: Vec<Option<bool>> = vec![None; triangles.len()];
    let (mut parts, mut count) = (Vec::new(), 0);
    for seed in 0..triangles.len() as u32 {
        if turned[seed as usize].is_some() {
            continue;
        }
        let part = spread(seed, &neighbours, &mut turned);
        let is_turned = |t: &&u32| turned[**t as usize] == Some(true);
        let minority = 2 * part.iter().filter(is_turned).count() <= part.len();
        for t in part.iter().filter(|t| is_turned(t) == minority) {
            triangles[*t as usize].swap(1, 2);
            count += 1;
        }
        parts.push(part);
    }
    if count > 0 {
        notes.push(format!(
            "turned {}, which faced against the neighbours",
            counted(count, "triangle", "triangles")
        ));
    }
    parts
}

/// For each triangle its neighbours across edges of exactly two, and whether the two run the edge the same
/// way: then one of them is the wrong way round.
fn neighbours(triangles: &[[u32; 3]]) -> Vec<Vec<(u32, bool)>> {
    let mut neighbours = vec![Vec::new(); triangles.len()];
    for uses in sides(triangles).chunk_by(|a, b| a.edge == b.edge) {
        if let [a, b] = uses {
            let against = a.forward == b.forward;
            neighbours[a.triangle as usize].push((b.triangle, against));
            neighbours[b.triangle as usize].push((a.triangle, against));
        }
    }
    neighbours
}

/// The part of a triangle, breadth first; sets which of it are to be turned to agree with that triangle.
fn spread(seed: u32, neighbours: &[Vec<(u32, bool)>], turned: &mut [Option<bool>]) -> Vec<u32> {
    turned[seed as usize] = Some(false);
    let mut part = vec![seed];
    let mut next = 0;
    while let Some(at) = part.get(next).copied() {
        next += 1;
        let own = turned[at as usize] == Some(true);
        for (other, against) in &neighbours[at as usize] {
            let slot = &mut turned[*other as usize];
            if slot.is_none() {
                part.push(*other);
                *slot = Some(own != *against);
            }
        }
    }
    part
}

/// The closed parts that enclose less than nothing and are no cavities, that is, lie within an even number of
/// others.
fn inverted_closed(vertices: &[DVec3], triangles: &[[u32; 3]], parts: &[Vec<u32>]) -> Vec<Vec<u32>> {
    let tree = |part: &Vec<u32>| TriangleTree::new(vertices.to_vec(), pick(triangles, part));
    let inwards: Vec<usize> =
        (0..parts.len()).filter(|i| faces_inwards(vertices, &pick(triangles, &parts[*i]))).collect();
    if inwards.is_empty() {
        return Vec::new();
    }
    let mut depth = vec![0; parts.len()];
    let boxes: Vec<(DVec3, DVec3)> = parts.iter().map(|part| bounds(vertices, triangles, part)).collect();
    for (outer, (min, max)) in boxes.iter().enumerate() {
        let fits =
            |i: &&usize| **i != outer && boxes[**i].0.cmpge(*min).all() && boxes[**i].1.cmple(*max).all();
        let within: Vec<usize> = inwards.iter().filter(fits).copied().collect();
        if !within.is_empty() {
            let outer = tree(&parts[outer]);
            within
                .into_iter()
                .filter(|i| lies_within(vertices, &pick(triangles, &parts[*i]), &outer))
                .for_each(|i| depth[i] += 1);
        }
    }
    inwards.into_iter().filter(|i| depth[*i] % 2 == 0).map(|i| parts[i].clone()).collect()
}

fn bounds(vertices: &[DVec3], triangles: &[[u32; 3]], part: &[u32]) -> (DVec3, DVec3) {
    let points = part.iter().flat_map(|t| triangles[*t as usize]).map(|v| vertices[v as usize]);
    points.fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(min, max), p| (min.min(p), max.max(p)))
}

fn lies_within(vertices: &[DVec3], part: &[[u32; 3]], outer: &TriangleTree) -> bool {
    let centre = |t: &[u32; 3]| t.map(|v| vertices[v as usize]).iter().sum::<DVec3>() / 3.0;
    part.iter()
        .step_by(part.len().div_ceil(PROBES).max(1))
        .all(|t| outer.winding_number(centre(t)).abs() > 0.5)
}

/// Whether the cones from the mean of the corners to the triangles have less than no volume.
fn faces_inwards(vertices: &[DVec3], triangles: &[[u32; 3]]) -> bool {
    let corners = || triangles.iter().map(|t| t.map(|v| vertices[v as usize]));
    let centre = corners().flatten().sum::<DVec3>() / (3 * triangles.len().max(1)) as f64;
    corners().map(|t| t.map(|v| v - centre)).map(|[a, b, c]| a.dot(b.cross(c))).sum::<f64>() < 0.0
}
