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
        self.numbers(accessor, &[], Dimensions::Vec3, place)
    }

    /// Two numbers per element; integers are shares of the largest.
    pub fn texture_coordinates(&self, accessor: &Accessor<'_>, place: &Place) -> Result<Vec<[f32; 2]>> {
        self.numbers(accessor, &[DataType::U8, DataType::U16], Dimensions::Vec2, place)
    }

    /// Four joint weights per element; integers are shares of the largest.
    pub fn joint_weights(&self, accessor: &Accessor<'_>, place: &Place) -> Result<Vec<[f32; 4]>> {
        self.numbers(accessor, &[DataType::U8, DataType::U16], Dimensions::Vec4, place)
    }

    /// Four rotation components per element; integers are shares of the largest.
    pub fn quaternions(&self, accessor: &Accessor<'_>, place: &Place) -> Result<Vec<[f32; 4]>> {
        self.numbers(accessor, &SHARES, Dimensions::Vec4, place)
    }

    /// A morph weight per element; integers are shares of the largest.
    pub fn morph_weights(&self, accessor: &Accessor<'_>, place: &Place) -> Result<Vec<f32>> {
        Ok(self.numbers::<1>(accessor, &SHARES, Dimensions::Scalar, place)?.into_flattened())
    }

    /// A f32 per element.
    pub fn times(&self, accessor: &Accessor<'_>, place: &Place) -> Result<Vec<f32>> {
        Ok(self.numbers::<1>(accessor, &[], Dimensions::Scalar, place)?.into_flattened())
    }

    /// Matrices by columns.
    pub fn matrices(&self, accessor: &Accessor<'_>, place: &Place) -> Result<Vec<[[f32; 4]; 4]>> {
        let numbers = self.numbers::<16>(accessor, &[], Dimensions::Mat4, place)?;
        Ok(numbers.iter().map(|m| std::array::from_fn(|column| std::array::from_fn(|row| m[4 * column + row]))).collect())
    }

    /// Three f32 per element, of which there must be `count`. A sparse accessor changes some of the elements that its view holds, or that are 0.
    pub fn displacements(&self, accessor: &Accessor<'_>, count: usize, place: &Place) -> Result<Vec<[f32; 3]>> {
        let number = accessor.index();
        if accessor.count() != count {
            let reason = format!("accessor {number} holds {} displacements of {count} vertices; export the file again", accessor.count());
            return Err(Error::invalid(place, reason));
        }
        expect_type(accessor, &[DataType::F32], Dimensions::Vec3, place)?;
        let vector = |bytes: &[u8]| std::array::from_fn(|k| number_at(bytes, k, DataType::F32));
        let size = accessor.size();
        let mut values = match accessor.view() {
            Some(view) => self.strided(accessor, &view, accessor.offset(), size, count, place)?.map(vector).collect(),
            None => vec![[0.0; 3]; count],
        };
        let Some(sparse) = accessor.sparse() else { return Ok(values) };
        let (indices, changes) = (sparse.indices(), sparse.values());
        let width = indices.index_type().size();
        let indices = self.strided(accessor, &indices.view(), indices.offset(), width, sparse.count(), place)?;
        let changes = self.strided(accessor, &changes.view(), changes.offset(), size, sparse.count(), place)?;
        for (index, change) in indices.map(|bytes| little_endian(Some(bytes))).zip(changes) {
            let beyond = || Error::invalid(place, format!("accessor {number} changes element {index} of {count}; export the file again"));
            *values.get_mut(index as usize).ok_or_else(beyond)? = vector(change);
        }
        Ok(values)
    }

    /// `N` numbers per element, f32 or, where the accessor calls them normalised, one of `shares`: integers that are shares of the largest.
    fn numbers<const N: usize>(
        &self,
        accessor: &Accessor<'_>,
        shares: &[DataType],
        dimensions: Dimensions,
        place: &Place,
    ) -> Result<Vec<[f32; N]>> {
        let data_type = accessor.data_type();
        if !(accessor.normalized() && shares.contains(&data_type) && accessor.dimensions() == dimensions) {
            expect_type(accessor, &[DataType::F32], dimensions, place)?;
        }
        let elements = self.elements(accessor, place)?;
        Ok(elements.map(|bytes| std::array::from_fn(|k| number_at(bytes, k, data_type))).collect())
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

    /// Four joint indices per element, widened.
    pub fn joint_indices(&self, accessor: &Accessor<'_>, place: &Place) -> Result<Vec<[u32; 4]>> {
        expect_type(accessor, &[DataType::U8, DataType::U16], Dimensions::Vec4, place)?;
        let size = accessor.data_type().size();
        let index = |bytes: &[u8], k: usize| little_endian(bytes.get(size * k..size * (k + 1)));
        Ok(self.elements(accessor, place)?.map(|bytes| std::array::from_fn(|k| index(bytes, k))).collect())
    }

    /// The bytes of each element.
    fn elements<'a>(&'a self, accessor: &Accessor<'_>, place: &Place) -> Result<impl Iterator<Item = &'a [u8]>> {
        let Some(view) = accessor.view().filter(|_| accessor.sparse().is_none()) else {
            return Err(Error::unsupported(place, "sparse accessors are read for morph targets only; export the file without them"));
        };
        self.strided(accessor, &view, accessor.offset(), accessor.size(), accessor.count(), place)
    }

    /// The bytes of `count` elements of `size` bytes in `view`, from `offset` on; they belong to `accessor`.
    fn strided<'a>(
        &'a self,
        accessor: &Accessor<'_>,
        view: &View<'_>,
        offset: usize,
        size: usize,
        count: usize,
        place: &Place,
    ) -> Result<impl Iterator<Item = &'a [u8]> + use<'a>> {
        let stride = view.stride().unwrap_or(size);
        let last = || count.checked_sub(1)?.checked_mul(stride)?.checked_add(offset)?.checked_add(size);
        let end = if count == 0 { Some(0) } else { last() };
        let bytes = self
            .view(view, place)
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

/// The integers that may stand for numbers of −1 to 1.
const SHARES: [DataType; 4] = [DataType::I8, DataType::U8, DataType::I16, DataType::U16];

/// Number `k` of an element; integers are shares of the largest (glTF 2.0, section 3.6.2.2).
fn number_at(element: &[u8], k: usize, data_type: DataType) -> f32 {
    let size = data_type.size();
    let bits = little_endian(element.get(size * k..size * (k + 1)));
    match data_type {
        DataType::I8 => (f32::from(bits as i8) / f32::from(i8::MAX)).max(-1.0),
        DataType::U8 => bits as f32 / f32::from(u8::MAX),
        DataType::I16 => (f32::from(bits as i16) / f32::from(i16::MAX)).max(-1.0),
        DataType::U16 => bits as f32 / f32::from(u16::MAX),
        _ => f32::from_bits(bits),
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
