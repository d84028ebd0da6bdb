//! The `.relume` file: a header, a table of sections, and the sections.
//!
//! ```text
//! offset  bytes  content (all integers little-endian)
//!      0      8  magic  89 'R' 'E' 'L' 'U' 'M' 'E' 0A
//!      8      4  container version
//!     12      4  kind
//!     16      4  kind version
//!     20      4  length T of the section table
//!     24      8  xxh3-64 of bytes 8..24 and of the table
//!     32      T  section table: bincode, fixed-size integers, see [`SectionInfo`]
//!   32+T         sections, contiguous, in the order of the table, to the end of the file
//! ```
//!
//! Sections stand in order of importance, so a reader that has only a prefix can already show a coarser answer.
//! A reader validates the whole table (sizes, products, contiguity, exact cover of the file) before it touches a payload,
//! and decodes one section at a time.

pub mod codec;
mod header;
pub mod planes;
mod read;
mod section;
mod write;

pub use header::{Codec, Element, Header, Kind, SectionInfo};
pub use read::{Reader, Unpacker};
pub use section::Section;
pub use write::{Writer, replace_file};

use crate::error::{Error, Place, Result};
use crate::regular::open_regular;
use std::fs::File;
use std::io::BufReader;
use std::path::Path;

/// First eight bytes of every file; the high bit and the line feed catch text-mode transfers.
pub const MAGIC: [u8; 8] = *b"\x89RELUME\n";
/// The one container version there is so far; it becomes 1 with the first release.
pub const CONTAINER_VERSION: u32 = 0;
/// No section is larger than this when decoded: the smallest binding limit a GPU may have.
pub const MAX_SECTION_BYTES: u64 = 128 << 20;
/// A file, and the files of a bundle together, decode to no more than this, or [`MAX_RATIO`] times their
/// length if that is more. So memory follows the file however well it compresses.
pub const MAX_DECODED_BYTES: u64 = 2 << 30;
/// See [`MAX_DECODED_BYTES`]. Images compress best, for whole slots may be 0; a black film of Full HD that
/// takes next to nothing is below the other limit.
pub const MAX_RATIO: u64 = 64;
/// Upper bound on the section table, in bytes.
pub const MAX_TABLE_BYTES: u32 = 16 << 20;
/// Upper bound on the number of sections.
pub const MAX_SECTIONS: usize = 1 << 16;
/// Length of the fixed part of the header.
pub const FIXED_HEADER_BYTES: u64 = 32;

/// A thing that one file holds. A kind lists its sections in order of importance and can be rebuilt from
/// them.
pub trait Stored: Sized {
    /// Which kind of file this is.
    const KIND: Kind;
    /// The version of the kind that this code writes, and the only one it reads.
    const VERSION: u32;

    /// Adds every section, most important first.
    fn encode(&self, out: &mut Writer) -> Result<()>;

    /// Rebuilds the value, checking every invariant. `sections` delivers them in file order.
    fn decode(sections: &mut Sections<'_>) -> Result<Self>;

    /// Checks what [`Stored::decode`] checks. Kinds whose files are large keep no more than a part of them at
    /// a time.
    fn check(sections: &mut Sections<'_>) -> Result<()> {
        Self::decode(sections).map(drop)
    }

    /// The whole file as it would be written; `place` is used in messages only.
    ///
    /// # Errors
    /// For a value that readers would refuse: what they check is checked here, by the same code.
    fn to_bytes(&self, place: Place) -> Result<Vec<u8>> {
        let bytes = self.to_bytes_unchecked(place.clone())?;
        let read =
            Reader::new(&bytes[..], bytes.len() as u64, place).and_then(|reader| reader.read(Self::check));
        read.map_err(unwritable).map(|()| bytes)
    }

    /// [`Stored::to_bytes`] of any value, whether readers accept it or not.
    fn to_bytes_unchecked(&self, place: Place) -> Result<Vec<u8>> {
        let mut writer = Writer::new(Self::KIND, Self::VERSION, place);
        self.encode(&mut writer)?;
        writer.finish()
    }

    /// Writes the value to `path`: all of it, or nothing. Returns the bytes written.
    fn write_file(&self, path: &Path) -> Result<Vec<u8>> {
        let bytes = self.to_bytes(Place::file(path))?;
        replace_file(path, &bytes)?;
        Ok(bytes)
    }

    /// Reads the value from `path`.
    fn read_file(path: &Path) -> Result<Self> {
        Self::open(path)?.read(Self::decode)
    }

    /// Checks the file at `path` without keeping what it holds.
    fn check_file(path: &Path) -> Result<()> {
        Self::open(path)?.read(Self::check)
    }

    /// Opens a file of this kind.
    fn open(path: &Path) -> Result<Reader<BufReader<File>>> {
        let reader = open(path)?;
        reader.header().expect_kind(Self::KIND, Self::VERSION, reader.place())?;
        Ok(reader)
    }
}

/// What a reader says of a damaged file, said of a value that makes no file.
fn unwritable(error: Error) -> Error {
    match error {
        Error::Invalid { place, reason } => {
            let reason = reason.strip_suffix(section::DAMAGED).unwrap_or(&reason).to_owned();
            Error::Invalid {
                place,
                reason: format!(
                    "{reason}; no reader would accept that, so it is not written; change what it comes from"
                ),
            }
        }
        other => other,
    }
}

/// Sections in file order, wherever they come from.
pub struct Sections<'a> {
    /// The file they belong to, for messages.
    pub place: Place,
    /// Gives the next section, or `None` after the last.
    pub next: &'a mut dyn FnMut() -> Result<Option<Section>>,
}

impl Sections<'_> {
    /// The next section, which must be called `name`.
    pub fn take(&mut self, name: &str) -> Result<Section> {
        match (self.next)()? {
            Some(section) if section.info.name == name => Ok(section),
            Some(section) => Err(Error::invalid(
                &self.place.part(format!("section `{}`", section.info.name)),
                format!("expected section `{name}` here; the file is damaged, bake it again"),
            )),
            None => Err(Error::invalid(
                &self.place,
                format!("section `{name}` is missing; the file is damaged, bake it again"),
            )),
        }
    }

    /// The next section, or `None` after the last.
    pub fn take_any(&mut self) -> Result<Option<Section>> {
        (self.next)()
    }

    /// Fails if anything is left.
    pub fn finish(&mut self) -> Result<()> {
        match (self.next)()? {
            None => Ok(()),
            Some(section) => Err(Error::invalid(
                &self.place.part(format!("section `{}`", section.info.name)),
                "unexpected section; the file is damaged, bake it again",
            )),
        }
    }
}

/// Fails if `decoded` bytes are more than files of `stored` bytes may decode to; see [`MAX_DECODED_BYTES`].
pub fn expect_decoded(decoded: u64, stored: u64, place: &Place) -> Result<()> {
    let most = MAX_DECODED_BYTES.max(stored.saturating_mul(MAX_RATIO));
    if decoded > most {
        let reason = format!(
            "{stored} bytes decode to {decoded}, more than {most} are not read; bake it again, smaller"
        );
        return Err(Error::invalid(place, reason));
    }
    Ok(())
}

/// Opens a file and validates its header and table; no payload is read yet.
pub fn open(path: &Path) -> Result<Reader<BufReader<File>>> {
    let place = Place::file(path);
    let file = open_regular(path)?;
    let length = file.metadata().map_err(|e| Error::io(&place, e))?.len();
    Reader::new(BufReader::new(file), length, place)
}
