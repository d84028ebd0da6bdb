//! What a bake will take, from the paths of a few of its pixels.

use super::albedo_errors::albedo_errors;
use super::bake::{projector, trace_pixels};
use super::basis::{model, space_for};
use super::chromaticity::chromaticity;
use super::fit::predicted_bytes;
use super::held_out::{self, HeldOutErrors};
use super::later::{LEAST_LOBES, later, may_have_lobes};
use super::settings::{Bases, Settings, TransferImagesMethod};
use crate::error::Result;
use crate::filter::Watcher;
use crate::guided;
use crate::job::Job;
use crate::method::Predicted;
use crate::methods::spread::spread;
use crate::trace::gather::Gather;
use crate::trace::lights::Lights;
use crate::trace::world::{World, reset_ray_counts, take_ray_count};
use rayon::prelude::*;
use relume_formats::Place;
use relume_formats::container::Stored;
use relume_formats::kinds::transfer_images::{Later, Layout};
use relume_formats::state::Model;
use relume_scenes::Scene;
use std::time::Instant;

/// Pixels whose paths are traced, and of these the share that is measured at too.
const PIXELS: usize = 256;
const MEASURED: usize = 16;
/// What choosing the number of bases looks at here, in parts of what it looks at in a bake.
const CHOICE: u32 = 4;
/// Bytes that a stored half takes on disk if it is not 0, and if it is; from bundles of the library's scenes.
const HALF: f64 = 0.85;
const ZERO: f64 = 0.03;
/// Bytes a second that are packed, compressed and written, per thread.
const PACKED: f64 = 2e7;
/// Values that are filtered a second, and pixels that a strength is chosen for, per thread.
const FILTERED: f64 = 2e6;
const CHOSEN: f64 = 1.2e4;

/// What baking `scene` by `method` will take.
///
/// # Errors
/// If LAPACK fails or the job is interrupted.
pub fn predict(method: &TransferImagesMethod, scene: &Scene, job: &Job) -> Result<Predicted> {
    let TransferImagesMethod { size, samples, seed, bases, filter, .. } = *method;
    let start = Instant::now();
    let world = World::new(scene);
    let lights = Lights::new(scene, &world);
    let gather = guided::gather(scene, &world, &lights, &method.paths(scene.reflections), job)?;
    let space = space_for(scene, bases.most())?;
    let preparing = start.elapsed().as_secs_f64();
    let start = Instant::now();
    let chosen = match bases {
        Bases::Number(bases) => bases,
        Bases::Error(max) => {
            let pixels = held_out::some_pixels(held_out::CHOICE_PIXELS / CHOICE, size);
            held_out::choose_bases(scene, &gather, space.whole(), samples, max, &pixels, job)?
        }
    };
    let choosing = start.elapsed().as_secs_f64() * f64::from(CHOICE);
    let mut tells = Vec::new();
    tells.extend(method.noise.map(|noise| {
        format!("tiles get samples until noise is about {} %: rays and time are the most", 100.0 * noise)
    }));
    if let Bases::Error(max) = bases {
        tells.extend(tell_of_sharper(scene, (&gather, samples, size), (chosen, max), job)?);
    }
    let start = Instant::now();
    let basis = space.basis(chosen);
    let chromaticity = chromaticity(scene);
    let settings = Settings { size, samples, seed, bases: chosen, filter };
    let later = later(scene, &gather, &settings, &basis, job)?;
    let images = later.as_ref().map(Later::images);
    let layout = Layout::new(scene.vary.materials.len(), chosen, chromaticity.is_some(), images);
    let preparing = preparing + start.elapsed().as_secs_f64();
    let watcher = Watcher::new(scene);
    let projector = projector(scene, &basis, (&layout, later.as_ref()), chromaticity, &watcher);
    let all = size[0] as usize * size[1] as usize;
    let pixels: Vec<u32> = spread(PIXELS, all).into_iter().map(|pixel| pixel as u32).collect();

    if let Some(later) = &later {
        let errors = albedo_errors(scene, &gather, (&basis, later), samples, &pixels, job)?;
        tells.push(tell(scene, later, layout.channels(), errors));
    }

    reset_ray_counts();
    let start = Instant::now();
    let some = |pixels: &[u32]| {
        let tile = trace_pixels(pixels.iter().copied(), samples, &gather, &projector);
        let zeros = tile.values.iter().filter(|value| **value == 0.0).count();
        (take_ray_count() as f64, tile.values.len() as f64, zeros as f64)
    };
    let traced =
        pixels.par_chunks(4).map(some).reduce(|| (0.0, 0.0, 0.0), |a, b| (a.0 + b.0, a.1 + b.1, a.2 + b.2));
    let scale = all as f64 / pixels.len() as f64;
    let [rays, values, zeros] = [traced.0, traced.1, traced.2].map(|count| count * scale);
    let tracing = start.elapsed().as_secs_f64() * scale;

    let start = Instant::now();
    let few: Vec<u32> = pixels.iter().copied().step_by(MEASURED).collect();
    held_out::trace(&gather, scene, (&basis, later.as_ref()), &few, samples);
    let per_pixel = start.elapsed().as_secs_f64() / few.len() as f64;
    let measuring = per_pixel * all as f64 / f64::from(held_out::SPACING.pow(2));
    let threads = rayon::current_num_threads() as f64;
    let packing = 2.0 * values / (PACKED * threads);
    // How noisy it is is told without a filter, too.
    let filtering = (all as f64 / CHOSEN + if filter { values / FILTERED } else { 0.0 }) / threads;
    Ok(Predicted {
        tells,
        rays,
        seconds: preparing + choosing + tracing + measuring + filtering + packing,
        bytes: (values - zeros) * HALF + zeros * ZERO + basis.to_bytes(Place::file("basis"))?.len() as f64,
        memory: predicted_bytes(scene, &settings),
        chosen: Some(chosen),
    })
}

