//! Samples of every kind, and files that are forged byte by byte.

pub mod playing;
pub mod raw_file;
pub mod reading;
pub mod received;
pub mod refusing;
pub mod regions;
pub mod relighting;
pub mod samples;
pub mod scenes;
pub mod shadows;
pub mod shapes;
pub mod spheres;
pub mod tensors;
