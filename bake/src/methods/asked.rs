//! What a user asks of methods.

use relume_scenes::Scene;
use serde::{Deserialize, Serialize};

/// Samples by name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Quality {
    /// A first look.
    Draft,
    /// Good to work with.
    Preview,
    /// Good to keep.
    Final,
}

impl Quality {
    /// Film samples a pixel.
    pub fn samples(self) -> u32 {
        match self {
            Self::Draft => 64,
            Self::Preview => 256,
            Self::Final => 1024,
        }
    }

    /// Rays for a texel of the light at whose border visibility changes.
    pub fn rays_per_texel(self) -> u32 {
        match self {
            Self::Draft => 1,
            Self::Preview => 16,
            Self::Final => 64,
        }
    }
}

/// What the user asks of methods; what is `None` follows from the rest.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Asked {
    /// Film size in pixels.
    pub size: [u32; 2],
    /// Samples by name.
    pub quality: Quality,
    /// Samples, instead of those of `quality`.
    pub samples: Option<u32>,
    /// Of all random numbers.
    pub seed: u64,
    /// Largest relative L2 error on states that the method was not made for.
    pub max_error: f64,
    /// Whether noise is filtered out of transfer-images.
    pub filter: bool,
    /// Noise of transfer-images that is good enough, relative L2 over random states.
    pub noise: Option<f64>,
    /// Bases of transfer-images.
    pub bases: Option<u32>,
    /// Terms of sparse-transfer and transfer-tensor.
    pub terms: Option<u32>,
}

impl Asked {
    /// What `bake run SCENE` bakes.
    pub fn of_scene(scene: &Scene) -> Self {
        Self {
            size: scene.size,
            quality: Quality::Preview,
            samples: None,
            seed: 0,
            max_error: scene.max_error,
            filter: true,
            noise: None,
            bases: None,
            terms: None,
        }
    }
}
