//! What a bake will take: nothing but measuring traces rays, and files are small enough to be made on the
//! spot.

use super::casters::{self, By, Choice};
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
use relume_scenes::{Object, Scene};
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
    let place = || Place::file(&scene.file);
    let shapes = scene.objects.iter().filter_map(|object| object.shape.as_deref());
    let shapes = shapes.map(|shape| Ok(shape.to_bytes(place())?.len())).sum::<Result<usize>>()?;
    let lobes = rows::bake(scene).to_bytes(place())?.len();
    let casts = casts(scene, &casters::choose(scene, &maps, None, casters, job)?);
    Ok(Predicted {
        tells: casts,
        rays: rays as f64 * scale,
        seconds: start.elapsed().as_secs_f64() * scale,
        bytes: (environment_lit::stored_bytes(scene)? + shapes + lobes) as f64,
        memory: predicted_bytes(scene),
        chosen: None,
    })
}

/// What objects will cast by, and why, a sentence each.
fn casts(scene: &Scene, choices: &[Choice]) -> Vec<String> {
    let sentence = |(object, Choice { by, error, .. }): (&Object, &Choice)| {
        let (name, error) = (&object.name, 100.0 * error);
        let is = match by {
            By::Nothing => format!("`{name}` casts nothing: its shadow is {error:.2} % of the light"),
            by => format!("`{name}` casts by {}, {error:.2} % off", by.words()),
        };
        match object.spheres.filter(|count| By::Spheres(*count).cost() < by.cost()) {
            Some(count) => format!("{is}; by its {count} spheres if these, once fitted, are as good"),
            None => is,
        }
    };
    scene.objects.iter().zip(choices).map(sentence).collect()
}
