//! Method `sparse-transfer`: shape and materials stay, the environment and the view vary.
//!
//! Gather: what each vertex sees of the environment, [`visibility`], and what other surfaces send it, [`bounce`]. Project: Haar, the most
//! important terms of each row, [`rows`]. Compress: blocks of integers with a scale per row, [`quantise`]. What it cannot do: highlights, lights other than
//! the environment, shadows finer than the mesh.

mod bounce;
mod errors;
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

use super::environment_lit::{environments, worst};
use super::{Traced, environment_lit};
use crate::error::{BakeError, Result};
use crate::job::Job;
use crate::trace::world::{World, take_ray_count};
use crate::work_log::WorkLog;
use bounce::Bouncer;
pub(super) use lights::{HeldOutLights, exact_radiances};
use rayon::prelude::*;
use relume_formats::Place;
use relume_formats::basis::cubemap::FACES;
use relume_formats::basis::haar;
use relume_formats::container::MAX_SECTION_BYTES;
use relume_formats::kinds::sparse_transfer::{MAX_BOUNCES, Meta};
use relume_formats::kinds::{Environment, SparseTransfer};
use relume_scenes::Scene;
use rows::Rows;
pub(super) use rows::{RADIANCES, STATES};
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Instant;
use texels::{FACE_SIZE, Texels};
use visibility::transfer_row;
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
/// Rows of one piece of the log.
const PIECE: usize = 64;
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
    /// What tracing took.
    pub traced: Traced,
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

/// Bakes `scene`. Finished pieces are in `log` already or are added to it.
///
/// # Errors
/// If the log cannot be written or read, or the job is interrupted.
pub fn bake(scene: &Scene, settings: &Settings, log: &WorkLog, job: &Job) -> Result<Baked> {
    let world = World::new(scene);
    let receivers = receivers(scene);
    let environments = environments(scene);
    let lights = HeldOutLights::new(&environments, face_size(scene));
    let start = Instant::now();
    let rays = AtomicU64::new(0);
    let gather = Gather { world: &world, receivers: &receivers, lights: &lights, log, job, rays: &rays };
    let texels = Texels::new(settings.rays_per_texel.isqrt() as usize);
    let rows = match bounces(scene) {
        0 => gather.direct(&texels)?,
        bounces => gather.bounced(scene, bounces, &texels)?,
    };
    let traced = Traced { rays: rays.into_inner(), seconds: start.elapsed().as_secs_f64() };
    let meta = Meta {
        vertices: receivers.len() as u32,
        face_size: face_size(scene) as u32,
        bounces: bounces(scene),
        rgb: rows.channels == 3,
        unit: quantise::unit_for(&rows.values),
        blocks: Vec::new(),
        rays_per_texel: settings.rays_per_texel,
    };
    let (transfer, errors) = pack(&rows, &lights, settings.terms, &meta, job)?;
    Ok(Baked { transfer, environments, errors, traced })
}

/// Rounds as many terms as are wanted and measures what that leaves.
fn pack(rows: &Rows, lights: &HeldOutLights, terms: Terms, meta: &Meta, job: &Job) -> Result<(SparseTransfer, [Errors; 2])> {
    let stage = job.stage("packing", 2);
    let by_terms = errors::by_terms(rows, lights);
    stage.advance(1);
    stage.check()?;
    let terms = terms.of(&by_terms);
    let blocks = quantise::shapes(terms);
    let transfer = SparseTransfer { blocks: quantise::blocks(rows, &blocks, meta.unit), meta: Meta { blocks, ..meta.clone() } };
    let stored = errors::of_stored(&transfer, rows, lights);
    stage.advance(1);
    Ok((transfer, [stored, by_terms[terms - 1]]))
}

/// What gathering needs at hand.
struct Gather<'a> {
    world: &'a World,
    receivers: &'a [Receiver],
    lights: &'a HeldOutLights,
    log: &'a WorkLog,
    job: &'a Job,
    rays: &'a AtomicU64,
}

