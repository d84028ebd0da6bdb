//! The files of a bundle, as they arrive: whole decoded sections in playback order.
//!
//! Wherever they come from, the player polls and is never kept waiting. So it meets a slow or short source in
//! one form only: sections that are late, or that do not come.

mod decode;
mod incoming;
mod playlist;

pub(crate) use decode::{decode_all, decode_sections};
pub use incoming::Incoming;
pub use playlist::{Item, Playlist};

use crate::error::Result;
use relume_formats::container::{Kind, Section};

/// Where the sections of a bundle come from.
pub trait Source {
    /// What has arrived since the last poll; never waits.
    ///
    /// # Errors
    /// If what comes is no part of the bundle, or nothing more can come.
    fn poll(&mut self) -> Result<Event>;
}

/// One section of one file.
#[derive(Debug)]
pub struct Arrival {
    /// What its file holds.
    pub kind: Kind,
    /// What the manifest calls that which its file holds, or the object that it is of; `None` for files of a
    /// method.
    pub name: Option<String>,
    /// The section, decoded and checked.
    pub section: Section,
    /// Whether it is the last one of its file.
    pub last: bool,
}

/// What a poll finds.
#[derive(Debug)]
pub enum Event {
    /// Nothing new yet.
    Waiting,
    /// The next section.
    Section(Arrival),
    /// Everything that will come has come.
    End {
        /// Whether that is the whole bundle, or the prefix that was asked for.
        complete: bool,
    },
}
