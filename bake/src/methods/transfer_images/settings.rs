//! What decides what a bake makes: settings, and what is read of the scene.

use super::held_out::CHOICE;
use crate::guided;
use crate::noise_target::NoiseTarget;
use crate::scene_hash::Part;

/// Name of the method.
pub const NAME: &str = relume_formats::method::TRANSFER_IMAGES.name;
/// Changes whenever the same scene and settings give other bytes than before.
pub const REVISION: u32 = 11;
/// What a bake reads of a scene.
pub(super) const READS: [Part; 6] =
    [Part::Geometry, Part::Surfaces, Part::Lights, Part::Camera, Part::Reflections, Part::Environment];

/// The settings that change results.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Settings {
    /// Film size in pixels.
    pub size: [u32; 2],
    /// Film samples a pixel.
    pub samples: u32,
    /// Seed of the paths.
    pub seed: u64,
    /// Number of bases, the diffuse one included.
    pub bases: usize,
    /// Whether noise is filtered out.
    pub filter: bool,
}

/// The method with the settings that it is to bake with.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TransferImagesMethod {
    /// Film size in pixels.
    pub size: [u32; 2],
    /// Film samples a pixel.
    pub samples: u32,
    /// Seed of the paths.
    pub seed: u64,
    /// How many bases.
    pub bases: Bases,
    /// Whether noise is filtered out.
    pub filter: bool,
    /// Relative L2 noise over random states that is good enough; `samples` are then the most in the mean.
    pub noise: Option<f64>,
}

impl TransferImagesMethod {
    /// Its paths, of at most so many reflections.
    pub(super) fn paths(&self, reflections: u32) -> guided::Settings {
        let Self { size, samples, seed, filter, noise, .. } = *self;
        let target = noise.map(|noise| NoiseTarget { noise, filter });
        guided::Settings { size, samples, reflections, seed, target }
    }
}

impl Bases {
    /// As many as may be wanted.
    pub(super) fn most(self) -> usize {
        match self {
            Self::Number(bases) => bases,
            Self::Error(_) => *CHOICE.end(),
        }
    }
}

/// How many bases.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Bases {
    /// This many, the diffuse one included.
    Number(usize),
    /// As many as keep the relative L2 error of every held-out state below this.
    Error(f64),
}
