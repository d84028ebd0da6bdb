//! Images of the same states with one approximation after the other, and how far each is from the path tracer
//! and from the one before.

use glam::Vec3A;
use rayon::prelude::*;
use relume_bake::compress::statistics::median;
use relume_bake::error::Result;
use relume_bake::job::{Job, ProgressMode};
use relume_bake::trace::lights::Lights;
use relume_bake::trace::receivers::{Receiver, receivers};
use relume_bake::trace::reference::{self, Paths, Settings};
use relume_bake::trace::sampler::PixelSampler;
use relume_bake::trace::spot::UNPAINTED;
use relume_bake::trace::world::{Owner, Surface, World};
use relume_chart::play::Playing;
use relume_chart::{reference as stored, states};
use relume_formats::state::Rgb;
use relume_formats::{Error, Place};
use relume_scenes::Scene;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Film size in pixels.
pub const SIZE: [u32; 2] = [256, 256];
/// Film samples of references, and of all drawings: the same ones, so that nothing of an error is film noise.
pub const SAMPLES: u32 = 256;
/// States that errors are measured on.
pub const STATES: u32 = 4;
/// Light samples at a vertex for its exact radiance.
const LIGHT_SAMPLES: u32 = 1024;

/// A quiet job.
pub fn quiet() -> Job {
    Job::new(ProgressMode::None)
}

/// The library's scene `name`.
pub fn library(name: &str) -> Result<Scene> {
    Ok(relume_scenes::load(&relume_scenes::resolve(name)?)?)
}

/// Where `make bake SCENE=…` puts the bundle of `name`, from any folder; what is there is used again.
pub fn bundle_folder(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../baked").join(name)
}

/// `scene` in random state number `number`.
pub fn at_state(scene: &Scene, number: u32) -> Result<Scene> {
    Ok(scene.with_state(&states::random(scene, number), &Place::file(&scene.file))?)
}

/// `scene` in all states that errors are measured on.
pub fn at_states(scene: &Scene) -> Result<Vec<Scene>> {
    (0..STATES).map(|number| at_state(scene, number)).collect()
}

/// The path tracer's image of direct light.
fn reference(scene: &Scene, seed: u64) -> Result<Vec<Rgb>> {
    let settings =
        Settings { size: SIZE, samples: SAMPLES, seed, reflections: 1, paths: Paths::Best, target: None };
    Ok(reference::render(scene, std::slice::from_ref(scene), &[], &settings, &quiet())?
        .swap_remove(0)
        .radiance)
}

/// Where the pixels of a film are sampled.
#[derive(Clone, Copy)]
pub enum Film {
    /// Where a reference with seed 0 samples them.
    Reference,
    /// In the middles of their quarters, as the player does.
    Quarters,
}

impl Film {
    /// Samples of a pixel.
    pub fn samples(self) -> u32 {
        match self {
            Self::Reference => SAMPLES,
            Self::Quarters => 4,
        }
    }

    /// Where on `pixel` a sample is.
    pub fn place(self, pixel: u32, index: u32) -> [f32; 2] {
        match self {
            Self::Reference => PixelSampler::new(0, pixel).sample(index).pair(0),
            Self::Quarters => [index % 2, index / 2].map(|quarter| 0.25 + 0.5 * quarter as f32),
        }
    }
}

/// A state's film as a linear map from radiances at vertices.
pub struct Drawing {
    /// What is seen past all surfaces, by pixel.
    background: Vec<Vec3A>,
    /// By pixel: vertices and the share of their white radiance, times albedo, that counts.
    shares: Vec<Vec<(u32, Vec3A)>>,
    /// Pixels that show surfaces.
    pub shows_surface: Vec<bool>,
}

