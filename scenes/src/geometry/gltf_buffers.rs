//! The bytes behind a glTF file: its buffers, wherever they are, and bounds-checked views of them.

use super::MAX_ELEMENTS;
use crate::library::read_bytes;
use base64::Engine;
use gltf::accessor::{Accessor, DataType, Dimensions};
use gltf::buffer::{Source, View};
use relume_formats::{Error, Place, Result};
use std::path::Path;

/// Every buffer of a document, at least as long as declared.
pub(super) struct Buffers(Vec<Vec<u8>>);

impl Buffers {
    /// Fetches the buffers of `document`, which lies at `path` and came with `blob` if it is a GLB.
    pub fn load(document: &gltf::Document, mut blob: Option<Vec<u8>>, path: &Path) -> Result<Self> {
        let place = Place::file(path);
        let mut buffers = Vec::new();
        for buffer in document.buffers() {
            let place = place.part(format!("buffer {}", buffer.index()));
            let bytes = match buffer.source() {
                Source::Bin => blob.take().ok_or_else(|| Error::invalid(&place, "has no uri, and the file has no binary chunk"))?,
                Source::Uri(uri) => read_uri(uri, path, &place)?,
            };
            if bytes.len() < buffer.length() {
                return Err(Error::invalid(
                    &place,
                    format!("{} bytes, {} are declared; export the file again", bytes.len(), buffer.length()),
                ));
            }
            buffers.push(bytes);
        }
        Ok(Self(buffers))
    }

    /// Three f32 per element.
    pub fn vectors(&self, accessor: &Accessor<'_>, place: &Place) -> Result<Vec<[f32; 3]>> {
        expect_type(accessor, &[DataType::F32], Dimensions::Vec3, place)?;
        let elements = self.elements(accessor, place)?;
        Ok(elements.map(|bytes| std::array::from_fn(|k| f32::from_bits(little_endian(bytes.get(4 * k..4 * k + 4))))).collect())
    }

    /// Two numbers per element; integers are shares of the largest.
    pub fn texture_coordinates(&self, accessor: &Accessor<'_>, place: &Place) -> Result<Vec<[f32; 2]>> {
        let integers: &[DataType] = if accessor.normalized() { &[DataType::F32, DataType::U8, DataType::U16] } else { &[DataType::F32] };
        expect_type(accessor, integers, Dimensions::Vec2, place)?;
        let number = |bytes: &[u8]| match (little_endian(Some(bytes)), accessor.data_type()) {
            (bits, DataType::F32) => f32::from_bits(bits),
            (share, DataType::U8) => share as f32 / f32::from(u8::MAX),
            (share, _) => share as f32 / f32::from(u16::MAX),
        };
        let size = accessor.data_type().size();
        let elements = self.elements(accessor, place)?;
        Ok(elements.map(|bytes| std::array::from_fn(|k| number(bytes.get(size * k..size * (k + 1)).unwrap_or_default()))).collect())
    }

    /// The bytes of a whole view.
    pub fn view(&self, view: &View<'_>, place: &Place) -> Result<&[u8]> {
        let end = view.offset().checked_add(view.length());
        let bytes = self.0.get(view.buffer().index()).zip(end).and_then(|(buffer, end)| buffer.get(view.offset()..end));
        bytes.ok_or_else(|| Error::invalid(place, format!("buffer view {} reaches beyond its buffer; export the file again", view.index())))
    }

    /// Vertex indices, widened.
    pub fn indices(&self, accessor: &Accessor<'_>, place: &Place) -> Result<Vec<u32>> {
        expect_type(accessor, &[DataType::U8, DataType::U16, DataType::U32], Dimensions::Scalar, place)?;
        Ok(self.elements(accessor, place)?.map(|bytes| little_endian(Some(bytes))).collect())
    }

    /// The bytes of each element.
    fn elements<'a>(&'a self, accessor: &Accessor<'_>, place: &Place) -> Result<impl Iterator<Item = &'a [u8]>> {
        let Some(view) = accessor.view().filter(|_| accessor.sparse().is_none()) else {
            return Err(Error::unsupported(place, "sparse accessors are not read; export the file without them"));
        };
        let (size, count, offset) = (accessor.size(), accessor.count(), accessor.offset());
        let stride = view.stride().unwrap_or(size);
        let last = || count.checked_sub(1)?.checked_mul(stride)?.checked_add(offset)?.checked_add(size);
        let end = if count == 0 { Some(0) } else { last() };
        let bytes = self
            .view(&view, place)
            .ok()
            .zip(end)
            .and_then(|(view, end)| view.get(..end))
            .filter(|_| stride >= size && count <= MAX_ELEMENTS);
        let bytes = bytes.ok_or_else(|| {
            Error::invalid(place, format!("accessor {} reaches beyond its buffer or limits; export the file again", accessor.index()))
        })?;
        Ok((0..count).map(move |i| bytes.get(offset + i * stride..).and_then(|b| b.get(..size)).unwrap_or_default()))
    }
}

fn little_endian(bytes: Option<&[u8]>) -> u32 {
    bytes.unwrap_or_default().iter().rev().fold(0, |value, byte| value << 8 | u32::from(*byte))
}

fn expect_type(accessor: &Accessor<'_>, types: &[DataType], dimensions: Dimensions, place: &Place) -> Result<()> {
    if types.contains(&accessor.data_type()) && accessor.dimensions() == dimensions {
        return Ok(());
    }
    let reason = format!(
        "accessor {} holds {:?} {:?}, expected {types:?} {dimensions:?}; export the file without quantisation",
        accessor.index(),
        accessor.data_type(),
        accessor.dimensions()
    );
    Err(Error::unsupported(place, reason))
}

/// The bytes behind a URI in the file at `path`.
pub(super) fn read_uri(uri: &str, path: &Path, place: &Place) -> Result<Vec<u8>> {
    if let Some(data) = uri.strip_prefix("data:") {
        let (_, text) = data.split_once(";base64,").ok_or_else(|| Error::unsupported(place, "a data URI that is not base64"))?;
        // The glTF file itself is of bounded size, and with it the text.
        return base64::engine::general_purpose::STANDARD
            .decode(text)
            .map_err(|e| Error::invalid(place, format!("broken base64 ({e}); export the file again")));
    }
    if uri.contains("://") {
        return Err(Error::unsupported(place, format!("lies at {uri}; download it and name it by a relative path")));
    }
    let file = path.with_file_name(percent_decoded(uri));
    read_bytes(&file).map_err(|error| match error {
        Error::Io { source, .. } => {
            Error::io(&Place::file(&file), std::io::Error::new(source.kind(), format!("{source}; {} needs it", path.display())))
        }
        other => other,
    })
}

/// Undoes `%20` and its like; whatever is no such escape stays.
fn percent_decoded(uri: &str) -> String {
    let mut bytes = Vec::with_capacity(uri.len());
    let mut rest = uri.as_bytes();
    while let Some((first, after)) = rest.split_first() {
        let hex = after.get(..2).filter(|_| *first == b'%').and_then(|h| std::str::from_utf8(h).ok());
        let escaped = hex.and_then(|h| u8::from_str_radix(h, 16).ok());
        bytes.push(escaped.unwrap_or(*first));
        rest = if escaped.is_some() { after.get(2..).unwrap_or_default() } else { after };
    }
    String::from_utf8_lossy(&bytes).into_owned()
}
