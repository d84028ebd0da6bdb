//! A sphere set as arrays, as numbers, and as a mesh to look at.

use super::super::sphere_metrics::SphereMetrics;
use super::out::Out;
use super::sphere_mesh;
use relume_formats::Result;
use relume_formats::kinds::SphereSet;

/// `spheres.npy` [spheres, 4] centre and radius, `points.npy` [points, 3], `cluster.npy` [points]: the sphere of each point, `history.npy`
/// [iterations]: E/V(T), `spheres.ply`, `metrics.json`; lengths in mesh units.
pub(super) fn export(set: &SphereSet, out: &mut Out) -> Result<()> {
    out.npy("spheres.npy", &[set.spheres.len(), 4], set.spheres.as_flattened().iter().copied())?;
    out.npy("points.npy", &[set.points.len(), 3], set.points.as_flattened().iter().copied())?;
    out.npy("cluster.npy", &[set.clusters.len()], set.clusters.iter().copied())?;
    out.npy("history.npy", &[set.history.len()], set.history.iter().copied())?;
    out.bytes("spheres.ply", &sphere_mesh::encode(&set.spheres))?;
    out.json("metrics.json", &SphereMetrics::of(set))
}
