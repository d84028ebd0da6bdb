//! The records of a PLY file, as text or binary of either byte order.

use super::MAX_ELEMENTS;
use super::ply_header::{Element, Encoding, Header, Property, Scalar};
use super::text::{Lines, next_word, number, quoted, words};
use relume_formats::counts::counted;
use relume_formats::{Error, Place, Result};

/// Where the reader is.
pub(super) struct Body<'a> {
    encoding: Encoding,
    /// What has not been read.
    rest: Lines<'a>,
    /// Of text, what has not been read of the line, and its number.
    line: &'a [u8],
    number: usize,
    /// Whether line ends are nothing but blanks.
    flows: bool,
    place: &'a Place,
}

/// What a record holds of what was asked for.
pub(super) struct Record {
    /// Numbers of single properties, in the order asked for; 0 where there is none.
    pub values: Vec<f64>,
    /// The numbers of the list.
    pub list: Vec<f64>,
}

impl<'a> Body<'a> {
    /// Records of text each have a line, or, if it `flows`, stand one after the other wherever lines end.
    pub fn new(header: &Header<'a>, flows: bool, place: &'a Place) -> Self {
        Self { encoding: header.encoding, rest: header.body.clone(), line: &[], number: 0, flows, place }
    }

    /// True if no word of text is left.
    pub fn is_read(&mut self) -> bool {
        self.word().is_none()
    }

    /// What stands behind the data, if anything but blanks.
    pub fn leftover(&self) -> Option<String> {
        let count = match self.encoding {
            Encoding::Ascii => counted(
                self.rest.clone().filter(|(_, line)| words(line).next().is_some()).count(),
                "line",
                "lines",
            ),
            _ if words(self.rest.rest).next().is_none() => return None,
            _ => counted(self.rest.rest.len(), "byte", "bytes"),
        };
        (!count.starts_with("0 ")).then(|| format!("ignored {count} after the data that the header tells of"))
    }

    /// Reads all records of `element` and shows them to `visit`, with their number: the single properties at
    /// `wanted` and the list at `list`, as they stand among all. What nobody asks for is not even looked at.
    pub fn read(
        &mut self,
        element: &Element,
        wanted: &[Option<usize>],
        list: Option<usize>,
        mut visit: impl FnMut(usize, &Record) -> Result<()>,
    ) -> Result<()> {
        let mut record = Record { values: vec![0.0; wanted.len()], list: Vec::new() };
        let slots: Vec<Option<usize>> = (0..element.properties.len())
            .map(|index| wanted.iter().position(|wanted| *wanted == Some(index)))
            .collect();
        for index in (0..element.count).take_while(|_| !element.properties.is_empty()) {
            self.begin(element, index)?;
            for (position, (property, slot)) in element.properties.iter().zip(&slots).enumerate() {
                self.property(
                    property,
                    (list == Some(position)).then_some(&mut record.list),
                    slot.map(|slot| &mut record.values[slot]),
                )
                .map_err(|reason| self.refusal(element, index, &reason))?;
            }
            visit(index, &record)?;
        }
        Ok(())
    }

    /// A record of text has a line of its own, if the text does not flow.
    fn begin(&mut self, element: &Element, index: usize) -> Result<()> {
        if self.encoding != Encoding::Ascii || self.flows {
            return Ok(());
        }
        self.next_line().ok_or_else(|| {
            let (name, count) = (plain(&element.name), element.count);
            Error::invalid(
                self.place,
                format!("ends in `{name}` {index} of {count}; fetch or export it again"),
            )
        })
    }

    /// Goes to the next line that has words.
    fn next_line(&mut self) -> Option<()> {
        (self.number, self.line) = self.rest.find(|(_, line)| words(line).next().is_some())?;
        Some(())
    }

    fn word(&mut self) -> Option<&'a [u8]> {
        match next_word(&mut self.line) {
            None if self.flows => self.next_line().and_then(|()| next_word(&mut self.line)),
            word => word,
        }
    }

    fn refusal(&self, element: &Element, index: usize, reason: &str) -> Error {
        let place = match self.encoding {
            Encoding::Ascii => self.place.part(format!("line {}", self.number)),
            _ => self.place.clone(),
        };
        Error::invalid(
            &place,
            format!(
                "{reason} in `{}` {index} of {}; mend or export the file again",
                plain(&element.name),
                element.count
            ),
        )
    }

    fn property(
        &mut self,
        property: &Property,
        list: Option<&mut Vec<f64>>,
        value: Option<&mut f64>,
    ) -> std::result::Result<(), String> {
        let missing = || format!("`{}` is missing", plain(&property.name));
        let Some(length) = property.length else {
            return match value {
                Some(value) => self.number(property.scalar).map(|number| *value = number),
                None => self.skip(property.scalar, 1),
            }
            .map_err(|reason| reason.unwrap_or_else(missing));
        };
        let length = self.number(length).map_err(|reason| reason.unwrap_or_else(missing))?;
        if length.fract() != 0.0 || !(0.0..=MAX_ELEMENTS as f64).contains(&length) {
            return Err(format!("{length} is no length of a list"));
        }
        match list {
            Some(list) => {
                list.clear();
                (0..length as usize)
                    .try_for_each(|_| self.number(property.scalar).map(|number| list.push(number)))
            }
            None => self.skip(property.scalar, length as usize),
        }
        .map_err(|reason| reason.unwrap_or_else(missing))
    }

    /// The next number. An error without a reason is an end where it should be.
    fn number(&mut self, scalar: Scalar) -> std::result::Result<f64, Option<String>> {
        if self.encoding == Encoding::Ascii {
            let word = self.word().ok_or(None)?;
            return number(word).ok_or_else(|| Some(format!("{} is no number", quoted(word))));
        }
        let (bytes, rest) = self.rest.rest.split_at_checked(scalar.size()).ok_or(None)?;
        self.rest.rest = rest;
        Ok(decoded(scalar, bytes, self.encoding == Encoding::BigEndian))
    }

    fn skip(&mut self, scalar: Scalar, count: usize) -> std::result::Result<(), Option<String>> {
        if self.encoding == Encoding::Ascii {
            return (0..count).try_for_each(|_| self.word().map(drop).ok_or(None));
        }
        self.rest.rest = self.rest.rest.get(scalar.size() * count..).ok_or(None)?;
        Ok(())
    }
}

/// A name of the file in a message.
fn plain(name: &str) -> String {
    name.chars().take(40).flat_map(char::escape_debug).collect()
}

fn decoded(scalar: Scalar, bytes: &[u8], big_endian: bool) -> f64 {
    let mut number = [0; 8];
    number[..bytes.len()].copy_from_slice(bytes);
    if big_endian {
        number[..bytes.len()].reverse();
    }
    let [a, b, c, d, ..] = number;
    match scalar {
        Scalar::I8 => f64::from(a as i8),
        Scalar::U8 => f64::from(a),
        Scalar::I16 => f64::from(i16::from_le_bytes([a, b])),
        Scalar::U16 => f64::from(u16::from_le_bytes([a, b])),
        Scalar::I32 => f64::from(i32::from_le_bytes([a, b, c, d])),
        Scalar::U32 => f64::from(u32::from_le_bytes([a, b, c, d])),
        Scalar::F32 => f64::from(f32::from_le_bytes([a, b, c, d])),
        Scalar::F64 => f64::from_le_bytes(number),
    }
}
