//! Triangles of an outline in the plane that may be concave, run along a cut to a hole and back, or touch
//! itself.
//!
//! A constrained Delaunay triangulation holds every edge of the outline; a triangle belongs to the inside if
//! the way out to it crosses the outline an odd number of times. Corners on a line get triangles of their own
//! height, so that neighbours along that line stay joined.

use glam::DVec2;
use spade::handles::FixedVertexHandle;
use spade::{ConstrainedDelaunayTriangulation, Point2, Triangulation};
use std::collections::HashMap;

/// Edges of the outline count how often it runs along them.
type Delaunay = ConstrainedDelaunayTriangulation<Point2<f64>, (), u32>;

/// Counter-clockwise triangles of indices into `outline`; none if the outline crosses itself or has no
/// inside.
pub(super) fn triangulate(outline: &[DVec2]) -> Option<Vec<[usize; 3]>> {
    let mut known = HashMap::new();
    let (mut points, mut first) = (Vec::new(), Vec::new());
    let mut vertex_of = |(corner, point): (usize, &DVec2)| {
        *known.entry(point.to_array().map(f64::to_bits)).or_insert_with(|| {
            points.push(Point2::new(point.x, point.y));
            first.push(corner);
            points.len() - 1
        })
    };
    // Adding 0 turns −0 into +0; what is too small for exact predicates is 0 as far as the outline can tell.
    let tidy = |p: &DVec2| DVec2::from_array(p.to_array().map(|x| if x.abs() < 1e-30 { 0.0 } else { x }));
    let tidied: Vec<DVec2> = outline.iter().map(tidy).collect();
    let vertices: Vec<usize> = tidied.iter().enumerate().map(&mut vertex_of).collect();
    let mut delaunay = Delaunay::bulk_load_cdt(points, Vec::new()).ok()?;
    add_outline(&mut delaunay, &vertices)?;
    let inside = insides(&delaunay);
    let corners = |face: &[usize; 3]| face.map(|vertex| first[vertex]);
    let faces = delaunay.inner_faces().filter(|face| inside.get(face.fix().index()) == Some(&Some(true)));
    let triangles: Vec<[usize; 3]> =
        faces.map(|face| corners(&face.vertices().map(|v| v.fix().index()))).collect();
    (!triangles.is_empty()).then_some(triangles)
}

/// None if it crosses itself.
fn add_outline(delaunay: &mut Delaunay, vertices: &[usize]) -> Option<()> {
    for (from, to) in vertices.iter().zip(vertices.iter().cycle().skip(1)).filter(|(from, to)| from != to) {
        let edges = delaunay
            .try_add_constraint(FixedVertexHandle::from_index(*from), FixedVertexHandle::from_index(*to));
        if edges.is_empty() {
            return None;
        }
        edges
            .iter()
            .for_each(|edge| *delaunay.undirected_edge_data_mut(edge.as_undirected()).data_mut() += 1);
    }
    Some(())
}

/// For each face, whether it lies inside, spread from the hull inwards.
fn insides(delaunay: &Delaunay) -> Vec<Option<bool>> {
    let mut inside = vec![None; delaunay.num_all_faces()];
    if let Some(outer) = inside.first_mut() {
        *outer = Some(false);
    }
    let mut edges: Vec<_> = delaunay.convex_hull().flat_map(|edge| [edge, edge.rev()]).collect();
    while let Some(edge) = edges.pop() {
        let (from, to) = (edge.face().fix().index(), edge.rev().face().fix().index());
        let (Some(Some(state)), Some(None)) = (inside.get(from).copied(), inside.get(to).copied()) else {
            continue;
        };
        inside[to] = Some(state != (edge.as_undirected().data().data() % 2 == 1));
        edges.extend(edge.rev().face().as_inner().iter().flat_map(|face| face.adjacent_edges()));
    }
    inside
}
