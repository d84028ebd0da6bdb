//! What is told of files and bundles.

use super::super::codec::codec_name;
use super::file_bake::FileBake;
use crate::inspected::Facts;
use relume_formats::container::SectionInfo;
use relume_formats::kinds::Manifest;
use serde::Serialize;

/// One `.relume` file.
#[derive(Serialize)]
pub(in super::super) struct FileInfo {
    pub file: String,
    pub kind: &'static str,
    pub kind_version: u32,
    pub container_version: u32,
    pub totals: Totals,
    pub details: Box<dyn erased_serde::Serialize>,
    /// What is in `details`, for people.
    #[serde(skip)]
    pub facts: Facts,
    /// The bake that a method's main file came from, if a manifest lies beside it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub bake: Option<FileBake>,
    pub sections: Vec<SectionRow>,
}

/// Sizes of a file or of all files of a bundle.
#[derive(Debug, Clone, Copy, Default, Serialize)]
pub(in super::super) struct Totals {
    pub sections: usize,
    /// Whole files, headers included.
    pub bytes_on_disk: u64,
    /// All sections decoded.
    pub bytes_in_memory: u64,
    /// In memory over on disk.
    pub ratio: f64,
}

/// One row of the section table.
#[derive(Debug, Serialize)]
pub(in super::super) struct SectionRow {
    pub name: String,
    pub element: &'static str,
    pub shape: Vec<u64>,
    pub codec: &'static str,
    pub offset: u64,
    pub stored_bytes: u64,
    pub raw_bytes: u64,
    pub ratio: f64,
    pub xxh3: String,
}

/// A bundle and its files.
#[derive(Serialize)]
pub(in super::super) struct BundleInfo {
    pub kind: &'static str,
    pub folder: String,
    pub manifest: Manifest,
    pub totals: Totals,
    pub files: Vec<FileInfo>,
}

impl Totals {
    pub(super) fn new(sections: usize, bytes_on_disk: u64, bytes_in_memory: u64) -> Self {
        Self { sections, bytes_on_disk, bytes_in_memory, ratio: ratio(bytes_in_memory, bytes_on_disk) }
    }
}

impl SectionRow {
    pub(super) fn new(info: &SectionInfo) -> Self {
        Self {
            name: info.name.clone(),
            element: info.element.name(),
            shape: info.shape.clone(),
            codec: codec_name(info.codec),
            offset: info.offset,
            stored_bytes: info.stored_bytes,
            raw_bytes: info.raw_bytes,
            ratio: ratio(info.raw_bytes, info.stored_bytes),
            xxh3: format!("{:016x}", info.checksum),
        }
    }
}

/// How many times smaller `stored` is than `raw`.
pub(in super::super) fn ratio(raw: u64, stored: u64) -> f64 {
    raw as f64 / stored.max(1) as f64
}
