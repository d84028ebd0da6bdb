//! Speed against accuracy: bundles are played by the `player` that stands beside `bake`, and what they show
//! and cost is measured.
//!
//! * [`chart`]: every method and setting that fits a scene, measured against the reference;
//! * [`sweep`], [`sweeps`]: the settings of each method that trade speed for accuracy;
//! * [`states`], [`reference`](mod@reference): what is compared, and the truth;
//! * [`metrics`]: how far images are from their references;
//! * [`figures`], [`csv`], [`svg`], [`picture`]: what comes of a chart, as data, as a table, as a drawing, as
//!   images; [`files`] writes them;
//! * [`gallery`]: charts and pictures of many scenes on one page;
//! * [`plan`]: what a scene needs, what baking it will take, and what earlier bakes and charts measured;
//! * [`play`]: runs the player;
//! * [`frame_cost`]: what a frame of a new bundle costs;
//! * [`harmonics`]: spherical harmonics, for rivals.
//!
//! Each method's error by causes is an example: `cargo run --release --example ablation`.

pub mod chart;
pub mod csv;
mod digits;
pub mod figures;
#[cfg(test)]
mod figures_tests;
pub mod files;
pub mod frame_cost;
pub mod gallery;
pub mod harmonics;
pub mod metrics;
mod pareto;
pub mod picture;
pub mod plan;
pub mod play;
pub mod reference;
pub mod states;
pub mod svg;
pub mod sweep;
pub mod sweeps;
#[cfg(test)]
mod test_chart;
mod timing;
