//! What Relume lights: scene files, geometry loading, procedural shapes, environment maps, and their
//! validation.
//!
//! [`Scene`] is the one product of this crate; tracing and baking read nothing else. [`resolve`] finds a
//! scene file, [`load`] reads it, [`Scene::with_state`] changes what may change. [`load_mesh`] and
//! [`load_deforming`] read single geometry files, [`starter`] makes a first scene for one.

mod description;
mod geometry;
mod image_file;
mod library;
mod loading;
mod numbering;
pub mod painting;
mod scene;
mod shapes;
mod skies;
pub mod starter;
mod suggest;
mod transform;

pub use geometry::{Deforming, load_deforming, load_mesh};
pub use library::{library, resolve};
pub use loading::load;
pub use relume_formats::basis::{EquirectMap, Filter, Texture, Wrap};
pub use scene::{
    ALL_REFLECTIONS, Cone, Emitter, Environment, Glow, Light, MAX_SPHERES, Material, Mesh, NamedMap, Object,
    Scene, Vary,
};
pub use shapes::icosphere;

#[cfg(test)]
mod library_shadow_tests;
#[cfg(test)]
mod library_tensor_tests;
#[cfg(test)]
mod library_tests;
#[cfg(test)]
mod test_support;
