//! The chart: speed against accuracy, for every method and setting that fits what a scene varies.
//!
//! [`states`] are drawn at random from what varies, and [`reference`](mod@reference) path traces them. Every
//! method that fits has a [sweep](crate::sweep) of the settings that trade speed for accuracy, or its default
//! settings; each of its bundles is played by the `player` that users have, whose images are compared with
//! the reference ([`metrics`]) and whose frames are timed in turns (`timing`). [`figures`] is what comes of
//! it, [`csv`](crate::csv) and [`svg`](crate::svg) the same as a table and as a drawing, [`picture`] images
//! beside their references.

use crate::figures::{self, Chart, FrameTime, ImageErrors, PICTURE, Picture, Point};
use crate::metrics::{Pair, image_errors};
use crate::play::{Played, Playing};
use crate::reference::{self, Reference};
use crate::sweep::{Bench, Variant};
use crate::{files, picture, states, sweeps, timing};
use relume_bake::darkness;
use relume_bake::error::{BakeError, Result};
use relume_bake::job::{Job, say};
use relume_bake::methods::asked::Asked;
use relume_bake::methods::choice::METHODS;
use relume_bake::methods::registered::Registered;
use relume_bake::output::create_folder;
use relume_bake::scene_hash::scene_hash;
use relume_bake::unfinished::FolderLock;
use relume_formats::container::replace_file;
use relume_formats::kinds::Manifest;
use relume_formats::state::{Rgb, State};
use relume_formats::{Error, Place};
use relume_scenes::Scene;
use std::path::{Path, PathBuf};

/// Number of states.
const STATES: u32 = 8;
/// Of which the picture shows the first ones.
const SHOWN: usize = 2;
/// Most pixels of a film: a chart's images are not larger than 256².
const MAX_PIXELS: f64 = 65_536.0;
/// Folder for bundles and references while the chart is being made; an interrupted chart goes on with them.
const WORK: &str = "unfinished";

/// Where the charts of scenes go if nothing else is said.
pub const FOLDER: &str = "charts";

/// Measures `methods`, or all that fit if none is named, on `scene`, and writes chart.csv, chart.json,
/// chart.svg and picture.png into `folder`.
///
/// # Errors
/// If no method fits, one that is named does not, the player is missing or fails, or the user interrupts;
/// finished work stays for the next time.
pub fn run(scene: &Scene, methods: &[&str], folder: &Path, job: &Job) -> Result<Chart> {
    let methods = fitting(scene, methods)?;
    crate::play::player()?;
    let _lock = FolderLock::take(folder)?;
    // What varies of materials alone lights nothing.
    if !(scene.vary.light || scene.vary.view || scene.vary.shape)
        && darkness::is_black(scene, film_size(scene))?
    {
        return Err(BakeError::invalid(&Place::file(&scene.file), darkness::WARNING));
    }
    let work = folder.join(WORK);
    let states: Vec<State> = (0..STATES).map(|number| states::random(scene, number)).collect();
    let bench = Bench { folder: &work.join(key(scene, &states)), size: film_size(scene), job };
    create_folder(bench.folder)?;
    let animation = bench.folder.join("states.toml");
    states::write_animation(&states, &animation)?;
    let truths = states
        .iter()
        .enumerate()
        .map(|(number, state)| truth(scene, number, state, &bench))
        .collect::<Result<Vec<_>>>()?;
    let variants = methods
        .iter()
        .map(|method| sweeps::variants(method, scene, &bench))
        .collect::<Result<Vec<_>>>()?
        .concat();
    let shown = show_all(&variants, &truths, &animation, &bench)?;
    let times = timing::measure(&variants, &animation, STATES, bench.size, job)?;
    let points = variants
        .iter()
        .zip(&shown.measured)
        .zip(times)
        .map(|((variant, (errors, played)), frame)| point(variant, errors, played, frame));
    let points: Vec<Point> = points.collect::<Result<_>>()?;
    let rows: Vec<Pair<'_>> =
        shown.best_images.iter().zip(&truths).take(SHOWN).map(|(ours, truth)| truth.pair(ours)).collect();
    let (png, factor) = picture::beside(&rows, bench.size)?;
    replace_file(&folder.join(PICTURE), &png)?;
    let halves: Vec<Pair<'_>> = truths.iter().map(|truth| truth.pair(&truth.reference.half)).collect();
    let chart = Chart {
        scene: scene.name.clone(),
        size: bench.size,
        states: STATES,
        reference_samples: reference::samples(),
        reference_seconds: truths.iter().map(|truth| truth.reference.seconds).sum(),
        noise: image_errors(&halves, bench.size),
        adapter: shown.measured.first().map_or_else(String::new, |(_, played)| played.adapter.clone()),
        baseline: points.first().map_or_else(String::new, Point::name),
        picture: Picture { point: points.get(shown.best).map_or_else(String::new, Point::name), factor },
        machine: figures::machine(),
        date: figures::today(),
        program: concat!("bake ", env!("CARGO_PKG_VERSION")).to_owned(),
        points,
    };
    files::write(&chart, folder)?;
    std::fs::remove_dir_all(&work).map_err(|e| Error::output(&Place::file(&work), e))?;
    Ok(chart)
}

