//! Method `sparse-transfer`: shape and materials stay, the environment and the view vary.
//!
//! Gather: what each vertex sees of the environment, [`visibility`], and what other surfaces send it, [`bounce`]. Project: Haar, the most
//! important terms of each row, [`rows`]. Compress: blocks of integers with a scale per row, [`quantise`]. What it cannot do: highlights, lights other than
//! the environment, shadows finer than the mesh.

mod bounce;
mod errors;
mod gather;
mod importance;
mod lights;
mod method;
mod prediction;
mod quantise;
mod registered;
mod rows;
mod sweep;
mod texels;
mod visibility;

pub use errors::Errors;
pub use method::Wanted;
pub use registered::METHOD;
pub use rows::MAX_TERMS;
pub use sweep::SWEEP;

use super::environment_lit;
use super::environment_lit::{environments, worst};
use crate::error::{BakeError, Result};
use crate::job::Job;
use crate::stage::Stage;
use crate::work_log::WorkLog;
use gather::Gather;
pub(super) use lights::{HeldOutLights, exact_radiances};
use relume_formats::Place;
use relume_formats::basis::cubemap::FACES;
use relume_formats::basis::haar;
use relume_formats::container::MAX_SECTION_BYTES;
use relume_formats::kinds::sparse_transfer::{MAX_BOUNCES, Meta};
use relume_formats::kinds::{Environment, SparseTransfer};
use relume_scenes::Scene;
use rows::Rows;
pub(super) use rows::{RADIANCES, STATES};
use texels::FACE_SIZE;
pub(crate) use visibility::{Receiver, receivers};

#[cfg(test)]
mod ablation;
#[cfg(test)]
mod accuracy_table;

/// Name of the method.
pub const NAME: &str = relume_formats::method::SPARSE_TRANSFER.name;
/// Changes whenever the same scene and settings give other bytes than before.
pub const REVISION: u32 = 1;
/// Texels along a side of the light's faces where light bounces.
const BOUNCED_FACE_SIZE: usize = 16;
/// What rounding to bytes may add to an error, as a factor: the number of terms is chosen to leave room for it.
const ROUNDING: f64 = 1.05;

/// The settings that change results.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// Rays a texel where visibility changes: a square number.
    pub rays_per_texel: u32,
    /// How many terms to keep.
    pub terms: Terms,
}

/// How many terms to keep.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Terms {
    /// This many.
    Number(usize),
    /// As many as keep the relative L2 error under every held-out light below this.
    Error(f64),
}

impl Terms {
    /// How many these are for rows with errors `by_terms`, those of the first 1, 2, … terms.
    fn of(self, by_terms: &[Errors]) -> usize {
        match self {
            Self::Number(terms) => terms.min(by_terms.len()),
            Self::Error(max) => 1 + by_terms[..by_terms.len() - 1].iter().take_while(|e| worst(*e) * ROUNDING > max).count(),
        }
    }
}

/// What a bake gives.
pub struct Baked {
    /// The rows.
    pub transfer: SparseTransfer,
    /// The maps, the scene's own first.
    pub environments: Vec<Environment>,
    /// Errors at the vertices as stored, and before rounding.
    pub errors: [Errors; 2],
}

/// Fails, naming what stands in the way, unless the method can show `scene`.
pub fn expect_fit(scene: &Scene) -> Result<()> {
    let place = Place::file(&scene.file);
    let refuse = |reason: String| Err(BakeError::invalid(&place, reason));
    if scene.vary.shape {
        return refuse(format!("[vary] shape = true, but {NAME} keeps shapes fixed; set it to false"));
    }
    environment_lit::expect_fit(scene, NAME)?;
    if bounces(scene) > MAX_BOUNCES {
        let most = MAX_BOUNCES + 1;
        return refuse(format!("[render] reflections = {}, {NAME} models at most {most}; lower it", scene.reflections));
    }
    Ok(())
}

