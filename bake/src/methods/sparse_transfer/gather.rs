//! The stages that trace: what vertices see of the environment, and the light of each bounce. Nothing in
//! their logs depends on a map, or on how many terms are wanted.

use super::bounce::{self, Bouncer, TEXELS};
use super::settings::{NAME, REVISION};
use super::texels::Texels;
use super::visibility::{encode, look, rows_of};
use crate::compress::floats::{from_planes, to_planes};
use crate::compress::frame::{grow, shrink};
use crate::error::Result;
use crate::job::Job;
use crate::methods::receiver_pieces::{PIECE, Pieces, receivers_of};
use crate::scene_hash::{Part, hash_of};
use crate::stage::Stage;
use crate::trace::receivers::{Receiver, receivers};
use crate::trace::world::World;
use crate::work_log::WorkLog;
use rayon::prelude::*;
use relume_formats::Error;
use relume_scenes::Scene;
use xxhash_rust::xxh3::xxh3_128;

/// Values of a row of light that bounced.
const BOUNCED: usize = 3 * TEXELS;

/// What runs a stage: the log that has all pieces, or `None` if others make some.
pub type Run<'a> = &'a dyn Fn(&dyn Stage) -> Result<Option<WorkLog>>;

/// What gathering needs at hand.
pub struct Gather<'a> {
    scene: &'a Scene,
    world: World,
    receivers: Vec<Receiver>,
    texels: Texels,
    rays_per_texel: u32,
    job: &'a Job,
}

/// What was traced: rows of all vertices, as logs.
pub struct Logs {
    /// What vertices see.
    direct: WorkLog,
    /// The light of each bounce.
    bounces: Vec<WorkLog>,
}

fn refuse(log: &WorkLog) -> Error {
    log.refuse("holds rows of another length; bake again with --force")
}

impl<'a> Gather<'a> {
    /// For `scene`.
    pub fn new(scene: &'a Scene, rays_per_texel: u32, job: &'a Job) -> Self {
        let texels = Texels::new(rays_per_texel.isqrt() as usize);
        Self { scene, world: World::new(scene), receivers: receivers(scene), texels, rays_per_texel, job }
    }

    /// Pieces of rows.
    pub fn pieces(&self) -> usize {
        self.receivers.len().div_ceil(PIECE)
    }

    /// The key of the stage called `name`, which reads `parts` of the scene. What cuts holes into surfaces is
    /// part of their textures.
    fn key(&self, name: &str, parts: &[Part]) -> u128 {
        let reads = hash_of(self.scene, &[&[Part::Geometry, Part::Textures][..], parts].concat());
        xxh3_128(format!("{reads:032x} {name} {} {REVISION}", self.rays_per_texel).as_bytes())
    }

    /// Traces direct light and so many `bounces`; `None` if others make pieces of it.
    ///
    /// # Errors
    /// If a log cannot be written or read, or the user interrupts.
    pub fn trace(&self, bounces: u32, run: Run<'_>) -> Result<Option<Logs>> {
        let bytes = |receivers: &[Receiver]| {
            let seen = receivers.iter().map(|receiver| look(receiver, &self.world, &self.texels));
            Ok(encode(&seen.collect::<Vec<_>>())?)
        };
        let (name, key) = (NAME.to_owned(), self.key(NAME, &[]));
        let direct = run(&Pieces { receivers: &self.receivers, name, label: "tracing", key, bytes })?;
        let Some(direct) = direct else { return Ok(None) };
        let mut logs = Logs { direct, bounces: Vec::new() };
        if bounces > 0 && !self.bounce(&mut logs, bounces, run)? {
            return Ok(None);
        }
        Ok(Some(logs))
    }

    /// Traces so many `bounces` of the direct light in `logs`; whether all of it is there.
    fn bounce(&self, logs: &mut Logs, bounces: u32, run: Run<'_>) -> Result<bool> {
        let bouncer = Bouncer::new(self.scene, &self.world);
        let (mut arriving, mut channels) = (self.dense(TEXELS, |piece| self.coarse(&logs.direct, piece))?, 1);
        for bounce in 1..=bounces {
            let bytes = |receivers: &[Receiver]| {
                let rows = receivers.iter().flat_map(|receiver| bouncer.row(receiver, &arriving, channels));
                Ok(shrink(&to_planes(&rows.collect::<Vec<_>>()))?)
            };
            let name = format!("{NAME}-bounce-{bounce}");
            let key = self.key(&name, &[Part::Albedos]);
            let log = run(&Pieces { receivers: &self.receivers, name, label: "bouncing", key, bytes })?;
            let Some(log) = log else { return Ok(false) };
            if bounce < bounces {
                // One set of rows at a time.
                drop(std::mem::take(&mut arriving));
                (arriving, channels) = (self.dense(BOUNCED, |piece| self.bounced(&log, piece))?, 3);
            }
            logs.bounces.push(log);
        }
        Ok(true)
    }

