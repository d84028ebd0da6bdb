//! Plays Relume bundles inside another program: given a wgpu device and queue, the bytes of a bundle as they come, and a state, it draws into a texture.
//!
//! ```text
//! manifest ──► Playlist ──► Source ──► Player ──► draw ──► show ──► the caller's texture
//! ```
//!
//! * [`Playlist`]: which files of a bundle are played, in which order;
//! * [`Source`]: where their sections come from; [`Incoming`] is one that takes bytes in any portions;
//! * [`Player`]: takes sections in, and encodes frames;
//! * [`Controls`]: state and animation on top of the scene's defaults; [`Surfaces`]: what stands in the camera's way;
//! * [`MaterialMap`]: which material is seen where;
//! * [`methods`]: one folder per method, the GPU twins of `relume_formats::evaluate`; `lit`: meshes in the light of an environment map, which several
//!   methods draw.
//!
//! It starts no threads, opens no files, reads no clocks and never waits, neither for bytes nor for the GPU: the caller polls, submits, and decides when to wait.
//! `examples/embed.rs` shows all of it. (With the feature `cpu` one method may do its sums on all cores while it is updated.)

#![forbid(unsafe_code)]
#![cfg_attr(test, allow(clippy::disallowed_methods, reason = "tests are callers: they have files, and wait"))]

mod controls;
mod error;
mod gpu;
mod lit;
mod materials;
pub mod methods;
mod player;
mod stream;
mod surfaces;

#[cfg(test)]
#[path = "../tests/support/mod.rs"]
mod support;
#[cfg(test)]
mod testing;

pub use controls::{Controls, Look, PlacedAnimation, PlacedState, Scope};
pub use error::{Error, Result};
pub use gpu::{Film, PassTimes};
pub use materials::{MaterialMap, Seen};
pub use player::{FindMap, NOT_MEASURED, Options, Player, Progress, VertexRadiance};
pub use stream::{Arrival, Event, Incoming, Item, Playlist, Source};
pub use surfaces::Surfaces;
