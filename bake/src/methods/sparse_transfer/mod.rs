//! Method `sparse-transfer`: shape and materials stay, the environment and the view vary.
//!
//! Gather: what each vertex sees of the environment, [`visibility`], and what other surfaces send it,
//! [`bounce`]. Project: Haar, the most important terms of each row, [`rows`]. Compress: blocks of integers
//! with a scale per row, [`quantise`]. What it cannot do: highlights, lights other than the environment,
//! shadows finer than the mesh.
//!
//! The steps are public for charts, which cut bundles with other settings out of one bake, and for telling
//! which step an error comes from.

mod bake;
mod bounce;
pub mod errors;
mod fit;
mod gather;
pub mod importance;
mod inspected;
mod method;
mod prediction;
pub mod quantise;
mod registered;
pub mod rows;
mod settings;
#[cfg(test)]
mod test_scene;
pub mod texels;
pub mod visibility;

pub use bake::{Baked, bake};
pub use errors::Errors;
pub use method::SparseTransferMethod;
pub use registered::METHOD;
pub use rows::MAX_TERMS;
pub use settings::{NAME, REVISION, Settings, Terms};
pub(in crate::methods) use settings::{keeps, vertices};
