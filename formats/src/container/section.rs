//! A decoded section: its row of the table and its raw little-endian bytes.

use super::{Element, SectionInfo};
use crate::error::{Error, Place, Result};
use half::f16;

/// What a section is, and what to do about it, if it is not as it should be.
pub(super) const DAMAGED: &str = "; the file is damaged, bake it again";

/// One decoded section.
#[derive(Debug, Clone)]
pub struct Section {
    /// The file it came from.
    pub place: Place,
    /// Its row of the table.
    pub info: SectionInfo,
    /// Exactly `info.raw_bytes` bytes, little-endian.
    pub bytes: Vec<u8>,
}

macro_rules! typed {
    ($(#[$doc:meta])* $name:ident, $type:ty, $element:ident) => {
        $(#[$doc])*
        pub fn $name(&self) -> Result<Vec<$type>> {
            self.expect_element(Element::$element)?;
            Ok(self.bytes.as_chunks().0.iter().map(|bytes| <$type>::from_le_bytes(*bytes)).collect())
        }
    };
}

impl Section {
    typed!(
        /// The elements, which must be stored as `u8`.
        u8s, u8, U8
    );
    typed!(
        /// The elements, which must be stored as `i8`.
        i8s, i8, I8
    );
    typed!(
        /// The elements, which must be stored as `i16`.
        i16s, i16, I16
    );
    typed!(
        /// The elements, which must be stored as `u16`.
        u16s, u16, U16
    );
    typed!(
        /// The elements, which must be stored as `u32`.
        u32s, u32, U32
    );
    typed!(
        /// The elements, which must be stored as half floats.
        f16s, f16, F16
    );
    typed!(
        /// The elements, which must be stored as `f32`.
        f32s, f32, F32
    );

    /// Rows of `N` floats, which the shape must say.
    pub fn f32_rows<const N: usize>(&self) -> Result<Vec<[f32; N]>> {
        self.expect_element(Element::F32)?;
        self.expect_shape(&[self.bytes.len() as u64 / (4 * N as u64), N as u64])?;
        Ok(self
            .bytes
            .as_chunks::<4>()
            .0
            .as_chunks::<N>()
            .0
            .iter()
            .map(|row| row.map(f32::from_le_bytes))
            .collect())
    }

    /// Rows of `N` indices, which the shape must say.
    pub fn u32_rows<const N: usize>(&self) -> Result<Vec<[u32; N]>> {
        self.expect_element(Element::U32)?;
        self.expect_shape(&[self.bytes.len() as u64 / (4 * N as u64), N as u64])?;
        Ok(self
            .bytes
            .as_chunks::<4>()
            .0
            .as_chunks::<N>()
            .0
            .iter()
            .map(|row| row.map(u32::from_le_bytes))
            .collect())
    }

    fn expect_element(&self, element: Element) -> Result<()> {
        if self.info.element != element {
            return Err(self.invalid(format!(
                "holds {}, expected {}",
                self.info.element.name(),
                element.name()
            )));
        }
        Ok(())
    }

    /// Fails unless the shape is exactly `shape`.
    pub fn expect_shape(&self, shape: &[u64]) -> Result<()> {
        if self.info.shape != shape {
            return Err(self.invalid(format!("has shape {:?}, expected {shape:?}", self.info.shape)));
        }
        Ok(())
    }

    /// The single dimension of a one-dimensional section.
    pub fn length(&self) -> Result<u64> {
        match self.info.shape[..] {
            [n] => Ok(n),
            _ => Err(self.invalid(format!("has shape {:?}, expected one dimension", self.info.shape))),
        }
    }

    /// Decodes a small record that [`super::Writer::record`] wrote.
    pub fn record<T: serde::de::DeserializeOwned>(&self) -> Result<T> {
        self.expect_element(Element::U8)?;
        let (value, used) = bincode::serde::decode_from_slice(&self.bytes, super::write::record_config())
            .map_err(|e| self.invalid(format!("is malformed ({e})")))?;
        if used != self.bytes.len() {
            return Err(self.invalid("has bytes left over"));
        }
        Ok(value)
    }

    /// Fails unless every value is finite.
    pub fn expect_finite(&self, values: &[f32]) -> Result<()> {
        match values.iter().position(|v| !v.is_finite()) {
            None => Ok(()),
            Some(at) => Err(self.invalid(format!("element {at} is not a finite number"))),
        }
    }

    /// Fails unless every value is finite and its size at most `most`.
    pub fn expect_at_most(&self, values: &[f32], most: f32) -> Result<()> {
        self.expect_finite(values)?;
        match values.iter().position(|v| v.abs() > most) {
            None => Ok(()),
            Some(at) => Err(self.invalid(format!(
                "element {at}, {:?}, is beyond {most:?}, the most that makes sense",
                values[at]
            ))),
        }
    }

    /// Fails with `fault` if there is one.
    pub fn expect(&self, fault: Option<String>) -> Result<()> {
        fault.map_or(Ok(()), |fault| Err(self.invalid(fault)))
    }

    /// Fails as `check` does, to which it gives the place of this section.
    pub fn expect_valid(&self, check: impl FnOnce(&Place) -> Result<()>) -> Result<()> {
        check(&self.place.part(format!("section `{}`", self.info.name))).map_err(|error| match error {
            Error::Invalid { place, reason } => Error::Invalid { place, reason: reason + DAMAGED },
            other => other,
        })
    }

    /// An [`Error::Invalid`] that names this section.
    pub fn invalid(&self, reason: impl AsRef<str>) -> Error {
        Error::invalid(
            &self.place.part(format!("section `{}`", self.info.name)),
            format!("{}{DAMAGED}", reason.as_ref()),
        )
    }
}
