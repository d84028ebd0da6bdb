//! From a scene to tensors as they are stored.

use super::errors;
use super::packed::{RANKS, SECOND_RANK};
use super::ranks;
use super::reflected::{Reflected, Stages};
use super::rows::Rows;
use super::settings::{Settings, materials_of_vertices};
use super::sizes::Sizes;
use super::spaces::{Columns, spaces};
use super::stages::{Run, seen};
use super::{quantise, seen_texels};
use crate::compress::quantise::unit_for;
use crate::error::Result;
use crate::job::Job;
use crate::methods::environment_lit::environments;
use crate::methods::receiver_pieces::{PIECE, receivers_of};
use crate::methods::sparse_transfer::texels::{FACE_SIZE, Texels};
use crate::methods::sparse_transfer::visibility::rows_of;
use crate::methods::sparse_transfer::{Errors, Terms, importance, vertices};
use crate::methods::spread::spread;
use crate::trace::held_out_lights::HeldOutLights;
use crate::trace::receivers::{Receiver, receivers};
use crate::trace::world::World;
use crate::work_log::WorkLog;
use rayon::prelude::*;
use relume_formats::basis::hemisphere;
use relume_formats::kinds::transfer_tensor::Meta;
use relume_formats::kinds::{BrdfBasis, BrdfTensor, Environment, TransferTensor};
use relume_scenes::Scene;

/// Vertices at which errors are measured.
const MEASURED: usize = 768;

/// What a bake gives.
pub struct Baked {
    /// The tensors.
    pub transfer: TransferTensor,
    /// The BRDF spaces of all models.
    pub spaces: Vec<BrdfTensor>,
    /// The bases of what reflects.
    pub bases: Vec<BrdfBasis>,
    /// The maps, the scene's own first.
    pub environments: Vec<Environment>,
    /// Errors as stored.
    pub errors: Measured,
}

/// Errors under the held-out lights, as stored, in parts of what white diffuse surfaces show of their direct
/// light.
pub struct Measured {
    /// Of direct light.
    pub direct: Errors,
    /// Of what other surfaces reflect.
    pub reflected: Errors,
}

/// Direct light before it is packed.
struct Direct {
    rows: Rows,
    /// [vertices, [`hemisphere::TEXELS`]].
    seen: Vec<u8>,
}

/// Bakes `scene`. `run` makes the pieces of a stage and gives the log that has them; what is `None` there ends the bake
/// without tensors.
///
/// # Errors
/// If a log cannot be written or read, LAPACK does not converge, or the job is interrupted.
pub fn bake(scene: &Scene, settings: &Settings, job: &Job, run: Run<'_>) -> Result<Option<Baked>> {
    let preparing = job.step("preparing");
    let (world, receivers) = (World::new(scene), receivers(scene));
    let texels = Texels::new(settings.rays_per_texel.isqrt() as usize);
    drop(preparing);
    let Some(log) = seen(scene, (&world, &receivers), &texels, settings, run)? else { return Ok(None) };
    let preparing = job.step("preparing");
    let (spaces, environments) = (spaces(scene)?, environments(scene));
    drop(preparing);
    let stages = Stages { scene, world: &world, receivers: &receivers, texels: &texels, settings, job, run };
    let Some(reflected) = stages.reflected(&log, &spaces, &environments)? else { return Ok(None) };
    let preparing = job.step("preparing");
    let lights = HeldOutLights::new(&environments, FACE_SIZE, false);
    drop(preparing);
    let direct = project(scene, (&log, &receivers, &texels), &spaces, &lights, job)?;
    let (bases, meta) = (reflected.bases.clone(), meta(scene, settings, &direct.rows, &reflected));
    let (transfer, errors) = pack((direct, reflected), &lights, settings.terms, meta, job)?;
    Ok(Some(Baked { transfer, spaces, bases, environments, errors }))
}

/// The small print but for what [`pack`] chooses.
fn meta(scene: &Scene, settings: &Settings, rows: &Rows, reflected: &Reflected) -> Meta {
    Meta {
        vertices: vertices(scene) as u32,
        columns: rows.columns as u32,
        blocks: Vec::new(),
        unit: unit_for(&rows.values),
        rays_per_texel: settings.rays_per_texel,
        reflections: scene.reflections,
        clusters: reflected.clusters as u32,
        ranks: [0; 2],
        vectors: 0,
        sources: reflected.sources.clone(),
    }
}

