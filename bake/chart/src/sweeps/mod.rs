//! The sweeps, a file for each method that has one.

pub mod sparse_transfer;
pub mod sphere_shadows;
pub mod transfer_images;
pub mod transfer_tensor;

use crate::sweep::{Bench, Sweep, Variant, by_default};
use relume_bake::error::Result;
use relume_bake::methods::registered::Registered;
use relume_scenes::Scene;

/// The sweeps of methods whose settings trade speed for accuracy.
const SWEEPS: [Sweep; 4] =
    [transfer_images::SWEEP, sparse_transfer::SWEEP, transfer_tensor::SWEEP, sphere_shadows::SWEEP];

/// The bundles of `method` to chart: those of its sweep, or the one that it bakes by default.
///
/// # Errors
/// If a bake fails, or a file of a bundle cannot be read or written.
pub fn variants(method: &'static Registered, scene: &Scene, bench: &Bench<'_>) -> Result<Vec<Variant>> {
    match SWEEPS.iter().find(|sweep| sweep.method.card == method.card) {
        Some(sweep) => (sweep.variants)(scene, bench),
        None => by_default(method, scene, bench),
    }
}
