//! Meshes in the light of an environment map, as the methods have them that know the radiance of every
//! vertex: the map turned, brought to a cube and to Haar coefficients, and the meshes drawn with what comes
//! of it.

mod gpu_data;
mod light;
mod mesh;
mod mips;
mod picture;
mod pipeline;
mod suns;
mod surface;
mod surroundings;
mod targets;
#[cfg(test)]
mod tests;

pub(crate) use light::{Light, Map};
pub(crate) use mesh::Mesh;
pub(crate) use picture::Picture;
pub(crate) use surface::{Bound, Surface};
pub(crate) use surroundings::{Surroundings, belongs};
pub(crate) use targets::drawable;
#[cfg(test)]
pub(crate) use targets::expect_drawable;

const ENVIRONMENT: &str = include_str!("environment.wgsl");
const HAAR: &str = include_str!("haar.wgsl");
const CAST: &str = include_str!("cast.wgsl");
const EXTENT: &str = include_str!("extent.wgsl");
const DIFFUSE: &str = include_str!("diffuse.wgsl");
const AVERAGE: &str = include_str!("average.wgsl");
