//! Where methods stop being right, a suite for each: every trap of a method and every limit that its page in
//! docs/ states, with the outcome that is expected: an error, a bound, or a loss that is graceful.
//! docs/STABILITY.md shows the failures and lists which test holds which.
//!
//! * [`rays`]: what all methods stand on;
//! * [`transfer_images`], [`sparse_transfer`], [`transfer_tensor`], [`sphere_shadows`] and [`sphere_bundles`];
//! * [`corners`]: where surfaces meet, with the methods whose light is received at vertices;
//! * [`turning`]: maps that turn slowly;
//! * [`pictures`]: makes the pictures of the page.

mod corners;
mod pictures;
mod rays;
mod sparse_transfer;
mod sphere_bundles;
mod sphere_shadows;
mod transfer_images;
mod transfer_tensor;
mod turning;
