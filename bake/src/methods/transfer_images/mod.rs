//! Method `transfer-images` (thesis §4.1): light and view stay, materials of whole objects vary.
//!
//! Gather: the paths of [`crate::trace::gather`]. Project: every path on every basis, [`project`]. Compress: halves with a range per image,
//! [`pack`]. What it cannot do: exponents above 200 or roughness below 0.32, more than two
//! reflections, lights or views that vary.

pub mod held_out;
mod method;
mod pack;
mod prediction;
mod project;
mod registered;
mod sweep;
mod tiles;

#[cfg(test)]
mod ablation;

use crate::brdf;
use crate::error::{BakeError, Result};
use crate::job::Job;
use crate::scene_hash::hash_of;
use crate::stage::Stage;
use crate::trace::gather::{Gather, MAX_REFLECTIONS};
use crate::trace::lights::Lights;
use crate::trace::world::World;
use crate::work_log::WorkLog;
pub use method::{Bases, Wanted};
use project::Projector;
pub use registered::METHOD;
use relume_formats::Place;
use relume_formats::basis::linear_from_srgb;
use relume_formats::kinds::BrdfBasis;
use relume_formats::kinds::brdf_basis::Functions;
use relume_formats::kinds::manifest::content_hash;
use relume_formats::kinds::transfer_images::{Layout, MAX_MATERIALS, Meta, TransferImages};
use relume_formats::state::{Brdf, Model, Rgb};
use relume_scenes::{Emitter, Scene};
pub use sweep::SWEEP;
use tiles::{Tile, TileFragment};
use xxhash_rust::xxh3::xxh3_128;

/// Name of the method.
pub const NAME: &str = relume_formats::method::TRANSFER_IMAGES.name;
/// Changes whenever the same scene and settings give other bytes than before.
pub const REVISION: u32 = 2;
/// Side of a tile, pixels.
const TILE: u32 = 16;

/// The settings that change results.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Settings {
    /// Film size in pixels.
    pub size: [u32; 2],
    /// Film samples a pixel.
    pub samples: u32,
    /// Seed of the paths.
    pub seed: u64,
    /// Number of bases, the diffuse one included.
    pub bases: usize,
}

/// Fails, naming what stands in the way, unless the method serves what `scene` varies.
pub fn expect_fit(scene: &Scene) -> Result<()> {
    let place = Place::file(&scene.file);
    let refuse = |reason: String| Err(BakeError::invalid(&place, reason));
    if scene.vary.shape {
        return refuse(format!("[vary] shape = true, but {NAME} keeps shapes fixed; set it to false"));
    }
    if scene.vary.materials.is_empty() {
        return refuse(
            "[vary] names no materials, so there is nothing to bake; `bake reference` makes an image of a scene that never changes".into(),
        );
    }
    if scene.vary.materials.len() > MAX_MATERIALS {
        return refuse(format!("[vary] names {} materials, {NAME} serves at most {MAX_MATERIALS}", scene.vary.materials.len()));
    }
    let varying = || scene.vary.materials.iter().map(|index| &scene.materials[*index]);
    if let Some(other) = varying().find(|m| m.brdf.model() != model(scene)) {
        let (first, name) = (&scene.materials[scene.vary.materials[0]], &other.name);
        return refuse(format!(
            "[vary] names materials of two models, `{}` of \"{}\" and `{name}` of \"{}\", but one bake has bases for one; give both the same brdf",
            first.name,
            first.brdf.model().name(),
            other.brdf.model().name()
        ));
    }
    if scene.reflections > MAX_REFLECTIONS {
        return refuse(format!("[render] reflections = {}, {NAME} models at most {MAX_REFLECTIONS}; set 2 or 1", scene.reflections));
    }
    Ok(())
}

/// The model of the materials that vary, all the same in a scene that fits.
pub fn model(scene: &Scene) -> Model {
    scene.vary.materials.first().map_or(Model::BlinnPhong, |index| scene.materials[*index].brdf.model())
}

/// A basis for the materials of `scene` that vary. The diffuse basis carries the texture of textured ones, so highlights may not use it then.
///
/// # Errors
/// If LAPACK fails.
pub fn basis_for(scene: &Scene, bases: usize) -> Result<BrdfBasis> {
    let textured = scene.vary.materials.iter().any(|index| scene.materials[*index].texture.is_some());
    Ok(brdf::basis::build(model(scene), bases, !textured)?)
}

