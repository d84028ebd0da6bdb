//! What the player writes. Every file is written as a whole or not at all.

mod contact_sheet;
mod exr;
mod frame_path;
mod numbered;
mod png;

pub use contact_sheet::ContactSheet;
pub use exr::encode as encode_exr;
pub use frame_path::FramePath;
pub use numbered::write_numbered;
pub use png::encode as encode_png;

use crate::error::Result;
use relume_formats::container::replace_file;
use relume_formats::{Error, Place};
use std::path::Path;

/// Writes `bytes` to `path`, all of them or none, creating the folders above it.
pub fn write_whole(path: &Path, bytes: &[u8]) -> Result<()> {
    if let Some(folder) = path.parent() {
        std::fs::create_dir_all(folder).map_err(|e| Error::output(&Place::file(folder), e))?;
    }
    Ok(replace_file(path, bytes)?)
}
