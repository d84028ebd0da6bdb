//! Writing a file: sections are compressed some at a time, the header goes in front at the end.

use super::header::{Fixed, encode_table};
use super::{
    Codec, Element, FIXED_HEADER_BYTES, Header, Kind, MAX_SECTION_BYTES, MAX_TABLE_BYTES, SectionInfo,
};
use super::{codec, planes};
use crate::error::{Error, Place, Result};
use half::f16;
use std::io::Write as _;
use std::path::Path;
use xxhash_rust::xxh3::xxh3_64;

type RecordConfig = bincode::config::Configuration<
    bincode::config::LittleEndian,
    bincode::config::Fixint,
    bincode::config::Limit<{ 16 << 20 }>,
>;

pub(super) fn record_config() -> RecordConfig {
    bincode::config::standard().with_fixed_int_encoding().with_limit()
}

/// Bytes that wait to be compressed together, at most, but for those of one section.
const MAX_WAITING: usize = 64 << 20;

/// Collects the compressed sections of one file.
pub struct Writer {
    kind: Kind,
    kind_version: u32,
    place: Place,
    sections: Vec<SectionInfo>,
    payload: Vec<u8>,
    /// The last of `sections`, as they are to be compressed.
    waiting: Vec<Vec<u8>>,
}

impl Writer {
    /// An empty file of the given kind; `place` is used in messages only.
    pub fn new(kind: Kind, kind_version: u32, place: Place) -> Self {
        Self { kind, kind_version, place, sections: Vec::new(), payload: Vec::new(), waiting: Vec::new() }
    }

    /// Adds a small record as a `u8` section.
    pub fn record<T: serde::Serialize>(&mut self, name: &str, value: &T) -> Result<()> {
        let bytes = bincode::serde::encode_to_vec(value, record_config()).map_err(|e| {
            Error::invalid(&self.place.part(format!("section `{name}`")), format!("cannot be encoded: {e}"))
        })?;
        self.bytes(name, Element::U8, &[bytes.len() as u64], Codec::Zstd, &bytes)
    }

    /// Adds a `u8` section of the given shape.
    pub fn u8s(&mut self, name: &str, shape: &[u64], values: &[u8]) -> Result<()> {
        self.bytes(name, Element::U8, shape, Codec::Zstd, values)
    }

    /// Adds an `i8` section of the given shape.
    pub fn i8s(&mut self, name: &str, shape: &[u64], values: &[i8]) -> Result<()> {
        self.bytes(name, Element::I8, shape, Codec::Zstd, bytemuck::cast_slice(values))
    }

    /// Adds an `i16` section of the given shape.
    pub fn i16s(&mut self, name: &str, shape: &[u64], values: &[i16]) -> Result<()> {
        let bytes = le_bytes(values, i16::to_le_bytes);
        self.bytes(name, Element::I16, shape, Codec::ZstdPlanes, &bytes)
    }

    /// Adds a `u16` section of the given shape.
    pub fn u16s(&mut self, name: &str, shape: &[u64], values: &[u16]) -> Result<()> {
        let bytes = le_bytes(values, u16::to_le_bytes);
        self.bytes(name, Element::U16, shape, Codec::ZstdPlanes, &bytes)
    }

    /// Adds a `u32` section of the given shape.
    pub fn u32s(&mut self, name: &str, shape: &[u64], values: &[u32]) -> Result<()> {
        let bytes = le_bytes(values, u32::to_le_bytes);
        self.bytes(name, Element::U32, shape, Codec::ZstdPlanes, &bytes)
    }

    /// Adds a half-float section of the given shape.
    pub fn f16s(&mut self, name: &str, shape: &[u64], values: &[f16]) -> Result<()> {
        let bytes = le_bytes(values, f16::to_le_bytes);
        self.bytes(name, Element::F16, shape, Codec::ZstdPlanes, &bytes)
    }

    /// Adds an `f32` section of the given shape.
    pub fn f32s(&mut self, name: &str, shape: &[u64], values: &[f32]) -> Result<()> {
        let bytes = le_bytes(values, f32::to_le_bytes);
        self.bytes(name, Element::F32, shape, Codec::ZstdPlanes, &bytes)
    }

