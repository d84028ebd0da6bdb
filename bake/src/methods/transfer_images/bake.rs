//! From a scene to images: tiles of traced and projected pixels, packed.

use super::channels::channels;
use super::chromaticity::{chromaticity, grey_channel};
use super::held_out::{SPACING, one_pixel_in};
use super::later::later;
use super::pack::pack;
use super::project::Projector;
use super::settings::{NAME, READS, REVISION, Settings};
use crate::error::Result;
use crate::filter::{Filter, Noise, Watcher};
use crate::fragments::{self, Filtered, PixelRecords, Records, Tile, pixels_of, tiles_of};
use crate::job::Job;
use crate::scene_hash::hash_of;
use crate::stage::Stage;
use crate::trace::gather::{Gather, GatherPath};
use crate::work_log::WorkLog;
use relume_formats::kinds::BrdfBasis;
use relume_formats::kinds::brdf_basis::Functions;
use relume_formats::kinds::manifest::content_hash;
use relume_formats::kinds::transfer_images::{Later, LaterImages, Layout, Meta, TransferImages};
use relume_formats::state::{Brdf, Rgb};
use relume_scenes::Scene;
use xxhash_rust::xxh3::xxh3_128;

/// Images of a scene.
pub struct Baked {
    /// As they are stored.
    pub images: TransferImages,
    /// What they were before the filter where bakes are measured, if they were filtered.
    pub unfiltered: Option<TransferImages>,
    /// What noise they have; `None` if they show nothing.
    pub noise: Option<Noise>,
}

/// Bakes `scene`, whose paths are those of `gather`. `run` makes the pieces of a stage and gives the log that
/// has them; what is `None` there ends the bake without images.
///
/// # Errors
/// If the log cannot be written or read, or the job is interrupted.
pub fn bake(
    scene: &Scene,
    gather: &Gather<'_>,
    settings: &Settings,
    basis: &BrdfBasis,
    job: &Job,
    run: impl Fn(&dyn Stage) -> Result<Option<WorkLog>>,
) -> Result<Option<Baked>> {
    let chromaticity = chromaticity(scene);
    let later = later(scene, gather, settings, basis, job)?;
    let images = later.as_ref().map(Later::images);
    let layout = Layout::new(scene.vary.materials.len(), settings.bases, chromaticity.is_some(), images);
    let watcher = Watcher::new(scene);
    let projector = projector(scene, basis, (&layout, later.as_ref()), chromaticity, &watcher);
    let tiles = Tiles {
        settings: *settings,
        gather,
        projector,
        key: tiles_key(scene, gather, (settings, images), basis),
    };
    let Some(log) = run(&tiles)? else { return Ok(None) };
    let samples = |pixel: u32| gather.samples(pixel, settings.samples);
    let channels = channels(&layout);
    let fixed = layout.materials as u16;
    let traced = Records { log: &log, tiles: tiles.pieces(), channels: &channels, fixed, samples: &samples };
    let filter = Filter::new(traced.film(settings.size[0], job)?, job)?;
    let noise = filter.noise();

    let meta = Meta {
        size: settings.size,
        materials: scene.vary.materials.iter().map(|m| scene.materials[*m].name.clone()).collect(),
        bases: settings.bases as u32,
        chromaticity,
        samples: settings.samples,
        seed: settings.seed,
        editable_fragments: 0,
    };
    let head = (meta, later.clone());
    if !settings.filter {
        let noise = noise.map(|noise| Noise { after: noise.before, ..noise });
        let images = pack(&traced, &layout, basis, head, None, job)?;
        return Ok(Some(Baked { images, unfiltered: None, noise }));
    }
    let mut measured = one_pixel_in(SPACING, settings.size);
    measured.sort_unstable();
    let unfiltered = pack(&traced, &layout, basis, head.clone(), Some(&measured), job)?;
    let stage = Filtered::new(&traced, filter, tiles_of(settings.size), tiles.key, NAME);
    let Some(filtered) = run(&stage)? else { return Ok(None) };
    let filtered = Records { log: &filtered, ..traced };
    let images = pack(&filtered, &layout, basis, head, None, job)?;
    Ok(Some(Baked { images, unfiltered: Some(unfiltered), noise }))
}

/// Everything that the tiles depend on.
fn tiles_key(
    scene: &Scene,
    gather: &Gather<'_>,
    (settings, later): (&Settings, Option<LaterImages>),
    basis: &BrdfBasis,
) -> u128 {
    let functions: &[f32] = match &basis.functions {
        Functions::BlinnPhong { lobes } => lobes,
        Functions::Microfacet { weights, .. } => weights,
    };
    // What is traced is filtered or not.
    let settings = Settings { filter: false, ..*settings };
    let (reads, functions) = (hash_of(scene, &READS), content_hash(bytemuck::cast_slice(functions)));
    let counts = gather.counts();
    xxh3_128(format!("{reads:032x} {settings:?} {later:?} {counts:?} {REVISION} {functions}").as_bytes())
}

/// Tracing and projecting, a tile a piece.
struct Tiles<'a> {
    settings: Settings,
    gather: &'a Gather<'a>,
    projector: Projector<'a>,
    key: u128,
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
        let [columns, rows] = tiles_of(self.settings.size);
        columns * rows
    }

    fn piece(&self, number: u32) -> Result<Vec<u8>> {
        let pixels = pixels_of(number, self.settings.size);
        Ok(trace_pixels(pixels, self.settings.samples, self.gather, &self.projector).encode())
    }
}

/// What projects the paths of `scene`.
pub(super) fn projector<'a>(
    scene: &Scene,
    basis: &'a BrdfBasis,
    (layout, later): (&'a Layout, Option<&'a Later>),
    chromaticity: Option<Rgb>,
    watcher: &'a Watcher,
) -> Projector<'a> {
    let materials: Vec<Brdf> = scene.materials.iter().map(|m| m.brdf).collect();
    let grey_channel = grey_channel(chromaticity);
    Projector::new(basis, layout, &materials, &scene.vary.materials, grey_channel, later, watcher)
}

/// The fragments of some pixels, projected.
pub(super) fn trace_pixels(
    pixels: impl Iterator<Item = u32>,
    samples: u32,
    gather: &Gather<'_>,
    projector: &Projector<'_>,
) -> Tile {
    let add = |path: &GatherPath, half: usize, records: &mut PixelRecords| projector.add(path, half, records);
    fragments::trace(pixels, samples, gather, projector.empty(), add)
}
