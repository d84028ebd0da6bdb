//! One module per kind of stored thing: its specification, type, encoding, decoding and validation.

pub mod animation;
pub mod brdf_basis;
pub mod haar_table;
pub mod manifest;
pub mod scene;
pub mod transfer_images;

pub use brdf_basis::BrdfBasis;
pub use haar_table::HaarTable;
pub use manifest::Manifest;
pub use scene::StoredScene;
pub use transfer_images::TransferImages;
