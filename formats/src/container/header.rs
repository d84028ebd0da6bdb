//! The header and its section table, and the checks that make them trustworthy.

use super::codec;
use super::{
    CONTAINER_VERSION, FIXED_HEADER_BYTES, MAGIC, MAX_SECTION_BYTES, MAX_SECTIONS, MAX_TABLE_BYTES, Sections,
    Stored as _, expect_decoded,
};
use crate::error::{Error, Place, Result};
use crate::kinds;
use serde::{Deserialize, Serialize};
use xxhash_rust::xxh3::Xxh3;

/// Writes down what there is to say of each kind, a line each: number, name, type, and most sections of a
/// file.
macro_rules! kinds {
    ($($(#[$doc:meta])* $kind:ident = $number:literal, $name:literal, $stored:ty, $sections:expr;)*) => {
        /// What a file holds. The number is what stands in the file.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
        #[repr(u32)]
        pub enum Kind {
            $($(#[$doc])* $kind = $number,)*
        }

        impl Kind {
            /// Every kind this version knows.
            pub const ALL: [Kind; [$(Kind::$kind),*].len()] = [$(Kind::$kind),*];

            /// The name used in messages, manifests and `bake info`.
            pub const fn name(self) -> &'static str {
                match self { $(Kind::$kind => $name),* }
            }

            /// Most sections that a file of this kind has. Small kinds are read whole, so this bounds what a
            /// hostile one can ask for.
            pub fn max_sections(self) -> usize {
                match self { $(Kind::$kind => $sections),* }
            }

            /// The version of the kind that this program reads and writes.
            pub fn current_version(self) -> u32 {
                match self { $(Kind::$kind => <$stored>::VERSION),* }
            }

            /// What checks the sections of a file of this kind, see [`Stored::check`].
            pub(crate) fn check(self) -> fn(&mut Sections<'_>) -> Result<()> {
                match self { $(Kind::$kind => <$stored>::check),* }
            }
        }
    };
}

kinds! {
    /// Meshes, camera and materials of a scene: `kinds::scene`.
    Scene = 1, "scene", kinds::StoredScene, 4;
    /// One animation: `kinds::animation`.
    Animation = 2, "animation", crate::state::Animation, 1;
    /// A basis of a BRDF space: `kinds::brdf_basis`.
    BrdfBasis = 3, "brdf-basis", kinds::BrdfBasis, 5;
    /// The images of the method `transfer-images`: `kinds::transfer_images`.
    TransferImages = 4, "transfer-images", kinds::TransferImages, MAX_SECTIONS;
    /// The Haar coefficients of every 4 × 4 bitmap: `kinds::haar_table`.
    HaarTable = 5, "haar-table", kinds::HaarTable, 1;
    /// An equirectangular environment map: `kinds::environment`.
    Environment = 6, "environment", kinds::Environment, 2;
    /// Texture coordinates and textures of a scene's meshes: `kinds::textures`.
    Textures = 7, "textures", kinds::Textures, 18;
    /// The rows of the method `sparse-transfer`: `kinds::sparse_transfer`.
    SparseTransfer = 8, "sparse-transfer", kinds::SparseTransfer, MAX_SECTIONS;
    /// Spheres that cover a solid: `kinds::sphere_set`.
    SphereSet = 9, "sphere-set", kinds::SphereSet, 7;
    /// The texels that one sphere blocks, for every direction and size: `kinds::visibility_table`.
    VisibilityTable = 10, "visibility-table", kinds::VisibilityTable, 1;
    /// A mesh that deforms, and its clips: `kinds::shape`.
    Shape = 11, "shape", crate::shape::DeformingMesh, 12;
    /// The receivers of the method `sphere-shadows` and the lobes of their normals: `kinds::sphere_shadows`.
    SphereShadows = 12, "sphere-shadows", kinds::SphereShadows, 8;
    /// The lobes of a BRDF space as a tensor of low rank: `kinds::brdf_tensor`.
    BrdfTensor = 13, "brdf-tensor", kinds::BrdfTensor, 11;
    /// Light that vertices receive, of the method `transfer-tensor`: `kinds::transfer_tensor`.
    TransferTensor = 14, "transfer-tensor", kinds::TransferTensor, MAX_SECTIONS;
    /// The images of the method `region-images`: `kinds::region_images`.
    RegionImages = 15, "region-images", kinds::RegionImages, 128;
}

impl Kind {
    /// The kind called `name`.
    pub fn find(name: &str) -> Option<Self> {
        Self::ALL.iter().copied().find(|kind| kind.name() == name)
    }
}

/// The type of one element of a section.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Element {
    /// Unsigned byte.
    U8,
    /// Unsigned 16-bit integer.
    U16,
    /// Unsigned 32-bit integer.
    U32,
    /// IEEE 754 half precision.
    F16,
    /// IEEE 754 single precision.
    F32,
    /// Signed byte, two's complement.
    I8,
    /// Signed 16-bit integer, two's complement.
    I16,
}

impl Element {
    /// Size of one element in bytes.
    pub fn bytes(self) -> u64 {
        match self {
            Element::U8 | Element::I8 => 1,
            Element::U16 | Element::I16 | Element::F16 => 2,
            Element::U32 | Element::F32 => 4,
        }
    }

    /// The name used by `bake info`.
    pub fn name(self) -> &'static str {
        match self {
            Element::U8 => "u8",
            Element::I8 => "i8",
            Element::I16 => "i16",
            Element::U16 => "u16",
            Element::U32 => "u32",
            Element::F16 => "f16",
            Element::F32 => "f32",
        }
    }
}

/// How a section is stored.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Codec {
    /// zstd over the raw bytes.
    Zstd,
    /// zstd over the raw bytes regrouped by significance: first the lowest byte of every element, then the
    /// next, and so on. Neighbouring floats share their high bytes, so these then compress well.
    ZstdPlanes,
}

