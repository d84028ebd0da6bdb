//! The CPU meaning of a bundle at a state, one file per method: clear, not fast. The player's shaders must
//! equal it.

pub mod region_images;
pub mod sparse_transfer;
pub mod sphere_set;
pub mod sphere_shadows;
pub mod suns;
pub mod transfer_images;
pub mod transfer_tensor;
