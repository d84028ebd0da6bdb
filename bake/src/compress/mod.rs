//! Numerics that make data small, and what is lost by that.

pub mod bits;
pub mod floats;
pub mod frame;
pub mod linalg;
pub mod quantise;
pub mod statistics;
pub mod tucker;
