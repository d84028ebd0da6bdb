//! From a scene to tensors as they are stored.

use super::classes::Column;
use super::errors;
use super::packed::{RANKS, SECOND_RANK};
use super::rows::Rows;
use super::settings::{Settings, materials_of_vertices};
use super::spaces::{Columns, spaces};
use super::stages::{Once, Run, Twice, seen};
use super::{Arriving, Classes, cluster, quantise, seen_texels};
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
use half::f16;
use rayon::prelude::*;
use relume_formats::basis::hemisphere;
use relume_formats::kinds::transfer_tensor::{self, Meta, Source};
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
    /// Errors of direct light as stored, and before rounding.
    pub errors: [Errors; 2],
}

/// Direct light before it is packed.
struct Direct {
    rows: Rows,
    /// [vertices, [`hemisphere::TEXELS`]].
    seen: Vec<u8>,
}

/// Reflected light.
#[derive(Default)]
struct Reflected {
    sources: Vec<Source>,
    bases: Vec<BrdfBasis>,
    clusters: u32,
    once: Option<transfer_tensor::Once>,
    twice: Option<transfer_tensor::Twice>,
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
    let places = (&world, &receivers[..]);
    let Some(reflected) = reflected(scene, places, (&log, &texels), settings, job, run)? else {
        return Ok(None);
    };
    let preparing = job.step("preparing");
    let spaces = spaces(scene)?;
    let environments = environments(scene);
    let lights = HeldOutLights::new(&environments, FACE_SIZE, false);
    drop(preparing);
    let direct = project(scene, (&log, &receivers, &texels), &spaces, &lights, job)?;
    let meta = Meta {
        vertices: vertices(scene) as u32,
        columns: direct.rows.columns as u32,
        blocks: Vec::new(),
        unit: unit_for(&direct.rows.values),
        rays_per_texel: settings.rays_per_texel,
        reflections: scene.reflections,
        clusters: reflected.clusters,
        ranks: if reflected.once.is_some() { RANKS.map(|rank| rank as u32) } else { [0; 2] },
        vectors: if reflected.twice.is_some() { SECOND_RANK as u32 } else { 0 },
        sources: reflected.sources,
    };
    let bases = reflected.bases;
    let (once, twice) = (reflected.once, reflected.twice);
    let (transfer, errors) = pack(direct, &lights, settings.terms, &meta, job)?;
    Ok(Some(Baked {
        transfer: TransferTensor { once, twice, ..transfer },
        spaces,
        bases,
        environments,
        errors,
    }))
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

/// Rounds as many terms as are wanted and measures what that leaves.
fn pack(
    direct: Direct,
    lights: &HeldOutLights,
    terms: Terms,
    meta: &Meta,
    job: &Job,
) -> Result<(TransferTensor, [Errors; 2])> {
    let progress = job.progress("packing", 2);
    let Direct { rows, seen } = direct;
    let by_terms = errors::by_terms(&rows, lights);
    progress.advance(1);
    progress.check()?;
    let terms = terms.of(&by_terms);
    let shapes = quantise::shapes(terms);
    let blocks = quantise::blocks(&rows, &shapes, meta.unit);
    let meta = Meta { blocks: shapes, ..meta.clone() };
    let transfer = TransferTensor { meta, blocks, seen, once: None, twice: None };
    let stored = errors::of_stored(&transfer, &rows, lights);
    progress.advance(1);
    Ok((transfer, [stored, by_terms[terms - 1]]))
}

/// Light that other surfaces reflect, as far as `scene` asks for it; `None` if others make pieces of it.
fn reflected(
    scene: &Scene,
    places: (&World, &[Receiver]),
    (log, texels): (&WorkLog, &Texels),
    settings: &Settings,
    job: &Job,
    run: Run<'_>,
) -> Result<Option<Reflected>> {
    if scene.reflections < 2 {
        return Ok(Some(Reflected::default()));
    }
    let preparing = job.step("preparing");
    let classes = Classes::new(scene)?;
    let receivers = places.1;
    let arriving = Arriving::of_rows(receivers.len().div_ceil(PIECE), super::FACE_SIZE, |piece, give| {
        let read = rows_of(&log.read(piece as u32)?, receivers_of(receivers, piece), texels, give);
        Ok(read.ok_or_else(|| log.refuse("holds rows of another length; bake again with --force"))?)
    })?;
    let clusters = cluster::near(receivers, (cluster::VERTICES, RANKS[0]))?;
    drop(preparing);
    let stage = Once::new(scene, places, (&arriving, &classes), &clusters, settings);
    let Some(log) = run(&stage)? else { return Ok(None) };
    let (once, coarse) = gather_once(&stage, &log, &clusters, &classes)?;
    let mut reflected = Reflected {
        sources: sources(scene, &classes),
        bases: classes.bases.clone(),
        clusters: clusters.len() as u32,
        once: Some(once),
        twice: None,
    };
    if scene.reflections > 2 {
        let stage = Twice::new(scene, places, &classes, &coarse, &stage, settings)?;
        let Some(log) = run(&stage)? else { return Ok(None) };
        reflected.twice = Some(gather_twice(&stage, &log, &clusters)?);
    }
    Ok(Some(reflected))
}

/// All pieces together, and the light by coarse texels at all vertices.
fn gather_once(
    stage: &Once<'_>,
    log: &WorkLog,
    clusters: &[Vec<usize>],
    classes: &Classes,
) -> Result<(transfer_tensor::Once, Vec<f16>)> {
    let vertices: usize = clusters.iter().map(Vec::len).sum();
    let of_vertex = classes.columns.len() * RANKS[0];
    let mut once = transfer_tensor::Once {
        clusters: vec![0; vertices],
        shares: vec![0; vertices * of_vertex],
        core: Vec::new(),
        light: Vec::new(),
    };
    let mut coarse = Vec::new();
    for (number, members) in clusters.iter().enumerate() {
        let mut piece = stage.read(log, number)?;
        once.core.append(&mut piece.core);
        once.light.append(&mut piece.light);
        let of_coarse = piece.coarse.len() / members.len().max(1);
        coarse.resize(vertices * of_coarse, f16::ZERO);
        let rows = piece.shares.chunks_exact(of_vertex).zip(piece.coarse.chunks_exact(of_coarse.max(1)));
        for (vertex, (shares, light)) in members.iter().zip(rows) {
            once.clusters[*vertex] = number as u16;
            once.shares[vertex * of_vertex..][..of_vertex].copy_from_slice(shares);
            coarse[vertex * of_coarse..][..of_coarse].copy_from_slice(light);
        }
    }
    Ok((once, coarse))
}

fn gather_twice(stage: &Twice<'_>, log: &WorkLog, clusters: &[Vec<usize>]) -> Result<transfer_tensor::Twice> {
    let vertices: usize = clusters.iter().map(Vec::len).sum();
    let mut twice = transfer_tensor::Twice { shares: vec![0; vertices * SECOND_RANK], vectors: Vec::new() };
    for (number, members) in clusters.iter().enumerate() {
        let mut piece = stage.read(log, number)?;
        twice.vectors.append(&mut piece.vectors);
        for (vertex, shares) in members.iter().zip(piece.shares.chunks_exact(SECOND_RANK)) {
            twice.shares[vertex * SECOND_RANK..][..SECOND_RANK].copy_from_slice(shares);
        }
    }
    Ok(twice)
}

/// What the columns of reflected light are called in files.
pub(super) fn sources(scene: &Scene, classes: &Classes) -> Vec<Source> {
    let source = |column: &Column| Source {
        material: scene.vary.materials.get(column.class).map(|material| *material as u32),
        basis: column.basis as u32,
        channel: column.channel.map(|channel| channel as u32),
    };
    classes.columns.iter().map(source).collect()
}