impl Gather<'_> {
    fn pieces(&self) -> u32 {
        self.receivers.len().div_ceil(PIECE) as u32
    }

    fn receivers_of(&self, piece: u32) -> &[Receiver] {
        let first = piece as usize * PIECE;
        &self.receivers[first..(first + PIECE).min(self.receivers.len())]
    }

    /// Makes the pieces that the log lacks, numbered from `first`.
    fn fill_log(&self, stage: &'static str, first: u32, make: impl Fn(u32) -> Vec<u8> + Sync) -> Result<()> {
        let finished = self.log.finished();
        let missing: Vec<u32> = (0..self.pieces()).filter(|piece| finished.binary_search(&(first + piece)).is_err()).collect();
        let stage = self.job.stage(stage, missing.len() as u64);
        missing.par_iter().try_for_each(|&piece| {
            stage.check()?;
            let bytes = make(piece);
            self.rays.fetch_add(take_ray_count(), Ordering::Relaxed);
            self.log.append(first + piece, &bytes)?;
            stage.advance(1);
            Ok::<_, BakeError>(())
        })
    }

    /// Rows of direct light.
    fn direct(&self, texels: &Texels) -> Result<Rows> {
        let weights = importance::weights(FACE_SIZE);
        self.fill_log("tracing", 0, |piece| {
            let mut rows = Rows::new(MAX_TERMS, 1);
            let mut row = vec![0.0; weights.len()];
            for receiver in self.receivers_of(piece) {
                transfer_row(receiver, self.world, texels, &mut row);
                push(&mut rows, vec![row.clone()], &weights, self.lights, FACE_SIZE);
            }
            rows.encode()
        })?;
        let mut all = Rows::new(MAX_TERMS, 1);
        for piece in 0..self.pieces() {
            let count = self.receivers_of(piece).len();
            let rows = Rows::decode(&self.log.read(piece)?, count, MAX_TERMS, 1);
            all.append(rows.ok_or_else(|| self.log.refuse("holds rows of another length; bake again with --force"))?);
        }
        Ok(all)
    }

    /// Rows of direct light and so many `bounces`, in colour.
    fn bounced(&self, scene: &Scene, bounces: u32, texels: &Texels) -> Result<Rows> {
        let coefficients = FACES * BOUNCED_FACE_SIZE * BOUNCED_FACE_SIZE;
        self.fill_log("tracing", 0, |piece| {
            let mut row = vec![0.0; texels.weights.len()];
            let of = |receiver| {
                transfer_row(receiver, self.world, texels, &mut row);
                bounce::coarse(&row, FACE_SIZE, BOUNCED_FACE_SIZE).into_iter().flat_map(f32::to_le_bytes).collect::<Vec<u8>>()
            };
            self.receivers_of(piece).iter().flat_map(of).collect()
        })?;
        let direct = self.dense_rows(0, coefficients)?;
        let bouncer = Bouncer::new(scene, self.world);
        let mut arriving = direct.iter().flat_map(|v| [*v; 3]).collect::<Vec<f32>>();
        let mut total = arriving.clone();
        for bounce in 1..=bounces {
            let first = bounce * self.pieces();
            self.fill_log("bouncing", first, |piece| {
                let rows = self.receivers_of(piece).iter().flat_map(|receiver| bouncer.row(receiver, &arriving, 3 * coefficients));
                rows.flat_map(f32::to_le_bytes).collect()
            })?;
            arriving = self.dense_rows(first, 3 * coefficients)?;
            total.iter_mut().zip(&arriving).for_each(|(sum, value)| *sum += value);
        }
        Ok(self.selected(&total, coefficients))
    }

    /// All values of the pieces from `first` on, rows of `length`.
    fn dense_rows(&self, first: u32, length: usize) -> Result<Vec<f32>> {
        let mut all = Vec::with_capacity(self.receivers.len() * length);
        for piece in 0..self.pieces() {
            let bytes = self.log.read(first + piece)?;
            all.extend(bytes.as_chunks().0.iter().map(|b| f32::from_le_bytes(*b)));
        }
        if all.len() != self.receivers.len() * length {
            return Err(self.log.refuse("holds rows of another length; bake again with --force").into());
        }
        Ok(all)
    }

    /// The most important terms of `rows`, which are of texels × RGB.
    fn selected(&self, rows: &[f32], coefficients: usize) -> Rows {
        let weights = importance::weights(BOUNCED_FACE_SIZE);
        let selected = rows.par_chunks(PIECE * coefficients * 3).map(|piece| {
            let mut selected = Rows::new(MAX_TERMS, 3);
            for row in piece.chunks_exact(coefficients * 3) {
                let planes = (0..3).map(|c| row.iter().skip(c).step_by(3).copied().collect()).collect();
                push(&mut selected, planes, &weights, self.lights, BOUNCED_FACE_SIZE);
            }
            selected
        });
        let mut all = Rows::new(MAX_TERMS, 3);
        selected.collect::<Vec<_>>().into_iter().for_each(|rows| all.append(rows));
        all
    }
}

/// Adds a row given by texels, one plane per channel.
fn push(rows: &mut Rows, mut planes: Vec<Vec<f32>>, weights: &[f32], lights: &HeldOutLights, face_size: usize) {
    let exact = exact_radiances(&planes, lights);
    planes.iter_mut().for_each(|plane| haar::forward_cube(plane, face_size));
    rows.push(&planes, weights, &exact);
}
