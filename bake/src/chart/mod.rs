//! The chart: speed against accuracy, for every method and setting that fits what a scene varies.
//!
//! * [`states`]: random states of what a scene varies;
//! * [`figures`]: what a chart says, and its files;
//! * [`metrics`]: how far images are from their references;
//! * [`picture`]: images beside their references;
//! * [`csv`], [`svg`]: the figures as a table and as a drawing.

pub mod csv;
pub(crate) mod digits;
pub mod figures;
#[cfg(test)]
mod figures_tests;
pub mod metrics;
mod pareto;
pub mod picture;
pub mod states;
pub mod svg;
#[cfg(test)]
pub(crate) mod test_chart;