impl Drawing {
    /// Of `scene`.
    pub fn new(scene: &Scene, places: Film) -> Self {
        let world = World::new(scene);
        let lights = Lights::new(scene, &world);
        let film = scene.camera.film(SIZE[0], SIZE[1]);
        let mut corners = Vec::new();
        let mut first = 0;
        for object in &scene.objects {
            corners.extend(object.mesh.triangles.iter().map(|t| t.map(|corner| corner + first)));
            first += object.mesh.positions.len() as u32;
        }
        let pixel = |pixel: u32| {
            let (mut background, mut shares) = (Vec3A::ZERO, BTreeMap::new());
            let count = places.samples() as f32;
            for index in 0..places.samples() {
                let [dx, dy] = places.place(pixel, index);
                let direction = film.direction((pixel % SIZE[0]) as f32 + dx, (pixel / SIZE[0]) as f32 + dy);
                let Some(hit) = world.meet(film.eye_in_world, direction) else {
                    background += lights.background(direction);
                    continue;
                };
                let Owner::Material(material) = hit.owner else { continue };
                let albedo =
                    Vec3A::from(scene.materials[material as usize].brdf.diffuse_albedo()) * hit.albedo;
                let [v, w] = hit.barycentric;
                for (vertex, share) in corners[hit.triangle as usize].into_iter().zip([1.0 - v - w, v, w]) {
                    *shares.entry(vertex).or_insert(Vec3A::ZERO) += albedo * (share / count);
                }
            }
            (background / count, shares.into_iter().collect::<Vec<_>>())
        };
        let (background, shares): (Vec<_>, Vec<Vec<_>>) =
            (0..SIZE[0] * SIZE[1]).into_par_iter().map(pixel).unzip();
        let shows_surface = shares.iter().map(|shares| !shares.is_empty()).collect();
        Self { background, shares, shows_surface }
    }

    /// The pixels that show any of these vertices.
    pub fn shows(&self, vertices: std::ops::Range<u32>) -> Vec<bool> {
        self.shares.iter().map(|shares| shares.iter().any(|(vertex, _)| vertices.contains(vertex))).collect()
    }

    /// The image with these radiances of white surfaces at all vertices.
    pub fn draw(&self, radiance: &[Rgb]) -> Vec<Rgb> {
        let of = |(background, shares): (&Vec3A, &Vec<(u32, Vec3A)>)| {
            let surfaces: Vec3A =
                shares.iter().map(|(vertex, share)| *share * Vec3A::from(radiance[*vertex as usize])).sum();
            (*background + surfaces).to_array()
        };
        self.background.iter().zip(&self.shares).map(of).collect()
    }
}

/// Radiance of a white surface at every vertex under direct light as the scene has it: many samples of the
/// lights, nothing rounded to texels.
pub fn exact(scene: &Scene) -> Vec<Rgb> {
    let world = World::new(scene);
    let lights = Lights::new(scene, &world);
    let of = |(vertex, receiver): (usize, &Receiver)| {
        let surface = Surface {
            position: receiver.origin,
            geometric_normal: receiver.normal,
            shading_normal: receiver.normal,
            owner: Owner::Material(0),
            light: None,
            albedo: Vec3A::ONE,
            uv: UNPAINTED,
            front: true,
            outgoing: receiver.normal,
            rounding: 0.0,
        };
        let sampler = PixelSampler::new(77, vertex as u32);
        let light = |index| {
            let sample = sampler.sample(index);
            let light = lights.sample_visible(&world, &surface, sample.pair(0)[0], sample.pair(1));
            light.map_or(Vec3A::ZERO, |light| light.weight * light.direction.dot(receiver.normal))
        };
        let sum: Vec3A = (0..LIGHT_SAMPLES).map(light).sum();
        (sum / (std::f32::consts::PI * LIGHT_SAMPLES as f32)).to_array()
    };
    receivers(scene).par_iter().enumerate().map(|(vertex, receiver)| of((vertex, receiver))).collect()
}

/// What the player shows of `method` of the bundle in `folder`, in the first states.
pub fn played(scene: &Scene, method: &str, folder: &Path) -> Result<Vec<Vec<Rgb>>> {
    let temporary = tempfile::tempdir().map_err(|e| Error::output(&Place::file(std::env::temp_dir()), e))?;
    let (animation, pattern) =
        (temporary.path().join("states.toml"), temporary.path().join("%04d.exr").display().to_string());
    let states: Vec<_> = (0..STATES).map(|number| states::random(scene, number)).collect();
    states::write_animation(&states, &animation)?;
    Playing { folder, method, animation: &animation, frames: STATES, size: SIZE, exr: Some(&pattern) }
        .play()?;
    (0..STATES).map(|frame| stored::read(&temporary.path().join(format!("{frame:04}.exr")), SIZE)).collect()
}

