//! The truth that all points of a chart are measured against: path-traced images of its states, in two
//! independent halves, so that their own noise is known.

use rayon::prelude::*;
use relume_bake::error::Result;
use relume_bake::exr_file::{read_exr, write_exr};
use relume_bake::job::Job;
use relume_bake::trace::reference::{self, Paths, Settings};
use relume_bake::trace::world::{Owner, World};
use relume_formats::container::replace_file;
use relume_formats::state::Rgb;
use relume_formats::{Error, Place};
use relume_scenes::Scene;
use std::path::Path;
use std::time::Instant;

/// Paths a pixel of each half.
const SAMPLES: u32 = 256;
/// Of the halves. No bake traces with these unless it is asked to, so that its noise is never ours.
const SEEDS: [u64; 2] = [0x0074_7275_7468, 0x0074_7275_7469];
/// Places along a side of a pixel that are looked at to tell whether it shows surfaces alone.
const LOOKS: u32 = 4;

/// The image of one state.
#[derive(Debug, Clone)]
pub struct Reference {
    /// The mean of both halves, linear radiance, row by row.
    pub radiance: Vec<Rgb>,
    /// One half: it is as far from the mean as the mean is from the truth, if chance alone decides.
    pub half: Vec<Rgb>,
    /// Pixels that show surfaces that reflect and nothing else. Lights and background are not what methods
    /// compute, and a sun in view outshines the rest.
    pub counted: Vec<bool>,
    /// Wall-clock seconds that it took, in whichever run.
    pub seconds: f64,
}

/// Paths a pixel of both halves together.
pub fn samples() -> u32 {
    SAMPLES * SEEDS.len() as u32
}

/// Renders `scene`, which is in state number `number`, or reads what an interrupted run left in `folder`.
/// Paths have as many reflections as the scene says that methods model.
///
/// # Errors
/// If the job is interrupted, or files cannot be written or read.
pub fn render(scene: &Scene, number: usize, size: [u32; 2], folder: &Path, job: &Job) -> Result<Reference> {
    let half = |half: usize| -> Result<(Vec<Rgb>, f64)> {
        let path = folder.join(format!("reference-{number:02}-{half}.exr"));
        let took = path.with_extension("seconds");
        if path.is_file() {
            let seconds = std::fs::read_to_string(&took).ok().and_then(|text| text.parse().ok());
            return Ok((read(&path, size)?, seconds.unwrap_or_default()));
        }
        let start = Instant::now();
        let settings = Settings {
            size,
            samples: SAMPLES,
            seed: SEEDS[half],
            reflections: scene.reflections,
            paths: Paths::Best,
            target: None,
        };
        let estimate =
            reference::render(scene, std::slice::from_ref(scene), &[], &settings, job)?.swap_remove(0);
        let seconds = start.elapsed().as_secs_f64();
        replace_file(&took, seconds.to_string().as_bytes())?;
        write(&path, size, &estimate.radiance)?;
        Ok((estimate.radiance, seconds))
    };
    let [(first, one), (second, other)] = [half(0)?, half(1)?];
    let mean = |(a, b): (&Rgb, &Rgb)| std::array::from_fn(|c| 0.5 * (a[c] + b[c]));
    Ok(Reference {
        radiance: first.iter().zip(&second).map(mean).collect(),
        half: first,
        counted: counted(scene, size),
        seconds: one + other,
    })
}

/// Pixels in which all of a grid of film positions show a surface that reflects.
fn counted(scene: &Scene, size: [u32; 2]) -> Vec<bool> {
    let (world, film) = (World::new(scene), scene.camera.film(size[0], size[1]));
    let shows_surface = |pixel: u32, look: u32| {
        let at = |pixel: u32, look: u32| pixel as f32 + (look as f32 + 0.5) / LOOKS as f32;
        let direction = film.direction(at(pixel % size[0], look % LOOKS), at(pixel / size[0], look / LOOKS));
        world
            .intersect(film.eye_in_world, direction)
            .is_some_and(|surface| matches!(surface.owner, Owner::Material(_)))
    };
    (0..size[0] * size[1])
        .into_par_iter()
        .map(|pixel| (0..LOOKS * LOOKS).all(|look| shows_surface(pixel, look)))
        .collect()
}

/// Reads the red, green and blue of an image of `size`.
///
/// # Errors
/// If it cannot be read, or is of another size.
pub fn read(path: &Path, size: [u32; 2]) -> Result<Vec<Rgb>> {
    let planes = read_exr(path)?;
    let place = Place::file(path);
    if [planes.width, planes.height] != size.map(|n| n as usize) {
        let reason = format!(
            "{}x{} pixels, expected {}x{}; remove the file",
            planes.width, planes.height, size[0], size[1]
        );
        return Err(Error::invalid(&place, reason).into());
    }
    let plane = |name: &str| {
        planes
            .channel(name)
            .ok_or_else(|| Error::invalid(&place, format!("has no channel `{name}`; remove the file")))
    };
    let [r, g, b] = [plane("R")?, plane("G")?, plane("B")?];
    Ok(r.iter().zip(g).zip(b).map(|((r, g), b)| [*r, *g, *b]).collect())
}

fn write(path: &Path, size: [u32; 2], radiance: &[Rgb]) -> Result<()> {
    let [r, g, b] = [0, 1, 2].map(|c| radiance.iter().map(|pixel| pixel[c]).collect::<Vec<f32>>());
    Ok(write_exr(path, size[0] as usize, size[1] as usize, &[("R", &r), ("G", &g), ("B", &b)])?)
}
