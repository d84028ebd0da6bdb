//! What can end a bake.

use crate::job::Interrupted;
use relume_formats::{Error, Place};

/// Shorthand for results of this crate.
pub type Result<T> = std::result::Result<T, BakeError>;

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
    #[error("this bake needs about {needed_mib} MiB of memory and {available_mib} MiB are free; {remedy}")]
    Memory {
        /// Predicted need.
        needed_mib: u64,
        /// Free at the start.
        available_mib: u64,
        /// What to do.
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
            _ => 1,
        }
    }

    /// Bad input, named with its place.
    pub fn invalid(place: &Place, reason: impl Into<String>) -> Self {
        Self::File(Error::invalid(place, reason))
    }
}
