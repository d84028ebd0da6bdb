//! One error type for the player, with the exit code that each error leads to.

/// Shorthand for results of this crate.
pub type Result<T> = std::result::Result<T, Error>;

/// What can go wrong while playing.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A file could not be read, understood or written.
    #[error(transparent)]
    Format(#[from] relume_formats::Error),
    /// The command line asks for something impossible; the text says what to do instead.
    #[error("{0}")]
    Usage(String),
    /// The machine failed: no adapter, out of memory, a lost device.
    #[error("{0}")]
    Failed(String),
    /// The user asked to stop.
    #[error("interrupted; every file written so far is whole")]
    Interrupted,
}

impl From<relume_playback::Error> for Error {
    fn from(error: relume_playback::Error) -> Self {
        match error {
            relume_playback::Error::Format(error) => Self::Format(error),
            relume_playback::Error::Request(reason) => Self::Usage(reason),
            other => Self::Failed(other.to_string()),
        }
    }
}

impl Error {
    /// This error with the line of the state or animation that it speaks of.
    pub fn with_line(self) -> Self {
        match self {
            Self::Format(error) => Self::Format(relume_formats::state::with_line(error)),
            other => other,
        }
    }

    /// The exit code of the program: 1 failed at run time, 2 wrong usage or bad input, 130 interrupted.
    pub fn exit_code(&self) -> u8 {
        match self {
            Self::Format(error) if error.is_bad_input() => 2,
            Self::Format(_) | Self::Failed(_) => 1,
            Self::Usage(_) => 2,
            Self::Interrupted => 130,
        }
    }
}
