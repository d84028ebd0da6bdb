//! Scenes made on the spot, bakes, and the binaries.

pub mod images;
pub mod pictures;
pub mod regions;
pub mod relit;
pub mod room;
pub mod waiting;

use glam::Vec3A;
use relume_bake::exr_file::read_exr;
use relume_bake::job::{Job, ProgressMode};
use relume_bake::trace::lights::Lights;
use relume_bake::trace::path::PathTracer;
use relume_bake::trace::reference::{self, Estimate, Paths, Settings};
use relume_bake::trace::sampler::PixelSampler;
use relume_bake::trace::world::World;
use relume_scenes::Scene;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::Arc;

/// A scene loaded from the given text, and the folder it lives in.
pub fn scene(text: &str) -> Scene {
    let folder = tempfile::tempdir().unwrap();
    relume_scenes::load(&write_scene(folder.path(), text)).unwrap()
}

/// Writes `text` as scene.toml into `folder`.
pub fn write_scene(folder: &Path, text: &str) -> PathBuf {
    let path = folder.join("scene.toml");
    std::fs::write(&path, text).unwrap();
    path
}

/// Copies a folder and all that is in it.
pub fn copy_folder(from: &Path, to: &Path) {
    std::fs::create_dir_all(to).unwrap();
    for entry in std::fs::read_dir(from).unwrap().map(|entry| entry.unwrap()) {
        let to = to.join(entry.file_name());
        if entry.path().is_dir() {
            copy_folder(&entry.path(), &to);
        } else {
            std::fs::copy(entry.path(), &to).unwrap();
        }
    }
}

/// A quiet job.
pub fn job() -> Job {
    Job::new(ProgressMode::None)
}

/// Renders one image of `scene` as it is.
pub fn render(
    scene: &Scene,
    size: [u32; 2],
    samples: u32,
    reflections: u32,
    paths: Paths,
    seed: u64,
) -> Estimate {
    let settings = Settings { size, samples, seed, reflections, paths, target: None };
    reference::render(scene, std::slice::from_ref(scene), &[], &settings, &job()).unwrap().swap_remove(0)
}

/// The path tracer's mean radiance along rays that `ray` makes from two uniform numbers, with its standard
/// error.
pub fn mean_radiance(
    scene: &Scene,
    reflections: u32,
    samples: u32,
    ray: impl Fn([f32; 2]) -> (Vec3A, Vec3A),
) -> (f64, f64) {
    let world = World::new(scene);
    let lights = Lights::new(scene, &world);
    let tracer = PathTracer::new(scene, &world, &lights, [1, 1], reflections, 0);
    let sampler = PixelSampler::new(11, 0);
    let (mut sum, mut squares) = (0.0, 0.0);
    for index in 0..samples {
        let sample = sampler.sample(index);
        let (origin, direction) = ray(sample.pair(1_000_000));
        let radiance = f64::from(tracer.radiance(origin, direction, &sample).y);
        sum += radiance;
        squares += radiance * radiance;
    }
    let n = f64::from(samples);
    let mean = sum / n;
    (mean, ((squares / n - mean * mean).max(0.0) / n).sqrt())
}

/// Radiance by pixel of an image in a file.
pub fn radiance_in(path: &Path) -> Vec<[f32; 3]> {
    let image = read_exr(path).unwrap();
    let [r, g, b] = ["R", "G", "B"].map(|channel| image.channel(channel).unwrap());
    r.iter().zip(g).zip(b).map(|((r, g), b)| [*r, *g, *b]).collect()
}

/// Relative L2 difference over all channels.
pub fn relative_l2(x: &[[f32; 3]], reference: &[[f32; 3]]) -> f64 {
    let (mut difference, mut norm) = (0.0, 0.0);
    for (a, b) in x.as_flattened().iter().zip(reference.as_flattened()) {
        difference += (f64::from(*a) - f64::from(*b)).powi(2);
        norm += f64::from(*b).powi(2);
    }
    (difference / norm).sqrt()
}

/// The library's scene `name`.
pub fn library_scene(name: &str) -> Scene {
    relume_scenes::load(&relume_scenes::resolve(name).unwrap()).unwrap()
}

/// The library's scene `name` with light of at most two reflections.
pub fn with_two_reflections(name: &str) -> Scene {
    Scene { reflections: 2, ..library_scene(name) }
}

/// `scene` as it would be with lengths in another unit: everything `scale` times as large about the origin.
pub fn scaled(scene: &Scene, scale: f32) -> Scene {
    let mut scene = scene.clone();
    let scaled = |v: [f32; 3]| v.map(|x| x * scale);
    for object in &mut scene.objects {
        Arc::make_mut(&mut object.mesh).positions.iter_mut().for_each(|p| *p = scaled(*p));
    }
    for light in &mut scene.lights {
        if let relume_scenes::Emitter::Area { corner, edge_u, edge_v, .. } = &mut light.emitter {
            [*corner, *edge_u, *edge_v] = [scaled(*corner), scaled(*edge_u), scaled(*edge_v)];
        }
    }
    scene.camera.position = scaled(scene.camera.position);
    scene.camera.target = scaled(scene.camera.target);
    scene
}

/// Runs one of our binaries, which `make test` builds beside the tests.
pub fn run(binary: &str, arguments: &[&str]) -> Output {
    command(binary).args(arguments).output().unwrap()
}

/// One of our binaries, ready to be given arguments.
pub fn command(binary: &str) -> Command {
    let test = std::env::current_exe().unwrap();
    let release = test.parent().and_then(Path::parent).unwrap();
    let path = release.join(binary);
    assert!(
        path.exists(),
        "{} is missing; run `cargo build --release --workspace` first, as `make test` does",
        path.display()
    );
    Command::new(path)
}

/// Runs and expects exit code `code`; returns standard error, which for failures must be a single `error: …`
/// line after any warnings and progress.
pub fn expect_exit(binary: &str, arguments: &[&str], code: i32) -> String {
    let output = run(binary, arguments);
    let stderr = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(code), "{binary} {arguments:?}: {stderr}");
    if code != 0 && code != 130 {
        assert_eq!(stderr.lines().filter(|l| l.starts_with("error: ")).count(), 1, "{stderr}");
        assert!(!stderr.contains("panicked"), "{stderr}");
    }
    stderr
}
