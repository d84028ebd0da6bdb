//! The bytes behind a glTF file: its buffers, wherever they are, and bounds-checked views of them.

use super::MAX_ELEMENTS;
use super::gltf_uris::read_uri;
use gltf::accessor::{Accessor, DataType, Dimensions};
use gltf::buffer::{Source, View};
use relume_formats::{Error, Place, Result};
use std::borrow::Cow;
use std::path::Path;

/// Most elements of an accessor whose values are not in the file: they are 0 but for those that a sparse
/// accessor changes.
const MAX_ZEROS: usize = 1 << 24;

/// Most bytes of all buffers of a file.
const MAX_BYTES: usize = 1 << 32;

/// Every buffer of a document, at least as long as declared.
pub(super) struct Buffers(Vec<Vec<u8>>);

impl Buffers {
    /// Fetches the buffers of `document`, which lies at `path` and came with `blob` if it is a GLB.
    pub fn load(document: &gltf::Document, mut blob: Option<Vec<u8>>, path: &Path) -> Result<Self> {
        let place = Place::file(path);
        let (mut buffers, mut total) = (Vec::new(), 0usize);
        for buffer in document.buffers() {
            let place = place.part(format!("buffer {}", buffer.index()));
            let bytes = match buffer.source() {
                Source::Bin => blob
                    .take()
                    .ok_or_else(|| Error::invalid(&place, "has no uri, and the file has no binary chunk"))?,
                Source::Uri(uri) => read_uri(uri, path, &place)?,
            };
            if bytes.len() < buffer.length() {
                return Err(Error::invalid(
                    &place,
                    format!("{} bytes, {} are declared; export the file again", bytes.len(), buffer.length()),
                ));
            }
            total = total.saturating_add(bytes.len());
            if total > MAX_BYTES {
                return Err(Error::invalid(
                    &place,
                    format!("all buffers together hold more than {MAX_BYTES} bytes; split the file"),
                ));
            }
            buffers.push(bytes);
        }
        Ok(Self(buffers))
    }

    /// Three f32 per element.
    pub fn exact_vectors(&self, accessor: &Accessor<'_>, place: &Place) -> Result<Vec<[f32; 3]>> {
        self.numbers(accessor, Integers::None, Dimensions::Vec3, place)
    }

    /// Three numbers per element.
    pub fn vectors(&self, accessor: &Accessor<'_>, place: &Place) -> Result<Vec<[f32; 3]>> {
        self.numbers(accessor, Integers::Plain, Dimensions::Vec3, place)
    }

    /// Two numbers per element.
    pub fn texture_coordinates(&self, accessor: &Accessor<'_>, place: &Place) -> Result<Vec<[f32; 2]>> {
        self.numbers(accessor, Integers::Plain, Dimensions::Vec2, place)
    }

    /// Four joint weights per element.
    pub fn joint_weights(&self, accessor: &Accessor<'_>, place: &Place) -> Result<Vec<[f32; 4]>> {
        self.numbers(accessor, Integers::Shares, Dimensions::Vec4, place)
    }

    /// Four rotation components per element.
    pub fn quaternions(&self, accessor: &Accessor<'_>, place: &Place) -> Result<Vec<[f32; 4]>> {
        self.numbers(accessor, Integers::Shares, Dimensions::Vec4, place)
    }

    /// A morph weight per element.
    pub fn morph_weights(&self, accessor: &Accessor<'_>, place: &Place) -> Result<Vec<f32>> {
        Ok(self.numbers::<1>(accessor, Integers::Shares, Dimensions::Scalar, place)?.into_flattened())
    }

    /// A f32 per element.
    pub fn times(&self, accessor: &Accessor<'_>, place: &Place) -> Result<Vec<f32>> {
        Ok(self.numbers::<1>(accessor, Integers::None, Dimensions::Scalar, place)?.into_flattened())
    }

    /// Matrices by columns.
    pub fn matrices(&self, accessor: &Accessor<'_>, place: &Place) -> Result<Vec<[[f32; 4]; 4]>> {
        let numbers = self.numbers::<16>(accessor, Integers::None, Dimensions::Mat4, place)?;
        Ok(numbers
            .iter()
            .map(|m| std::array::from_fn(|column| std::array::from_fn(|row| m[4 * column + row])))
            .collect())
    }

    /// Three numbers per element, of which there must be `count`.
    pub fn displacements(
        &self,
        accessor: &Accessor<'_>,
        count: usize,
        place: &Place,
    ) -> Result<Vec<[f32; 3]>> {
        if accessor.count() != count {
            let (number, given) = (accessor.index(), accessor.count());
            let reason = format!(
                "accessor {number} holds {given} displacements of {count} vertices; export the file again"
            );
            return Err(Error::invalid(place, reason));
        }
        self.vectors(accessor, place)
    }

