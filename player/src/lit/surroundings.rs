//! What arrives before the main file of a method: the scene, its maps and its textures.

use super::{Light, Map, Mesh, Picture};
use crate::error::{Error, Result};
use crate::gpu::Gpu;
use crate::methods::Setup;
use crate::stream::{Arrival, decode_all};
use relume_formats::container::{Kind, Section};
use relume_formats::kinds::{Environment, StoredScene, Textures, scene};
use relume_formats::{Error as FormatError, Place};

/// A scene and what shines on it, as far as it has arrived.
pub(crate) struct Surroundings {
    /// The scene.
    pub(crate) scene: StoredScene,
    size: [u32; 2],
    maps: Vec<Map>,
    /// The same for the CPU, if it is to work with them.
    environments: Vec<Environment>,
    textures: Option<Textures>,
    /// Sections of the file that is arriving.
    pending: Vec<Section>,
}

/// Whether files of this kind are for [`Surroundings::section_arrived`].
pub(crate) fn belongs(kind: Kind) -> bool {
    matches!(kind, Kind::Environment | Kind::Textures)
}

impl Surroundings {
    /// Those of `setup`, without maps yet.
    ///
    /// # Errors
    /// If the film would be too large.
    pub(crate) fn new(setup: Setup) -> Result<Self> {
        let size = setup.size.unwrap_or(setup.scene.meta.size);
        if !scene::is_legal_size(size) {
            let ([width, height], most) = (size, scene::MAX_PIXELS);
            return Err(Error::Usage(format!("--size {width}x{height} is too large; at most {most} pixels are drawn")));
        }
        Ok(Self { scene: setup.scene, size, maps: Vec::new(), environments: Vec::new(), textures: None, pending: Vec::new() })
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
        textures.expect_scene(self.scene.positions.len(), self.scene.meta.materials.len(), &place)?;
        self.textures = Some(textures);
        Ok(())
    }

    fn map_arrived(&mut self, gpu: &Gpu, environment: Environment, place: &Place) -> Result<()> {
        if self.maps.iter().any(|map| map.name == environment.name) {
            let reason = format!("is the second environment map called `{}`; bake it again", environment.name);
            return Err(FormatError::invalid(place, reason).into());
        }
        self.maps.push(Map::new(gpu, &environment));
        self.environments.extend(gpu.radiance_on_cpu.then_some(environment));
        gpu.check()
    }

    /// Files of different bakes can each be sound and yet not fit together: fails if the main file at `place`, with what it calls `what` for so many
    /// `vertices`, does not fit what came before it.
    pub(crate) fn expect_bake(&self, what: &str, vertices: u64, place: &Place) -> relume_formats::Result<()> {
        let refuse = |reason: String| Err(FormatError::invalid(place, format!("{reason}; bake the whole bundle again")));
        let there = self.scene.positions.len();
        if vertices != there as u64 {
            return refuse(format!("has {what} for {vertices} vertices of a scene of {there}"));
        }
        if self.textures.is_none() && self.scene.meta.materials.iter().any(|material| material.textured) {
            return refuse("needs the scene's textures before it".to_owned());
        }
        match &self.scene.meta.environment {
            None => refuse("needs an environment, and the scene has none".to_owned()),
            Some(look) if self.maps.iter().all(|map| map.name != look.map) => {
                refuse(format!("needs the scene's environment map `{}` before it", look.map))
            }
            Some(_) => Ok(()),
        }
    }

    /// Names of the maps, in the order of their arrival.
    pub(crate) fn map_names(&self) -> Vec<String> {
        self.maps.iter().map(|map| map.name.clone()).collect()
    }

    /// The maps for the CPU, if it is to work with them; that takes them away.
    pub(crate) fn take_environments(&mut self) -> Vec<Environment> {
        std::mem::take(&mut self.environments)
    }

    /// The light of the maps on faces of `face_size` texels a side, which takes them away.
    pub(crate) fn light(&mut self, gpu: &Gpu, face_size: u32) -> Light {
        Light::new(gpu, std::mem::take(&mut self.maps), face_size)
    }

    /// The picture of the meshes with `radiance` by vertex, before the maps of `light`.
    ///
    /// # Errors
    /// If the GPU cannot draw so wide a picture.
    pub(crate) fn picture(&self, gpu: &Gpu, radiance: &wgpu::Buffer, light: &Light) -> Result<Picture> {
        Picture::new(gpu, self.size, Mesh::new(gpu, &self.scene, self.textures.as_ref()), radiance, light)
    }
}
