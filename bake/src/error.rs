//! What can end a bake.

use crate::interrupted::Interrupted;
use relume_formats::state::with_line;
use relume_formats::{Error, Place};

/// Shorthand for results of this crate.
pub type Result<T> = std::result::Result<T, BakeError>;

/// What memory is that the user allows.
pub(crate) const ALLOWED: &str = "allowed by --memory";

/// What can end a bake.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum BakeError {
    /// The user asked to stop.
    #[error(transparent)]
    Interrupted(#[from] Interrupted),
    /// A file could not be read or written, or holds something wrong.
    #[error(transparent)]
    File(#[from] Error),
    /// LAPACK failed.
    #[error("the BRDF basis could not be computed: {0}; choose another number of bases")]
    Algebra(#[from] ndarray_linalg::error::LinalgError),
    /// The work does not fit the machine.
    #[error(
        "this bake needs about {needed_mib} MiB of memory and {available_mib} MiB are {of_what}; {remedy}"
    )]
    Memory {
        /// Predicted need.
        needed_mib: u64,
        /// What there is.
        available_mib: u64,
        /// Whether that is free, or allowed.
        of_what: &'static str,
        /// What to do.
        remedy: &'static str,
    },
    /// Another process bakes into the same folder.
    #[error("{folder}: another bake is at work here{process}; wait for it, or bake elsewhere with -o")]
    Busy {
        /// The folder.
        folder: Place,
        /// " (process 123)", where that is known.
        process: String,
    },
    /// The work was stopped and can go on.
    #[error("{error}; {remedy}")]
    Kept {
        /// What stopped it.
        error: Box<BakeError>,
        /// That finished work is kept, and how to go on with it.
        remedy: &'static str,
    },
    /// Signals could not be watched.
    #[error("interrupts cannot be watched: {0}; another program holds the handler")]
    Signals(#[from] ctrlc::Error),
    /// The player could not be run, or failed.
    #[error("{0}")]
    Player(String),
    /// Threads could not be started.
    #[error("threads could not be started: {0}; lower --threads")]
    Threads(#[from] rayon::ThreadPoolBuildError),
}

impl BakeError {
    /// The process exit code: 130 interrupted, 2 bad input, 1 failed at run time.
    pub fn exit_code(&self) -> u8 {
        match self {
            Self::Interrupted(_) => 130,
            Self::File(error) if error.is_bad_input() => 2,
            Self::Memory { of_what: ALLOWED, .. } => 2,
            Self::Kept { error, .. } => error.exit_code(),
            _ => 1,
        }
    }

    /// This error with the `remedy` that goes with finished work, if it stopped work that `is_kept`.
    pub fn kept(self, is_kept: bool, remedy: &'static str) -> Self {
        // What was refused would be refused again.
        if !is_kept || self.exit_code() == 2 || matches!(self, Self::Busy { .. }) {
            return self;
        }
        Self::Kept { error: Box::new(self), remedy }
    }

    /// This error with the line of the scene, state or animation that it speaks of.
    pub fn with_line(self) -> Self {
        match self {
            Self::File(error) => Self::File(with_line(error)),
            other => other,
        }
    }

    /// Bad input, named with its place.
    pub fn invalid(place: &Place, reason: impl Into<String>) -> Self {
        Self::File(Error::invalid(place, reason))
    }
}