fn bounces(scene: &Scene) -> u32 {
    scene.reflections - 1
}

fn face_size(scene: &Scene) -> usize {
    if bounces(scene) > 0 { BOUNCED_FACE_SIZE } else { FACE_SIZE }
}

fn channels(scene: &Scene) -> usize {
    if bounces(scene) > 0 { 3 } else { 1 }
}

fn vertices(scene: &Scene) -> usize {
    scene.objects.iter().map(|o| o.mesh.positions.len()).sum()
}

/// Fails if a file of the bundle could not hold the rows of `scene`.
pub fn expect_sizes(scene: &Scene) -> Result<()> {
    // The largest section is a block of sixteen columns of 16-bit integers.
    let most = MAX_SECTION_BYTES / (16 * 2 * channels(scene) as u64);
    let vertices = vertices(scene) as u64;
    if vertices > most {
        let reason = format!("{vertices} vertices, {NAME} holds at most {most} of this kind; simplify the meshes");
        return Err(BakeError::invalid(&Place::file(&scene.file), reason));
    }
    Ok(())
}

/// Bytes that a bake holds at most: selected rows twice over, the hierarchy, the lights; where light bounces also all coefficients of all rows.
pub fn predicted_bytes(scene: &Scene) -> u64 {
    let (vertices, channels, size) = (vertices(scene) as u64, channels(scene) as u64, face_size(scene) as u64);
    let triangles: u64 = scene.objects.iter().map(|o| o.mesh.triangles.len() as u64).sum();
    let coefficients = FACES as u64 * size * size;
    let selected = vertices * (MAX_TERMS as u64 * (2 + 4 * channels) + 4 * RADIANCES as u64);
    // Direct rows, then in colour their sum, what arrives, and what arrives next.
    let dense = if bounces(scene) > 0 { vertices * coefficients * 4 * (1 + 3 * 3) } else { 0 };
    let lights = coefficients * RADIANCES as u64 * 4 * 5;
    2 * selected + dense + triangles * 600 + lights + (64 << 20)
}

/// Bakes `scene`. `run` makes the pieces of a stage and gives the log that has them; what is `None` there ends the bake without rows.
///
/// # Errors
/// If a log cannot be written or read, or the job is interrupted.
pub fn bake(scene: &Scene, settings: &Settings, job: &Job, run: &dyn Fn(&dyn Stage) -> Result<Option<WorkLog>>) -> Result<Option<Baked>> {
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
        unit: quantise::unit_for(&rows.values),
        blocks: Vec::new(),
        rays_per_texel: settings.rays_per_texel,
    };
    let (transfer, errors) = pack(&rows, &lights, settings.terms, &meta, job)?;
    Ok(Some(Baked { transfer, environments, errors }))
}

/// Rounds as many terms as are wanted and measures what that leaves.
fn pack(rows: &Rows, lights: &HeldOutLights, terms: Terms, meta: &Meta, job: &Job) -> Result<(SparseTransfer, [Errors; 2])> {
    let progress = job.progress("packing", 2);
    let by_terms = errors::by_terms(rows, lights);
    progress.advance(1);
    progress.check()?;
    let terms = terms.of(&by_terms);
    let blocks = quantise::shapes(terms);
    let transfer = SparseTransfer { blocks: quantise::blocks(rows, &blocks, meta.unit), meta: Meta { blocks, ..meta.clone() } };
    let stored = errors::of_stored(&transfer, rows, lights);
    progress.advance(1);
    Ok((transfer, [stored, by_terms[terms - 1]]))
}

/// Adds a row given by texels, one plane per channel.
fn push(rows: &mut Rows, mut planes: Vec<Vec<f32>>, weights: &[f32], lights: &HeldOutLights, face_size: usize) {
    let exact = exact_radiances(&planes, lights);
    planes.iter_mut().for_each(|plane| haar::forward_cube(plane, face_size));
    rows.push(&planes, weights, &exact);
}
