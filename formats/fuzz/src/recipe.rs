//! A flat form of a file that a fuzzer can mutate to some purpose: no checksums, offsets or compression, and
//! no length that can be wrong.
//!
//! A recipe is a list of sections, each `name length u8, name, element u8, flags u8, dimensions u8, shape
//! u32…, content length u32, content`, integers little-endian. The low bits of the flags are the codec.
//! Content is repeated until it fills the shape, so that a few bytes make an array of any size, unless the
//! flag [`AS_IT_IS`] is set.

use crate::raw_file::{RawFile, RawSection};
use relume_formats::container::Kind;

/// The content is not adapted to the shape.
pub const AS_IT_IS: u8 = 0x80;
/// Longest content that is made of a shape, so that a fuzzer does not spend its time on zeros.
const MAX_FILLED_BYTES: u64 = 1 << 20;
/// Most sections, for the same reason.
const MAX_SECTIONS: usize = 256;

struct Cursor<'a>(&'a [u8]);

impl<'a> Cursor<'a> {
    fn bytes(&mut self, n: usize) -> &'a [u8] {
        let (head, tail) = self.0.split_at(n.min(self.0.len()));
        self.0 = tail;
        head
    }

    fn byte(&mut self) -> u8 {
        self.bytes(1).first().copied().unwrap_or(0)
    }

    fn u32(&mut self) -> u32 {
        let mut word = [0; 4];
        let bytes = self.bytes(4);
        word[..bytes.len()].copy_from_slice(bytes);
        u32::from_le_bytes(word)
    }
}

/// The file, with valid checksums, that `recipe` describes.
pub fn file(kind: Kind, recipe: &[u8]) -> Vec<u8> {
    let mut cursor = Cursor(recipe);
    let mut sections = Vec::new();
    while !cursor.0.is_empty() && sections.len() < MAX_SECTIONS {
        sections.push(section(&mut cursor));
    }
    RawFile::new(kind as u32, sections).bytes()
}

fn section(cursor: &mut Cursor<'_>) -> RawSection {
    let length = cursor.byte();
    let name = String::from_utf8_lossy(cursor.bytes(length.into())).into_owned();
    let (element, flags, dimensions) = (u32::from(cursor.byte() % 5), cursor.byte(), cursor.byte() % 10);
    let shape: Vec<u64> = (0..dimensions).map(|_| cursor.u32().into()).collect();
    let length = cursor.u32();
    let content = cursor.bytes(length as usize);
    let width = RawSection::width(element) as u64;
    let filled = shape
        .iter()
        .try_fold(width, |product, n| product.checked_mul(*n))
        .filter(|n| flags & AS_IT_IS == 0 && *n <= MAX_FILLED_BYTES);
    let raw = match filled {
        Some(bytes) if content.is_empty() => vec![0; bytes as usize],
        Some(bytes) => content.iter().copied().cycle().take(bytes as usize).collect(),
        None => content[..content.len() - content.len() % width as usize].to_vec(),
    };
    RawSection::new(&name, element, &shape, u32::from(flags & 1), &raw)
}

/// The recipe of a sound file; the inverse of [`file`].
pub fn of(file: &RawFile) -> Vec<u8> {
    let mut recipe = Vec::new();
    for section in &file.sections {
        let raw = section.raw();
        recipe.push(section.name.len() as u8);
        recipe.extend(section.name.as_bytes());
        recipe.extend([section.element as u8, section.codec as u8, section.shape.len() as u8]);
        section.shape.iter().for_each(|n| recipe.extend((*n as u32).to_le_bytes()));
        recipe.extend((raw.len() as u32).to_le_bytes());
        recipe.extend(raw);
    }
    recipe
}
