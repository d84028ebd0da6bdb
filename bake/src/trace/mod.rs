//! Rays, samples, lights, the path tracer that is our truth, and every gather.

mod bounce;
mod chances;
pub mod coat;
mod coating;
mod coordinates;
pub mod environment;
pub mod gather;
pub mod guide;
pub mod held_out_lights;
pub mod later;
mod light_mesh;
pub mod lights;
mod orientation;
pub mod path;
pub mod receivers;
pub mod reference;
pub mod sampler;
pub mod spans;
pub mod spot;
pub mod tile_counts;
pub mod triangle;
mod wide;
pub mod world;
