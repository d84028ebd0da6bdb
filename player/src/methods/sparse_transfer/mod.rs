//! Method `sparse-transfer` on the GPU: the radiance of every vertex is a sum over its columns of value × coefficient of the light, and the
//! meshes are drawn with it.
//!
//! Columns arrive in blocks, the most important first; a picture comes from those that are there. What a frame costs depends on what has
//! changed: the map or its rotation ask for a new light and a new sum, new columns for a new sum, camera and gain for neither. The gain is
//! a factor on every sum, so it is applied where the picture is drawn.

mod columns;
mod gpu_data;
mod light;
mod mesh;
mod picture;
mod stage;
mod storage;

use super::{Method, Pieces, Playback, Setup};
use crate::controls::Look;
use crate::error::Result;
use crate::gpu::{Film, Gpu, Passes};
use crate::stream::{Arrival, decode_all, decode_sections};
use light::{Light, Map};
use relume_formats::container::{Kind, Section};
use relume_formats::kinds::sparse_transfer::{BLOCK_SECTIONS, Meta};
use relume_formats::kinds::{Environment, StoredScene, Textures};
use relume_formats::state::Rgb;
use relume_formats::{Error as FormatError, Place};
use stage::Stage;

/// The method's line in the registry.
pub const METHOD: Method = Method {
    name: "sparse-transfer",
    kind: Kind::SparseTransfer,
    // Behind the meta.
    first_piece: BLOCK_SECTIONS,
    start: |_, setup| Ok(Box::new(SparseTransfer::new(setup)?)),
};

const ENVIRONMENT: &str = include_str!("environment.wgsl");
const HAAR: &str = include_str!("haar.wgsl");
const ACCUMULATE: &str = include_str!("accumulate.wgsl");
const DRAW: &str = include_str!("draw.wgsl");
const AVERAGE: &str = include_str!("average.wgsl");

/// What has arrived of a bake, on its way to and on the GPU.
struct SparseTransfer {
    /// What waits for the rows.
    waiting: Option<Waiting>,
    /// Sections of the file or block that is arriving.
    pending: Vec<Section>,
    /// Names of the maps, as soon as the rows come.
    maps: Option<Vec<String>>,
    stage: Option<Stage>,
}

/// Everything that comes before the rows.
struct Waiting {
    scene: StoredScene,
    size: [u32; 2],
    maps: Vec<Map>,
    textures: Option<Textures>,
}

impl SparseTransfer {
    fn new(setup: Setup) -> Result<Self> {
        let size = setup.size.unwrap_or(setup.scene.meta.size);
        if !relume_formats::kinds::scene::is_legal_size(size) {
            let most = relume_formats::kinds::scene::MAX_PIXELS;
            return Err(crate::error::Error::Usage(format!(
                "--size {}x{} is too large; at most {most} pixels are drawn",
                size[0], size[1]
            )));
        }
        let waiting = Waiting { scene: setup.scene, size, maps: Vec::new(), textures: None };
        Ok(Self { waiting: Some(waiting), pending: Vec::new(), maps: None, stage: None })
    }

    fn rows_arrived(&mut self, gpu: &Gpu, arrival: Arrival) -> Result<()> {
        let (place, last) = (arrival.section.place.clone(), arrival.last);
        self.pending.push(arrival.section);
        let Some(stage) = &mut self.stage else {
            let meta = decode_sections(&place, std::mem::take(&mut self.pending), Meta::decode)?;
            let Some(waiting) = self.waiting.take() else { return Ok(()) };
            waiting.expect_bake(&meta, &place)?;
            self.maps = Some(waiting.maps.iter().map(|map| map.name.clone()).collect());
            self.stage = Some(waiting.set_up(gpu, meta, &place)?);
            return gpu.check();
        };
        let number = stage.columns().blocks_arrived();
        let meta = stage.columns().meta();
        if self.pending.len() < BLOCK_SECTIONS && !last {
            return Ok(());
        }
        let block = decode_sections(&place, std::mem::take(&mut self.pending), |sections| meta.decode_block(number, sections))?;
        stage.block_arrived(gpu, &block);
        gpu.check()
    }
}

