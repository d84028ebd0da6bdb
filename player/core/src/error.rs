//! What can go wrong while playing.

/// Shorthand for results of this crate.
pub type Result<T> = std::result::Result<T, Error>;

/// What can go wrong while playing.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A file of the bundle, a state or an animation is not what it should be.
    #[error(transparent)]
    Format(#[from] relume_formats::Error),
    /// The caller asks for something impossible; the text says what to do instead.
    #[error("{0}")]
    Request(String),
    /// Nothing has arrived yet that could be drawn.
    #[error("nothing has arrived that could be rendered")]
    NothingThere,
}
