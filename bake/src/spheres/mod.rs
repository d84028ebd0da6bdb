//! Sphere sets.
#![allow(missing_docs)]

pub mod ball;
pub mod coverage;
pub mod enclosing;
pub mod fit;
pub mod growth;
pub mod nearest;
pub mod pieces;
pub mod refit;
pub mod search;
pub mod choose;
pub mod cluster;
pub mod moves;
pub mod start;
pub mod tighten;
pub mod triangle_tree;
pub mod winding;

pub use fit::relative_outside;

#[cfg(test)]
mod test_meshes;
#[cfg(test)]
mod ball_tests;
