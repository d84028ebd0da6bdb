//! What a bake will take, from the paths of a few of its pixels.

use super::layout::Layout;
use super::project::Projector;
use super::settings::Settings;
use super::weights::Weights;
use crate::error::Result;
use crate::filter::Watcher;
use crate::fragments::{self, PixelRecords};
use crate::guided;
use crate::job::Job;
use crate::method::Predicted;
use crate::methods::spread::spread;
use crate::methods::transfer_images::space_for;
use crate::paintings::paintings;
use crate::trace::gather::GatherPath;
use crate::trace::lights::Lights;
use crate::trace::world::{World, reset_ray_counts, take_ray_count};
use rayon::prelude::*;
use relume_formats::kinds::region_images::REGION_COUNT;
use relume_scenes::Scene;
use std::time::Instant;

/// Pixels whose paths are traced.
const PIXELS: usize = 256;
/// Components of a pair of bases, and bytes on disk of what is stored of a pixel; from bundles of the library's scenes.
const COMPONENTS: u64 = 64;
const BYTES: f64 = 60.0;
/// How much longer than tracing all that comes before and after takes, from bakes of the same.
const OTHER_STEPS: f64 = 1.6;
/// Bytes that are known of a fragment while its filter is chosen.
const FILTERED: u64 = 512;

/// What baking `scene` will take.
///
/// # Errors
/// If LAPACK fails or the job is interrupted.
pub fn predict(settings: &Settings, scene: &Scene, job: &Job) -> Result<Predicted> {
    let Settings { size, samples, bases, .. } = *settings;
    let paintings = paintings(scene, job)?;
    let world = World::painted(scene, &paintings);
    let lights = Lights::new(scene, &world);
    let gather = guided::gather(scene, &world, &lights, &settings.paths(scene.reflections), job)?;
    let basis = space_for(scene, bases)?.basis(bases);
    let weights = Weights { squares: vec![1.0; bases], ..Weights::default() };
    let layout = Layout::new(scene, settings, &weights);
    let watcher = Watcher::new(scene);
    let projector = Projector::new(scene, &basis, &layout, &weights, &watcher);
    let all = size[0] as usize * size[1] as usize;
    let pixels: Vec<u32> = spread(PIXELS, all).into_iter().map(|pixel| pixel as u32).collect();
    reset_ray_counts();
    let start = Instant::now();
    let some = |pixels: &[u32]| {
        let add =
            |path: &GatherPath, half: usize, records: &mut PixelRecords| projector.add(path, half, records);
        fragments::trace(pixels.iter().copied(), samples, &gather, projector.empty(), add);
        take_ray_count() as f64
    };
    let rays: f64 = pixels.par_chunks(4).map(some).sum();
    let scale = all as f64 / pixels.len() as f64;
    let tracing = start.elapsed().as_secs_f64() * scale;
    Ok(Predicted {
        tells: tells(settings, scene, &layout),
        rays: rays * scale,
        seconds: tracing * OTHER_STEPS,
        bytes: all as f64 * BYTES,
        memory: memory(settings, scene),
        chosen: None,
    })
}

/// What never exists: an image of each region and pair of bases.
fn tells(settings: &Settings, scene: &Scene, layout: &Layout) -> Vec<String> {
    let pairs = layout.bases[1].pow(2) as f64;
    let regions = (scene.vary.painted.len() * REGION_COUNT) as f64;
    let pixels = f64::from(settings.size[0]) * f64::from(settings.size[1]);
    let colours = if layout.chromaticity.is_some() { 1.0 } else { 3.0 };
    let gigabytes = 4.0 * pairs * regions * pixels * colours / 1e9;
    vec![format!(
        "an image of every region and pair of bases would be {gigabytes:.1} GB; what is kept of them goes by --max-error"
    )]
}

/// Bytes that a bake holds at most: products of regions, values of all components in the tiles at hand, fragments while
/// they are filtered, and the hierarchy.
pub(super) fn memory(settings: &Settings, scene: &Scene) -> u64 {
    let pixels = u64::from(settings.size[0]) * u64::from(settings.size[1]);
    let pairs = (settings.indirect_bases(scene.reflections) as u64).pow(2);
    let groups = pairs * scene.vary.painted.len() as u64;
    let products = groups * 8 * (REGION_COUNT * REGION_COUNT) as u64;
    let triangles: u64 = scene.objects.iter().map(|o| o.mesh.triangles.len() as u64).sum();
    let texels = scene.environment.as_ref().map_or(0, |e| e.map.map.texels.len() as u64);
    // A tile of cells, twice, for each thread, and those fragments that have no cell on the film.
    let components = groups * COMPONENTS * 4;
    let tiles = 16 * 2048 * components + pixels / 10 * components;
    let threads = rayon::current_num_threads() as u64;
    // While eigenvectors are found, each thread has three more matrices.
    let eigen = threads * 3 * 8 * (REGION_COUNT * REGION_COUNT) as u64;
    2 * products
        + eigen
        + tiles
        + pixels * (FILTERED + 200)
        + triangles * 600
        + texels * 48
        + if scene.reflections < 2 { 0 } else { guided::MEMORY }
}
