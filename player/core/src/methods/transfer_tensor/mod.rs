//! Method `transfer-tensor` on the GPU: every vertex receives direct light and light that was reflected once or
//! twice, by the materials as they are, and shows the eye what its own material makes of it.
//!
//! What a frame costs depends on what has changed. The light is transformed and multiplied with blocks ([`direct`])
//! and clusters ([`once`]); materials come in where clusters' functions meet at vertices ([`once`], [`twice`]); all
//! that a vertex receives is gathered in the columns of its BRDF space, which tell what of it goes towards the eye
//! ([`shown`]); what highlights have of the map itself every point that is drawn looks up in cones. A map or its rotation asks for all of it, a
//! material for all but the sums under the light, the camera for the last pass alone.
//!
//! Blocks arrive the most important first, with the first what vertices see, then reflected light; any prefix
//! plays.

mod bands;
mod blurs;
mod clusters;
mod direct;
mod dispatches;
mod gpu_data;
mod once;
mod shown;
mod stage;
mod tables;
mod twice;

use super::{Method, Pieces, Playback, Setup};
use crate::controls::Look;
use crate::error::Result;
use crate::gpu::{Film, Gpu, Passes};
use crate::lit::{Surroundings, belongs};
use crate::stream::{Arrival, decode_all, decode_sections};
use gpu_data::MAX_CONES;
use relume_formats::bundle::expect_spaces;
use relume_formats::container::{Kind, Section};
use relume_formats::kinds::transfer_tensor::{BLOCK_SECTIONS, Meta, ONCE_SECTIONS, TWICE_SECTIONS};
use relume_formats::kinds::{BrdfTensor, Environment};
use relume_formats::state::Rgb;
use relume_formats::{Error as FormatError, Place};
use stage::{Stage, Waiting};

/// The method's line in the registry.
pub const METHOD: Method = Method {
    card: &relume_formats::method::TRANSFER_TENSOR,
    on_cpu: false,
    resizes: true,
    start: |gpu, setup| Ok(Box::new(TransferTensor::new(gpu, setup)?)),
};

const DIRECT: &str = include_str!("direct.wgsl");
const PROJECT: &str = include_str!("project.wgsl");
const CORE: &str = include_str!("core.wgsl");
const BOUNCE: &str = include_str!("bounce.wgsl");
const PAIRS: &str = include_str!("pairs.wgsl");
const SECOND: &str = include_str!("second.wgsl");
const GATHER: &str = include_str!("gather.wgsl");
const LOOK: &str = include_str!("look.wgsl");
const GLOSSY: &str = include_str!("glossy.wgsl");

/// What has arrived of a bake, on its way to and on the GPU.
struct TransferTensor {
    /// What waits for the main file.
    waiting: Option<Waiting>,
    /// Sections of the piece that is arriving.
    pending: Vec<Section>,
    /// What of the main file comes next.
    next: Piece,
    /// Names of the maps, as soon as the main file comes.
    maps: Option<Vec<String>>,
    stage: Option<Stage>,
}

/// A part of the main file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Piece {
    Meta,
    Block(usize),
    Seen,
    Once,
    Twice,
}

impl Piece {
    fn sections(self) -> usize {
        match self {
            Self::Meta | Self::Seen => 1,
            Self::Block(_) => BLOCK_SECTIONS,
            Self::Once => ONCE_SECTIONS,
            Self::Twice => TWICE_SECTIONS,
        }
    }

    /// What comes behind it.
    fn next(self, meta: &Meta) -> Self {
        let block_or_once =
            |number: usize| if number < meta.blocks.len() { Self::Block(number) } else { Self::Once };
        match self {
            Self::Meta => Self::Block(0),
            Self::Block(0) => Self::Seen,
            Self::Seen => block_or_once(1),
            Self::Block(number) => block_or_once(number + 1),
            Self::Once | Self::Twice => Self::Twice,
        }
    }
}

impl TransferTensor {
    fn new(gpu: &Gpu, setup: Setup) -> Result<Self> {
        let surroundings = Surroundings::new(gpu, setup, true)?;
        Ok(Self {
            waiting: Some(Waiting { surroundings, spaces: Vec::new(), bases: Vec::new() }),
            pending: Vec::new(),
            next: Piece::Meta,
            maps: None,
            stage: None,
        })
    }

