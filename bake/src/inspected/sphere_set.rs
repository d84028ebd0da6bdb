//! Sphere sets as arrays, as numbers, and as a mesh to look at.

use super::out::Out;
use super::sphere_mesh;
use super::sphere_metrics::SphereMetrics;
use super::words::{grouped, many};
use super::{Described, Facts, Inspected};
use relume_formats::Result;
use relume_formats::container::{Kind, Stored};
use relume_formats::kinds::SphereSet;
use relume_formats::kinds::sphere_set::Solid;
use serde::Serialize;
use std::path::Path;

/// See there.
pub(super) const INSPECTED: Inspected = Inspected { kind: Kind::SphereSet, describe, export };

#[derive(Serialize)]
struct Details {
    #[serde(flatten)]
    metrics: SphereMetrics,
    points: usize,
    /// How many the history has.
    iterations_done: usize,
}

fn describe(path: &Path) -> Result<Described> {
    let set = SphereSet::read_file(path)?;
    let details = Details {
        metrics: SphereMetrics::of(&set),
        points: set.points.len(),
        iterations_done: set.history.len(),
    };
    Ok(Described { facts: facts(&details), details: Box::new(details) })
}

/// Lengths in parts of the diagonal, for nobody knows what a mesh's units are.
fn facts(details: &Details) -> Facts {
    let Details { metrics: m, points, iterations_done } = details;
    let percent = |length: f64| format!("{:.4} %", length / f64::from(m.diagonal) * 100.0);
    let solid = match m.solid {
        Solid::Closed => "closed, so its volumes are exact".to_owned(),
        Solid::WindingNumber { cells } => {
            format!("open or meets itself: inside is where it winds around, on a grid of {cells} cells along")
        }
    };
    let coverage = if m.tight > 0.0 {
        format!("up to {} % of the diagonal uncovered", m.tight * 100.0)
    } else {
        "complete coverage".to_owned()
    };
    let [mean, p95, max] = [m.protrusion.mean, m.protrusion.p95, m.protrusion.max].map(percent);
    vec![
        (
            "mesh",
            format!(
                "{}, {}, {}, diagonal {}",
                m.mesh,
                many(m.vertices as usize, "vertex", "vertices"),
                many(m.triangles as usize, "triangle", "triangles"),
                m.diagonal
            ),
        ),
        ("solid", solid),
        ("spheres", format!("{}, which follow {}", grouped(m.n as u64), many(*points, "point", "points"))),
        (
            "fit",
            format!(
                "seed {}, {iterations_done} of at most {}, {coverage}",
                m.seed,
                many(m.iterations as usize, "iteration", "iterations")
            ),
        ),
        ("E/V(T)", format!("{:.6}, of the volume {}", m.relative_outside_volume, m.volume)),
        (
            "coverage",
            format!(
                "{:.4} % of the surface, {:.4} % of the volume",
                m.coverage_surface * 100.0,
                m.coverage_volume * 100.0
            ),
        ),
        ("gap", format!("{} of the diagonal at most", percent(m.largest_uncovered_gap))),
        ("protrusion", format!("{mean} of the diagonal in the mean, {p95} at 95 %, {max} at most")),
        ("overlap", format!("{:.4}", m.overlap)),
    ]
}

/// `spheres.npy` [spheres, 4] centre and radius, `points.npy` [points, 3], `cluster.npy` [points]: the sphere
/// of each point, `history.npy` [iterations]: E/V(T), `spheres.ply`, `metrics.json`; lengths in mesh units.
fn export(path: &Path, out: &mut Out) -> Result<()> {
    let set = SphereSet::read_file(path)?;
    out.npy("spheres.npy", &[set.spheres.len(), 4], set.spheres.as_flattened().iter().copied())?;
    out.npy("points.npy", &[set.points.len(), 3], set.points.as_flattened().iter().copied())?;
    out.npy("cluster.npy", &[set.clusters.len()], set.clusters.iter().copied())?;
    out.npy("history.npy", &[set.history.len()], set.history.iter().copied())?;
    out.bytes("spheres.ply", &sphere_mesh::encode(&set.spheres))?;
    out.json("metrics.json", &SphereMetrics::of(&set))
}
