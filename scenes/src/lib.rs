//! What Relume lights: scene files, geometry loading, procedural shapes, environment maps, and their validation.
//!
//! [`Scene`] is the one product of this crate; tracing and baking read nothing else. [`resolve`] finds a scene file,
//! [`load`] reads it, [`Scene::with_state`] changes what may change.

mod description;
mod geometry;
mod image_file;
mod library;
mod loading;
mod scene;
mod shapes;
mod suggest;
mod texture;
mod transform;

pub use library::resolve;
pub use loading::load;
pub use scene::{Cone, Emitter, Environment, EnvironmentMap, Light, Material, Mesh, Object, Scene, Vary};
pub use texture::{Texture, Wrap};

#[cfg(test)]
mod library_tests;
#[cfg(test)]
mod test_support;
