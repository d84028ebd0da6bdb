//! Whether a closed mesh bounds a solid: winding number 1 just inside and 0 just outside, wherever one looks.

use super::super::triangle_tree::TriangleTree;
use rayon::prelude::*;

/// Most triangles that are looked at.
const PROBES: usize = 4000;
/// How far from a triangle's centre, in parts of the diagonal; less where the triangle is so small that its neighbours would be in the way.
const OFFSET: f64 = 1e-6;
/// How far the winding number may be from what it should be: far more than its own error.
const TOLERANCE: f64 = 0.2;

/// What speaks against a mesh as the boundary of a solid.
pub enum Doubts {
    /// It has edges that no two triangles share.
    Open,
    /// It is closed; this share of its triangles has something else than 1 on the inside and 0 on the outside.
    Meets(f64),
}

impl Doubts {
    /// What to say of a mesh that will do, or why it will not.
    pub fn note(&self, tolerable: f64) -> Result<Option<String>, String> {
        match self {
            Self::Open => Err("is not closed".to_owned()),
            Self::Meets(share) if *share > tolerable => Err("meets itself or has parts within parts".to_owned()),
            Self::Meets(share) if *share > 0.0 => Ok(Some(format!(
                "the mesh meets itself at {:.3} % of its triangles; volumes count there what is enclosed twice as often",
                share * 100.0
            ))),
            Self::Meets(_) => Ok(None),
        }
    }
}

/// Looks at up to [`PROBES`] triangles of a closed mesh.
pub fn doubts(mesh: &TriangleTree, diagonal: f64) -> Doubts {
    let count = mesh.triangles.len();
    let step = count.div_ceil(PROBES).max(1);
    let probes: Vec<usize> = (0..count).step_by(step).filter(|t| mesh.planes[*t].1 > 0.0).collect();
    let wrong = probes.par_iter().filter(|t| !is_boundary(mesh, **t, diagonal)).count();
    Doubts::Meets(wrong as f64 / probes.len().max(1) as f64)
}

fn is_boundary(mesh: &TriangleTree, triangle: usize, diagonal: f64) -> bool {
    let [a, b, c] = mesh.corners(triangle);
    let (normal, area) = mesh.planes[triangle];
    let longest = a.distance(b).max(b.distance(c)).max(c.distance(a));
    let offset = normal * (OFFSET * diagonal).min(0.01 * area / longest);
    let centre = (a + b + c) / 3.0;
    (mesh.winding_number(centre - offset) - 1.0).abs() < TOLERANCE && mesh.winding_number(centre + offset).abs() < TOLERANCE
}
