//! What a mesh bounds.
//!
//! A mesh that is closed and does not meet itself bounds its solid, and volumes against it are exact. Of any
//! other mesh the inside is where the generalised winding number (Jacobson et al. 2013) is at least 1/2, and
//! an isosurface on a grid bounds that.

mod clean;
mod isosurface;
mod orient;
#[cfg(test)]
mod tests;
mod weld;

use super::triangle_tree::TriangleTree;
use crate::error::{BakeError, Result};
use clean::Doubts;
use glam::DVec3;
pub use orient::is_closed;
use relume_formats::Place;
use relume_formats::counts::counted;
use relume_formats::kinds::sphere_set::Solid as Kind;
use relume_scenes::Mesh;
pub use weld::Welded;

/// Cells of the winding number's grid along the longest side.
const CELLS: u32 = 96;
/// Largest share of the surface that may meet itself where a mesh still counts as the boundary of its solid.
const MEETING: f64 = 1e-3;
/// A solid of less than this, in cubes of the diagonal, is none.
const LEAST_VOLUME: f64 = 1e-12;

/// What spheres are fitted to. Lengths are in mesh units.
#[derive(Debug, Clone)]
pub struct Solid {
    /// Bounds the solid: closed, facing outwards, not meeting itself.
    pub boundary: TriangleTree,
    /// What must be covered: the mesh's triangles with its vertices welded, and those of `boundary` where
    /// that is not the mesh itself.
    pub surface: TriangleTree,
    /// For each vertex of the mesh its index in the vertices of `surface`, where each position stands once.
    /// Vertices that only the boundary has follow.
    pub welded: Vec<u32>,
    /// The other way: for each welded vertex the first vertex of the mesh there. What only the boundary has
    /// is beyond its end.
    pub mesh_vertex: Vec<u32>,
    /// What counts as the inside.
    pub kind: Kind,
    /// Of the solid.
    pub volume: f64,
    /// Of the mesh's bounding box.
    pub diagonal: f64,
    /// What was mended or is not as it should be, a line each.
    pub notes: Vec<String>,
}

impl Solid {
    /// The solid of a finite mesh without degenerate triangles. `place` names the mesh in errors.
    ///
    /// # Errors
    /// If the mesh encloses no volume.
    pub fn of(mesh: &Mesh, place: &Place) -> Result<Self> {
        let (welded, mut notes) = weld(mesh);
        let tree = TriangleTree::new(welded.vertices.clone(), welded.triangles.clone());
        let diagonal = tree.nodes.first().map_or(0.0, |root| (root.max - root.min).length());
        let doubts = if is_closed(&welded.triangles) { clean::doubts(&tree, diagonal) } else { Doubts::Open };
        let solid = match doubts.note(MEETING) {
            Ok(note) => {
                notes.extend(note);
                let volume = volume(&tree);
                Self {
                    boundary: tree.clone(),
                    surface: tree,
                    kind: Kind::Closed,
                    volume,
                    diagonal,
                    notes,
                    welded: welded.index,
                    mesh_vertex: welded.first,
                }
            }
            Err(reason) => Self::by_winding_number(&tree, diagonal, welded, &reason, notes),
        };
        if solid.volume.is_nan() || solid.volume <= LEAST_VOLUME * diagonal.powi(3) {
            return Err(no_volume(place, solid.kind));
        }
        Ok(solid)
    }

    fn by_winding_number(
        mesh: &TriangleTree,
        diagonal: f64,
        welded: Welded,
        reason: &str,
        mut notes: Vec<String>,
    ) -> Self {
        let (vertices, triangles, cell) = isosurface::isosurface(mesh, CELLS);
        notes.push(format!(
            "the mesh {reason}: inside is where its winding number is at least 1/2, on a grid of {CELLS} cells along the longest side; parts thinner than \
             a cell ({cell:.2e}) have no volume there, and volumes are exact to about a cell's thickness at edges and openings"
        ));
        let offset = welded.vertices.len() as u32;
        let moved = triangles.iter().map(|t| t.map(|v| v + offset));
        let all_triangles = welded.triangles.iter().copied().chain(moved).collect();
        let all_vertices: Vec<DVec3> = welded.vertices.iter().chain(&vertices).copied().collect();
        let surface = TriangleTree::new(all_vertices, all_triangles);
        let boundary = TriangleTree::new(vertices, triangles);
        let (kind, volume) = (Kind::WindingNumber { cells: CELLS }, volume(&boundary));
        Self {
            boundary,
            surface,
            kind,
            volume,
            diagonal,
            notes,
            welded: welded.index,
            mesh_vertex: welded.first,
        }
    }
}

/// The mesh with its triangles turned to agree, and what was mended. Vertices that only rounding keeps apart
/// are welded where that closes it; a mesh that is closed as it is, or open anyhow, keeps its least details.
fn weld(mesh: &Mesh) -> (Welded, Vec<String>) {
    let oriented = |mut welded: Welded| {
        let mut notes = Vec::new();
        orient::orient(&welded.vertices, &mut welded.triangles, &mut notes);
        if welded.left_out > 0 {
            notes.push(format!(
                "left out {}, there again or without extent",
                counted(welded.left_out, "triangle", "triangles")
            ));
        }
        (welded, notes)
    };
    let exact = oriented(Welded::exactly(mesh));
    if is_closed(&exact.0.triangles) {
        return exact;
    }
    let mut near = oriented(Welded::nearly(mesh));
    if near.0.triangles.is_empty() || !is_closed(&near.0.triangles) {
        return exact;
    }
    let welded = exact.0.vertices.len() - near.0.vertices.len();
    near.1.push(format!(
        "welded {} to others at less than a millionth of the diagonal, which closes the mesh",
        counted(welded, "vertex", "vertices")
    ));
    near
}

/// The surface of `mesh`: its triangles by welded vertices, turned to agree and closed parts outwards.
pub fn welded(mesh: &Mesh) -> Welded {
    weld(mesh).0
}

/// Signed volume within a closed mesh.
fn volume(tree: &TriangleTree) -> f64 {
    tree.nodes.first().map_or(0.0, |root| root.moment / 3.0)
}

fn no_volume(place: &Place, kind: Kind) -> BakeError {
    let cells = match kind {
        Kind::Closed => String::new(),
        Kind::WindingNumber { cells } => {
            format!(" that a grid of {cells} cells along its longest side would show")
        }
    };
    BakeError::invalid(place, format!("encloses no volume{cells}; give it thickness, or close its holes"))
}
