//! The registry of methods, and which one bakes a scene unless the user says otherwise.

use super::{Method, sparse_transfer, sphere_shadows, transfer_images};
use crate::inspect::Bundled;
use clap::ValueEnum;
use relume_formats::bundle::Maps;
use relume_formats::container::Kind;
use relume_formats::method::{Card, Materials, Variation};
use relume_scenes::{Scene, Vary};
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::collections::BTreeMap;
use std::path::PathBuf;

/// All methods, a line each, in the order of their cards: the one whose frames cost least first.
pub const METHODS: [&Registered; 3] = [&transfer_images::METHOD, &sparse_transfer::METHOD, &sphere_shadows::METHOD];

/// A method's line in the registry.
#[derive(Debug)]
pub struct Registered {
    /// What there is to say of it.
    pub card: &'static Card,
    /// Why it is the one to take where it is, for `bake plan`.
    pub why: &'static str,
    /// The option of `bake run` that is its own, and whether the user gave it.
    pub option: Option<(&'static str, fn(&Asked) -> bool)>,
    /// The method with its settings for a scene.
    pub new: fn(&Asked, &Scene) -> Box<dyn Method>,
    /// What makes a bake with these settings more exact, for a warning.
    pub remedy: fn(&BTreeMap<String, Value>) -> String,
    /// Checks what must agree between its files and with the scene; the maps that are among them.
    pub verify: fn(&Bundled<'_>, &[(Kind, PathBuf)]) -> relume_formats::Result<Maps>,
}

impl Registered {
    /// The method called `name`.
    pub fn find(name: &str) -> Option<&'static Self> {
        METHODS.into_iter().find(|method| method.card.name == name)
    }

    /// Whether it lets vary all of `vary`.
    pub fn serves_all(&self, vary: &Vary) -> bool {
        self.card.lets_vary.includes(&asked_of(vary))
    }
}

/// Samples by name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum, Serialize, Deserialize)]
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
    /// Bases of transfer-images.
    pub bases: Option<u32>,
    /// Terms of sparse-transfer.
    pub terms: Option<u32>,
}

impl Asked {
    /// What `bake run SCENE` bakes.
    pub fn of_scene(scene: &Scene) -> Self {
        Self { size: scene.size, quality: Quality::Preview, samples: None, seed: 0, max_error: scene.max_error, bases: None, terms: None }
    }
}

/// What `vary` asks of a method.
fn asked_of(vary: &Vary) -> Variation {
    let materials = if vary.materials.is_empty() { Materials::Fixed } else { Materials::Whole };
    Variation { light: vary.light, view: vary.view, materials, shape: vary.shape, media: false }
}

/// The cheapest method that serves whatever varies of light, view and shape. Materials vary only where none of these does, for no method varies both.
pub fn cheapest(vary: &Vary) -> &'static Registered {
    let moves = Variation { materials: Materials::Fixed, ..asked_of(vary) };
    let [.., last] = METHODS;
    METHODS.into_iter().find(|method| method.card.lets_vary.includes(&moves)).unwrap_or(last)
}

#[cfg(test)]
mod tests {
    use super::*;
    use relume_formats::method::CARDS;

    #[test]
    fn the_cheapest_that_serves_what_moves_is_chosen() {
        use relume_formats::method::{SPARSE_TRANSFER, SPHERE_SHADOWS, TRANSFER_IMAGES};
        let vary = |light, view, shape, materials: &[usize]| Vary { light, view, shape, materials: materials.to_vec() };
        let cases = [
            (vary(false, false, false, &[0]), TRANSFER_IMAGES, true),
            (vary(false, false, false, &[]), TRANSFER_IMAGES, true),
            (vary(true, false, false, &[]), SPARSE_TRANSFER, true),
            (vary(false, true, false, &[]), SPARSE_TRANSFER, true),
            (vary(true, true, false, &[0, 1]), SPARSE_TRANSFER, false),
            (vary(false, false, true, &[]), SPHERE_SHADOWS, true),
            (vary(true, true, true, &[]), SPHERE_SHADOWS, true),
            (vary(false, false, true, &[2]), SPHERE_SHADOWS, false),
        ];
        for (vary, expected, all) in cases {
            assert_eq!((cheapest(&vary).card, cheapest(&vary).serves_all(&vary)), (&expected, all), "{vary:?}");
        }
        assert!(!transfer_images::METHOD.serves_all(&vary(true, false, false, &[0])));
        assert!(sphere_shadows::METHOD.serves_all(&vary(true, true, false, &[])));
        assert_eq!(METHODS.map(|method| method.card), CARDS, "both in one order");
    }
}
