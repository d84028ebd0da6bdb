//! Numerics that make data small, and what is lost by that.

pub mod linalg;
pub mod quantise;
pub mod statistics;
