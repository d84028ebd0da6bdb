//! Numerics that make data small, and what is lost by that.

pub mod bits;
pub mod clusters;
pub mod floats;
pub mod frame;
pub mod linalg;
pub mod moving_basis;
pub mod quantise;
pub mod statistics;
pub mod tucker;
pub mod tucker2;
