//! Reading a file front to back, a section at a time.

use super::header::Fixed;
use super::{Codec, Element, FIXED_HEADER_BYTES, Header, Section, SectionInfo, Sections};
use crate::error::{Error, Place, Result};
use std::io::Read;
use xxhash_rust::xxh3::xxh3_64;

/// Delivers the sections of one file in order. It only ever reads forwards, so any byte stream will do.
pub struct Reader<R> {
    input: R,
    header: Header,
    place: Place,
    next: usize,
}

impl<R: Read> Reader<R> {
    /// Reads and validates header and table. `file_bytes` is the length that the whole file has.
    pub fn new(mut input: R, file_bytes: u64, place: Place) -> Result<Self> {
        let mut fixed_bytes = [0; FIXED_HEADER_BYTES as usize];
        read_exact(&mut input, &mut fixed_bytes, &place)?;
        let fixed = Fixed::parse(&fixed_bytes, file_bytes, &place)?;
        let mut table = vec![0; fixed.table_bytes as usize];
        read_exact(&mut input, &mut table, &place)?;
        let header = Header::parse(&fixed_bytes, &fixed, &table, file_bytes, &place)?;
        Ok(Self { input, header, place, next: 0 })
    }

    /// What it reads from.
    pub fn input(&self) -> &R {
        &self.input
    }

    /// The validated header.
    pub fn header(&self) -> &Header {
        &self.header
    }

    /// The file, for messages.
    pub fn place(&self) -> &Place {
        &self.place
    }

    /// Hands all sections to `read`, which must take every one.
    pub fn read<T>(mut self, read: impl FnOnce(&mut Sections<'_>) -> Result<T>) -> Result<T> {
        let place = self.place.clone();
        let mut next = move || self.next_section();
        let mut sections = Sections { place, next: &mut next };
        let value = read(&mut sections)?;
        sections.finish()?;
        Ok(value)
    }

    /// Reads, checks and decodes the next section; `None` after the last.
    pub fn next_section(&mut self) -> Result<Option<Section>> {
        let Some(info) = self.header.sections.get(self.next).cloned() else {
            return Ok(None);
        };
        self.next += 1;
        let place = self.place.part(format!("section `{}`", info.name));
        let mut stored = vec![0; info.stored_bytes as usize];
        read_exact(&mut self.input, &mut stored, &place)?;
        if xxh3_64(&stored) != info.checksum {
            return Err(Error::invalid(&place, "checksum does not match; the file is damaged, bake it again"));
        }
        let bytes = decode(&info, stored, &place)?;
        Ok(Some(Section { place: self.place.clone(), info, bytes }))
    }
}

fn read_exact(input: &mut impl Read, buffer: &mut [u8], place: &Place) -> Result<()> {
    input.read_exact(buffer).map_err(|e| match e.kind() {
        std::io::ErrorKind::UnexpectedEof => Error::invalid(place, "the file ends early; it is cut short, bake it again"),
        _ => Error::io(place, e),
    })
}

/// Takes the stored bytes, which are gone before the decoded ones are regrouped.
fn decode(info: &SectionInfo, stored: Vec<u8>, place: &Place) -> Result<Vec<u8>> {
    // `raw_bytes` was capped when the header was validated.
    let raw = zstd::bulk::decompress(&stored, info.raw_bytes as usize)
        .map_err(|e| Error::invalid(place, format!("cannot be decompressed ({e}); bake it again")))?;
    if raw.len() as u64 != info.raw_bytes {
        return Err(Error::invalid(place, format!("decompresses to {} bytes, expected {}; bake it again", raw.len(), info.raw_bytes)));
    }
    drop(stored);
    Ok(match info.codec {
        Codec::Zstd => raw,
        Codec::ZstdPlanes => interleave(&raw, info.element),
    })
}

/// Inverse of [`super::write::planes`].
fn interleave(planes: &[u8], element: Element) -> Vec<u8> {
    match element.bytes() {
        2 => interleaved::<2>(planes),
        4 => interleaved::<4>(planes),
        _ => planes.to_vec(),
    }
}

fn interleaved<const WIDTH: usize>(planes: &[u8]) -> Vec<u8> {
    let count = planes.len() / WIDTH;
    let mut out = vec![0; planes.len()];
    for (byte, plane) in planes.chunks_exact(count.max(1)).enumerate().take(WIDTH) {
        for (element, value) in out.as_chunks_mut::<WIDTH>().0.iter_mut().zip(plane) {
            element[byte] = *value;
        }
    }
    out
}
