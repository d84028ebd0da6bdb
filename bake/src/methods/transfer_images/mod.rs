//! Method `transfer-images` (thesis §4.1): light and view stay, materials of whole objects vary.
//!
//! Gather: the paths of [`crate::trace::gather`]. Project: every path on every basis, [`project`]. Filter:
//! noise out, the same way of all images, [`crate::fragments`]. Compress: halves with a range per image, [`pack`].
//! What it cannot do: exponents above 200 or roughness below 0.32, lights or views that vary. Third and later
//! reflections know materials by their albedos alone, [`later`].
//!
//! [`pack`] is public for charts, which cut bundles with fewer bases out of one bake.

pub mod albedo_errors;
mod bake;
mod basis;
mod channels;
mod chromaticity;
mod fit;
pub mod held_out;
mod inspected;
pub mod later;
mod method;
pub mod pack;
mod prediction;
mod project;
mod registered;
mod rounding;
mod settings;
mod states;

pub use bake::{Baked, bake};
pub use basis::{model, space_for};
pub use chromaticity::chromaticity;
pub(super) use chromaticity::grey_channel;
pub(super) use fit::expect_fit;
pub use registered::METHOD;
pub use settings::{Bases, NAME, REVISION, Settings, TransferImagesMethod};
