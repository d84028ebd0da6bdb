//! What a bake will take, from the rows of a few of its vertices.

use super::bounce::{self, Bouncer, add, coarse};
use super::fit::predicted_bytes;
use super::rows::{MAX_TERMS, Rows};
use super::settings::{Settings, bounces, channels, cubes, face_size};
use super::texels::Texels;
use super::visibility::transfer_row;
use super::{errors, importance, quantise};
use crate::compress::quantise::unit_for;
use crate::error::Result;
use crate::job::Job;
use crate::method::Predicted;
use crate::methods::environment_lit::{self, environments};
use crate::methods::spread::spread;
use crate::trace::held_out_lights::HeldOutLights;
use crate::trace::receivers::{Receiver, receivers};
use crate::trace::world::{World, reset_ray_counts, take_ray_count};
use rayon::prelude::*;
use relume_formats::kinds::sparse_transfer::Meta;
use relume_scenes::Scene;
use std::time::Instant;

/// Vertices whose rows are traced.
const VERTICES: usize = 128;
/// Rows that are at hand when light bounces, to be read in place of all others.
const SOURCES: usize = 1024;
/// Bytes on disk of an index, of a byte and of a 16-bit value that are not 0, in parts of what they take in
/// memory; from bundles of the library's scenes.
const INDEX: f64 = 0.62;
const VALUE: f64 = 0.6;
const WIDE: f64 = 0.9;
/// Bytes a second that are packed, compressed and written.
const PACKED: f64 = 2e7;

/// What baking `scene` with `settings` will take.
///
/// # Errors
/// If the job is interrupted.
pub fn predict(settings: &Settings, scene: &Scene, job: &Job) -> Result<Predicted> {
    let (world, receivers) = (World::new(scene), receivers(scene));
    let lights = HeldOutLights::new(&environments(scene), face_size(scene), bounces(scene) > 0);
    let texels = Texels::new(settings.rays_per_texel.isqrt() as usize);
    let some: Vec<Receiver> = spread(VERTICES, receivers.len())
        .into_iter()
        .filter_map(|vertex| receivers.get(vertex).copied())
        .collect();
    let progress = job.progress("predicting", some.len() as u64);
    reset_ray_counts();
    let start = Instant::now();
    let traced = some.par_iter().map(|receiver| {
        progress.check()?;
        let mut row = vec![0.0; texels.weights.len()];
        transfer_row(receiver, &world, &texels, &mut row);
        progress.advance(1);
        Ok((row, take_ray_count()))
    });
    let traced = traced.collect::<Result<Vec<(Vec<f32>, u64)>>>()?;
    let bouncing = bounced(scene, &world, &some);
    let scale = receivers.len() as f64 / some.len().max(1) as f64;
    let seconds = start.elapsed().as_secs_f64() * scale;
    let rays = traced.iter().map(|(_, rays)| rays).sum::<u64>() + bouncing;
    let direct: Vec<Vec<f32>> = traced.into_iter().map(|(row, _)| row).collect();
    let rows = selected(scene, &world, &receivers, &some, direct, &lights);
    let terms = settings.terms.of(&errors::by_terms(&rows, &lights));
    let own = stored_bytes(&rows, terms, scene) * scale;
    Ok(Predicted {
        tells: Vec::new(),
        rays: rays as f64 * scale,
        seconds: seconds + 2.0 * own / PACKED,
        bytes: own + environment_lit::stored_bytes(scene)? as f64,
        memory: predicted_bytes(scene),
        chosen: Some(terms),
    })
}

/// The terms of `some` vertices with these rows of direct light, as the bake selects them. Where light bounces, what
/// other vertices send on is not known: it is taken to be what would reach these if nothing stood in the way.
fn selected(
    scene: &Scene,
    world: &World,
    receivers: &[Receiver],
    some: &[Receiver],
    direct: Vec<Vec<f32>>,
    lights: &HeldOutLights,
) -> Rows {
    let weights = importance::weights(face_size(scene), cubes(scene));
    let bouncer = (bounces(scene) > 0).then(|| Bouncer::new(scene, world));
    let texels = Texels::new(1);
    let of = |(receiver, direct): (&Receiver, Vec<f32>)| {
        let planes = bouncer.as_ref().map(|bouncer| {
            let mut bounced = vec![0.0; 3 * bounce::TEXELS];
            for (vertex, share) in bouncer.shares(receiver) {
                let normal = receivers[vertex as usize].normal;
                let open = texels.centres.directions().iter().zip(&texels.weights);
                let open: Vec<f32> = open.map(|(d, weight)| normal.dot(*d).max(0.0) * weight).collect();
                add(&mut bounced, share, &coarse(&open), 1);
            }
            bounce::planes(&coarse(&direct), &bounced)
        });
        let mut rows = Rows::new(MAX_TERMS, channels(scene));
        rows.push_texels(planes.unwrap_or_else(|| vec![direct]), &weights, lights, face_size(scene));
        rows
    };
    let pieces: Vec<Rows> = some.par_iter().zip(direct).map(of).collect();
    let mut all = Rows::new(MAX_TERMS, channels(scene));
    pieces.into_iter().for_each(|rows| all.append(rows));
    all
}

/// Gathers what bounces to some vertices and throws it away; returns the rays. Rows of other vertices, not
/// known yet, are as long and as many as caches cannot hold.
fn bounced(scene: &Scene, world: &World, some: &[Receiver]) -> u64 {
    if bounces(scene) == 0 {
        return 0;
    }
    let bouncer = Bouncer::new(scene, world);
    let sources = vec![1.0f32; 3 * bounce::TEXELS * SOURCES];
    let of = |receiver: &Receiver, channels: usize| {
        let (mut row, length) = (vec![0.0; 3 * bounce::TEXELS], channels * bounce::TEXELS);
        for (vertex, share) in bouncer.shares(receiver) {
            add(&mut row, share, &sources[vertex as usize % SOURCES * length..][..length], channels);
        }
        std::hint::black_box(&row);
        take_ray_count()
    };
    let of_all = |channels: usize| some.par_iter().map(|receiver| of(receiver, channels)).sum::<u64>();
    // What arrives first has no colour yet.
    (0..bounces(scene)).map(|bounce| of_all(if bounce == 0 { 1 } else { 3 })).sum()
}

/// What the first `terms` of `rows` take on disk.
fn stored_bytes(rows: &Rows, terms: usize, scene: &Scene) -> f64 {
    let shapes = quantise::shapes(terms);
    let unit = unit_for(&rows.values);
    let blocks = quantise::blocks(rows, &shapes, unit);
    let meta = Meta {
        vertices: rows.count() as u32,
        face_size: face_size(scene) as u32,
        bounces: bounces(scene),
        rgb: rows.channels == 3,
        unit,
        blocks: shapes.clone(),
        rays_per_texel: 1,
    };
    let mut bytes = 0.0;
    for (block, shape) in blocks.iter().zip(&shapes) {
        for term in 0..shape.terms as usize {
            let values = (0..rows.count())
                .flat_map(|row| block.value(&meta, term, row).into_iter().take(rows.channels));
            let filled = values.filter(|value| *value != 0.0).count() as f64;
            bytes += filled * if shape.wide { 2.0 * WIDE } else { VALUE }
                + 2.0 * INDEX * filled / rows.channels as f64;
        }
    }
    bytes
}
