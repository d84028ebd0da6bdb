//! A decoded section: its row of the table and its raw little-endian bytes.

use super::{Element, SectionInfo};
use crate::error::{Error, Place, Result};
use half::f16;

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
            Ok(self.bytes.chunks_exact(size_of::<$type>()).filter_map(|c| c.try_into().ok().map(<$type>::from_le_bytes)).collect())
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

    fn expect_element(&self, element: Element) -> Result<()> {
        if self.info.element != element {
            return Err(self.invalid(format!("holds {}, expected {}", self.info.element.name(), element.name())));
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

    /// An [`Error::Invalid`] that names this section.
    pub fn invalid(&self, reason: impl AsRef<str>) -> Error {
        Error::invalid(
            &self.place.part(format!("section `{}`", self.info.name)),
            format!("{}; the file is damaged, bake it again", reason.as_ref()),
        )
    }
}
