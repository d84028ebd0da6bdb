//! Rays, samples, lights, the path tracer that is our truth, and every gather.

mod coating;
pub mod environment;
pub mod gather;
mod light_mesh;
pub mod lights;
pub mod path;
pub mod reference;
pub mod sampler;
pub mod triangle;
pub mod world;
