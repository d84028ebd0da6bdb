//! The header of a PLY file: which elements follow, what properties they have, and how those are written.

use super::MAX_ELEMENTS;
use super::text::{Lines, quoted, unmarked, words};
use relume_formats::counts::counted;
use relume_formats::{Error, Place, Result};

/// How numbers are written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Encoding {
    Ascii,
    LittleEndian,
    BigEndian,
}

/// The type of a number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Scalar {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

impl Scalar {
    fn called(name: &[u8]) -> Option<Self> {
        Some(match name.to_ascii_lowercase().as_slice() {
            b"char" | b"int8" => Self::I8,
            b"uchar" | b"uint8" => Self::U8,
            b"short" | b"int16" => Self::I16,
            b"ushort" | b"uint16" => Self::U16,
            b"int" | b"int32" => Self::I32,
            b"uint" | b"uint32" => Self::U32,
            b"float" | b"float32" => Self::F32,
            b"double" | b"float64" => Self::F64,
            _ => return None,
        })
    }

    /// Bytes of a number in binary files.
    pub fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::F64 => 8,
        }
    }
}

/// A property of every record of an element.
#[derive(Debug, PartialEq)]
pub(super) struct Property {
    pub name: String,
    /// The type of the length that comes before it, if it is a list.
    pub length: Option<Scalar>,
    /// The type of its number or numbers.
    pub scalar: Scalar,
}

/// A run of records.
#[derive(Debug, PartialEq)]
pub(super) struct Element {
    pub name: String,
    pub count: usize,
    pub properties: Vec<Property>,
}

impl Element {
    /// Where the property of that name stands among all.
    pub fn find(&self, name: &str) -> Option<usize> {
        self.properties.iter().position(|property| property.name == name)
    }
}

/// A header, and what follows it.
pub(super) struct Header<'a> {
    pub encoding: Encoding,
    pub elements: Vec<Element>,
    pub body: Lines<'a>,
    /// What was ignored, if anything.
    pub note: Option<String>,
}

/// What lines of a header begin with.
const KEYWORDS: [&[u8]; 4] = [b"format", b"element", b"property", b"end_header"];

/// Reads the header.
pub(super) fn read<'a>(bytes: &'a [u8], place: &Place) -> Result<Header<'a>> {
    let bytes = unmarked(bytes, place)?;
    let mut lines = Lines::new(bytes);
    if lines.next().is_none_or(|(_, line)| !line.trim_ascii_end().eq_ignore_ascii_case(b"ply")) {
        return Err(Error::invalid(place, "not a PLY file, whose first line is `ply`; export it again"));
    }
    let (mut encoding, mut elements, mut unknown) = (None, Vec::new(), Vec::new());
    while let Some((number, line)) = lines.next() {
        let refuse = |reason: String| {
            Error::invalid(&place.part(format!("line {number}")), format!("{reason}; export the file again"))
        };
        let words: Vec<&[u8]> = words(line).collect();
        let keyword = words.first().map(|word| word.to_ascii_lowercase());
        let by_keyword: Vec<&[u8]> =
            keyword.iter().map(Vec::as_slice).chain(words.iter().skip(1).copied()).collect();
        match *by_keyword.as_slice() {
            [] | [b"comment" | b"obj_info", ..] => {}
            [b"format", name, ..] => {
                encoding =
                    Some(encoding_called(name).ok_or_else(|| refuse(format!("no format {}", quoted(name))))?)
            }
            [b"element", name, count] => elements.push(element(name, count, &elements).map_err(refuse)?),
            [b"property", ref rest @ ..] => {
                let property =
                    property(rest).ok_or_else(|| refuse(format!("{} is no property", quoted(line))))?;
                let element = elements
                    .last_mut()
                    .ok_or_else(|| refuse("a property before the first element".to_owned()))?;
                element.properties.push(property);
            }
            [b"end_header"] => {
                let encoding = encoding.ok_or_else(|| refuse("the line `format` is missing".to_owned()))?;
                return Ok(Header { encoding, elements, body: body(bytes, lines), note: note_of(&unknown) });
            }
            [first, ..] if !KEYWORDS.contains(&first) => unknown.push((number, line)),
            _ => return Err(refuse(format!("{} is no line of a header", quoted(line)))),
        }
    }
    let first = unknown
        .first()
        .map(|(number, line)| format!(", in which line {number}, {}, is not known", quoted(line)));
    Err(Error::invalid(
        place,
        format!("ends within its header{}; fetch or export it again", first.unwrap_or_default()),
    ))
}

/// Programs write a line of their own about themselves without the word `comment`.
fn note_of(unknown: &[(usize, &[u8])]) -> Option<String> {
    let (number, line) = unknown.first()?;
    let count = counted(unknown.len(), "unknown line", "unknown lines");
    Some(format!("ignored {count} of the header; the first is line {number}, {}", quoted(line)))
}

/// A binary body may begin with the byte of a line feed, which belongs to the line end only if the other
/// lines end so.
fn body<'a>(bytes: &'a [u8], mut rest: Lines<'a>) -> Lines<'a> {
    let ends_in_cr = bytes
        .iter()
        .position(|b| matches!(b, b'\n' | b'\r'))
        .is_some_and(|at| bytes[at..].starts_with(b"\r") && !bytes[at..].starts_with(b"\r\n"));
    let start = bytes.len() - rest.rest.len();
    if ends_in_cr && bytes[..start].ends_with(b"\r\n") {
        rest.rest = &bytes[start - 1..];
    }
    rest
}

fn encoding_called(name: &[u8]) -> Option<Encoding> {
    match name.to_ascii_lowercase().as_slice() {
        b"ascii" => Some(Encoding::Ascii),
        b"binary_little_endian" => Some(Encoding::LittleEndian),
        b"binary_big_endian" => Some(Encoding::BigEndian),
        _ => None,
    }
}

/// Refuses counts that would keep the reader busy without a byte of the file behind them.
fn element(name: &[u8], count: &[u8], before: &[Element]) -> std::result::Result<Element, String> {
    let name = String::from_utf8_lossy(name).into_owned();
    let parsed = std::str::from_utf8(count).ok().and_then(|count| count.parse().ok());
    match parsed {
        _ if before.iter().any(|element| element.name == name) => {
            Err(format!("a second element {}", quoted(name.as_bytes())))
        }
        Some(count @ 0..=MAX_ELEMENTS) => Ok(Element { name, count, properties: Vec::new() }),
        _ => Err(format!(
            "{} of {}, which is no number up to {MAX_ELEMENTS}",
            quoted(count),
            quoted(name.as_bytes())
        )),
    }
}

fn property(words: &[&[u8]]) -> Option<Property> {
    let (length, scalar, name) = match *words {
        [list, length, scalar, name] if list.eq_ignore_ascii_case(b"list") => {
            (Some(Scalar::called(length)?), scalar, name)
        }
        [scalar, name] => (None, scalar, name),
        _ => return None,
    };
    Some(Property {
        name: String::from_utf8_lossy(name).into_owned(),
        length,
        scalar: Scalar::called(scalar)?,
    })
}
