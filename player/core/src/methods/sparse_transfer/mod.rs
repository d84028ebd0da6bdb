//! Method `sparse-transfer` on the GPU: the radiance of every vertex is a sum over its columns of value ×
//! coefficient of the light, and the meshes are drawn with it.
//!
//! Columns arrive in blocks, the most important first; a picture comes from those that are there. What a
//! frame costs depends on what has changed: the map or its rotation ask for a new light and a new sum, new
//! columns for a new sum, camera and gain for neither. The gain is a factor on every sum, so it is applied
//! where the picture is drawn.

mod columns;
mod gpu_data;
mod stage;
mod storage;

use super::{Method, Pieces, Playback, Setup};
use crate::controls::Look;
use crate::error::Result;
use crate::gpu::{Film, Gpu, Passes};
use crate::lit::{Surface, Surroundings, belongs};
use crate::stream::{Arrival, decode_sections};
use relume_formats::Place;
use relume_formats::container::{Kind, Section};
use relume_formats::kinds::Environment;
use relume_formats::kinds::sparse_transfer::{BLOCK_SECTIONS, Meta};
use relume_formats::state::Rgb;
use stage::Stage;

/// The method's line in the registry.
pub const METHOD: Method = Method {
    card: &relume_formats::method::SPARSE_TRANSFER,
    on_cpu: false,
    resizes: true,
    start: |gpu, setup| Ok(Box::new(SparseTransfer::new(gpu, setup)?)),
};

const ACCUMULATE: &str = include_str!("accumulate.wgsl");

/// What has arrived of a bake, on its way to and on the GPU.
struct SparseTransfer {
    /// What waits for the rows.
    waiting: Option<Surroundings>,
    /// Sections of the block that is arriving.
    pending: Vec<Section>,
    /// Names of the maps, as soon as the rows come.
    maps: Option<Vec<String>>,
    stage: Option<Stage>,
}

impl SparseTransfer {
    fn new(gpu: &Gpu, setup: Setup) -> Result<Self> {
        Ok(Self {
            waiting: Some(Surroundings::new(gpu, setup, false)?),
            pending: Vec::new(),
            maps: None,
            stage: None,
        })
    }

    fn rows_arrived(&mut self, gpu: &Gpu, arrival: Arrival) -> Result<()> {
        let (place, last) = (arrival.section.place.clone(), arrival.last);
        self.pending.push(arrival.section);
        let Some(stage) = &mut self.stage else {
            let meta = decode_sections(&place, std::mem::take(&mut self.pending), Meta::decode)?;
            let Some(waiting) = self.waiting.take() else { return Ok(()) };
            waiting.expect_bake("rows", meta.vertices.into(), &place)?;
            waiting.settings.expect_rows(&meta)?;
            self.maps = Some(waiting.map_names());
            self.stage = Some(set_up(gpu, waiting, meta, &place)?);
            return Ok(());
        };
        let number = stage.columns().blocks_arrived();
        let meta = stage.columns().meta();
        if self.pending.len() < BLOCK_SECTIONS && !last {
            return Ok(());
        }
        let block = decode_sections(&place, std::mem::take(&mut self.pending), |sections| {
            meta.decode_block(number, sections)
        })?;
        stage.block_arrived(gpu, &block);
        Ok(())
    }
}

fn set_up(gpu: &Gpu, mut surroundings: Surroundings, meta: Meta, place: &Place) -> Result<Stage> {
    let light = surroundings.light(gpu, meta.face_size, meta.bounces > 0);
    let columns = columns::Columns::new(gpu, meta, light.coefficients(), place)?;
    let picture = surroundings.picture(gpu, Surface::diffuse(columns.radiance()), &light);
    Ok(Stage::new(light, columns, picture))
}

impl Playback for SparseTransfer {
    fn section_arrived(&mut self, gpu: &Gpu, arrival: Arrival) -> Result<()> {
        match (&mut self.waiting, arrival.kind) {
            (_, Kind::SparseTransfer) => self.rows_arrived(gpu, arrival),
            (Some(waiting), kind) if belongs(kind) => waiting.section_arrived(gpu, arrival),
            _ => Err(METHOD.has_no_use_for(&arrival)),
        }
    }

    fn maps(&self) -> Option<Vec<String>> {
        self.maps.clone()
    }

    fn add_map(&mut self, gpu: &Gpu, map: &Environment) {
        if let Some(stage) = &mut self.stage {
            stage.add_map(gpu, map);
        }
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

    fn resize(&mut self, gpu: &Gpu, size: [u32; 2]) -> Result<()> {
        match (&mut self.stage, &mut self.waiting) {
            (Some(stage), _) => stage.picture.resize(gpu, size),
            (None, Some(waiting)) => waiting.resize(gpu, size),
            (None, None) => Ok(()),
        }
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

    fn vertex_radiance(&self) -> Option<(&wgpu::Buffer, Rgb)> {
        self.stage.as_ref().map(Stage::vertex_radiance)
    }
}

#[cfg(test)]
mod tests;
