//! What a bake will take, from a few of its vertices.

use super::bake::columns_of;
use super::fit::predicted_bytes;
use super::packed::{RANKS, SECOND_RANK};
use super::rows::Rows;
use super::settings::{Settings, materials_of_vertices};
use super::sizes::Sizes;
use super::spaces::{Columns, spaces};
use super::{Arriving, Classes, Gather, cluster, errors};
use crate::error::Result;
use crate::job::Job;
use crate::method::Predicted;
use crate::methods::environment_lit::{self, environments};
use crate::methods::sparse_transfer::importance;
use crate::methods::sparse_transfer::texels::{FACE_SIZE, Texels};
use crate::methods::sparse_transfer::visibility::transfer_row;
use crate::methods::spread::spread;
use crate::trace::held_out_lights::HeldOutLights;
use crate::trace::receivers::{Receiver, receivers};
use crate::trace::world::{World, reset_ray_counts, take_ray_count};
use rayon::prelude::*;
use relume_scenes::Scene;
use std::time::Instant;

/// Vertices whose rows are found.
const VERTICES: usize = 96;
/// Vertices whose light after a reflection is gathered.
const GATHERED: usize = 24;
/// Seconds that decomposing takes on one core, for a vertex and source of a cluster, from docs/notes/TRANSFER-TENSOR.md.
const DECOMPOSED: f64 = 1.2e-3;
/// Bytes a second that are packed, compressed and written.
const PACKED: f64 = 2e7;

/// What baking `scene` with `settings` will take.
///
/// # Errors
/// If the job is interrupted, or LAPACK does not converge.
pub fn predict(settings: &Settings, scene: &Scene, job: &Job) -> Result<Predicted> {
    let (world, receivers) = (World::new(scene), receivers(scene));
    let spaces = spaces(scene)?;
    let lights = HeldOutLights::new(&environments(scene), FACE_SIZE, false);
    let columns: Vec<Columns> = (0..scene.materials.len()).map(|m| columns_of(scene, m, &spaces)).collect();
    let (most, materials) =
        (columns.iter().map(Columns::count).max().unwrap_or(1), materials_of_vertices(scene));
    let (texels, weights) =
        (Texels::new(settings.rays_per_texel.isqrt() as usize), importance::weights(FACE_SIZE, 1));
    let some = spread(VERTICES, receivers.len());
    let scale = receivers.len() as f64 / some.len().max(1) as f64;
    let progress = job.progress("predicting", some.len() as u64);
    reset_ray_counts();
    let start = Instant::now();
    let of_vertex = |vertex: &usize| {
        progress.check()?;
        let (receiver, mut row) = (&receivers[*vertex], vec![0.0; texels.weights.len()]);
        transfer_row(receiver, &world, &texels, &mut row);
        let mut rows = Rows::new(most);
        rows.push((receiver, &row), (&columns[materials[*vertex]], &texels), &weights, Some(&lights));
        progress.advance(1);
        Ok((rows, take_ray_count()))
    };
    let traced = some.par_iter().map(of_vertex).collect::<Result<Vec<_>>>()?;
    let mut seconds = start.elapsed().as_secs_f64() * scale;
    let mut rays = traced.iter().map(|(_, rays)| *rays as f64).sum::<f64>() * scale;
    let mut all = Rows::new(most);
    traced.into_iter().for_each(|(rows, _)| all.append(rows));
    let terms = settings.terms.of(&errors::by_terms(&all, &lights));
    let vertices = receivers.len() as f64;
    let sizes = Sizes { vertices, columns: most as f64, clusters: 0.0, sources: 0.0, pairs: 0.0 };
    let mut own = sizes.of_terms(terms) + sizes.of_seen();
    if scene.reflections > 1 {
        let reflected = reflected(settings, scene, &world, &receivers)?;
        (seconds, rays, own) = (seconds + reflected.seconds, rays + reflected.rays, own + reflected.bytes);
    }
    Ok(Predicted {
        tells: Vec::new(),
        rays,
        seconds: seconds + 2.0 * own / PACKED,
        bytes: own + environment_lit::stored_bytes(scene)? as f64,
        memory: predicted_bytes(scene),
        chosen: Some(terms),
    })
}

/// What reflected light adds.
struct Added {
    seconds: f64,
    rays: f64,
    bytes: f64,
}

fn reflected(settings: &Settings, scene: &Scene, world: &World, receivers: &[Receiver]) -> Result<Added> {
    let classes = Classes::new(scene)?;
    // As if nothing stood in the way of the light that surfaces receive, which takes as long or longer.
    let texels = Texels::new(1);
    let arriving = Arriving::open(receivers, &texels, super::FACE_SIZE);
    let gather = Gather::new(scene, (world, receivers), &arriving, &classes, settings.seed)
        .with_rays(settings.samples);
    let some = spread(GATHERED, receivers.len());
    reset_ray_counts();
    let start = Instant::now();
    let of_vertex = |vertex: &usize| {
        let mut tensor = vec![0.0; gather.shape().iter().product()];
        gather.tensor(*vertex, &mut tensor);
        std::hint::black_box(&tensor);
        take_ray_count()
    };
    let rays: u64 = some.par_iter().map(of_vertex).sum();
    let (vertices, scale) = (receivers.len() as f64, receivers.len() as f64 / some.len().max(1) as f64);
    let sources = classes.columns.len() as f64;
    let decomposing = DECOMPOSED * vertices * sources / rayon::current_num_threads() as f64;
    let (clusters, pairs) = (vertices / cluster::VERTICES as f64, classes.pairs().len() as f64);
    let sizes = Sizes { vertices, columns: 0.0, clusters, sources, pairs };
    let vectors = if scene.reflections > 2 { SECOND_RANK } else { 0 };
    let bytes = sizes.of_ranks(RANKS) + sizes.of_vectors(vectors);
    // Light that was reflected twice takes a quarter of the rays, and less for each.
    let again = if scene.reflections > 2 { 1.25 } else { 1.0 };
    let seconds = again * start.elapsed().as_secs_f64() * scale + decomposing;
    Ok(Added { seconds, rays: again * rays as f64 * scale, bytes })
}
