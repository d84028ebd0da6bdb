//! The chart: speed against accuracy, for every method and setting that fits what a scene varies.
//!
//! [`states`] are drawn at random from what varies, and [`reference`] path traces them. Every method that fits [`sweep`]s the settings that trade speed for accuracy;
//! each of its bundles is played by the `player` that users have, whose images are compared with the reference ([`metrics`]) and whose frames are timed in turns
//! ([`timing`]). [`figures`] is what comes of it, [`csv`] and [`svg`] the same as a table and as a drawing, [`picture`] images beside their references.

#[cfg(test)]
pub(crate) mod ablation;
pub mod csv;
pub(crate) mod digits;
pub mod figures;
#[cfg(test)]
mod figures_tests;
pub mod metrics;
mod pareto;
pub mod picture;
pub mod reference;
pub mod states;
pub mod svg;
pub mod sweep;
#[cfg(test)]
pub(crate) mod test_chart;
mod timing;

use crate::error::{BakeError, Result};
use crate::job::{Job, say};
use crate::play::{Played, Playing};
use crate::scene_hash::scene_hash;
use figures::{Chart, FrameTime, ImageErrors, PICTURE, Picture, Point};
use metrics::{Pair, image_errors};
use reference::Reference;
use relume_formats::container::replace_file;
use relume_formats::kinds::Manifest;
use relume_formats::state::Rgb;
use relume_formats::{Error, Place};
use relume_scenes::Scene;
use std::path::{Path, PathBuf};
use sweep::{Bench, SWEEPS, Sweep, Variant};

/// Number of states.
const STATES: u32 = 8;
/// Of which the picture shows the first ones.
const SHOWN: usize = 3;
/// Most pixels of a film: a chart's images are not larger than 256².
const MAX_PIXELS: f64 = 65_536.0;
/// Folder for bundles and references while the chart is being made; an interrupted chart goes on with them.
const WORK: &str = "unfinished";

/// Where the charts of scenes go if nothing else is said.
pub const FOLDER: &str = "charts";

/// Measures `methods`, or all that fit if none is named, on `scene`, and writes chart.csv, chart.json, chart.svg and picture.png into `folder`.
///
/// # Errors
/// If no method fits, one that is named does not, the player is missing or fails, or the user interrupts; finished work stays for the next time.
pub fn run(scene: &Scene, methods: &[&str], folder: &Path, job: &Job) -> Result<Chart> {
    let sweeps = fitting(scene, methods)?;
    crate::play::player()?;
    let work = folder.join(WORK);
    let bench = Bench { folder: &work.join(format!("{:016x}", scene_hash(scene) as u64)), size: film_size(scene), job };
    std::fs::create_dir_all(bench.folder).map_err(|e| Error::io(&Place::file(bench.folder), e))?;
    let (scenes, animation) = in_states(scene, bench.folder)?;
    let render = |(number, scene)| reference::render(scene, number, bench.size, bench.folder, job);
    let truths = scenes.iter().enumerate().map(render).collect::<Result<Vec<Reference>>>()?;
    let reference_seconds = truths.iter().map(|truth| truth.seconds).sum();
    let variants = sweeps.iter().map(|sweep| (sweep.variants)(scene, &bench)).collect::<Result<Vec<_>>>()?.concat();
    let exposures: Vec<f32> = scenes.iter().map(|scene| scene.camera.exposure_ev).collect();
    let compare = |ours: &dyn Fn(usize) -> Vec<Rgb>| errors_of(ours, &truths, &exposures, bench.size);
    let noise = compare(&|state| truths[state].half.clone());
    let stage = job.stage("showing", variants.len() as u64);
    let mut shown = Vec::new();
    for variant in &variants {
        stage.check()?;
        let (images, played) = show(variant, &animation, &bench)?;
        shown.push((compare(&|state| images[state].clone()), played, images));
        stage.advance(1);
    }
    drop(stage);
    let times = timing::measure(&variants, &animation, STATES, bench.size, job)?;
    let best = (0..shown.len()).min_by(|a, b| shown[*a].0.relative_l2.median.total_cmp(&shown[*b].0.relative_l2.median));
    let mut picture = Picture { point: String::new(), factor: 1.0 };
    if let Some(best) = best {
        let path = folder.join(PICTURE);
        let rows: Vec<Pair<'_>> = (0..SHOWN).map(|state| pair(&shown[best].2[state], &truths[state], exposures[state])).collect();
        let (png, factor) = picture::beside(&rows, bench.size)?;
        replace_file(&path, &png)?;
        picture = Picture { point: name(&variants[best]), factor };
    }
    let adapter = shown.first().map_or_else(String::new, |(_, played, _)| played.adapter.clone());
    let points =
        variants.iter().zip(&shown).zip(times).map(|((variant, (errors, played, _)), frame)| point(variant, errors, played, frame));
    let baseline = variants.first().map_or_else(String::new, name);
    let chart = Chart {
        scene: scene.name.clone(),
        size: bench.size,
        states: STATES,
        reference_samples: reference::samples(),
        reference_seconds,
        noise,
        adapter,
        baseline,
        picture,
        machine: figures::machine(),
        date: figures::today(),
        program: concat!("bake ", env!("CARGO_PKG_VERSION")).to_owned(),
        points: points.collect::<Result<_>>()?,
    };
    chart.write(folder)?;
    std::fs::remove_dir_all(&work).map_err(|e| Error::io(&Place::file(&work), e))?;
    Ok(chart)
}

