//! Speed against accuracy: what every method costs and how far its pictures are from path-traced ones.
//!
//! * [`figures`]: what a chart says, and its files;
//! * [`metrics`]: how far images are from their references;
//! * [`picture`]: images beside their references;
//! * [`states`]: random states of what a scene varies;
//! * [`csv`], [`svg`]: the figures as a table and as a drawing.

pub mod csv;
mod digits;
pub mod figures;
#[cfg(test)]
mod figures_tests;
pub mod metrics;
mod pareto;
pub mod picture;
pub mod states;
pub mod svg;
#[cfg(test)]
mod test_chart;
