//! The container under any kind: header, table and sections, as they come or forged with valid checksums.

#![no_main]

use libfuzzer_sys::arbitrary::{self, Arbitrary};
use libfuzzer_sys::fuzz_target;
use relume_formats::container::{MAGIC, MAX_SECTION_BYTES, Reader};
use relume_formats_fuzz::raw_file::{RawFile, RawSection};
use relume_formats_fuzz::{check_refusal, place};
use xxhash_rust::xxh3::xxh3_64;

/// What stands in the file.
#[derive(Debug, Arbitrary)]
enum Input<'a> {
    /// Anything.
    Bytes(&'a [u8]),
    /// A table of any bytes under a header that fits it, then a payload.
    Table { kind: u8, kind_version: u8, table: &'a [u8], payload: &'a [u8] },
    /// Sections with claims of their own.
    Sections { kind: u8, sections: Vec<Section<'a>>, count_error: u64, tail: &'a [u8], length_error: u32 },
}

#[derive(Debug, Arbitrary)]
struct Section<'a> {
    name: &'a str,
    element: u8,
    shape: Vec<u64>,
    planes: bool,
    codec_error: u8,
    offset_error: u64,
    stored_bytes: Option<u64>,
    raw_bytes: Option<u64>,
    /// Instead of what compressing the content gives.
    stored: Option<&'a [u8]>,
    content: &'a [u8],
    fits: bool,
}

impl Section<'_> {
    fn raw(&self) -> RawSection {
        let element = u32::from(self.element % 5);
        let width = RawSection::width(element);
        let content = &self.content[..self.content.len() - self.content.len() % width];
        let fitting = [(content.len() / width) as u64];
        let shape = if self.fits { &fitting } else { self.shape.as_slice() };
        let mut section = RawSection::new(self.name, element, shape, u32::from(self.planes), content);
        if let Some(stored) = self.stored {
            (section.stored, section.stored_bytes) = (stored.to_vec(), stored.len() as u64);
        }
        section.codec += u32::from(self.codec_error);
        section.offset_error = self.offset_error;
        section.stored_bytes = self.stored_bytes.unwrap_or(section.stored_bytes);
        section.raw_bytes = self.raw_bytes.unwrap_or(section.raw_bytes);
        section
    }
}

impl Input<'_> {
    fn file(&self) -> Vec<u8> {
        match self {
            Self::Bytes(bytes) => bytes.to_vec(),
            Self::Table { kind, kind_version, table, payload } => {
                let fields =
                    [0, u32::from(*kind), u32::from(*kind_version), table.len() as u32].map(u32::to_le_bytes);
                let sum = xxh3_64(&[fields.as_flattened(), table].concat()).to_le_bytes();
                [&MAGIC, fields.as_flattened(), &sum, table, payload].concat()
            }
            Self::Sections { kind, sections, count_error, tail, length_error } => {
                let mut file =
                    RawFile::new(1 + u32::from(*kind % 9), sections.iter().map(Section::raw).collect());
                file.section_count = file.section_count.wrapping_add(*count_error);
                (file.table_tail, file.table_bytes_error) = (tail.to_vec(), *length_error);
                file.bytes()
            }
        }
    }
}

fuzz_target!(|input: Input<'_>| {
    let file = input.file();
    let mut reader = match Reader::new(&file[..], file.len() as u64, place()) {
        Ok(reader) => reader,
        Err(error) => return check_refusal(&error),
    };
    assert!(reader.header().sections.len() <= reader.header().kind.max_sections());
    loop {
        match reader.next_section() {
            Ok(Some(section)) => {
                assert_eq!(section.bytes.len() as u64, section.info.raw_bytes);
                assert!(section.info.raw_bytes <= MAX_SECTION_BYTES);
                let numbers = [
                    section.u16s().map(|v| v.len()),
                    section.u32s().map(|v| v.len()),
                    section.f16s().map(|v| v.len()),
                    section.f32s().map(|v| v.len()),
                ];
                let product: u64 = section.info.shape.iter().product();
                numbers.into_iter().flatten().for_each(|count| assert_eq!(count as u64, product));
                let _ = section.record::<Vec<String>>();
            }
            Ok(None) => break,
            Err(error) => return check_refusal(&error),
        }
    }
});