/// What lobes cost that are sharper than usual, if `scene` asks for them: `chosen` bases are to keep their error
/// below `max`. Lobes no sharper than usual are tried on the same paths.
fn tell_of_sharper(
    scene: &Scene,
    (gather, samples, size): (&Gather<'_>, u32, [u32; 2]),
    (chosen, max): (usize, f64),
    job: &Job,
) -> Result<Option<String>> {
    let (model, mut usual) = (model(scene), scene.clone());
    (usual.vary.shininess_max, usual.vary.roughness_min) = (None, None);
    let [asked, sharpest] = [scene, &usual].map(|scene| scene.vary.sharpest(model));
    if asked == sharpest {
        return Ok(None);
    }
    let space = space_for(&usual, Bases::Error(max).most())?;
    let pixels = held_out::some_pixels(held_out::CHOICE_PIXELS / CHOICE, size);
    let enough = held_out::choose_bases(&usual, gather, space.whole(), samples, max, &pixels, job)?;
    let parameter = if model == Model::BlinnPhong { "shininess" } else { "roughness" };
    let taken = if chosen == *held_out::CHOICE.end() {
        format!("all {chosen} bases that there may be")
    } else {
        format!("{chosen} bases")
    };
    Ok(Some(format!(
        "lobes as sharp as {parameter} {asked} take {taken}, as sharp as {sharpest} about {enough}"
    )))
}

/// What later reflections cost, and how far off they are where materials shine.
fn tell(scene: &Scene, later: &Later, channels: usize, errors: Option<HeldOutErrors>) -> String {
    let images = later.images().count(later.textures.len());
    let share = 100.0 * (3 * images) as f64 / channels as f64;
    let errors = errors.map_or_else(String::new, |HeldOutErrors { median, worst }| {
        format!(": error over random states median {:.1} %, worst {:.1} %", 100.0 * median, 100.0 * worst)
    });
    let lobes = match later.lobes {
        0 if !may_have_lobes(scene) => String::new(),
        0 => format!("; their lobes would change the median state by less than {} %", 100.0 * LEAST_LOBES),
        _ => ", and by their broad lobes at the surface that light leaves last".to_owned(),
    };
    format!(
        "third and later reflections take {images} RGB images, {share:.0} % of the values of a surface that varies; materials that vary count by their albedos there{lobes}{errors}"
    )
}
