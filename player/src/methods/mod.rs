//! The methods that this player knows, one folder each: the GPU twin of the method's file in `relume_formats::evaluate`.
//!
//! A method is a [`Playback`] and a line in [`METHODS`]; nothing else in the player knows one from another.

mod sparse_transfer;
mod sphere_shadows;
mod transfer_images;

use crate::controls::Look;
use crate::error::{Error, Result};
use crate::gpu::{Film, Gpu, Passes};
use crate::stream::Arrival;
use relume_formats::bundle::Settings;
use relume_formats::kinds::StoredScene;
use relume_formats::kinds::transfer_images::Head;
use relume_formats::method::Card;
use relume_formats::state::Rgb;
use relume_formats::{Error as FormatError, Place};

/// Every method that this player knows.
pub const METHODS: [Method; 3] = [transfer_images::METHOD, sparse_transfer::METHOD, sphere_shadows::METHOD];

/// A method's line in the registry.
#[derive(Clone, Copy)]
pub struct Method {
    /// What there is to say of it.
    pub card: &'static Card,
    /// Whether it can do its sums on the CPU, as the adapter `cpu` asks for.
    pub on_cpu: bool,
    /// Begins to play.
    pub start: fn(&Gpu, Setup) -> Result<Box<dyn Playback>>,
}

/// What there is before the first file of a method arrives.
pub struct Setup {
    /// The scene.
    pub scene: StoredScene,
    /// Its file.
    pub place: Place,
    /// What the manifest says of the method's settings.
    pub settings: Settings,
    /// Size of the film that the user asks for, in pixels.
    pub size: Option<[u32; 2]>,
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

/// A method at work: what has arrived of a bake, on its way to and on the GPU. Its pieces arrive in order of importance, and it plays from the
/// first one on.
pub trait Playback {
    /// Takes the next section of one of the method's files, which come in the order of the manifest.
    ///
    /// # Errors
    /// If the section is malformed, does not fit those before it, or is more than the GPU can bind.
    fn section_arrived(&mut self, gpu: &Gpu, arrival: Arrival) -> Result<()>;

    /// Names of the environment maps to choose from, the scene's own first, as soon as no more can come.
    fn maps(&self) -> Option<Vec<String>>;

    /// What has arrived.
    fn pieces(&self) -> Pieces;

    /// What frames are drawn on, once its size is known.
    fn film(&self) -> Option<&Film>;

    /// The materials that every pixel shows, where the view is fixed.
    fn pixels(&self) -> Option<&Head> {
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

    /// Waits for the frame, and returns the radiance of a white diffuse surface at every vertex of the scene, W/(sr·m²).
    ///
    /// # Errors
    /// If the method knows nothing of vertices.
    fn vertex_radiance(&self, _: &Gpu) -> Result<Vec<Rgb>> {
        Err(Error::Usage("this method computes no radiance at vertices; choose another with --method".to_owned()))
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

    /// Fails if `gpu` is to leave the sums to the CPU and this method cannot.
    pub fn expect_adapter(&self, gpu: &Gpu) -> Result<()> {
        if self.on_cpu || !gpu.radiance_on_cpu {
            return Ok(());
        }
        let able: Vec<_> = METHODS.iter().filter(|method| method.on_cpu).map(|method| method.card.name).collect();
        let (name, able) = (self.card.name, able.join(", "));
        Err(Error::Usage(format!(
            "--adapter cpu is for the method {able}, not {name}; choose another adapter, --list-adapters tells which"
        )))
    }

    /// The error that a file of this kind does not belong to the method, or not in this place.
    fn has_no_use_for(&self, arrival: &Arrival) -> Error {
        let reason = format!("method {} has no use for kind `{}` here; bake it again", self.card.name, arrival.kind.name());
        FormatError::invalid(&arrival.section.place, reason).into()
    }
}

#[cfg(test)]
mod tests {
    use naga::valid::{Capabilities, ValidationFlags, Validator};
    use std::path::{Path, PathBuf};

    fn shaders(folder: &Path, found: &mut Vec<PathBuf>) {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                shaders(&path, found);
            } else if path.extension().is_some_and(|e| e == "wgsl") {
                found.push(path);
            }
        }
    }

    #[test]
    fn every_shader_is_valid_without_optional_features() {
        let mut found = Vec::new();
        shaders(&Path::new(env!("CARGO_MANIFEST_DIR")).join("src"), &mut found);
        assert!(!found.is_empty());
        for path in found {
            let text = std::fs::read_to_string(&path).unwrap();
            let module = naga::front::wgsl::parse_str(&text)
                .unwrap_or_else(|e| panic!("{}", e.emit_to_string_with_path(&text, &path.display().to_string())));
            // `unpack2x16float` is part of WebGPU, though naga knows devices below it.
            Validator::new(ValidationFlags::all(), Capabilities::SHADER_FLOAT16_IN_FLOAT32)
                .validate(&module)
                .unwrap_or_else(|e| panic!("{}", e.emit_to_string_with_path(&text, &path.display().to_string())));
        }
    }
}
