//! The bases that stored numbers refer to.

mod angles;
pub mod approximate;
pub mod brdf_grid;
pub mod cubemap;
mod equirect;
pub mod haar;
pub mod lobe_table;
pub mod microfacet;
mod texture;

pub use angles::Angles;
pub use equirect::EquirectMap;
pub use texture::{Texture, Wrap, linear_from_srgb};