/// Whether an interrupted chart left finished work in `folder`: references, or pieces and files of bundles.
pub fn holds_work(folder: &Path) -> bool {
    let inside = |folder: &Path| {
        std::fs::read_dir(folder)
            .into_iter()
            .flatten()
            .flatten()
            .map(|entry| entry.path())
            .collect::<Vec<_>>()
    };
    let is_work = |path: &PathBuf| path.is_dir() || path.extension().is_some_and(|e| e == "exr");
    inside(&folder.join(WORK)).iter().flat_map(|charts| inside(charts)).any(|path| is_work(&path))
}

/// Names everything that references depend on, so that those of another scene or an older program are not
/// taken for this one's.
fn key(scene: &Scene, states: &[State]) -> String {
    let text = format!("{:032x} {states:?} {}", scene_hash(scene), reference::samples());
    format!("{:016x}", xxhash_rust::xxh3::xxh3_64(text.as_bytes()))
}

/// What a state truly looks like.
struct Truth {
    reference: Reference,
    exposure_ev: f32,
}

impl Truth {
    fn pair<'a>(&'a self, ours: &'a [Rgb]) -> Pair<'a> {
        Pair {
            ours,
            truth: &self.reference.radiance,
            counted: &self.reference.counted,
            exposure_ev: self.exposure_ev,
        }
    }
}

fn truth(scene: &Scene, number: usize, state: &State, bench: &Bench<'_>) -> Result<Truth> {
    let scene = scene.with_state(state, &Place::file(&scene.file))?;
    let reference = reference::render(&scene, number, bench.size, bench.folder, bench.job)?;
    Ok(Truth { reference, exposure_ev: scene.camera.exposure_ev })
}

/// What all variants show.
struct Shown {
    /// Errors, and what the player says of itself.
    measured: Vec<(ImageErrors, Played)>,
    /// The variant that comes nearest to the truth.
    best: usize,
    /// Its images, one for each state.
    best_images: Vec<Vec<Rgb>>,
}

fn show_all(variants: &[Variant], truths: &[Truth], animation: &Path, bench: &Bench<'_>) -> Result<Shown> {
    let progress = bench.job.progress("showing", variants.len() as u64);
    let mut shown = Shown { measured: Vec::new(), best: 0, best_images: Vec::new() };
    for (number, variant) in variants.iter().enumerate() {
        progress.check()?;
        let (images, played) = show(variant, animation, bench)?;
        let pairs: Vec<Pair<'_>> = images.iter().zip(truths).map(|(ours, truth)| truth.pair(ours)).collect();
        shown.measured.push((image_errors(&pairs, bench.size), played));
        let error = |number: usize| shown.measured[number].0.relative_l2.median;
        if number == 0 || error(number) < error(shown.best) {
            (shown.best, shown.best_images) = (number, images);
        }
        progress.advance(1);
    }
    Ok(shown)
}

/// Fails unless a method shows everything that the scene varies.
///
/// # Errors
/// `Invalid` with the remedy.
pub fn expect_fit(scene: &Scene) -> Result<()> {
    fitting(scene, &[]).map(drop)
}

