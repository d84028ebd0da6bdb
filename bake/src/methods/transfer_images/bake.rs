//! From a scene to images: tiles of traced and projected pixels, packed.

use super::chromaticity::{chromaticity, grey_channel};
use super::later::later;
use super::pack;
use super::project::Projector;
use super::settings::{NAME, READS, REVISION, Settings};
use super::tiles::{Tile, TileFragment};
use crate::error::Result;
use crate::job::Job;
use crate::scene_hash::hash_of;
use crate::stage::Stage;
use crate::trace::gather::Gather;
use crate::work_log::WorkLog;
use relume_formats::kinds::BrdfBasis;
use relume_formats::kinds::brdf_basis::Functions;
use relume_formats::kinds::manifest::content_hash;
use relume_formats::kinds::transfer_images::{Later, Layout, Meta, TransferImages};
use relume_formats::state::{Brdf, Rgb};
use relume_scenes::Scene;
use xxhash_rust::xxh3::xxh3_128;

/// Side of a tile, pixels.
const TILE: u32 = 16;

/// Bakes `scene`, whose paths are those of `gather`. `run` makes the tiles and gives the log that has them;
/// what is `None` there ends the bake without images.
///
/// # Errors
/// If the log cannot be written or read, or the job is interrupted.
pub fn bake(
    scene: &Scene,
    gather: &Gather<'_>,
    settings: &Settings,
    basis: &BrdfBasis,
    job: &Job,
    run: impl FnOnce(&dyn Stage) -> Result<Option<WorkLog>>,
) -> Result<Option<TransferImages>> {
    let chromaticity = chromaticity(scene);
    let later = later(scene, gather, settings, basis, job)?;
    let images = later.as_ref().map(Later::images);
    let layout = Layout::new(scene.vary.materials.len(), settings.bases, chromaticity.is_some(), images);
    let projector = projector(scene, basis, &layout, chromaticity, later.as_ref());
    let tiles = Tiles { settings: *settings, gather, projector, key: tiles_key(scene, settings, basis) };
    let Some(log) = run(&tiles)? else { return Ok(None) };

    let meta = Meta {
        size: settings.size,
        materials: scene.vary.materials.iter().map(|m| scene.materials[*m].name.clone()).collect(),
        bases: settings.bases as u32,
        chromaticity,
        samples: settings.samples,
        seed: settings.seed,
        editable_fragments: 0,
    };
    let progress = job.progress("packing", 2 * u64::from(tiles.pieces()));
    pack::pack(&log, tiles.pieces(), &layout, basis, (meta, later), &progress).map(Some)
}

/// Everything that the tiles depend on.
fn tiles_key(scene: &Scene, settings: &Settings, basis: &BrdfBasis) -> u128 {
    let functions: &[f32] = match &basis.functions {
        Functions::BlinnPhong { lobes } => lobes,
        Functions::Microfacet { weights, .. } => weights,
    };
    let (reads, functions) = (hash_of(scene, &READS), content_hash(bytemuck::cast_slice(functions)));
    xxh3_128(format!("{reads:032x} {settings:?} {REVISION} {functions}").as_bytes())
}

/// Tracing and projecting, a tile a piece.
struct Tiles<'a> {
    settings: Settings,
    gather: &'a Gather<'a>,
    projector: Projector<'a>,
    key: u128,
}

impl Tiles<'_> {
    /// Tiles along each side of the film.
    fn grid(&self) -> [u32; 2] {
        self.settings.size.map(|side| side.div_ceil(TILE))
    }
}

impl Stage for Tiles<'_> {
    fn name(&self) -> String {
        NAME.to_owned()
    }

    fn label(&self) -> Option<&'static str> {
        Some("tracing")
    }

    fn key(&self) -> u128 {
        self.key
    }

    fn pieces(&self) -> u32 {
        let [columns, rows] = self.grid();
        columns * rows
    }

    fn piece(&self, number: u32) -> Result<Vec<u8>> {
        let ([width, height], [columns, _]) = (self.settings.size, self.grid());
        let (x0, y0) = (number % columns * TILE, number / columns * TILE);
        let row = |y: u32| (x0..(x0 + TILE).min(width)).map(move |x| y * width + x);
        let pixels = (y0..(y0 + TILE).min(height)).flat_map(row);
        Ok(trace_pixels(pixels, self.settings.samples, self.gather, &self.projector).encode())
    }
}

/// What projects the paths of `scene`.
pub(super) fn projector<'a>(
    scene: &Scene,
    basis: &'a BrdfBasis,
    layout: &'a Layout,
    chromaticity: Option<Rgb>,
    later: Option<&Later>,
) -> Projector<'a> {
    let materials: Vec<Brdf> = scene.materials.iter().map(|m| m.brdf).collect();
    let nodes = later.map_or_else(Vec::new, Later::node_albedos);
    Projector::new(basis, layout, &materials, &scene.vary.materials, grey_channel(chromaticity), nodes)
}

/// The fragments of some pixels, projected.
pub(super) fn trace_pixels(
    pixels: impl Iterator<Item = u32>,
    samples: u32,
    gather: &Gather<'_>,
    projector: &Projector<'_>,
) -> Tile {
    let mut records = projector.empty();
    let mut tile = Tile::default();
    for pixel in pixels {
        gather.pixel(pixel, samples, |path| projector.add(path, &mut records));
        records.drain(|class, count, sums| {
            tile.fragments.push(TileFragment { pixel, class: class as u16, count });
            tile.values.extend_from_slice(sums);
        });
    }
    tile
}
