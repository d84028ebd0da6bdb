//! What decides what a bake makes: settings, and what follows from the scene.

use relume_scenes::Scene;

/// Name of the method.
pub const NAME: &str = relume_formats::method::TRANSFER_TENSOR.name;
/// Changes whenever the same scene and settings give other bytes than before, in bundles or in logs.
pub const REVISION: u32 = 0;
/// What rounding to bytes may add to an error, as a factor: the number of terms is chosen to leave room for it.
pub(super) const ROUNDING: f64 = 1.05;

/// The settings that change results.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// Rays a texel where visibility changes: a square number.
    pub rays_per_texel: u32,
    /// Rays a vertex that light reflected once is gathered by.
    pub samples: u32,
    /// Of their directions.
    pub seed: u64,
    /// How many terms of direct light to keep.
    pub terms: Terms,
}

/// How many terms to keep.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Terms {
    /// This many.
    Number(usize),
    /// As many as keep the relative L2 error under every held-out light below this.
    Error(f64),
}

/// Of all meshes.
pub(super) fn vertices(scene: &Scene) -> usize {
    scene.objects.iter().map(|object| object.mesh.positions.len()).sum()
}

/// By vertex the index of its material.
pub(super) fn materials_of_vertices(scene: &Scene) -> Vec<usize> {
    let of_object =
        |object: &relume_scenes::Object| std::iter::repeat_n(object.material, object.mesh.positions.len());
    scene.objects.iter().flat_map(of_object).collect()
}
