//! The tests of the program from outside, in one binary, for each takes its time to link.
#![allow(clippy::unwrap_used, clippy::panic, clippy::expect_used, reason = "a test fails by panicking")]

mod cli;
#[cfg(target_os = "linux")]
#[path = "support/desk.rs"]
mod desk;
mod embed;
#[cfg(target_os = "linux")]
mod frames;
mod render;
#[path = "support/run.rs"]
mod run;
mod shadows;
#[cfg(target_os = "linux")]
mod soak;
mod support;
#[cfg(target_os = "linux")]
mod window;