/// The one colour of all light in `scene`, its largest channel 1; `None` if colours differ.
pub fn chromaticity(scene: &Scene) -> Option<Rgb> {
    let colours = scene.lights.iter().flat_map(|light| colours_of(&light.emitter));
    let environment = scene.environment.iter().flat_map(|e| {
        let gain = e.gain;
        e.map.map.texels.iter().map(move |t| [t[0] * gain[0], t[1] * gain[1], t[2] * gain[2]])
    });
    let mut common: Option<Rgb> = None;
    for colour in colours.chain(environment) {
        let largest = colour.iter().copied().fold(0.0, f32::max);
        if largest <= 0.0 {
            continue;
        }
        let unit = colour.map(|c| c / largest);
        match common {
            None => common = Some(unit),
            Some(c) if c.iter().zip(unit).all(|(a, b)| (a - b).abs() <= 1e-6) => {}
            Some(_) => return None,
        }
    }
    Some(common.unwrap_or([1.0; 3]))
}

/// Every colour that a light has somewhere.
fn colours_of(emitter: &Emitter) -> Box<dyn Iterator<Item = Rgb> + '_> {
    match emitter {
        Emitter::Mesh { radiance, glow: Some(glow), .. } => Box::new(glow.texture.texels.iter().map(|texel| {
            let share = |k: usize| linear_from_srgb(texel[k]);
            std::array::from_fn(|k| radiance[k] * share(k))
        })),
        Emitter::Area { radiance, .. } | Emitter::Mesh { radiance, .. } => Box::new(std::iter::once(*radiance)),
        Emitter::Point { intensity, .. } => Box::new(std::iter::once(*intensity)),
        Emitter::Directional { irradiance, .. } => Box::new(std::iter::once(*irradiance)),
    }
}

/// Bytes that a bake holds at most, which is while it writes: halves, their compressed copies, the images that measuring compares with, the
/// hierarchy, and the environment.
pub fn predicted_bytes(scene: &Scene, settings: &Settings) -> u64 {
    let layout = Layout::new(scene.vary.materials.len(), settings.bases, chromaticity(scene).is_some());
    let pixels = u64::from(settings.size[0]) * u64::from(settings.size[1]);
    // A tenth of the pixels show a second class at most in all scenes seen so far.
    let fragments = pixels + pixels / 10;
    let triangles: u64 = scene.objects.iter().map(|o| o.mesh.triangles.len() as u64).sum();
    let texels = scene.environment.as_ref().map_or(0, |e| e.map.map.texels.len() as u64);
    fragments * (layout.channels() as u64 * 8 + 32) + pixels * 12 * u64::from(held_out::STATES) + triangles * 600 + texels * 48
}

/// Bakes `scene`. `run` makes the tiles and gives the log that has them; what is `None` there ends the bake without images.
///
/// # Errors
/// If the log cannot be written or read, or the job is interrupted.
pub fn bake(
    scene: &Scene,
    settings: &Settings,
    basis: &BrdfBasis,
    job: &Job,
    run: impl FnOnce(&dyn Stage) -> Result<Option<WorkLog>>,
) -> Result<Option<TransferImages>> {
    let chromaticity = chromaticity(scene);
    let layout = Layout::new(scene.vary.materials.len(), settings.bases, chromaticity.is_some());
    let world = World::new(scene);
    let lights = Lights::new(scene, &world);
    let gather = Gather::new(scene, &world, &lights, settings.size, scene.reflections, settings.seed);
    let projector = projector(scene, basis, &layout, chromaticity);
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
    pack::pack(&log, tiles.pieces(), &layout, basis, meta, &progress).map(Some)
}

/// Everything that the tiles depend on.
fn tiles_key(scene: &Scene, settings: &Settings, basis: &BrdfBasis) -> u128 {
    let functions: &[f32] = match &basis.functions {
        Functions::BlinnPhong { lobes } => lobes,
        Functions::Ggx { weights, .. } => weights,
    };
    let (reads, functions) = (hash_of(scene, &method::READS), content_hash(bytemuck::cast_slice(functions)));
    xxh3_128(format!("{reads:032x} {settings:?} {REVISION} {functions}").as_bytes())
}

/// Tracing and projecting, a tile a piece.
struct Tiles<'a> {
    settings: Settings,
    gather: Gather<'a>,
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
        Ok(trace_pixels(pixels, self.settings.samples, &self.gather, &self.projector).encode())
    }
}

fn projector<'a>(scene: &Scene, basis: &'a BrdfBasis, layout: &'a Layout, chromaticity: Option<Rgb>) -> Projector<'a> {
    let materials: Vec<Brdf> = scene.materials.iter().map(|m| m.brdf).collect();
    Projector::new(basis, layout, &materials, &scene.vary.materials, grey_channel(chromaticity))
}

fn grey_channel(chromaticity: Option<Rgb>) -> usize {
    let colour = chromaticity.unwrap_or([1.0; 3]);
    (0..3).max_by(|a, b| colour[*a].total_cmp(&colour[*b])).unwrap_or(0)
}

/// The fragments of some pixels, projected.
fn trace_pixels(pixels: impl Iterator<Item = u32>, samples: u32, gather: &Gather<'_>, projector: &Projector<'_>) -> Tile {
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
