//! The methods that this player knows, one folder each: the GPU twin of the method's file in
//! `relume_formats::evaluate`.
//!
//! A method is a [`Playback`] and a line in [`METHODS`]; nothing else in the player knows one from another.

mod sparse_transfer;
mod sphere_shadows;
mod transfer_images;
mod transfer_tensor;

use crate::controls::Look;
use crate::error::{Error, Result};
use crate::gpu::{Film, Gpu, Passes};
use crate::materials::MaterialMap;
use crate::stream::Arrival;
use relume_formats::Error as FormatError;
use relume_formats::bundle::Settings;
use relume_formats::kinds::{Environment, StoredScene};
use relume_formats::method::Card;
use relume_formats::state::Rgb;

/// Every method that this player knows.
pub const METHODS: [Method; 4] =
    [transfer_images::METHOD, sparse_transfer::METHOD, transfer_tensor::METHOD, sphere_shadows::METHOD];

/// A method's line in the registry.
#[derive(Debug, Clone, Copy)]
pub struct Method {
    /// What there is to say of it.
    pub card: &'static Card,
    /// Whether it can do its sums on the CPU, as the adapter `cpu` asks for.
    pub on_cpu: bool,
    /// Whether its frames can be drawn at any size, and not only at that of the scene.
    pub resizes: bool,
    /// Begins to play.
    pub(crate) start: fn(&Gpu, Setup) -> Result<Box<dyn Playback>>,
}

/// What there is before the first file of a method arrives.
pub(crate) struct Setup {
    /// The scene.
    pub(crate) scene: StoredScene,
    /// What the manifest says of the method's settings.
    pub(crate) settings: Settings,
    /// Size of the film that the caller asks for, in pixels.
    pub(crate) size: Option<[u32; 2]>,
}

/// How much has arrived of what a method sums up.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Pieces {
    /// What they are called, in the plural.
    pub what: &'static str,
    /// How many there will be; 0 while that is not known.
    pub expected: usize,
    /// Which of them have not arrived.
    pub missing: Vec<usize>,
    /// Bytes of them that a frame reads at most.
    pub bytes_per_frame: u64,
}

/// A method at work: what has arrived of a bake, on its way to and on the GPU. Its pieces arrive in order of
/// importance, and it plays from the first one on.
pub(crate) trait Playback: Send {
    /// Takes the next section of one of the method's files, which come in the order of the manifest.
    ///
    /// # Errors
    /// If the section is malformed, does not fit those before it, or is more than the GPU can bind.
    fn section_arrived(&mut self, gpu: &Gpu, arrival: Arrival) -> Result<()>;

    /// Names of the environment maps to choose from, the scene's own first, as soon as no more can come.
    fn maps(&self) -> Option<Vec<String>>;

    /// Adds an environment map, or puts it in the place of the one that has its name, once [`Playback::maps`]
    /// tells of some; of a method whose light does not vary there is nothing to add to.
    fn add_map(&mut self, _: &Gpu, _: &Environment) {}

    /// What has arrived.
    fn pieces(&self) -> Pieces;

    /// What frames are drawn on, once its size is known.
    fn film(&self) -> Option<&Film>;

    /// Draws frames of `size` pixels from now on, and makes nothing anew that does not depend on that.
    ///
    /// # Errors
    /// If such frames cannot be drawn, or are baked at another size. Then nothing has changed.
    fn resize(&mut self, gpu: &Gpu, size: [u32; 2]) -> Result<()>;

    /// The material that every pixel shows, where the view is fixed.
    fn materials(&self) -> Option<MaterialMap> {
        None
    }

    /// Where the vertices of the scene are, metres in world space, if they move at all.
    fn moving_vertices(&self) -> Option<Vec<[f32; 3]>> {
        None
    }

    /// Sets how things look in the frames encoded from now on.
    fn update(&mut self, gpu: &Gpu, look: &Look) -> Result<()>;

    /// Encodes the passes that fill the film, as far as what has changed since the last frame asks for them.
    fn encode(&mut self, passes: &mut Passes<'_>);

    /// By vertex of the scene, four floats of which the last is unused: the radiance of a white diffuse
    /// surface there, W/(sr·m²), and a factor on all of it; `None` if the method knows nothing of vertices.
    fn vertex_radiance(&self) -> Option<(&wgpu::Buffer, Rgb)> {
        None
    }
}

impl Pieces {
    /// How many have arrived.
    pub fn arrived(&self) -> usize {
        self.expected.saturating_sub(self.missing.len())
    }
}

impl Method {
    /// The method called `name`.
    pub fn find(name: &str) -> Option<Self> {
        METHODS.into_iter().find(|method| method.card.name == name)
    }

    /// The error that a file of this kind does not belong to the method, or not in this place.
    fn has_no_use_for(&self, arrival: &Arrival) -> Error {
        let reason = format!(
            "method {} has no use for kind `{}` here; bake it again",
            self.card.name,
            arrival.kind.name()
        );
        FormatError::invalid(&arrival.section.place, reason).into()
    }
}
