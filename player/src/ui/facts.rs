//! What the window tells about the player itself.

/// Something that can be saved.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Save {
    /// The picture as shown, without what the window draws over it.
    Png,
    /// Linear radiance.
    Exr,
    /// The settings, for `player --state`.
    State,
}

impl Save {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Png, Self::Exr, Self::State];

    /// What the file names end in.
    pub fn extension(self) -> &'static str {
        match self {
            Self::Png => "png",
            Self::Exr => "exr",
            Self::State => "toml",
        }
    }
}

/// How loading stands.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Loading {
    /// More is to come.
    Arriving,
    /// The whole bundle is there.
    Complete,
    /// The prefix that was asked for is there.
    Prefix,
    /// The rest will not come, for this reason.
    Failed(String),
    /// Nothing is drawn any more, for this reason.
    Stopped(String),
}

/// Figures about the player.
#[derive(Debug, Clone, PartialEq)]
pub struct Facts {
    /// Name of the GPU.
    pub adapter: String,
    /// Name of the method that plays.
    pub method: String,
    /// Film size in pixels, once known.
    pub size: Option<[u32; 2]>,
    /// Milliseconds of the CPU per frame, median over a second.
    pub cpu_ms: Option<f64>,
    /// Milliseconds of the GPU per frame, median over a second, where it tells.
    pub gpu_ms: Option<f64>,
    /// Bytes read.
    pub bytes: u64,
    /// Bytes of the whole bundle.
    pub bytes_expected: u64,
    /// What the pieces are called that the method sums up.
    pub what: &'static str,
    /// Pieces that have arrived.
    pub pieces: usize,
    /// All pieces.
    pub pieces_expected: usize,
    /// Whether the map that is shown is not one of the bundle's own.
    pub map_from_outside: bool,
    /// Whether another bake of the bundle is on disk than the one on show.
    pub rebaked: bool,
    /// How loading stands.
    pub loading: Loading,
}

/// What happened last: that something was done, or why it was not.
pub type Note = Result<String, String>;
