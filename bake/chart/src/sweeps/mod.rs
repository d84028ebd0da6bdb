//! The sweeps, a file for each method.

pub mod sparse_transfer;
pub mod sphere_shadows;
pub mod transfer_images;

use crate::sweep::Sweep;

/// All sweeps. A new method adds its line.
pub const SWEEPS: [Sweep; 3] = [transfer_images::SWEEP, sparse_transfer::SWEEP, sphere_shadows::SWEEP];