impl Waiting {
    fn map_arrived(&mut self, gpu: &Gpu, environment: &Environment, place: &Place) -> Result<()> {
        if self.maps.iter().any(|map| map.name == environment.name) {
            let reason = format!("is the second environment map called `{}`; bake it again", environment.name);
            return Err(FormatError::invalid(place, reason).into());
        }
        self.maps.push(Map::new(gpu, environment));
        gpu.check()
    }

    /// Files of different bakes can each be sound and yet not fit together.
    fn expect_bake(&self, meta: &Meta, place: &Place) -> relume_formats::Result<()> {
        let refuse = |reason: String| Err(FormatError::invalid(place, format!("{reason}; bake the whole bundle again")));
        let vertices = self.scene.positions.len();
        if meta.vertices as usize != vertices {
            return refuse(format!("has rows for {} vertices of a scene of {vertices}", meta.vertices));
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

    fn set_up(self, gpu: &Gpu, meta: Meta, place: &Place) -> Result<Stage> {
        let light = Light::new(gpu, self.maps, meta.face_size);
        let columns = columns::Columns::new(gpu, meta, place)?;
        let mesh = mesh::Mesh::new(gpu, &self.scene, self.textures.as_ref());
        let picture = picture::Picture::new(gpu, self.size, mesh, columns.radiance(), &light)?;
        Ok(Stage::new(gpu, light, columns, picture))
    }
}

impl Playback for SparseTransfer {
    fn section_arrived(&mut self, gpu: &Gpu, arrival: Arrival) -> Result<()> {
        let small = |kind| matches!(kind, Kind::Environment | Kind::Textures);
        let place = arrival.section.place.clone();
        match (&mut self.waiting, arrival.kind) {
            (_, Kind::SparseTransfer) => self.rows_arrived(gpu, arrival),
            (Some(_), kind) if small(kind) && !arrival.last => {
                self.pending.push(arrival.section);
                Ok(())
            }
            (Some(waiting), kind) if small(kind) => {
                self.pending.push(arrival.section);
                let sections = std::mem::take(&mut self.pending);
                if kind == Kind::Environment {
                    return waiting.map_arrived(gpu, &decode_all(sections)?, &place);
                }
                let textures: Textures = decode_all(sections)?;
                textures.expect_scene(waiting.scene.positions.len(), waiting.scene.meta.materials.len(), &place)?;
                waiting.textures = Some(textures);
                Ok(())
            }
            _ => Err(METHOD.has_no_use_for(&arrival)),
        }
    }

    fn maps(&self) -> Option<Vec<String>> {
        self.maps.clone()
    }

    fn pieces(&self) -> Pieces {
        let mut pieces = Pieces { what: "blocks", ..Pieces::default() };
        if let Some(stage) = &self.stage {
            let (columns, expected) = (stage.columns(), stage.columns().meta().blocks.len());
            (pieces.expected, pieces.missing) = (expected, (columns.blocks_arrived()..expected).collect());
            pieces.bytes_per_frame = columns.bytes();
        }
        pieces
    }

    fn film(&self) -> Option<&Film> {
        self.stage.as_ref().map(Stage::film)
    }

    fn update(&mut self, gpu: &Gpu, look: &Look) -> Result<()> {
        if let Some(stage) = &mut self.stage {
            stage.update(gpu, look);
        }
        Ok(())
    }

    fn encode(&mut self, passes: &mut Passes<'_>) {
        if let Some(stage) = &mut self.stage {
            stage.encode(passes);
        }
    }

    fn vertex_radiance(&self, gpu: &Gpu) -> Result<Vec<Rgb>> {
        self.stage.as_ref().map_or(Ok(Vec::new()), |stage| stage.vertex_radiance(gpu))
    }
}

#[cfg(test)]
mod tests;