    fn bytes(&mut self, name: &str, element: Element, shape: &[u64], codec: Codec, raw: &[u8]) -> Result<()> {
        let place = self.place.part(format!("section `{name}`"));
        let raw_bytes = raw.len() as u64;
        if shape.iter().try_fold(element.bytes(), |product, n| product.checked_mul(*n)) != Some(raw_bytes) {
            return Err(Error::invalid(
                &place,
                format!("shape {shape:?} does not fit {raw_bytes} bytes of {}", element.name()),
            ));
        }
        if raw_bytes > MAX_SECTION_BYTES {
            return Err(Error::unsupported(
                &place,
                format!(
                    "{raw_bytes} bytes, a section holds at most {MAX_SECTION_BYTES}; bake a smaller size"
                ),
            ));
        }
        self.sections.push(SectionInfo {
            name: name.to_owned(),
            element,
            shape: shape.to_vec(),
            codec,
            // Known when it is compressed.
            offset: 0,
            stored_bytes: 0,
            raw_bytes,
            checksum: 0,
        });
        self.waiting.push(match codec {
            Codec::Zstd => raw.to_vec(),
            Codec::ZstdPlanes => planes::split(raw, element.bytes() as usize),
        });
        if self.waiting.iter().map(Vec::len).sum::<usize>() >= MAX_WAITING {
            self.compress()?;
        }
        Ok(())
    }

    /// Compresses what is waiting.
    fn compress(&mut self) -> Result<()> {
        let waiting = std::mem::take(&mut self.waiting);
        let first = self.sections.len() - waiting.len();
        for (section, stored) in self.sections[first..].iter_mut().zip(codec::compress_all(&waiting)) {
            let place = || self.place.part(format!("section `{}`", section.name));
            let stored = stored.map_err(|e| Error::io(&place(), e))?;
            // Relative to the payload until `finish` knows the header's length.
            section.offset = self.payload.len() as u64;
            section.stored_bytes = stored.len() as u64;
            section.checksum = xxh3_64(&stored);
            self.payload.extend_from_slice(&stored);
        }
        Ok(())
    }

    /// The complete file.
    pub fn finish(mut self) -> Result<Vec<u8>> {
        self.compress()?;
        // Fixed-size integers: the table is as long with offset 0 as with any other.
        let table_length = encode_table(&self.sections, &self.place)?.len();
        let table_bytes =
            u32::try_from(table_length).ok().filter(|n| *n <= MAX_TABLE_BYTES).ok_or_else(|| {
                Error::unsupported(
                    &self.place,
                    format!("section table of {table_length} bytes, at most {MAX_TABLE_BYTES} are allowed"),
                )
            })?;
        for section in &mut self.sections {
            section.offset += FIXED_HEADER_BYTES + u64::from(table_bytes);
        }
        let table = encode_table(&self.sections, &self.place)?;
        // What a reader would refuse is not written.
        let payload_start = FIXED_HEADER_BYTES + u64::from(table_bytes);
        let header = Header { kind: self.kind, kind_version: self.kind_version, sections: self.sections };
        header.validate(payload_start, payload_start + self.payload.len() as u64, &self.place)?;
        let mut file = Vec::with_capacity(FIXED_HEADER_BYTES as usize + table.len() + self.payload.len());
        file.extend_from_slice(&Fixed::encode(self.kind, self.kind_version, &table, table_bytes));
        file.extend_from_slice(&table);
        file.extend_from_slice(&self.payload);
        Ok(file)
    }
}

fn le_bytes<T: Copy, const N: usize>(values: &[T], to_bytes: impl Fn(T) -> [u8; N]) -> Vec<u8> {
    let mut bytes = vec![0; N * values.len()];
    // As pairs of arrays this is a copy; byte by byte it takes as long as compressing.
    bytes.as_chunks_mut().0.iter_mut().zip(values).for_each(|(bytes, value)| *bytes = to_bytes(*value));
    bytes
}

/// Puts `bytes` at `path`: all of them or none. An older file stays until the new one is whole. Where
/// something else than a file stands, a pipe or a device, it is written to instead of replaced.
pub fn replace_file(path: &Path, bytes: &[u8]) -> Result<()> {
    let place = Place::file(path);
    if std::fs::metadata(path).is_ok_and(|m| !m.is_file()) {
        return std::fs::write(path, bytes).map_err(|e| Error::output(&place, e));
    }
    // Behind a link, the file that it leads to is the one to replace.
    let target = path.canonicalize().unwrap_or_else(|_| path.to_path_buf());
    let mut temporary = target.as_os_str().to_owned();
    temporary.push(format!(".partial-{}", std::process::id()));
    let write = || -> std::io::Result<()> {
        let mut file = std::fs::File::create(&temporary)?;
        file.write_all(bytes)?;
        file.sync_all()?;
        std::fs::rename(&temporary, &target)
    };
    write().map_err(|e| {
        // The first error is the one worth telling; a failed clean-up would only hide it.
        let _ = std::fs::remove_file(&temporary);
        Error::output(&place, e)
    })
}
