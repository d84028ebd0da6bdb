//! From a scene to rows as they are stored.

use super::errors::{self, Errors};
use super::gather::{Gather, Logs, Run};
use super::rows::{MAX_TERMS, Rows};
use super::settings::{Settings, Terms, bounces, channels, cubes, face_size, vertices};
use super::{importance, quantise};
use crate::compress::quantise::unit_for;
use crate::error::Result;
use crate::job::Job;
use crate::methods::environment_lit::environments;
use crate::trace::held_out_lights::HeldOutLights;
use rayon::prelude::*;
use relume_formats::kinds::sparse_transfer::Meta;
use relume_formats::kinds::{Environment, SparseTransfer};
use relume_scenes::Scene;

/// What a bake gives.
pub struct Baked {
    /// The rows.
    pub transfer: SparseTransfer,
    /// The maps, the scene's own first.
    pub environments: Vec<Environment>,
    /// Errors at the vertices as stored, and before rounding.
    pub errors: [Errors; 2],
}

/// Bakes `scene`. `run` makes the pieces of a stage and gives the log that has them; what is `None` there
/// ends the bake without rows.
///
/// # Errors
/// If a log cannot be written or read, or the job is interrupted.
pub fn bake(scene: &Scene, settings: &Settings, job: &Job, run: Run<'_>) -> Result<Option<Baked>> {
    let preparing = job.step("preparing");
    let gather = Gather::new(scene, settings.rays_per_texel, job);
    drop(preparing);
    let Some(logs) = gather.trace(bounces(scene), run)? else { return Ok(None) };
    let preparing = job.step("preparing");
    let environments = environments(scene);
    let lights = HeldOutLights::new(&environments, face_size(scene), bounces(scene) > 0);
    drop(preparing);
    let rows = project(scene, &gather, &logs, &lights, job)?;
    let meta = Meta {
        vertices: vertices(scene) as u32,
        face_size: face_size(scene) as u32,
        bounces: bounces(scene),
        rgb: rows.channels == 3,
        unit: unit_for(&rows.values),
        blocks: Vec::new(),
        rays_per_texel: settings.rays_per_texel,
    };
    let (transfer, errors) = pack(&rows, &lights, settings.terms, &meta, job)?;
    Ok(Some(Baked { transfer, environments, errors }))
}

/// The most important terms of all rows in `logs`, and what each row is worth under `lights`.
fn project(
    scene: &Scene,
    gather: &Gather<'_>,
    logs: &Logs,
    lights: &HeldOutLights,
    job: &Job,
) -> Result<Rows> {
    let (size, channels) = (face_size(scene), channels(scene));
    let weights = importance::weights(size, cubes(scene));
    let progress = job.progress("projecting", gather.pieces() as u64);
    let of_piece = |piece: usize| {
        progress.check()?;
        let mut rows = Rows::new(MAX_TERMS, channels);
        gather.rows(logs, piece, |planes| rows.push_texels(planes, &weights, lights, size))?;
        progress.advance(1);
        Ok(rows)
    };
    let pieces = (0..gather.pieces()).into_par_iter().map(of_piece).collect::<Result<Vec<Rows>>>()?;
    let mut all = Rows::new(MAX_TERMS, channels);
    pieces.into_iter().for_each(|rows| all.append(rows));
    Ok(all)
}

/// Rounds as many terms as are wanted and measures what that leaves.
fn pack(
    rows: &Rows,
    lights: &HeldOutLights,
    terms: Terms,
    meta: &Meta,
    job: &Job,
) -> Result<(SparseTransfer, [Errors; 2])> {
    let progress = job.progress("packing", 2);
    let by_terms = errors::by_terms(rows, lights);
    progress.advance(1);
    progress.check()?;
    let terms = terms.of(&by_terms);
    let blocks = quantise::shapes(terms);
    let transfer = SparseTransfer {
        blocks: quantise::blocks(rows, &blocks, meta.unit),
        meta: Meta { blocks, ..meta.clone() },
    };
    let stored = errors::of_stored(&transfer, rows, lights);
    progress.advance(1);
    Ok((transfer, [stored, by_terms[terms - 1]]))
}
