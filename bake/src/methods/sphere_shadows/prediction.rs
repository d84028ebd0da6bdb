//! What a bake will take: nothing but measuring traces rays, and files are small enough to be made on the
//! spot.

use super::casters;
use super::errors::{poses, predicted_bytes, receivers_looked_at};
use super::method::Asked;
use super::rows;
use super::truth::Eyes;
use crate::error::Result;
use crate::job::Job;
use crate::method::Predicted;
use crate::methods::environment_lit;
use crate::methods::spread::spread;
use crate::trace::held_out_lights::HeldOutLights;
use crate::trace::world::{reset_ray_counts, take_ray_count};
use rayon::prelude::*;
use relume_formats::Place;
use relume_formats::basis::two_level::SIDE;
use relume_formats::container::Stored;
use relume_scenes::Scene;
use std::time::Instant;

/// Receivers that are measured.
const RECEIVERS: usize = 128;

/// What baking `scene` will take, its sphere sets left out.
///
/// # Errors
/// If a clip leads beyond all numbers.
pub fn predict(scene: &Scene, casters: Asked, job: &Job) -> Result<Predicted> {
    let maps = environment_lit::environments(scene);
    let lights = HeldOutLights::new(&maps, SIDE, false);
    let poses = poses(scene)?;
    let vertices: usize = scene.objects.iter().map(|object| object.mesh.positions.len()).sum();
    let looked_at = receivers_looked_at(vertices);
    let some: Vec<usize> =
        spread(RECEIVERS, looked_at.len()).into_iter().filter_map(|k| looked_at.get(k).copied()).collect();
    let eyes = Eyes::new(scene);
    reset_ray_counts();
    let start = Instant::now();
    let rays_from = |vertex: &usize| {
        std::hint::black_box(eyes.radiances(*vertex, &eyes.look(*vertex), &lights));
        take_ray_count()
    };
    let rays: u64 = some.par_iter().map(rays_from).sum();
    let scale = poses.len() as f64 * looked_at.len() as f64 / some.len().max(1) as f64;
    let tracing = start.elapsed().as_secs_f64() * scale;
    let place = || Place::file(&scene.file);
    let shapes = scene.objects.iter().filter_map(|object| object.shape.as_deref());
    let shapes = shapes.map(|shape| Ok(shape.to_bytes(place())?.len())).sum::<Result<usize>>()?;
    let shadows = rows::bake(scene);
    let lobes = shadows.to_bytes(place())?.len();
    let choosing = Instant::now();
    let choices = casters::choose(scene, &shadows, &maps, None, casters, job)?;
    Ok(Predicted {
        tells: casters::sentences(scene, &choices),
        rays: rays as f64 * scale,
        seconds: tracing + choosing.elapsed().as_secs_f64(),
        bytes: (environment_lit::stored_bytes(scene)? + shapes + lobes) as f64,
        memory: predicted_bytes(scene),
        chosen: None,
    })
}