/// Fails unless a method shows everything that the scene varies.
///
/// # Errors
/// `Invalid` with the remedy.
pub fn expect_fit(scene: &Scene) -> Result<()> {
    fitting(scene, &[]).map(drop)
}

/// What [`Point::name`] will be.
fn name(variant: &Variant) -> String {
    format!("{}, {}, {}", variant.method, variant.series, variant.label)
}

/// The sweeps of `methods`, or of all that show everything that the scene varies.
fn fitting(scene: &Scene, methods: &[&str]) -> Result<Vec<&'static Sweep>> {
    let place = Place::file(&scene.file);
    if scene.vary == relume_scenes::Vary::default() {
        return Err(BakeError::invalid(&place, "varies nothing, so there is nothing to chart; name what varies under [vary]"));
    }
    let mut sweeps = Vec::new();
    for sweep in SWEEPS.iter().filter(|sweep| methods.is_empty() || methods.contains(&sweep.method)) {
        let fits = match (sweep.serves)(&scene.vary) {
            true => (sweep.expect_fit)(scene),
            false => Err(BakeError::invalid(
                &place,
                format!("[vary] names more than {} lets vary; vary less, or leave that method out", sweep.method),
            )),
        };
        match fits {
            Ok(()) => sweeps.push(sweep),
            Err(e) if !methods.is_empty() => return Err(e),
            Err(e) => say(&format!("{} is left out: {e}", sweep.method)),
        }
    }
    if sweeps.is_empty() {
        return Err(BakeError::invalid(&place, "no method shows everything that varies; vary less"));
    }
    Ok(sweeps)
}

/// The scene's film, made smaller in proportion where it has more than [`MAX_PIXELS`].
fn film_size(scene: &Scene) -> [u32; 2] {
    let smaller = (MAX_PIXELS / (f64::from(scene.size[0]) * f64::from(scene.size[1]))).sqrt().min(1.0);
    scene.size.map(|side| ((f64::from(side) * smaller).round() as u32).max(1))
}

/// The scene in each of its states, and a file with an animation of these.
fn in_states(scene: &Scene, folder: &Path) -> Result<(Vec<Scene>, PathBuf)> {
    let states: Vec<_> = (0..STATES).map(|number| states::random(scene, number)).collect();
    let animation = folder.join("states.toml");
    states::write_animation(&states, &animation)?;
    let scenes = states.iter().map(|state| Ok(scene.with_state(state, &Place::file(&animation))?)).collect::<Result<_>>()?;
    Ok((scenes, animation))
}

