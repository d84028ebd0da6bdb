//! What the tests of the core share with those of the program, and the screen without a window.
#![allow(clippy::panic, reason = "a test fails by panicking")]

#[path = "../../core/tests/support/mod.rs"]
mod shared;

pub mod mirror;

pub use shared::*;
