//! Method `sphere-shadows`: light, view and shapes vary, materials stay.
//!
//! Nothing of the transfer is baked: spheres or triangles cast the shadows, wherever they are
//! ([`relume_formats::evaluate::sphere_shadows`]). What a bake makes is the lobes of normals ([`rows`]), what
//! objects cast by ([`casters`]), the shapes that deform, and the error ([`errors`]) against shadows of the meshes
//! themselves ([`truth`]). What it cannot do: highlights, light that bounces, lights other than the environment,
//! shadows finer than the receivers' mesh.
//!
//! [`casters`], [`errors`], [`rows`] and [`truth`] are public for telling which step an error comes from.

pub mod casters;
pub mod errors;
mod fit;
mod inspected;
mod method;
mod prediction;
mod registered;
pub mod rows;
mod settings;
pub mod truth;

pub use method::{Asked, SphereShadowsMethod};
pub use registered::METHOD;
pub use settings::{NAME, REVISION};
