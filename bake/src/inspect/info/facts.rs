//! What is told of files and bundles.

use super::super::codec::codec_name;
use super::super::sphere_metrics::SphereMetrics;
use super::file_bake::FileBake;
use relume_formats::container::SectionInfo;
use relume_formats::kinds::Manifest;
use relume_formats::kinds::brdf_basis::BasisError;
use relume_formats::kinds::scene::StoredMaterial;
use relume_formats::kinds::sphere_shadows::ShadowObject;
use relume_formats::shape::Clip;
use relume_formats::state::{Camera, Model, Rgb};
use serde::Serialize;

/// One `.relume` file.
#[derive(Debug, Serialize)]
pub(in super::super) struct FileInfo {
    pub file: String,
    pub kind: &'static str,
    pub kind_version: u32,
    pub container_version: u32,
    pub totals: Totals,
    pub details: Details,
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

/// What is particular to each kind.
#[derive(Debug, Serialize)]
#[serde(untagged)]
pub(in super::super) enum Details {
    Scene {
        name: String,
        size: [u32; 2],
        camera: Camera,
        vertices: usize,
        triangles: usize,
        objects: Vec<String>,
        materials: Vec<StoredMaterial>,
    },
    Animation {
        name: String,
        duration_s: f32,
        #[serde(rename = "loop")]
        looping: bool,
        tracks: Vec<TrackInfo>,
    },
    BrdfBasis {
        bases: usize,
        model: Model,
        nodes: usize,
        /// First and last exponent or roughness.
        range: [f32; 2],
        shared_diffuse: bool,
        error_at_samples: BasisError,
        error_between: BasisError,
    },
    TransferImages {
        size: [u32; 2],
        bases: u32,
        chromaticity: Option<Rgb>,
        samples: u32,
        seed: u64,
        rgb_images: usize,
        single_channel_images: usize,
        fragments: usize,
        classes: Vec<ClassInfo>,
    },
    HaarTable {
        bitmaps: u64,
        coefficients: u64,
    },
    Environment {
        name: String,
        /// Texels, width and height.
        size: [u32; 2],
        brightest: Rgb,
    },
    Textures {
        uvs: usize,
        /// Texels of each, width and height.
        sizes: Vec<[u32; 2]>,
    },
    SparseTransfer {
        rows: u32,
        terms: usize,
        face_size: u32,
        bounces: u32,
        channels: usize,
        /// How many of the terms are 16-bit integers; the others are bytes.
        wide_terms: u32,
        rays_per_texel: u32,
        /// What the rows would take as f32 with every coefficient.
        bytes_of_dense_matrix: u64,
    },
    SphereSet {
        #[serde(flatten)]
        metrics: SphereMetrics,
        points: usize,
        /// How many the history has.
        iterations_done: usize,
    },
    Shape {
        vertices: usize,
        nodes: usize,
        joints: usize,
        morph_targets: usize,
        clips: Vec<ClipInfo>,
    },
    SphereShadows {
        receivers: usize,
        /// Of them, those with a lobe of their own normal.
        exact_receivers: usize,
        /// Terms kept of the light and of each lobe.
        terms: u32,
        /// Whether the sum over terms of the light uses the second level of visibility.
        second_level: bool,
        rows: usize,
        /// Of them, the nodes of the grid of normals.
        grid_rows: usize,
        objects: Vec<ShadowObject>,
    },
    VisibilityTable {
        directions: usize,
        stored_directions: usize,
        radii: usize,
        /// Of a bitmap.
        texels: usize,
        /// Of the whole table as bitmaps.
        bytes_of_bitmaps: usize,
    },
}

/// One animated leaf.
#[derive(Debug, Serialize)]
pub(in super::super) struct TrackInfo {
    pub leaf: String,
    pub keys: usize,
}

/// A clip of a shape.
#[derive(Debug, Serialize)]
pub(in super::super) struct ClipInfo {
    pub name: String,
    pub duration_s: f32,
    pub tracks: usize,
    pub keys: usize,
}

impl ClipInfo {
    pub fn of(clip: &Clip) -> Self {
        let keys = clip.tracks.iter().map(|track| track.times_s.len()).sum();
        Self { name: clip.name.clone(), duration_s: clip.duration_s, tracks: clip.tracks.len(), keys }
    }
}

/// The fragments of one class.
#[derive(Debug, Serialize)]
pub(in super::super) struct ClassInfo {
    /// The editable material; `None` for everything fixed.
    pub material: Option<String>,
    pub fragments: usize,
}

/// A bundle and its files.
#[derive(Debug, Serialize)]
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
