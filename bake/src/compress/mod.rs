//! Numerics that make data small.

pub mod linalg;