/// The images of all states as the player shows them, and what it says of itself.
fn show(variant: &Variant, animation: &Path, bench: &Bench<'_>) -> Result<(Vec<Vec<Rgb>>, Played)> {
    let frames = tempfile::tempdir_in(bench.folder).map_err(|e| Error::io(&Place::file(bench.folder), e))?;
    let pattern = frames.path().join("%04d.exr").display().to_string();
    let Variant { method, folder, .. } = variant;
    let played = Playing { folder, method, animation, frames: STATES, size: bench.size, exr: Some(&pattern) }.play()?;
    let image = |frame| reference::read(&frames.path().join(format!("{frame:04}.exr")), bench.size);
    Ok(((0..STATES).map(image).collect::<Result<_>>()?, played))
}

fn errors_of(ours: &dyn Fn(usize) -> Vec<Rgb>, truths: &[Reference], exposures: &[f32], size: [u32; 2]) -> ImageErrors {
    let images: Vec<Vec<Rgb>> = (0..truths.len()).map(ours).collect();
    let pairs: Vec<Pair<'_>> = images.iter().zip(truths).zip(exposures).map(|((ours, truth), ev)| pair(ours, truth, *ev)).collect();
    image_errors(&pairs, size)
}

fn pair<'a>(ours: &'a [Rgb], truth: &'a Reference, exposure_ev: f32) -> Pair<'a> {
    Pair { ours, truth: &truth.radiance, counted: &truth.counted, exposure_ev }
}

fn point(variant: &Variant, errors: &ImageErrors, played: &Played, frame: FrameTime) -> Result<Point> {
    let Variant { method, series, label, settings, folder, bake_seconds } = variant.clone();
    let bytes_on_disk = Manifest::read(&folder)?.entries().map(|entry| entry.bytes).sum();
    let bytes_in_memory = played.gpu_bytes.unwrap_or_default();
    Ok(Point { method: method.to_owned(), series, label, settings, errors: *errors, frame, bytes_on_disk, bytes_in_memory, bake_seconds })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn library(name: &str) -> Scene {
        relume_scenes::load(&relume_scenes::resolve(name).unwrap()).unwrap()
    }

    #[test]
    fn films_keep_their_shape() {
        let mut scene = library("cornell-knot");
        for (size, expected) in [([256, 256], [256, 256]), ([512, 512], [256, 256]), ([1024, 256], [512, 128]), ([64, 32], [64, 32])] {
            scene.size = size;
            assert_eq!(film_size(&scene), expected);
        }
    }

    #[test]
    fn methods_that_show_all_that_varies_are_charted() {
        let names = |scene: &Scene, methods: &[&str]| {
            fitting(scene, methods).map(|sweeps| sweeps.iter().map(|sweep| sweep.method).collect::<Vec<_>>()).map_err(|e| e.to_string())
        };
        let room = library("cornell-knot");
        assert_eq!(names(&room, &[]), Ok(vec!["transfer-images"]));
        assert_eq!(names(&library("knot-outdoors"), &[]), Ok(vec!["sparse-transfer"]), "its objects have no spheres");
        let mut twist = library("knot-twist");
        assert_eq!(names(&twist, &[]), Ok(vec!["sphere-shadows"]));
        assert!(names(&twist, &["sparse-transfer"]).unwrap_err().contains("[vary] names more than sparse-transfer lets vary"));
        twist.vary.shape = false;
        assert_eq!(names(&twist, &[]), Ok(vec!["sparse-transfer", "sphere-shadows"]), "the two are compared");
        assert_eq!(names(&twist, &["sphere-shadows"]), Ok(vec!["sphere-shadows"]));
        twist.vary.materials = vec![0];
        assert!(names(&twist, &[]).unwrap_err().contains("no method shows everything that varies"));
        twist.vary = relume_scenes::Vary::default();
        assert!(names(&twist, &[]).unwrap_err().contains("varies nothing"));
    }
}
