//! From a scene to rows as they are stored.

use super::errors::{self, Errors};
use super::gather::Gather;
use super::quantise;
use super::rows::Rows;
use super::settings::{Settings, Terms, bounces, face_size, vertices};
use crate::compress::quantise::unit_for;
use crate::error::Result;
use crate::job::Job;
use crate::methods::environment_lit::environments;
use crate::stage::Stage;
use crate::trace::held_out_lights::HeldOutLights;
use crate::work_log::WorkLog;
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
pub fn bake(
    scene: &Scene,
    settings: &Settings,
    job: &Job,
    run: &dyn Fn(&dyn Stage) -> Result<Option<WorkLog>>,
) -> Result<Option<Baked>> {
    let environments = environments(scene);
    let lights = HeldOutLights::new(&environments, face_size(scene));
    let gather = Gather::new(scene, &lights, settings.rays_per_texel);
    let rows = match bounces(scene) {
        0 => gather.direct(run)?,
        bounces => gather.bounced(bounces, run)?,
    };
    let Some(rows) = rows else { return Ok(None) };
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