    /// `N` numbers per element, f32 or, as `integers` says, of at most 16 bits.
    fn numbers<const N: usize>(
        &self,
        accessor: &Accessor<'_>,
        integers: Integers,
        dimensions: Dimensions,
        place: &Place,
    ) -> Result<Vec<[f32; N]>> {
        let (data_type, normalised) = (accessor.data_type(), accessor.normalized());
        let allowed = match integers {
            Integers::Plain => true,
            Integers::Shares => normalised,
            Integers::None => false,
        };
        let types = [DataType::F32, DataType::I8, DataType::U8, DataType::I16, DataType::U16];
        let types = if allowed { types.as_slice() } else { &[DataType::F32] };
        expect_type(accessor, types, dimensions, place)?;
        let elements = self.elements(accessor, place)?;
        Ok(elements
            .iter()
            .map(|bytes| std::array::from_fn(|k| number_at(bytes, k, data_type, normalised)))
            .collect())
    }

    /// The bytes of a whole view.
    pub fn view(&self, view: &View<'_>, place: &Place) -> Result<&[u8]> {
        let end = view.offset().checked_add(view.length());
        let bytes = self
            .0
            .get(view.buffer().index())
            .zip(end)
            .and_then(|(buffer, end)| buffer.get(view.offset()..end));
        bytes.ok_or_else(|| {
            Error::invalid(
                place,
                format!("buffer view {} reaches beyond its buffer; export the file again", view.index()),
            )
        })
    }

    /// Vertex indices, widened.
    pub fn indices(&self, accessor: &Accessor<'_>, place: &Place) -> Result<Vec<u32>> {
        expect_type(accessor, &[DataType::U8, DataType::U16, DataType::U32], Dimensions::Scalar, place)?;
        Ok(self.elements(accessor, place)?.iter().map(|bytes| little_endian(Some(bytes))).collect())
    }

    /// Four joint indices per element, widened.
    pub fn joint_indices(&self, accessor: &Accessor<'_>, place: &Place) -> Result<Vec<[u32; 4]>> {
        expect_type(accessor, &[DataType::U8, DataType::U16], Dimensions::Vec4, place)?;
        let size = accessor.data_type().size();
        let index = |bytes: &[u8], k: usize| little_endian(bytes.get(size * k..size * (k + 1)));
        Ok(self
            .elements(accessor, place)?
            .iter()
            .map(|bytes| std::array::from_fn(|k| index(bytes, k)))
            .collect())
    }

    /// The bytes of each element. A sparse accessor changes some of those that its view holds, or that are 0
    /// if it has none.
    fn elements(&self, accessor: &Accessor<'_>, place: &Place) -> Result<Elements<'_>> {
        let (size, count) = (accessor.size(), accessor.count());
        let stored = accessor
            .view()
            .map(|view| self.strided(accessor, &view, accessor.offset(), size, count, place))
            .transpose()?;
        let Some(sparse) = accessor.sparse() else {
            return stored.map_or_else(|| zeros(accessor, place), Ok);
        };
        let mut elements = match stored {
            Some(stored) => Elements::packed(stored.iter().flatten().copied().collect(), size),
            None => zeros(accessor, place)?,
        };
        let (indices, changes) = (sparse.indices(), sparse.values());
        let width = indices.index_type().size();
        let indices =
            self.strided(accessor, &indices.view(), indices.offset(), width, sparse.count(), place)?;
        let changes =
            self.strided(accessor, &changes.view(), changes.offset(), size, sparse.count(), place)?;
        for (index, change) in
            indices.iter().map(|bytes| little_endian(Some(bytes)) as usize).zip(changes.iter())
        {
            let number = accessor.index();
            let beyond = || {
                Error::invalid(
                    place,
                    format!("accessor {number} changes element {index} of {count}; export the file again"),
                )
            };
            let bytes = elements.bytes.to_mut();
            bytes
                .get_mut(index.saturating_mul(size)..)
                .and_then(|b| b.get_mut(..size))
                .ok_or_else(beyond)?
                .copy_from_slice(change);
        }
        Ok(elements)
    }

    /// The bytes of `count` elements of `size` bytes in `view`, from `offset` on; they belong to `accessor`.
    fn strided(
        &self,
        accessor: &Accessor<'_>,
        view: &View<'_>,
        offset: usize,
        size: usize,
        count: usize,
        place: &Place,
    ) -> Result<Elements<'_>> {
        let stride = view.stride().unwrap_or(size);
        let last = || count.checked_sub(1)?.checked_mul(stride)?.checked_add(offset)?.checked_add(size);
        let end = if count == 0 { Some(0) } else { last() };
        let bytes = self
            .view(view, place)
            .ok()
            .zip(end)
            .and_then(|(view, end)| view.get(..end)?.get(offset.min(end)..))
            .filter(|_| stride >= size && count <= MAX_ELEMENTS);
        let bytes = bytes.ok_or_else(|| {
            Error::invalid(
                place,
                format!(
                    "accessor {} reaches beyond its buffer or limits; export the file again",
                    accessor.index()
                ),
            )
        })?;
        Ok(Elements { bytes: Cow::Borrowed(bytes), stride, size, count })
    }
}

