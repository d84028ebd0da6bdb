//! What Relume lights: scene files, geometry loading, procedural shapes, environment maps, and their validation.
//!
//! [`Scene`] is the one product of this crate; tracing and baking read nothing else.

mod scene;

pub use scene::{Emitter, Environment, EnvironmentMap, Light, Material, Mesh, Object, Scene, Vary};
