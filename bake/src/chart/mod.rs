//! The chart: speed against accuracy, for every method and setting that fits what a scene varies.

pub mod states;
