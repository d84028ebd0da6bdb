//! What arrives before the main file of a method: the scene, its maps and its textures.

use super::targets::expect_drawable;
use super::{Light, Map, Mesh, Picture, Surface};
use crate::error::Result;
use crate::gpu::Gpu;
use crate::methods::Setup;
use crate::stream::{Arrival, decode_all};
use relume_formats::Place;
use relume_formats::bundle::{Maps, Settings, expect_lit, expect_textures};
use relume_formats::container::{Kind, Section};
use relume_formats::kinds::{Environment, StoredScene, Textures};

/// A scene and what shines on it, as far as it has arrived.
pub(crate) struct Surroundings {
    /// The scene.
    pub(crate) scene: StoredScene,
    /// What the manifest says of the method's settings.
    pub(crate) settings: Settings,
    size: [u32; 2],
    maps: Vec<Map>,
    /// What is known of them.
    known: Maps,
    /// The same for the CPU, if it is to work with them.
    environments: Vec<Environment>,
    keeps_environments: bool,
    textures: Option<Textures>,
    /// Sections of the file that is arriving.
    pending: Vec<Section>,
}

/// Whether files of this kind are for [`Surroundings::section_arrived`].
pub(crate) fn belongs(kind: Kind) -> bool {
    matches!(kind, Kind::Environment | Kind::Textures)
}

impl Surroundings {
    /// Those of `setup`, without maps yet; these are kept for [`Surroundings::take_environments`] if it
    /// `keeps_environments`.
    ///
    /// # Errors
    /// If films of the size that is asked for [cannot be drawn](expect_drawable).
    pub(crate) fn new(gpu: &Gpu, setup: Setup, keeps_environments: bool) -> Result<Self> {
        let size = setup.size.unwrap_or(setup.scene.meta.size);
        expect_drawable(gpu, size)?;
        Ok(Self {
            scene: setup.scene,
            settings: setup.settings,
            size,
            maps: Vec::new(),
            known: Maps::default(),
            environments: Vec::new(),
            keeps_environments,
            textures: None,
            pending: Vec::new(),
        })
    }

    /// The picture will have `size` pixels.
    ///
    /// # Errors
    /// If films of that size [cannot be drawn](expect_drawable).
    pub(crate) fn resize(&mut self, gpu: &Gpu, size: [u32; 2]) -> Result<()> {
        expect_drawable(gpu, size)?;
        self.size = size;
        Ok(())
    }

    /// Takes the next section of a file that [belongs] here.
    pub(crate) fn section_arrived(&mut self, gpu: &Gpu, arrival: Arrival) -> Result<()> {
        let (place, kind) = (arrival.section.place.clone(), arrival.kind);
        self.pending.push(arrival.section);
        if !arrival.last {
            return Ok(());
        }
        let sections = std::mem::take(&mut self.pending);
        if kind == Kind::Environment {
            return self.map_arrived(gpu, decode_all(sections)?, &place);
        }
        let textures: Textures = decode_all(sections)?;
        expect_textures(&textures, &self.scene, &place)?;
        self.textures = Some(textures);
        Ok(())
    }

    fn map_arrived(&mut self, gpu: &Gpu, environment: Environment, place: &Place) -> Result<()> {
        self.known.add(&environment, place)?;
        self.maps.push(Map::new(gpu, &environment));
        self.environments.extend(self.keeps_environments.then_some(environment));
        Ok(())
    }

    /// Files of different bakes can each be sound and yet not fit together: fails if the main file at
    /// `place`, with what it calls `what` for so many `vertices`, does not fit what came before it.
    pub(crate) fn expect_bake(&self, what: &str, vertices: u64, place: &Place) -> relume_formats::Result<()> {
        expect_lit(what, vertices, &self.scene, &self.known, self.textures.is_some(), place)
    }

    /// Names of the maps, in the order of their arrival.
    pub(crate) fn map_names(&self) -> Vec<String> {
        self.known.names().to_vec()
    }

    /// The maps for the CPU, if they were kept; that takes them away.
    pub(crate) fn take_environments(&mut self) -> Vec<Environment> {
        std::mem::take(&mut self.environments)
    }

    /// The light of the maps on faces of `face_size` texels a side, which takes them away; see [`Light::new`].
    pub(crate) fn light(&mut self, gpu: &Gpu, face_size: u32, with_whole: bool) -> Light {
        Light::new(gpu, std::mem::take(&mut self.maps), face_size, with_whole)
    }

    /// The picture of the meshes, whose surfaces look like `surface`, before the maps of `light`.
    pub(crate) fn picture(&self, gpu: &Gpu, surface: Surface, light: &Light) -> Picture {
        Picture::new(gpu, self.size, Mesh::new(gpu, &self.scene, self.textures.as_ref()), surface, light)
    }
}
