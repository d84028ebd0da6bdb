//! Light that other surfaces reflect, from its stages to tensors as they are stored, with as many functions and
//! vectors as there are.

use super::classes::Column;
use super::packed::{RANKS, SECOND_RANK};
use super::ranks::{States, Tried};
use super::settings::Settings;
use super::stages::{Once, Run, Twice};
use super::{Arriving, Classes, FACE_SIZE, cluster};
use crate::error::Result;
use crate::job::Job;
use crate::methods::receiver_pieces::{PIECE, receivers_of};
use crate::methods::sparse_transfer::texels::Texels;
use crate::methods::sparse_transfer::visibility::rows_of;
use crate::trace::receivers::Receiver;
use crate::trace::world::World;
use crate::work_log::WorkLog;
use half::f16;
use relume_formats::kinds::transfer_tensor::{self, Source};
use relume_formats::kinds::{BrdfBasis, BrdfTensor, Environment};
use relume_scenes::Scene;

/// Reflected light.
pub(super) struct Reflected {
    pub(super) sources: Vec<Source>,
    pub(super) bases: Vec<BrdfBasis>,
    pub(super) clusters: usize,
    pub(super) once: Option<transfer_tensor::Once>,
    pub(super) twice: Option<transfer_tensor::Twice>,
    /// What fewer functions, and fewer vectors, leave out.
    pub(super) tried: (Tried<[usize; 2]>, Tried<usize>),
}

/// What the stages of reflected light are made of.
pub(super) struct Stages<'a> {
    pub(super) scene: &'a Scene,
    pub(super) world: &'a World,
    pub(super) receivers: &'a [Receiver],
    pub(super) texels: &'a Texels,
    pub(super) settings: &'a Settings,
    pub(super) job: &'a Job,
    pub(super) run: Run<'a>,
}

impl Stages<'_> {
    /// As much as the scene asks for, behind what vertices see, which is in `log`; `None` if others make pieces of
    /// it.
    ///
    /// # Errors
    /// If a log cannot be written or read, LAPACK does not converge, or the job is interrupted.
    pub(super) fn reflected(
        &self,
        log: &WorkLog,
        spaces: &[BrdfTensor],
        environments: &[Environment],
    ) -> Result<Option<Reflected>> {
        let mut reflected = Reflected {
            sources: Vec::new(),
            bases: Vec::new(),
            clusters: 0,
            once: None,
            twice: None,
            tried: (Tried::once(), Tried::twice()),
        };
        if self.scene.reflections < 2 {
            return Ok(Some(reflected));
        }
        let preparing = self.job.step("preparing");
        let classes = Classes::new(self.scene)?;
        let arriving = self.arriving(log)?;
        let clusters = cluster::near(self.receivers, (cluster::VERTICES, RANKS[0]))?;
        let states = States::new((self.scene, self.receivers), &classes, spaces, environments)?;
        drop(preparing);
        (reflected.sources, reflected.bases) = (sources(self.scene, &classes), classes.bases.clone());
        reflected.clusters = clusters.len();
        let places = (self.world, self.receivers);
        let stage = Once::new(self.scene, places, (&arriving, &classes), &clusters, self.settings);
        let Some(log) = (self.run)(&stage)? else { return Ok(None) };
        let (once, coarse) = gather_once((&stage, &log), &clusters, &mut reflected, &states)?;
        reflected.once = Some(once);
        if self.scene.reflections > 2 {
            let stage = Twice::new(self.scene, places, &classes, &coarse, &stage, self.settings)?;
            let Some(log) = (self.run)(&stage)? else { return Ok(None) };
            reflected.twice = Some(gather_twice((&stage, &log), &clusters, &mut reflected.tried.1, &states)?);
        }
        Ok(Some(reflected))
    }

    /// What arrives at vertices before any reflection.
    fn arriving(&self, log: &WorkLog) -> Result<Arriving> {
        let pieces = self.receivers.len().div_ceil(PIECE);
        Arriving::of_rows(pieces, FACE_SIZE, |piece, give| {
            let read =
                rows_of(&log.read(piece as u32)?, receivers_of(self.receivers, piece), self.texels, give);
            Ok(read.ok_or_else(|| log.refuse("holds rows of another length; bake again with --force"))?)
        })
    }
}

/// All pieces together, and the light by coarse texels at all vertices.
fn gather_once(
    (stage, log): (&Once<'_>, &WorkLog),
    clusters: &[Vec<usize>],
    reflected: &mut Reflected,
    states: &States<'_>,
) -> Result<(transfer_tensor::Once, Vec<f16>)> {
    let vertices: usize = clusters.iter().map(Vec::len).sum();
    let of_vertex = reflected.sources.len() * RANKS[0];
    let mut once = transfer_tensor::Once {
        clusters: vec![0; vertices],
        shares: vec![0; vertices * of_vertex],
        core: Vec::new(),
        light: Vec::new(),
    };
    let mut coarse = Vec::new();
    for (number, members) in clusters.iter().enumerate() {
        let mut piece = stage.read(log, number)?;
        reflected.tried.0.add(&piece, members, states);
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

fn gather_twice(
    (stage, log): (&Twice<'_>, &WorkLog),
    clusters: &[Vec<usize>],
    tried: &mut Tried<usize>,
    states: &States<'_>,
) -> Result<transfer_tensor::Twice> {
    let vertices: usize = clusters.iter().map(Vec::len).sum();
    let mut twice = transfer_tensor::Twice { shares: vec![0; vertices * SECOND_RANK], vectors: Vec::new() };
    for (number, members) in clusters.iter().enumerate() {
        let mut piece = stage.read(log, number)?;
        tried.add(&piece, members.len(), states);
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