/// The values of an accessor, each of `size` bytes, `stride` bytes apart.
struct Elements<'a> {
    bytes: Cow<'a, [u8]>,
    stride: usize,
    size: usize,
    count: usize,
}

impl Elements<'_> {
    fn packed(bytes: Vec<u8>, size: usize) -> Self {
        let count = bytes.len() / size.max(1);
        Elements { bytes: Cow::Owned(bytes), stride: size, size, count }
    }

    fn iter(&self) -> impl Iterator<Item = &[u8]> {
        (0..self.count)
            .map(|i| self.bytes.get(i * self.stride..).and_then(|b| b.get(..self.size)).unwrap_or_default())
    }
}

/// What an accessor without a view holds.
fn zeros(accessor: &Accessor<'_>, place: &Place) -> Result<Elements<'static>> {
    let (size, count) = (accessor.size(), accessor.count());
    if count > MAX_ZEROS {
        let reason = format!(
            "accessor {} has {count} elements without data, at most {MAX_ZEROS} are read; store them",
            accessor.index()
        );
        return Err(Error::invalid(place, reason));
    }
    Ok(Elements::packed(vec![0; size * count], size))
}

/// What integers of at most 16 bits mean.
#[derive(Clone, Copy)]
enum Integers {
    /// Shares of the largest where the accessor calls them normalised, else themselves
    /// (KHR_mesh_quantization).
    Plain,
    /// Shares of the largest.
    Shares,
    /// They are refused.
    None,
}

/// Number `k` of an element; normalised integers are shares of the largest (glTF 2.0, section 3.6.2.2).
fn number_at(element: &[u8], k: usize, data_type: DataType, normalised: bool) -> f32 {
    let size = data_type.size();
    let bits = little_endian(element.get(size * k..size * (k + 1)));
    let (value, largest) = match data_type {
        DataType::I8 => (f32::from(bits as i8), f32::from(i8::MAX)),
        DataType::U8 => (bits as f32, f32::from(u8::MAX)),
        DataType::I16 => (f32::from(bits as i16), f32::from(i16::MAX)),
        DataType::U16 => (bits as f32, f32::from(u16::MAX)),
        _ => return f32::from_bits(bits),
    };
    if normalised { (value / largest).max(-1.0) } else { value }
}

fn little_endian(bytes: Option<&[u8]>) -> u32 {
    bytes.unwrap_or_default().iter().rev().fold(0, |value, byte| value << 8 | u32::from(*byte))
}

/// As glTF calls it, in words.
fn in_words(data_type: DataType) -> &'static str {
    match data_type {
        DataType::I8 => "signed bytes",
        DataType::U8 => "unsigned bytes",
        DataType::I16 => "signed shorts",
        DataType::U16 => "unsigned shorts",
        DataType::U32 => "unsigned integers",
        DataType::F32 => "floats",
    }
}

fn shape_in_words(dimensions: Dimensions) -> &'static str {
    match dimensions {
        Dimensions::Scalar => "SCALAR",
        Dimensions::Vec2 => "VEC2",
        Dimensions::Vec3 => "VEC3",
        Dimensions::Vec4 => "VEC4",
        Dimensions::Mat2 => "MAT2",
        Dimensions::Mat3 => "MAT3",
        Dimensions::Mat4 => "MAT4",
    }
}

fn expect_type(
    accessor: &Accessor<'_>,
    types: &[DataType],
    dimensions: Dimensions,
    place: &Place,
) -> Result<()> {
    if types.contains(&accessor.data_type()) && accessor.dimensions() == dimensions {
        return Ok(());
    }
    let of = |types: &[DataType]| {
        types.iter().map(|data_type| in_words(*data_type)).collect::<Vec<_>>().join(", ")
    };
    let reason = format!(
        "accessor {} holds {} of {}, expected {} of {}; export the file again",
        accessor.index(),
        shape_in_words(accessor.dimensions()),
        of(&[accessor.data_type()]),
        shape_in_words(dimensions),
        of(types)
    );
    Err(Error::unsupported(place, reason))
}
