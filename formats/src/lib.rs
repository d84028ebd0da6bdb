//! What Relume stores on disk, what the stored numbers mean, and how a bundle is evaluated.
//!
//! Everything that passes from `bake` to `player` is defined here and nowhere else:
//!
//! * [`container`]: the `.relume` file: magic, versions, section table, checksums, limits;
//! * [`basis`]: the bases that stored numbers refer to;
//! * [`kinds`]: one module per kind of stored thing;
//! * `map_file`: environment maps from files of other programs, with the feature `maps`;
//! * `paint_file`: textures painted on materials, from such files, with the same feature;
//! * [`method`]: the cards of the methods: names, what they let vary, files;
//! * [`near`]: what was meant by a name that is not there;
//! * [`shape`]: shapes that deform, and where a clip moves them;
//! * [`bundle`]: what must agree between the files of a bundle;
//! * [`name`]: what names may be, and how they are printed;
//! * [`display`]: what a display shows of radiance;
//! * [`state`]: what may change at playback: materials, camera, animation;
//! * [`evaluate`]: the CPU meaning of a bundle at a state. The player's shaders must equal it;
//! * [`fast`]: the same in vector code on all cores, for machines without a GPU.
//!
//! This crate knows nothing of rays, windows or GPUs, uses threads only in [`fast`], and never panics on data
//! from outside.

pub mod basis;
pub mod bundle;
pub mod container;
pub mod counts;
pub mod display;
pub mod error;
pub mod evaluate;
#[cfg(feature = "fast")]
pub mod fast;
pub mod kinds;
#[cfg(feature = "maps")]
pub mod map_file;
pub mod method;
pub mod name;
pub mod near;
#[cfg(feature = "maps")]
pub mod paint_file;
mod regular;
pub mod shape;
pub mod state;

pub use error::{Error, Place, Result};
pub use regular::{has_extension, open_regular, read_regular};
