//! What decides what a bake makes: settings, and what follows from the scene.

use crate::methods::sparse_transfer::Terms;
use relume_scenes::Scene;

/// Name of the method.
pub const NAME: &str = relume_formats::method::TRANSFER_TENSOR.name;
/// Changes whenever the same scene and settings give other bytes than before, in bundles or in logs.
pub const REVISION: u32 = 1;
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

/// By vertex the index of its material.
pub(super) fn materials_of_vertices(scene: &Scene) -> Vec<usize> {
    let of_object =
        |object: &relume_scenes::Object| std::iter::repeat_n(object.material, object.mesh.positions.len());
    scene.objects.iter().flat_map(of_object).collect()
}
