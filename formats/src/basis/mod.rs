//! The bases that stored numbers refer to.

mod angles;
pub mod approximate;
pub mod blurred;
pub mod brdf_grid;
pub mod cap;
pub mod cubemap;
pub mod diffuse;
mod equirect;
pub mod haar;
pub mod half_difference;
pub mod hemisphere;
mod hex;
pub mod lanes;
pub mod lobe_table;
pub mod microfacet;
pub mod psum;
pub mod sh;
pub mod span;
pub mod suns;
#[cfg(test)]
mod test_bitmaps;
mod texture;
pub mod triple;
pub mod two_level;

pub use angles::Angles;
pub use equirect::EquirectMap;
pub use hex::{hex_from_linear, linear_from_hex};
pub use texture::{Filter, Texture, Wrap, linear_from_srgb, linear_from_srgb_unit, srgb_from_linear};
