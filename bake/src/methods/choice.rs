//! Which methods there are, what each lets vary, and which one bakes a scene unless the user says otherwise.

use super::sparse_transfer::{self, Terms};
use super::transfer_images::{self, Bases};
use super::{Method, sphere_shadows};
use crate::cli::{MethodName, Quality};
use relume_scenes::{Scene, Vary};

/// More rays than that a texel show nothing new.
const MAX_RAYS_PER_TEXEL: u32 = 256;

/// All methods, the one whose frames cost least first.
pub const METHODS: [MethodName; 3] = [MethodName::TransferImages, MethodName::SparseTransfer, MethodName::SphereShadows];

/// What the user asks of methods; what is `None` follows from the rest.
#[derive(Debug, Clone, Copy, PartialEq)]
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

    /// The method `name` with its settings for `scene`.
    pub fn method(&self, name: MethodName, scene: &Scene) -> Box<dyn Method> {
        match name {
            MethodName::TransferImages => Box::new(transfer_images::Wanted {
                size: self.size,
                samples: self.samples.unwrap_or(self.quality.samples()),
                seed: self.seed,
                bases: self.bases.map_or(Bases::Error(self.max_error), |n| Bases::Number(n as usize)),
            }),
            MethodName::SparseTransfer => {
                let rays = self.samples.unwrap_or(self.quality.rays_per_texel()).min(MAX_RAYS_PER_TEXEL);
                let side = (1..).find(|side| side * side >= rays).unwrap_or(1);
                let terms = self.terms.map_or(Terms::Error(self.max_error), |n| Terms::Number(n as usize));
                Box::new(sparse_transfer::Wanted { settings: sparse_transfer::Settings { rays_per_texel: side * side, terms } })
            }
            MethodName::SphereShadows => Box::new(sphere_shadows::Wanted::new(scene, self.seed)),
        }
    }
}

/// The cheapest method that serves whatever varies of light, view and shape. Materials vary only where none of these does, for no method varies both.
pub fn cheapest(vary: &Vary) -> MethodName {
    METHODS.into_iter().find(|name| moves_with(*name, vary)).unwrap_or(MethodName::SphereShadows)
}

/// Whether method `name` serves all of `vary`.
pub fn serves_all(name: MethodName, vary: &Vary) -> bool {
    moves_with(name, vary) && (vary.materials.is_empty() || name == MethodName::TransferImages)
}

/// Whether method `name` serves all of light, view and shape that varies.
fn moves_with(name: MethodName, vary: &Vary) -> bool {
    let (light_and_view, shape) = match name {
        MethodName::TransferImages => (false, false),
        MethodName::SparseTransfer => (true, false),
        MethodName::SphereShadows => (true, true),
    };
    (light_and_view || !(vary.light || vary.view)) && (shape || !vary.shape)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_cheapest_that_serves_what_moves_is_chosen() {
        use MethodName::{SparseTransfer, SphereShadows, TransferImages};
        let vary = |light, view, shape, materials: &[usize]| Vary { light, view, shape, materials: materials.to_vec() };
        let cases = [
            (vary(false, false, false, &[0]), TransferImages, true),
            (vary(false, false, false, &[]), TransferImages, true),
            (vary(true, false, false, &[]), SparseTransfer, true),
            (vary(false, true, false, &[]), SparseTransfer, true),
            (vary(true, true, false, &[0, 1]), SparseTransfer, false),
            (vary(false, false, true, &[]), SphereShadows, true),
            (vary(true, true, true, &[]), SphereShadows, true),
            (vary(false, false, true, &[2]), SphereShadows, false),
        ];
        for (vary, expected, all) in cases {
            assert_eq!((cheapest(&vary), serves_all(cheapest(&vary), &vary)), (expected, all), "{vary:?}");
        }
        assert!(!serves_all(TransferImages, &vary(true, false, false, &[0])));
        assert!(serves_all(SphereShadows, &vary(true, true, false, &[])));
    }
}
