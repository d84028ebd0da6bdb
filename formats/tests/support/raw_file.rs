//! The container by hand, written from its specification alone: any field can be set to anything, checksums
//! stay right.

use xxhash_rust::xxh3::xxh3_64;

/// One row of the table and its stored bytes.
#[derive(Debug, Clone, PartialEq)]
pub struct RawSection {
    pub name: String,
    /// 0 u8, 1 u16, 2 u32, 3 f16, 4 f32, 5 i8, 6 i16.
    pub element: u32,
    pub shape: Vec<u64>,
    /// 0 zstd, 1 zstd over byte planes.
    pub codec: u32,
    /// Added to the right offset.
    pub offset_error: u64,
    /// What the table claims; the stored bytes are what they are.
    pub stored_bytes: u64,
    pub raw_bytes: u64,
    pub stored: Vec<u8>,
}

/// A whole file.
#[derive(Debug, Clone, PartialEq)]
pub struct RawFile {
    pub magic: [u8; 8],
    pub container_version: u32,
    pub kind: u32,
    pub kind_version: u32,
    pub sections: Vec<RawSection>,
    /// What the table claims.
    pub section_count: u64,
    /// Bytes of the table after its last row.
    pub table_tail: Vec<u8>,
    /// Added to the right length of the table.
    pub table_bytes_error: u32,
}

struct Cursor<'a>(&'a [u8]);

impl<'a> Cursor<'a> {
    fn bytes(&mut self, n: usize) -> &'a [u8] {
        let (head, tail) = self.0.split_at(n);
        self.0 = tail;
        head
    }

    fn u32(&mut self) -> u32 {
        u32::from_le_bytes(self.bytes(4).try_into().unwrap())
    }

    fn u64(&mut self) -> u64 {
        u64::from_le_bytes(self.bytes(8).try_into().unwrap())
    }
}

impl RawSection {
    /// Bytes of one element.
    pub fn width(element: u32) -> usize {
        [1, 2, 4, 2, 4, 1, 2][element as usize]
    }

    /// A section that stores `raw` as it should be stored.
    pub fn new(name: &str, element: u32, shape: &[u64], codec: u32, raw: &[u8]) -> Self {
        let mut section = Self {
            name: name.to_owned(),
            element,
            shape: shape.to_vec(),
            codec,
            offset_error: 0,
            stored_bytes: 0,
            raw_bytes: 0,
            stored: Vec::new(),
        };
        section.set_raw(raw);
        section
    }

    /// Replaces the content, leaving the shape alone.
    pub fn set_raw(&mut self, raw: &[u8]) {
        let width = if self.codec == 1 { Self::width(self.element) } else { 1 };
        let count = raw.len() / width;
        let grouped: Vec<u8> = (0..raw.len()).map(|i| raw[(i % count) * width + i / count]).collect();
        self.stored = zstd::bulk::compress(&grouped, 3).unwrap();
        self.stored_bytes = self.stored.len() as u64;
        self.raw_bytes = raw.len() as u64;
    }

    /// The content.
    pub fn raw(&self) -> Vec<u8> {
        let grouped = zstd::bulk::decompress(&self.stored, self.raw_bytes as usize).unwrap();
        let width = if self.codec == 1 { Self::width(self.element) } else { 1 };
        let count = grouped.len() / width;
        (0..grouped.len()).map(|i| grouped[(i % width) * count + i / width]).collect()
    }

    fn row(&self, offset: u64, out: &mut Vec<u8>) {
        out.extend((self.name.len() as u64).to_le_bytes());
        out.extend(self.name.as_bytes());
        out.extend(self.element.to_le_bytes());
        out.extend((self.shape.len() as u64).to_le_bytes());
        self.shape.iter().for_each(|n| out.extend(n.to_le_bytes()));
        out.extend(self.codec.to_le_bytes());
        for field in
            [offset.wrapping_add(self.offset_error), self.stored_bytes, self.raw_bytes, xxh3_64(&self.stored)]
        {
            out.extend(field.to_le_bytes());
        }
    }
}

impl RawFile {
    pub fn new(kind: u32, sections: Vec<RawSection>) -> Self {
        Self {
            magic: *b"\x89RELUME\n",
            container_version: 0,
            kind,
            kind_version: 0,
            section_count: sections.len() as u64,
            sections,
            table_tail: Vec::new(),
            table_bytes_error: 0,
        }
    }

    /// Takes a sound file apart; panics if any field is not where the specification says.
    pub fn parse(file: &[u8]) -> Self {
        let mut cursor = Cursor(file);
        let magic = cursor.bytes(8).try_into().unwrap();
        let [container_version, kind, kind_version, table_bytes] = [(); 4].map(|()| cursor.u32());
        let checksum = cursor.u64();
        let mut table = Cursor(cursor.bytes(table_bytes as usize));
        assert_eq!(checksum, xxh3_64(&[&file[8..24], table.0].concat()), "header checksum");
        let section_count = table.u64();
        let mut expected_offset = 32 + u64::from(table_bytes);
        let sections = (0..section_count)
            .map(|_| {
                let length = table.u64() as usize;
                let name = String::from_utf8(table.bytes(length).to_vec()).unwrap();
                let element = table.u32();
                let dimensions = table.u64();
                let shape = (0..dimensions).map(|_| table.u64()).collect();
                let codec = table.u32();
                let [offset, stored_bytes, raw_bytes, sum] = [(); 4].map(|()| table.u64());
                assert_eq!(offset, expected_offset, "offset of {name}");
                expected_offset += stored_bytes;
                let stored = cursor.bytes(stored_bytes as usize).to_vec();
                assert_eq!(sum, xxh3_64(&stored), "checksum of {name}");
                RawSection { name, element, shape, codec, offset_error: 0, stored_bytes, raw_bytes, stored }
            })
            .collect();
        assert!(table.0.is_empty() && cursor.0.is_empty(), "nothing is left over");
        let table_tail = Vec::new();
        Self {
            magic,
            container_version,
            kind,
            kind_version,
            sections,
            section_count,
            table_tail,
            table_bytes_error: 0,
        }
    }

    /// The file with valid checksums.
    pub fn bytes(&self) -> Vec<u8> {
        let table_length = self.table(0).len() as u64;
        let table = self.table(32 + table_length);
        let mut file = self.magic.to_vec();
        let claimed = (table_length as u32).wrapping_add(self.table_bytes_error);
        for field in [self.container_version, self.kind, self.kind_version, claimed] {
            file.extend(field.to_le_bytes());
        }
        let checksum = xxh3_64(&[&file[8..24], &table].concat());
        file.extend(checksum.to_le_bytes());
        file.extend(table);
        self.sections.iter().for_each(|s| file.extend(&s.stored));
        file
    }

    fn table(&self, mut offset: u64) -> Vec<u8> {
        let mut table = self.section_count.to_le_bytes().to_vec();
        for section in &self.sections {
            section.row(offset, &mut table);
            offset += section.stored.len() as u64;
        }
        table.extend(&self.table_tail);
        table
    }
}
