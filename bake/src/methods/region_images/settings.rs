//! What decides what a bake makes: settings, and what is read of the scene.

use crate::guided;
use crate::scene_hash::{Part, hash_of};
use relume_scenes::Scene;
use xxhash_rust::xxh3::xxh3_128;

/// Name of the method.
pub const NAME: &str = relume_formats::method::REGION_IMAGES.name;
/// Changes whenever the same scene and settings give other bytes than before.
pub const REVISION: u32 = 1;
/// What a bake reads of a scene, beside which materials are painted.
const READS: [Part; 6] =
    [Part::Geometry, Part::Surfaces, Part::Lights, Part::Camera, Part::Reflections, Part::Environment];
/// Bases of direct light, unless others are asked for (thesis §4.2.2).
pub const BASES: usize = 6;
/// Most bases of light that was reflected before, at either surface.
pub const INDIRECT_BASES: usize = 6;

/// The settings that change results.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// Film size in pixels.
    pub size: [u32; 2],
    /// Film samples a pixel.
    pub samples: u32,
    /// Seed of the paths.
    pub seed: u64,
    /// Number of bases of direct light, the diffuse one included.
    pub bases: usize,
    /// Relative L2 error over random textures that bakes are to keep to.
    pub max_error: f64,
    /// Whether noise is filtered out.
    pub filter: bool,
}

impl Settings {
    /// Bases of light that was reflected before.
    pub fn indirect_bases(&self, reflections: u32) -> usize {
        if reflections < 2 { 0 } else { self.bases.min(INDIRECT_BASES) }
    }

    /// Its paths, of at most so many reflections.
    pub(super) fn paths(&self, reflections: u32) -> guided::Settings {
        let Self { size, samples, seed, .. } = *self;
        guided::Settings { size, samples, reflections, seed, target: None }
    }
}

/// A hash of what a bake reads of `scene`.
pub(super) fn reads(scene: &Scene) -> u128 {
    let parts = hash_of(scene, &READS);
    xxh3_128(format!("{parts:032x} {:?}", scene.vary.painted).as_bytes())
}
