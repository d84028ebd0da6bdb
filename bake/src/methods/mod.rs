//! The methods, one folder each: gather, project, compress; and which of them bakes a scene.

pub mod asked;
pub mod choice;
mod coarse;
pub mod environment_lit;
mod receiver_pieces;
pub mod region_images;
pub mod registered;
pub mod sparse_transfer;
pub mod sphere_shadows;
pub mod spread;
pub mod transfer_images;
pub mod transfer_tensor;
