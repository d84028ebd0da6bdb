//! The files of a playlist on disk.

use super::throttle::{Pace, Throttle};
use crate::error::Result;
use relume_formats::container::open;
use relume_formats::kinds::manifest::{FILE_NAME, of_listed};
use relume_formats::{Error as FormatError, open_regular};
use relume_playback::{Item, Playlist};
use std::fs::File;

/// Length of the shortest prefix that shows anything: every small file, and the main one up to its first
/// piece.
pub(super) fn least_bytes(playlist: &Playlist) -> Result<u64> {
    let (mut start, mut needed) = (0, 0);
    for item in &playlist.items {
        needed = start + least_bytes_of(item, playlist)?;
        start += item.bytes;
    }
    Ok(needed)
}

fn least_bytes_of(item: &Item, playlist: &Playlist) -> Result<u64> {
    if Some(item.kind) != playlist.method.card.main() {
        return Ok(item.bytes);
    }
    let reader = open(&item.place.file).map_err(|error| of_listed(error, &item.place))?;
    let last_needed = reader.header().sections.get(playlist.method.card.first_piece);
    Ok(last_needed.map_or(item.bytes, |info| info.offset + info.stored_bytes))
}

/// Opens a file, which must be as long as the manifest says.
pub(super) fn open_item<'a>(item: &Item, pace: &'a mut Pace) -> relume_formats::Result<Throttle<'a, File>> {
    let place = &item.place;
    let file = open_regular(&place.file).map_err(|error| of_listed(error, place))?;
    let length = file.metadata().map_err(|e| FormatError::io(place, e))?.len();
    if length != item.bytes {
        let reason = format!(
            "has {length} bytes where {FILE_NAME} says {}; it is cut short or of another bake, bake it again",
            item.bytes
        );
        return Err(FormatError::invalid(place, reason));
    }
    Ok(Throttle::new(file, pace))
}
