//! Whether a closed mesh bounds a solid: winding number 1 just inside and 0 just outside, wherever one looks.

use super::super::surface_points::stratified;
use super::super::triangle_tree::TriangleTree;
use glam::DVec3;
use rayon::prelude::*;

/// Points that are looked at.
const PROBES: u32 = 8192;
/// How far from the surface, in parts of the diagonal; less where a triangle's neighbours might be in the
/// way.
const OFFSET: f64 = 1e-6;
/// How far the winding number may be from what it should be: far more than its own error.
const TOLERANCE: f64 = 0.2;

/// What speaks against a mesh as the boundary of a solid.
pub enum Doubts {
    /// It has edges that no two triangles share.
    Open,
    /// It is closed; this share of its area has something else than 1 on the inside and 0 on the outside.
    Meets(f64),
}

impl Doubts {
    /// What to say of a mesh that will do, or why it will not.
    pub fn note(&self, tolerable: f64) -> Result<Option<String>, String> {
        match self {
            Self::Open => Err("is not closed".to_owned()),
            Self::Meets(share) if *share > tolerable => {
                Err("meets itself or has parts within parts".to_owned())
            }
            Self::Meets(share) if *share > 0.0 => Ok(Some(format!(
                "the mesh meets itself at {:.3} % of its area; volumes count there what is enclosed twice as often",
                share * 100.0
            ))),
            Self::Meets(_) => Ok(None),
        }
    }
}

/// Looks at [`PROBES`] points of a closed mesh.
pub fn doubts(mesh: &TriangleTree, diagonal: f64) -> Doubts {
    let probes = stratified(mesh, PROBES);
    let wrong = probes
        .par_iter()
        .filter(|(triangle, weights)| !is_boundary(mesh, *triangle, *weights, diagonal))
        .count();
    Doubts::Meets(wrong as f64 / f64::from(PROBES))
}

fn is_boundary(mesh: &TriangleTree, triangle: usize, weights: [f64; 3], diagonal: f64) -> bool {
    let corners = mesh.corners(triangle);
    let (normal, area) = mesh.planes[triangle];
    // Somewhat towards the centre, at least 1/30 of the height away from every edge.
    let weights = weights.map(|w| 0.9 * w + 0.1 / 3.0);
    let point: DVec3 = corners.into_iter().zip(weights).map(|(v, w)| v * w).sum();
    let longest = (0..3).map(|i| corners[i].distance(corners[(i + 1) % 3])).fold(0.0, f64::max);
    let offset = normal * (OFFSET * diagonal).min(1e-3 * area / longest);
    (mesh.winding_number(point - offset) - 1.0).abs() < TOLERANCE
        && mesh.winding_number(point + offset).abs() < TOLERANCE
}
