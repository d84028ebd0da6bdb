//! Method `region-images` (thesis §4.2): light and view stay, materials vary from point to point.
//!
//! Pilot: some paths tell how much each region of a painted material counts in each component, [`pilot`]. Gather: the
//! paths of [`crate::trace::gather`]. Project: every path on every basis and component, [`project`], so that images of
//! regions never exist. Filter: noise out, the same way of all images, [`crate::fragments`]. Compress: components as
//! Haar coefficients of tiles, the small ones left out, [`cells`]; light without a reflection before whole, [`pack`].
//! What it cannot do: lights or views that vary; at the surface before the eye's, materials are their regions' means.

pub mod bake;
mod cells;
mod covariance;
pub mod held_out;
mod inspected;
mod layout;
mod method;
mod model;
mod pack;
mod pilot;
mod prediction;
mod project;
mod registered;
mod rows;
mod settings;
mod taps;
mod weights;

pub use model::Parts;
pub use registered::METHOD;
pub use settings::{NAME, REVISION, Settings};
