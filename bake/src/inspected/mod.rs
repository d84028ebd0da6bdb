//! What `bake info` tells and `bake export` writes of a file, a file of this folder for each kind: those that
//! methods share here, a method's own in its room.

mod animation;
mod brdf_basis;
mod brdf_tensor;
mod environment;
mod haar_table;
pub mod out;
pub(crate) mod ply;
pub(crate) mod scene;
mod shape;
mod sphere_mesh;
mod sphere_metrics;
mod sphere_set;
mod textures;
mod visibility_table;
pub(crate) mod words;

pub(crate) use animation::animation_json;

use out::Out;
use relume_formats::Result;
use relume_formats::container::Kind;
use std::path::Path;

/// The kinds that methods share.
pub const SHARED: [Inspected; 10] = [
    scene::INSPECTED,
    animation::INSPECTED,
    brdf_basis::INSPECTED,
    brdf_tensor::INSPECTED,
    haar_table::INSPECTED,
    environment::INSPECTED,
    textures::INSPECTED,
    sphere_set::INSPECTED,
    visibility_table::INSPECTED,
    shape::INSPECTED,
];

/// What can be told and written of the files of a kind. Both functions are given files that have been
/// checked.
#[derive(Debug, Clone, Copy)]
pub struct Inspected {
    /// The kind.
    pub kind: Kind,
    /// Tells what is particular to the file at a path, if possible from its small sections alone.
    pub describe: fn(&Path) -> Result<Described>,
    /// Writes what is in the file at a path in standard formats.
    pub export: fn(&Path, &mut Out) -> Result<()>,
}

/// What is particular to a file.
pub struct Described {
    /// As JSON, under names with their units.
    pub details: Box<dyn erased_serde::Serialize>,
    /// For people to read.
    pub facts: Facts,
}

/// Names of at most eleven letters, and what there is to say.
pub type Facts = Vec<(&'static str, String)>;
