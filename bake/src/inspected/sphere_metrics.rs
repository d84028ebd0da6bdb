//! What `info` and `export` tell of a sphere set, under the same names.

use relume_formats::kinds::SphereSet;
use relume_formats::kinds::sphere_set::{Protrusion, Solid};
use serde::Serialize;

/// The numbers of a fit; lengths and volumes in mesh units.
#[derive(Debug, Serialize)]
pub(super) struct SphereMetrics {
    /// Number of spheres.
    pub n: usize,
    /// Volume of the spheres outside the solid, each sphere by itself, over the solid's volume.
    #[serde(rename = "E/V(T)")]
    pub relative_outside_volume: f64,
    /// The smaller of the two shares that follow.
    pub coverage: f64,
    pub coverage_surface: f64,
    pub coverage_volume: f64,
    pub protrusion: Protrusion,
    pub largest_uncovered_gap: f64,
    pub overlap: f64,
    pub volume: f64,
    pub outside_volume: f64,
    pub diagonal: f32,
    pub mesh: String,
    pub vertices: u32,
    pub triangles: u32,
    pub seed: u64,
    pub iterations: u32,
    pub tight: f32,
    pub poses: u32,
    pub solid: Solid,
}

impl SphereMetrics {
    pub fn of(set: &SphereSet) -> Self {
        let (meta, quality) = (&set.meta, &set.meta.quality);
        Self {
            n: set.spheres.len(),
            relative_outside_volume: meta.relative_outside_volume(),
            coverage: quality.coverage_surface.min(quality.coverage_volume),
            coverage_surface: quality.coverage_surface,
            coverage_volume: quality.coverage_volume,
            protrusion: quality.protrusion,
            largest_uncovered_gap: quality.largest_gap,
            overlap: quality.overlap,
            volume: meta.volume,
            outside_volume: meta.outside_volume,
            diagonal: meta.diagonal,
            mesh: meta.mesh.clone(),
            vertices: meta.vertices,
            triangles: meta.triangles,
            seed: meta.seed,
            iterations: meta.iterations,
            tight: meta.tight,
            poses: meta.poses,
            solid: meta.solid,
        }
    }
}