/// The most important terms of all vertices, and what they see.
fn project(
    scene: &Scene,
    (log, receivers, texels): (&WorkLog, &[Receiver], &Texels),
    spaces: &[BrdfTensor],
    lights: &HeldOutLights,
    job: &Job,
) -> Result<Direct> {
    let weights = importance::weights(FACE_SIZE, 1);
    let columns: Vec<Columns> =
        scene.materials.iter().enumerate().map(|(m, _)| columns_of(scene, m, spaces)).collect();
    let most = spaces.iter().map(BrdfTensor::columns).max().unwrap_or(1);
    let materials = materials_of_vertices(scene);
    let measured = spread(MEASURED, receivers.len());
    let pieces = receivers.len().div_ceil(PIECE);
    let progress = job.progress("projecting", pieces as u64);
    let of_piece = |piece: usize| {
        progress.check()?;
        let (of_piece, mut vertex) = (receivers_of(receivers, piece), piece * PIECE);
        let (mut rows, mut seen) = (Rows::new(most), Vec::with_capacity(of_piece.len() * hemisphere::TEXELS));
        let read = rows_of(&log.read(piece as u32)?, of_piece, texels, |row| {
            let receiver = &receivers[vertex];
            let lights = measured.binary_search(&vertex).is_ok().then_some(lights);
            rows.push((receiver, row), (&columns[materials[vertex]], texels), &weights, lights);
            seen.extend(seen_texels::seen(receiver, row, texels));
            vertex += 1;
        });
        read.ok_or_else(|| log.refuse("holds rows of another length; bake again with --force"))?;
        progress.advance(1);
        Ok((rows, seen))
    };
    let pieces = (0..pieces).into_par_iter().map(of_piece).collect::<Result<Vec<_>>>()?;
    let mut all = Direct { rows: Rows::new(most), seen: Vec::new() };
    for (rows, mut seen) in pieces {
        all.rows.append(rows);
        all.seen.append(&mut seen);
    }
    Ok(all)
}

/// The columns of a material: all of its space if it shines, or may.
pub(super) fn columns_of(scene: &Scene, material: usize, spaces: &[BrdfTensor]) -> Columns {
    let brdf = &scene.materials[material].brdf;
    let shines = brdf.has_highlight() || scene.vary.materials.contains(&material);
    let space = spaces.iter().find(|space| shines && space.meta.model == brdf.model());
    space.map_or_else(Columns::even, Columns::new)
}

/// Rounds as many terms, functions and vectors as are wanted and measures what that leaves.
fn pack(
    (direct, reflected): (Direct, Reflected),
    lights: &HeldOutLights,
    terms: Terms,
    meta: Meta,
    job: &Job,
) -> Result<(TransferTensor, Measured)> {
    let progress = job.progress("packing", 2);
    let Direct { rows, seen } = direct;
    let by_terms = errors::by_terms(&rows, lights);
    progress.advance(1);
    progress.check()?;
    let sizes = Sizes {
        vertices: f64::from(meta.vertices),
        columns: f64::from(meta.columns),
        clusters: f64::from(meta.clusters),
        sources: meta.sources.len() as f64,
        pairs: meta.pairs().len() as f64,
    };
    let tried = (&reflected.tried.0, &reflected.tried.1);
    let chosen = ranks::choose(&by_terms, tried, &errors::mean_squares(&rows), &sizes, terms);
    let shapes = quantise::shapes(chosen.terms);
    let blocks = quantise::blocks(&rows, &shapes, meta.unit);
    let ranks = chosen.ranks.map(|rank| rank as u32);
    let meta = Meta { blocks: shapes, ranks, vectors: chosen.vectors as u32, ..meta };
    let once = reflected.once.as_ref().map(|once| ranks::cut_once(once, RANKS, chosen.ranks));
    let vectors = [SECOND_RANK, chosen.vectors];
    let twice = reflected.twice.as_ref().map(|twice| ranks::cut_twice(twice, reflected.clusters, vectors));
    let transfer = TransferTensor { meta, blocks, seen, once, twice };
    let direct = errors::of_stored(&transfer, &rows, lights);
    progress.advance(1);
    Ok((transfer, Measured { direct, reflected: chosen.reflected }))
}