/// Those of `methods`, or of all if none is named, that show everything that the scene varies.
fn fitting(scene: &Scene, names: &[&str]) -> Result<Vec<&'static Registered>> {
    let place = Place::file(&scene.file);
    if scene.vary == relume_scenes::Vary::default() {
        return Err(BakeError::invalid(
            &place,
            "varies nothing, so there is nothing to chart; name what varies under [vary]",
        ));
    }
    let mut methods = Vec::new();
    for method in METHODS.into_iter().filter(|method| names.is_empty() || names.contains(&method.card.name)) {
        let name = method.card.name;
        let fits = match method.serves_all(&scene.vary) {
            true => (method.new)(&Asked::of_scene(scene), scene).expect_fit(scene),
            false => Err(BakeError::invalid(
                &place,
                format!("[vary] names more than {name} lets vary; vary less, or leave that method out"),
            )),
        };
        match fits.map_err(BakeError::with_line) {
            Ok(()) => methods.push(method),
            Err(e) if !names.is_empty() => return Err(e),
            Err(e) => say(&format!("{name} is left out: {e}")),
        }
    }
    if methods.is_empty() {
        return Err(BakeError::invalid(&place, "no method shows everything that varies; vary less"));
    }
    Ok(methods)
}

/// The scene's film, made smaller in proportion where it has more than [`MAX_PIXELS`].
fn film_size(scene: &Scene) -> [u32; 2] {
    let smaller = (MAX_PIXELS / (f64::from(scene.size[0]) * f64::from(scene.size[1]))).sqrt().min(1.0);
    scene.size.map(|side| ((f64::from(side) * smaller).round() as u32).max(1))
}

/// The images of all states as the player shows them, and what it says of itself.
fn show(variant: &Variant, animation: &Path, bench: &Bench<'_>) -> Result<(Vec<Vec<Rgb>>, Played)> {
    let frames =
        tempfile::tempdir_in(bench.folder).map_err(|e| Error::output(&Place::file(bench.folder), e))?;
    let pattern = frames.path().join("%04d.exr").display().to_string();
    let Variant { method, folder, .. } = variant;
    let played = Playing { folder, method, animation, frames: STATES, size: bench.size, exr: Some(&pattern) }
        .play()?;
    let image = |frame| reference::read(&frames.path().join(format!("{frame:04}.exr")), bench.size);
    Ok(((0..STATES).map(image).collect::<Result<_>>()?, played))
}

fn point(variant: &Variant, errors: &ImageErrors, played: &Played, frame: FrameTime) -> Result<Point> {
    let Variant { method, series, label, settings, folder, bake_seconds } = variant.clone();
    let bytes_on_disk = Manifest::read(&folder)?.entries().map(|entry| entry.bytes).sum();
    let bytes_in_memory = played.gpu_bytes.unwrap_or_default();
    Ok(Point {
        method: method.to_owned(),
        series,
        label,
        settings,
        errors: *errors,
        frame,
        bytes_on_disk,
        bytes_in_memory,
        bake_seconds,
    })
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
        for (size, expected) in [
            ([256, 256], [256, 256]),
            ([512, 512], [256, 256]),
            ([1024, 256], [512, 128]),
            ([64, 32], [64, 32]),
        ] {
            scene.size = size;
            assert_eq!(film_size(&scene), expected);
        }
    }

    #[test]
    fn methods_that_show_all_that_varies_are_charted() {
        let names = |scene: &Scene, methods: &[&str]| {
            fitting(scene, methods)
                .map(|fitting| fitting.iter().map(|method| method.card.name).collect::<Vec<_>>())
                .map_err(|e| e.to_string())
        };
        let room = library("cornell-knot");
        assert_eq!(names(&room, &[]), Ok(vec!["transfer-images"]));
        assert_eq!(
            names(&library("knot-outdoors"), &[]),
            Ok(vec!["sparse-transfer", "transfer-tensor", "sphere-shadows"])
        );
        let mut twist = library("knot-twist");
        assert_eq!(names(&twist, &[]), Ok(vec!["sphere-shadows"]));
        assert!(
            names(&twist, &["sparse-transfer"])
                .unwrap_err()
                .contains("[vary] names more than sparse-transfer lets vary")
        );
        twist.vary.shape = false;
        let all = vec!["sparse-transfer", "transfer-tensor", "sphere-shadows"];
        assert_eq!(names(&twist, &[]), Ok(all), "they are compared");
        assert_eq!(names(&twist, &["sphere-shadows"]), Ok(vec!["sphere-shadows"]));
        twist.vary.materials = vec![0];
        assert_eq!(names(&twist, &[]), Ok(vec!["transfer-tensor"]));
        twist.vary.shape = true;
        assert!(names(&twist, &[]).unwrap_err().contains("no method shows everything that varies"));
        twist.vary = relume_scenes::Vary::default();
        assert!(names(&twist, &[]).unwrap_err().contains("varies nothing"));
    }
}