    /// The rows that `of_piece` gives, of `length` values, one after the other.
    fn dense(&self, length: usize, of_piece: impl Fn(usize) -> Result<Vec<f32>> + Sync) -> Result<Vec<f32>> {
        let progress = self.job.progress("summing", self.pieces() as u64);
        let mut all = vec![0.0; self.receivers.len() * length];
        all.par_chunks_mut(PIECE * length).enumerate().try_for_each(|(piece, rows)| {
            progress.check()?;
            rows.copy_from_slice(&of_piece(piece)?);
            progress.advance(1);
            Ok::<_, crate::error::BakeError>(())
        })?;
        Ok(all)
    }

    /// Gives the rows of direct light of a piece, one after the other.
    fn direct(&self, log: &WorkLog, piece: usize, give: impl FnMut(&[f32])) -> Result<()> {
        let receivers = receivers_of(&self.receivers, piece);
        let rows = rows_of(&log.read(piece as u32)?, receivers, &self.texels, give);
        Ok(rows.ok_or_else(|| refuse(log))?)
    }

    /// The rows of direct light of a piece from the coarser light, [rows, texels].
    fn coarse(&self, log: &WorkLog, piece: usize) -> Result<Vec<f32>> {
        let mut rows = Vec::with_capacity(PIECE * TEXELS);
        self.direct(log, piece, |row| rows.append(&mut bounce::coarse(row)))?;
        Ok(rows)
    }

    /// The rows of a bounce of a piece, [rows, texels, RGB].
    fn bounced(&self, log: &WorkLog, piece: usize) -> Result<Vec<f32>> {
        let bytes = receivers_of(&self.receivers, piece).len() * BOUNCED * size_of::<f32>();
        let planes = grow(&log.read(piece as u32)?, bytes).filter(|planes| planes.len() == bytes);
        Ok(from_planes(&planes.ok_or_else(|| refuse(log))?))
    }

    /// Gives the rows of a piece one after the other, each as a plane of texels for every channel: what was
    /// seen, and behind it, where light bounces, what all bounces bring.
    ///
    /// # Errors
    /// If a log cannot be read, or holds something else.
    pub fn rows(&self, logs: &Logs, piece: usize, mut give: impl FnMut(Vec<Vec<f32>>)) -> Result<()> {
        if logs.bounces.is_empty() {
            return self.direct(&logs.direct, piece, |row| give(vec![row.to_vec()]));
        }
        let direct = self.coarse(&logs.direct, piece)?;
        let mut bounced = vec![0.0; 3 * direct.len()];
        for log in &logs.bounces {
            bounced.iter_mut().zip(self.bounced(log, piece)?).for_each(|(sum, value)| *sum += value);
        }
        for (direct, bounced) in direct.chunks_exact(TEXELS).zip(bounced.chunks_exact(BOUNCED)) {
            give(bounce::planes(direct, bounced));
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::super::settings::BOUNCED_FACE_SIZE;
    use super::super::test_scene::test_scene;
    use super::*;
    use crate::compress::floats::LARGEST_ERROR;
    use crate::job::ProgressMode;
    use crate::methods::environment_lit::environments;
    use crate::trace::held_out_lights::{HeldOutLights, RADIANCES, STATES, exact_radiances};

    /// Neither rows nor light are negative anywhere, so that radiance changes by no larger a part than a
    /// value of a row does; where the errors of many texels cancel, by far less.
    #[test]
    fn what_the_log_of_a_bounce_rounds_is_nothing() {
        let (scene, job) = (test_scene(), Job::new(ProgressMode::None));
        let gather = Gather::new(&scene, 4, &job);
        let folder = tempfile::tempdir().unwrap();
        let run = |stage: &dyn Stage| {
            let log = WorkLog::create(&folder.path().join(stage.name()), stage.key())?;
            crate::stage::fill(stage, &log, crate::stage::Share::WHOLE, &job)?;
            Ok(Some(log))
        };
        let logs = gather.trace(1, &run).unwrap().unwrap();
        let direct = gather.dense(TEXELS, |piece| gather.coarse(&logs.direct, piece)).unwrap();
        let stored = gather.dense(BOUNCED, |piece| gather.bounced(&logs.bounces[0], piece)).unwrap();
        let bouncer = Bouncer::new(&scene, &gather.world);
        let rows: Vec<f32> = gather.receivers.iter().flat_map(|r| bouncer.row(r, &direct, 1)).collect();
        let lights = HeldOutLights::new(&environments(&scene), BOUNCED_FACE_SIZE, false);
        let radiances = |rows: &[f32]| -> Vec<[f32; RADIANCES]> {
            let planes =
                |row: &[f32]| [0, 1, 2].map(|c| row.iter().skip(c).step_by(3).copied().collect()).to_vec();
            rows.chunks_exact(BOUNCED).map(|row| exact_radiances(&planes(row), &lights).seen).collect()
        };
        let (stored, exact) = (radiances(&stored), radiances(&rows));
        for state in 0..STATES {
            let (mut off, mut norm) = (0.0, 0.0);
            for (stored, exact) in stored.iter().zip(&exact) {
                for c in 3 * state..3 * state + 3 {
                    off += f64::from(stored[c] - exact[c]).powi(2);
                    norm += f64::from(exact[c]).powi(2);
                }
            }
            let error = (off / norm).sqrt();
            println!("light {state}: {error:.2e}");
            assert!(error > 0.0 && error <= f64::from(LARGEST_ERROR), "{error}");
        }
    }
}
