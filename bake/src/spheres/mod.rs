//! Sphere sets: covers a solid with spheres that have as little volume as possible outside it (sphere shadows
//! §3.2; Wang et al. 2006).
//!
//! * [`solid`]: what a mesh bounds; [`triangle_tree`], [`winding`], [`nearest`], [`ball`]: questions to it,
//!   answered exactly;
//! * [`pieces`]: what must be covered, in pieces that each go to one sphere whole;
//! * [`cluster`], [`growth`], [`refit`], [`tighten`]: spheres and the pieces that they cover;
//! * [`start`], [`moves`], [`search`], [`voids`]: the search for a set with little outside;
//! * [`fit`]: from a mesh to a stored set; [`members`]: which points each sphere follows;
//! * [`coverage`], [`measure`]: whether all is covered, exactly, and how good a set is.

pub mod ball;
pub mod cluster;
pub mod coverage;
pub mod fit;
pub mod growth;
pub mod measure;
pub mod members;
pub mod motion;
mod moves;
pub mod nearest;
pub mod pieces;
pub mod random;
pub mod refit;
pub mod search;
pub mod solid;
pub mod sphere;
pub mod start;
mod surface_points;
pub mod tighten;
pub mod triangle_tree;
pub mod voids;
pub mod winding;

pub use fit::relative_outside;

#[cfg(test)]
mod ball_tests;
#[cfg(test)]
mod coverage_tests;
#[cfg(test)]
mod fit_tests;
#[cfg(test)]
mod measure_tests;
#[cfg(test)]
mod motion_tests;
#[cfg(test)]
mod search_tests;
#[cfg(test)]
mod test_meshes;
#[cfg(test)]
mod winding_tests;
