//! Reading a file front to back, a section at a time.

use super::header::Fixed;
use super::{Codec, FIXED_HEADER_BYTES, Header, Section, SectionInfo, Sections};
use super::{codec, planes};
use crate::error::{Error, Place, Result};
use std::io::Read;
use xxhash_rust::xxh3::xxh3_64;

const CUT_SHORT: &str = "the file ends early; it is cut short, bake it again";

/// Makes the sections of one file of its bytes, which come in their order from wherever they may. It never
/// waits, and it asks for no more than one section needs.
pub struct Unpacker {
    file_bytes: u64,
    place: Place,
    stage: Stage,
}

/// What comes next.
enum Stage {
    Fixed,
    Table([u8; FIXED_HEADER_BYTES as usize], Fixed),
    Sections(Header, usize),
}

impl Unpacker {
    /// Of the file at `place` of `file_bytes` bytes, none of which has come.
    pub fn new(file_bytes: u64, place: Place) -> Self {
        Self { file_bytes, place, stage: Stage::Fixed }
    }

    /// How many bytes [`Unpacker::take`] is to be given next; `None` behind the last section.
    pub fn wanted(&self) -> Option<usize> {
        match &self.stage {
            Stage::Fixed => Some(FIXED_HEADER_BYTES as usize),
            Stage::Table(_, fixed) => Some(fixed.table_bytes as usize),
            Stage::Sections(header, next) => {
                header.sections.get(*next).map(|info| info.stored_bytes as usize)
            }
        }
    }

    /// Takes the next bytes of the file, as many as are [`wanted`](Self::wanted), and checks them; returns
    /// the section that they are, if they are one.
    pub fn take(&mut self, bytes: Vec<u8>) -> Result<Option<Section>> {
        match &mut self.stage {
            Stage::Fixed => {
                let fixed_bytes = bytes.try_into().map_err(|_| Error::invalid(&self.place, CUT_SHORT))?;
                let fixed = Fixed::parse(&fixed_bytes, self.file_bytes, &self.place)?;
                self.stage = Stage::Table(fixed_bytes, fixed);
            }
            Stage::Table(fixed_bytes, fixed) => {
                let header = Header::parse(fixed_bytes, fixed, &bytes, self.file_bytes, &self.place)?;
                self.stage = Stage::Sections(header, 0);
            }
            Stage::Sections(header, next) => {
                let Some(info) = header.sections.get(*next).cloned() else { return Ok(None) };
                *next += 1;
                let place = self.place.part(format!("section `{}`", info.name));
                if bytes.len() as u64 != info.stored_bytes {
                    return Err(Error::invalid(&place, CUT_SHORT));
                }
                if xxh3_64(&bytes) != info.checksum {
                    return Err(Error::invalid(
                        &place,
                        "checksum does not match; the file is damaged, bake it again",
                    ));
                }
                let bytes = decode(&info, bytes, &place)?;
                return Ok(Some(Section { place: self.place.clone(), info, bytes }));
            }
        }
        Ok(None)
    }

    /// The validated header, as soon as it has come.
    pub fn header(&self) -> Option<&Header> {
        match &self.stage {
            Stage::Sections(header, _) => Some(header),
            _ => None,
        }
    }

    /// The file, for messages.
    pub fn place(&self) -> &Place {
        &self.place
    }

    fn place_of_next(&self) -> Place {
        match &self.stage {
            Stage::Sections(header, next) => header.sections.get(*next).map_or_else(
                || self.place.clone(),
                |info| self.place.part(format!("section `{}`", info.name)),
            ),
            _ => self.place.clone(),
        }
    }
}

/// Delivers the sections of one file in order. It only ever reads forwards, so any byte stream will do.
pub struct Reader<R> {
    input: R,
    unpacker: Unpacker,
    header: Header,
}

impl<R: Read> Reader<R> {
    /// Reads and validates header and table. `file_bytes` is the length that the whole file has.
    pub fn new(mut input: R, file_bytes: u64, place: Place) -> Result<Self> {
        let mut unpacker = Unpacker::new(file_bytes, place);
        loop {
            if let Some(header) = unpacker.header().cloned() {
                return Ok(Self { input, unpacker, header });
            }
            read_wanted(&mut input, &mut unpacker)?;
        }
    }

    /// The validated header.
    pub fn header(&self) -> &Header {
        &self.header
    }

    /// The file, for messages.
    pub fn place(&self) -> &Place {
        self.unpacker.place()
    }

    /// Hands all sections to `read`, which must take every one.
    pub fn read<T>(self, read: impl FnOnce(&mut Sections<'_>) -> Result<T>) -> Result<T> {
        self.read_first(|sections| {
            let value = read(sections)?;
            sections.finish()?;
            Ok(value)
        })
    }

    /// Hands the sections to `read`, which may leave the last ones unread.
    pub fn read_first<T>(mut self, read: impl FnOnce(&mut Sections<'_>) -> Result<T>) -> Result<T> {
        let place = self.place().clone();
        let mut next = move || self.next_section();
        read(&mut Sections { place, next: &mut next })
    }

    /// Reads, checks and decodes the next section; `None` after the last.
    pub fn next_section(&mut self) -> Result<Option<Section>> {
        read_wanted(&mut self.input, &mut self.unpacker)
    }
}

/// Reads what `unpacker` wants, if it wants anything.
fn read_wanted(input: &mut impl Read, unpacker: &mut Unpacker) -> Result<Option<Section>> {
    let Some(wanted) = unpacker.wanted() else { return Ok(None) };
    let mut bytes = vec![0; wanted];
    input.read_exact(&mut bytes).map_err(|e| match e.kind() {
        std::io::ErrorKind::UnexpectedEof => Error::invalid(&unpacker.place_of_next(), CUT_SHORT),
        _ => Error::io(&unpacker.place_of_next(), e),
    })?;
    unpacker.take(bytes)
}

/// Takes the stored bytes, which are gone before the decoded ones are regrouped.
fn decode(info: &SectionInfo, stored: Vec<u8>, place: &Place) -> Result<Vec<u8>> {
    // `raw_bytes` was capped when the header was validated.
    let raw = codec::decompress(&stored, info.raw_bytes as usize)
        .map_err(|e| Error::invalid(place, format!("cannot be decompressed ({e}); bake it again")))?;
    if raw.len() as u64 != info.raw_bytes {
        return Err(Error::invalid(
            place,
            format!("decompresses to {} bytes, expected {}; bake it again", raw.len(), info.raw_bytes),
        ));
    }
    drop(stored);
    Ok(match info.codec {
        Codec::Zstd => raw,
        Codec::ZstdPlanes => planes::join(&raw, info.element.bytes() as usize),
    })
}
