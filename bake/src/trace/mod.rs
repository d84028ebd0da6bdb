//! Rays, samples, lights, the path tracer that is our truth, and every gather.

pub mod environment;
pub mod gather;
pub mod lights;
pub mod path;
pub mod reference;
pub mod sampler;
pub mod triangle;
pub mod world;