    fn tensors_arrived(&mut self, gpu: &Gpu, arrival: Arrival) -> Result<()> {
        let (place, last) = (arrival.section.place.clone(), arrival.last);
        self.pending.push(arrival.section);
        if self.pending.len() < self.next.sections() && !last {
            return Ok(());
        }
        let sections = std::mem::take(&mut self.pending);
        let Some(stage) = &mut self.stage else {
            return self.begin(gpu, decode_sections(&place, sections, Meta::decode)?, &place);
        };
        let meta = stage.meta().clone();
        match self.next {
            Piece::Meta => {}
            Piece::Block(number) => {
                let block =
                    decode_sections(&place, sections, |sections| meta.decode_block(number, sections))?;
                stage.block_arrived(gpu, &block);
            }
            Piece::Seen => {
                let seen = decode_sections(&place, sections, |sections| meta.decode_seen(sections))?;
                stage.seen_arrived(gpu, &seen);
            }
            Piece::Once => {
                let once = decode_sections(&place, sections, |sections| meta.decode_once(sections))?;
                once.into_iter().for_each(|once| stage.once_arrived(gpu, &once));
            }
            Piece::Twice => {
                let twice = decode_sections(&place, sections, |sections| meta.decode_twice(sections))?;
                twice.into_iter().for_each(|twice| stage.twice_arrived(gpu, &twice));
            }
        }
        self.next = self.next.next(&meta);
        Ok(())
    }

    /// Begins to play the bake that says `meta`.
    fn begin(&mut self, gpu: &Gpu, meta: Meta, place: &Place) -> Result<()> {
        let Some(waiting) = self.waiting.take() else { return Ok(()) };
        let Waiting { surroundings, spaces, bases } = &waiting;
        surroundings.expect_bake("tensors", meta.vertices.into(), place)?;
        expect_spaces(&meta, spaces, bases, &surroundings.scene.meta, place)?;
        expect_cones(spaces, place)?;
        surroundings.settings.expect_tensors(&meta)?;
        self.maps = Some(surroundings.map_names());
        self.next = Piece::Meta.next(&meta);
        self.stage = Some(Stage::new(gpu, waiting, meta, place)?);
        Ok(())
    }
}

/// Fails if a space has more cones than points are drawn with.
fn expect_cones(spaces: &[BrdfTensor], place: &Place) -> relume_formats::Result<()> {
    match spaces.iter().map(|space| space.cones.len()).find(|cones| *cones > MAX_CONES) {
        None => Ok(()),
        Some(cones) => Err(FormatError::unsupported(
            place,
            format!("comes after a BRDF tensor of {cones} cones, {} are drawn; bake it again", MAX_CONES),
        )),
    }
}

impl Playback for TransferTensor {
    fn section_arrived(&mut self, gpu: &Gpu, arrival: Arrival) -> Result<()> {
        match (&mut self.waiting, arrival.kind) {
            (_, Kind::TransferTensor) => self.tensors_arrived(gpu, arrival),
            (Some(waiting), kind) if belongs(kind) => waiting.surroundings.section_arrived(gpu, arrival),
            (Some(waiting), Kind::BrdfTensor | Kind::BrdfBasis) => {
                let kind = arrival.kind;
                self.pending.push(arrival.section);
                if arrival.last {
                    let sections = std::mem::take(&mut self.pending);
                    match kind {
                        Kind::BrdfTensor => waiting.spaces.push(decode_all(sections)?),
                        _ => waiting.bases.push(decode_all(sections)?),
                    }
                }
                Ok(())
            }
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
        let mut pieces = Pieces { what: "pieces", ..Pieces::default() };
        if let Some(stage) = &self.stage {
            let arrived = stage.arrived();
            pieces.expected = arrived.len();
            pieces.missing = (0..arrived.len()).filter(|piece| !arrived[*piece]).collect();
            pieces.bytes_per_frame = stage.bytes_per_frame();
        }
        pieces
    }

    fn film(&self) -> Option<&Film> {
        self.stage.as_ref().map(Stage::film)
    }

    fn resize(&mut self, gpu: &Gpu, size: [u32; 2]) -> Result<()> {
        match (&mut self.stage, &mut self.waiting) {
            (Some(stage), _) => stage.picture.resize(gpu, size),
            (None, Some(waiting)) => waiting.surroundings.resize(gpu, size),
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
