//! What the parts of a bundle that all methods share will take: the scene, its animations, the sphere sets.

use super::stored_scene::stored_scene;
use crate::error::Result;
use crate::job::Job;
use crate::spheres::fit::{self, DEFAULT_ITERATIONS, Settings};
use crate::spheres::motion::poses;
use relume_formats::Place;
use relume_formats::container::Stored;
use relume_scenes::Scene;
use std::time::Instant;

/// Iterations of a fit that is tried, and how many times longer the whole one takes.
const ITERATIONS: u32 = 8;
const WHOLE_FIT: f64 = 6.0;

/// What the shared parts will take.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Shared {
    /// Wall-clock seconds: fitting spheres.
    pub seconds: f64,
    /// On disk.
    pub bytes: f64,
}

/// What the parts of a bundle of `scene`, for a player's film of `size`, that all methods share will take; a
/// little of each fit is done here and now.
///
/// # Errors
/// If an object that asks for spheres encloses nothing, or the job is interrupted.
pub fn predict_shared(scene: &Scene, size: [u32; 2], seed: u64, job: &Job) -> Result<Shared> {
    let place = || Place::file(&scene.file);
    let mut bytes = stored_scene(scene, size).to_bytes(place())?.len();
    for animation in &scene.animations {
        bytes += animation.to_bytes(place())?.len();
    }
    let start = Instant::now();
    for (object, spheres) in scene.objects.iter().filter_map(|object| Some((object, object.spheres?))) {
        let settings = Settings {
            spheres: spheres as usize,
            seed,
            iterations: ITERATIONS.min(DEFAULT_ITERATIONS),
            tight: 0.0,
        };
        let poses = object.shape.as_deref().map(poses).unwrap_or_default();
        let part = place().part(format!("object `{}`", object.name));
        let fitted = fit::fit(&object.mesh, &poses, &object.name, &part, &settings, job)?;
        bytes += fitted.set.to_bytes(place())?.len();
    }
    Ok(Shared { seconds: start.elapsed().as_secs_f64() * WHOLE_FIT, bytes: bytes as f64 })
}