/// Relative L2 in per cent over the pixels of `mask`.
pub fn percent(image: &[Rgb], truth: &[Rgb], mask: &[bool]) -> f64 {
    let (mut off, mut norm) = (0.0, 0.0);
    for ((image, truth), _) in image.iter().zip(truth).zip(mask).filter(|(_, shown)| **shown) {
        for (a, b) in image.iter().zip(truth) {
            off += (f64::from(*a) - f64::from(*b)).powi(2);
            norm += f64::from(*b).powi(2);
        }
    }
    100.0 * (off / norm).sqrt()
}

/// Relative L2 in per cent over the pixels of `mask` to what two references with noises of their own estimate, without
/// that noise: the mean of the product of the differences from both has none of it.
fn percent_without_noise(image: &[Rgb], truths: [&[Rgb]; 2], mask: &[bool]) -> f64 {
    let (mut off, mut norm) = (0.0, 0.0);
    for (pixel, _) in mask.iter().enumerate().filter(|(_, shown)| **shown) {
        for c in 0..3 {
            let [ours, a, b] = [image, truths[0], truths[1]].map(|image| f64::from(image[pixel][c]));
            off += (ours - a) * (ours - b);
            norm += a * b;
        }
    }
    if off < 0.0 { 0.0 } else { 100.0 * (off / norm).sqrt() }
}

/// Images of all states, step by step.
pub struct Steps {
    /// The path tracer's with two seeds.
    truths: [Vec<Vec<Rgb>>; 2],
    /// Name, the step that it builds on if that is not the truth, images.
    steps: Vec<(String, Option<usize>, Vec<Vec<Rgb>>)>,
}

impl Steps {
    /// No steps yet; the truth is `scenes`, as the path tracer sees direct light in them.
    ///
    /// # Errors
    /// If the user interrupts.
    pub fn new(scenes: &[Scene]) -> Result<Self> {
        let traced =
            |seed: u64| scenes.iter().map(|scene| reference(scene, seed)).collect::<Result<Vec<_>>>();
        Ok(Self { truths: [traced(0)?, traced(1)?], steps: Vec::new() })
    }

    /// Adds a step that builds on step `before`, or on the truth; returns its number.
    pub fn push(&mut self, name: &str, before: Option<usize>, images: Vec<Vec<Rgb>>) -> Option<usize> {
        self.steps.push((name.to_owned(), before, images));
        Some(self.steps.len() - 1)
    }

    /// Prints each step's error against the truth and against the step that it builds on, state by state and
    /// their median; before them what two truths differ by.
    pub fn print(&self, title: &str, masks: &[&[bool]]) {
        println!("\n**{title}**: relative L2 to the path tracer without its noise, % (to the step before)\n");
        let states: Vec<String> = (0..masks.len()).map(|state| format!(" state {state} |")).collect();
        println!("| step |{} median |\n|---|{}", states.concat(), "---|".repeat(masks.len() + 1));
        let all = |of: &dyn Fn(usize) -> f64| (0..masks.len()).map(of).collect::<Vec<f64>>();
        let [truth, other] = &self.truths;
        let noise = all(&|at| percent(&other[at], &truth[at], masks[at]));
        let cells: String = noise.iter().map(|n| format!(" {n:.2} |")).collect();
        println!(
            "| *two path tracers with other seeds, their noise included* |{cells} {:.2} |",
            median(&noise)
        );
        for (name, before, images) in &self.steps {
            let errors = all(&|at| percent_without_noise(&images[at], [&truth[at], &other[at]], masks[at]));
            let steps = before
                .and_then(|before| self.steps.get(before))
                .map(|(_, _, before)| all(&|at| percent(&images[at], &before[at], masks[at])));
            let cell = |error: f64, step: Option<f64>| {
                step.map_or_else(|| format!(" {error:.2} |"), |step| format!(" {error:.2} ({step:.2}) |"))
            };
            let of_state = |at: usize| cell(errors[at], steps.as_ref().map(|steps| steps[at]));
            let cells: String = (0..masks.len()).map(of_state).collect();
            println!("| {name} |{cells}{}", cell(median(&errors), steps.as_deref().map(median)));
        }
    }
}
