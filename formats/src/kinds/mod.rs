//! One module per kind of stored thing: its specification, type, encoding, decoding and validation.

pub mod animation;
pub mod brdf_basis;
pub mod brdf_tensor;
pub mod environment;
pub mod haar_table;
pub mod manifest;
pub mod names;
pub mod region_images;
pub mod scene;
pub mod shape;
pub mod sparse_transfer;
pub mod sphere_set;
pub mod sphere_shadows;
pub mod textures;
pub mod transfer_images;
pub mod transfer_tensor;
pub mod visibility_table;

pub use brdf_basis::BrdfBasis;
pub use brdf_tensor::BrdfTensor;
pub use environment::Environment;
pub use haar_table::HaarTable;
pub use manifest::Manifest;
pub use region_images::RegionImages;
pub use scene::StoredScene;
pub use sparse_transfer::SparseTransfer;
pub use sphere_set::SphereSet;
pub use sphere_shadows::SphereShadows;
pub use textures::Textures;
pub use transfer_images::TransferImages;
pub use transfer_tensor::TransferTensor;
pub use visibility_table::VisibilityTable;

use crate::container::{Header, open};
use crate::error::Result;
use std::path::Path;

/// Checks every checksum and value of the file at `path`, whatever its kind; returns its header. No more than
/// a part of a large file is kept in memory.
///
/// # Errors
/// The first thing found wrong, with file and section.
pub fn check_file(path: &Path) -> Result<Header> {
    let reader = open(path)?;
    let (header, place) = (reader.header().clone(), reader.place().clone());
    header.expect_kind(header.kind, header.kind.current_version(), &place)?;
    reader.read(header.kind.check())?;
    Ok(header)
}