/// One row of the section table.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct SectionInfo {
    /// Unique within the file; at most 64 characters of `a-z 0-9 - _ . /`.
    pub name: String,
    /// Element type.
    pub element: Element,
    /// Row-major shape; its product times the element size is `raw_bytes`.
    pub shape: Vec<u64>,
    /// How the bytes are stored.
    pub codec: Codec,
    /// Where the section starts, from the beginning of the file.
    pub offset: u64,
    /// Stored length in bytes.
    pub stored_bytes: u64,
    /// Decoded length in bytes.
    pub raw_bytes: u64,
    /// xxh3-64 of the stored bytes.
    pub checksum: u64,
}

/// The validated header of a file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Header {
    /// What the file holds.
    pub kind: Kind,
    /// The version of that kind.
    pub kind_version: u32,
    /// The section table.
    pub sections: Vec<SectionInfo>,
}

type TableConfig = bincode::config::Configuration<
    bincode::config::LittleEndian,
    bincode::config::Fixint,
    bincode::config::Limit<{ MAX_TABLE_BYTES as usize }>,
>;

fn table_config() -> TableConfig {
    bincode::config::standard().with_fixed_int_encoding().with_limit()
}

/// Fields of the fixed part that are known before the table is read.
pub(super) struct Fixed {
    kind: u32,
    kind_version: u32,
    pub(super) table_bytes: u32,
    checksum: u64,
}

fn u32_at(bytes: &[u8; FIXED_HEADER_BYTES as usize], at: usize) -> u32 {
    u32::from_le_bytes([bytes[at], bytes[at + 1], bytes[at + 2], bytes[at + 3]])
}

impl Fixed {
    /// Checks magic, container version and table length.
    pub(super) fn parse(
        bytes: &[u8; FIXED_HEADER_BYTES as usize],
        file_bytes: u64,
        place: &Place,
    ) -> Result<Self> {
        if bytes[..8] != MAGIC {
            return Err(Error::invalid(
                place,
                "not a .relume file (wrong magic); give a file that `bake run` wrote",
            ));
        }
        let version = u32_at(bytes, 8);
        if version != CONTAINER_VERSION {
            return Err(Error::unsupported(
                place,
                format!(
                    "container version {version}, this program reads version {CONTAINER_VERSION}; use a matching program or bake again"
                ),
            ));
        }
        let table_bytes = u32_at(bytes, 20);
        if table_bytes > MAX_TABLE_BYTES
            || u64::from(table_bytes) > file_bytes.saturating_sub(FIXED_HEADER_BYTES)
        {
            return Err(Error::invalid(
                place,
                format!(
                    "section table of {table_bytes} bytes does not fit; the file is damaged or cut short, bake it again"
                ),
            ));
        }
        let mut sum = [0; 8];
        sum.copy_from_slice(&bytes[24..32]);
        Ok(Self {
            kind: u32_at(bytes, 12),
            kind_version: u32_at(bytes, 16),
            table_bytes,
            checksum: u64::from_le_bytes(sum),
        })
    }

    /// Bytes 0..32 of a file.
    pub(super) fn encode(
        kind: Kind,
        kind_version: u32,
        table: &[u8],
        table_bytes: u32,
    ) -> [u8; FIXED_HEADER_BYTES as usize] {
        let mut bytes = [0; FIXED_HEADER_BYTES as usize];
        bytes[..8].copy_from_slice(&MAGIC);
        bytes[8..12].copy_from_slice(&CONTAINER_VERSION.to_le_bytes());
        bytes[12..16].copy_from_slice(&(kind as u32).to_le_bytes());
        bytes[16..20].copy_from_slice(&kind_version.to_le_bytes());
        bytes[20..24].copy_from_slice(&table_bytes.to_le_bytes());
        let checksum = header_checksum(&bytes, table);
        bytes[24..].copy_from_slice(&checksum.to_le_bytes());
        bytes
    }
}

fn header_checksum(fixed: &[u8; FIXED_HEADER_BYTES as usize], table: &[u8]) -> u64 {
    let mut hash = Xxh3::new();
    hash.update(&fixed[8..24]);
    hash.update(table);
    hash.digest()
}

pub(super) fn encode_table(sections: &Vec<SectionInfo>, place: &Place) -> Result<Vec<u8>> {
    bincode::serde::encode_to_vec(sections, table_config())
        .map_err(|e| Error::invalid(place, format!("section table cannot be encoded: {e}")))
}

