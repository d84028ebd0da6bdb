//! Sphere sets.
#![allow(missing_docs)]

pub mod ball;
pub mod coverage;
pub mod enclosing;
pub mod growth;
pub mod measure;
pub mod nearest;
pub mod pieces;
pub mod refit;
pub mod search;
pub mod choose;
pub mod cluster;
pub mod moves;
pub mod solid;
pub mod start;
mod surface_points;
pub mod tighten;
pub mod triangle_tree;
pub mod winding;

#[cfg(test)]
mod test_meshes;
#[cfg(test)]
mod ball_tests;
#[cfg(test)]
mod coverage_tests;
#[cfg(test)]
mod enclosing_tests;
#[cfg(test)]
mod measure_tests;
#[cfg(test)]
mod winding_tests;
