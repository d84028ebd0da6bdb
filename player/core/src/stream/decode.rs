//! Files decoded from sections that have arrived one by one.

use crate::error::Result;
use relume_formats::Place;
use relume_formats::container::{Section, Sections, Stored};

/// Decodes a small file from all of its sections.
pub(crate) fn decode_all<T: Stored>(sections: Vec<Section>) -> Result<T> {
    let place = sections.first().map_or_else(|| Place::file(""), |section| section.place.clone());
    decode_sections(&place, sections, T::decode)
}

/// Decodes a part of the file at `place` from all of its sections.
pub(crate) fn decode_sections<T>(
    place: &Place,
    sections: Vec<Section>,
    decode: impl FnOnce(&mut Sections<'_>) -> relume_formats::Result<T>,
) -> Result<T> {
    let mut rest = sections.into_iter();
    let mut next = || Ok(rest.next());
    let mut sections = Sections { place: place.clone(), next: &mut next };
    let value = decode(&mut sections)?;
    sections.finish()?;
    Ok(value)
}