impl Header {
    /// Checks everything the table says against itself and against the length of the file.
    pub(super) fn parse(
        bytes: &[u8; FIXED_HEADER_BYTES as usize],
        fixed: &Fixed,
        table: &[u8],
        file_bytes: u64,
        place: &Place,
    ) -> Result<Self> {
        if header_checksum(bytes, table) != fixed.checksum {
            return Err(Error::invalid(
                place,
                "header checksum does not match; the file is damaged, bake it again",
            ));
        }
        let kind = Kind::ALL.into_iter().find(|k| *k as u32 == fixed.kind).ok_or_else(|| {
            Error::unsupported(
                place,
                format!("kind number {} is unknown to this program; use a newer one", fixed.kind),
            )
        })?;
        let (sections, used): (Vec<SectionInfo>, usize) =
            bincode::serde::decode_from_slice(table, table_config()).map_err(|e| {
                Error::invalid(place, format!("section table is malformed ({e}); bake it again"))
            })?;
        if used != table.len() {
            return Err(Error::invalid(place, "section table has bytes left over; bake it again"));
        }
        let header = Self { kind, kind_version: fixed.kind_version, sections };
        header.validate(FIXED_HEADER_BYTES + table.len() as u64, file_bytes, place)?;
        Ok(header)
    }

    pub(super) fn validate(&self, payload_start: u64, file_bytes: u64, place: &Place) -> Result<()> {
        let most = self.kind.max_sections();
        if self.sections.len() > most {
            let reason = format!(
                "{} sections, kind `{}` has at most {most}; bake it again",
                self.sections.len(),
                self.kind.name()
            );
            return Err(Error::invalid(place, reason));
        }
        let mut names = std::collections::BTreeSet::new();
        let mut expected_offset = payload_start;
        for info in &self.sections {
            let part = place.part(format!("section `{}`", info.name.escape_default()));
            info.validate(&part)?;
            if !names.insert(info.name.as_str()) {
                return Err(Error::invalid(&part, "the name occurs twice"));
            }
            if info.offset != expected_offset {
                return Err(Error::invalid(
                    &part,
                    format!(
                        "starts at byte {}, expected {expected_offset}: sections must be contiguous",
                        info.offset
                    ),
                ));
            }
            expected_offset = expected_offset
                .checked_add(info.stored_bytes)
                .ok_or_else(|| Error::invalid(&part, "stored length overflows"))?;
        }
        expect_decoded(self.decoded_bytes(), file_bytes, place)?;
        if expected_offset != file_bytes {
            return Err(Error::invalid(
                place,
                format!(
                    "the sections end at byte {expected_offset} but the file has {file_bytes}; it is cut short or damaged, bake it again"
                ),
            ));
        }
        Ok(())
    }

    /// Bytes of all sections, decoded.
    pub fn decoded_bytes(&self) -> u64 {
        self.sections.iter().map(|info| info.raw_bytes).sum()
    }

    /// Fails by name unless the file holds `kind` at `version`.
    pub fn expect_kind(&self, kind: Kind, version: u32, place: &Place) -> Result<()> {
        if self.kind != kind {
            return Err(Error::invalid(
                place,
                format!("holds kind `{}`, expected `{}`", self.kind.name(), kind.name()),
            ));
        }
        if self.kind_version != version {
            return Err(Error::unsupported(
                place,
                format!(
                    "kind `{}` version {}, this program reads version {version}; use a matching program or bake again",
                    kind.name(),
                    self.kind_version
                ),
            ));
        }
        Ok(())
    }
}

impl SectionInfo {
    fn validate(&self, place: &Place) -> Result<()> {
        let name_ok = (1..=64).contains(&self.name.len())
            && self
                .name
                .bytes()
                .all(|b| b.is_ascii_lowercase() || b.is_ascii_digit() || b"-_./".contains(&b));
        if !name_ok {
            return Err(Error::invalid(place, "section names have 1 to 64 characters of a-z 0-9 - _ . /"));
        }
        if self.shape.len() > 8 {
            return Err(Error::invalid(
                place,
                format!("{} dimensions, at most 8 are allowed", self.shape.len()),
            ));
        }
        let raw = self.shape.iter().try_fold(self.element.bytes(), |product, &n| product.checked_mul(n));
        if raw != Some(self.raw_bytes) {
            return Err(Error::invalid(
                place,
                format!(
                    "shape {:?} of {} does not make {} bytes",
                    self.shape,
                    self.element.name(),
                    self.raw_bytes
                ),
            ));
        }
        if self.raw_bytes > MAX_SECTION_BYTES {
            return Err(Error::invalid(
                place,
                format!("{} bytes, at most {MAX_SECTION_BYTES} are allowed in a section", self.raw_bytes),
            ));
        }
        if self.stored_bytes > codec::most_stored_bytes(self.raw_bytes) {
            return Err(Error::invalid(
                place,
                format!("stored as {} bytes, more than {} can need", self.stored_bytes, self.raw_bytes),
            ));
        }
        Ok(())
    }
}
