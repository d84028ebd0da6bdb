//! What decides what a bake makes: settings, and what follows from the scene.

use super::errors::Errors;
use super::texels::FACE_SIZE;
use crate::compress::statistics::worst;
use relume_scenes::Scene;

/// Name of the method.
pub const NAME: &str = relume_formats::method::SPARSE_TRANSFER.name;
/// Changes whenever the same scene and settings give other bytes than before, in bundles or in logs.
pub const REVISION: u32 = 4;
/// Texels along a side of the light's faces where light bounces.
pub(super) const BOUNCED_FACE_SIZE: usize = 16;
/// What rounding to bytes may add to an error, as a factor: the number of terms is chosen to leave room for
/// it.
const ROUNDING: f64 = 1.05;

/// The settings that change results.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// Rays a texel where visibility changes: a square number.
    pub rays_per_texel: u32,
    /// How many terms to keep.
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

impl Terms {
    /// How many these are for rows with errors `by_terms`, those of the first 1, 2, … terms.
    pub(in crate::methods) fn of(self, by_terms: &[Errors]) -> usize {
        match self {
            Self::Number(terms) => terms.min(by_terms.len()),
            Self::Error(max) => {
                1 + by_terms[..by_terms.len() - 1].iter().take_while(|errors| !keeps(errors, max)).count()
            }
        }
    }
}

/// Whether these errors, of rows before they are rounded, stay below `max` under every light.
pub(in crate::methods) fn keeps(errors: &Errors, max: f64) -> bool {
    worst(errors) * ROUNDING <= max
}

/// How often light bounces between surfaces.
pub(super) fn bounces(scene: &Scene) -> u32 {
    scene.reflections - 1
}

/// Texels along a side of the light's faces.
pub(super) fn face_size(scene: &Scene) -> usize {
    if bounces(scene) > 0 { BOUNCED_FACE_SIZE } else { FACE_SIZE }
}

/// Values of a coefficient.
pub(super) fn channels(scene: &Scene) -> usize {
    if bounces(scene) > 0 { 3 } else { 1 }
}

/// Cubes of the light: without suns, and, where light bounces, the whole.
pub(super) fn cubes(scene: &Scene) -> usize {
    if bounces(scene) > 0 { 2 } else { 1 }
}

/// Of all meshes.
pub(in crate::methods) fn vertices(scene: &Scene) -> usize {
    scene.objects.iter().map(|o| o.mesh.positions.len()).sum()
}
