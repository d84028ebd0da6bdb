//! The stages that trace: rows of direct light, and of the light of each bounce.

use super::bounce::{self, Bouncer};
use super::importance;
use super::rows::{MAX_TERMS, Rows};
use super::settings::{BOUNCED_FACE_SIZE, NAME, REVISION, bounces};
use super::texels::{FACE_SIZE, Texels};
use super::visibility::transfer_row;
use crate::error::Result;
use crate::scene_hash::{Part, hash_of};
use crate::stage::Stage;
use crate::trace::held_out_lights::HeldOutLights;
use crate::trace::receivers::{Receiver, receivers};
use crate::trace::world::World;
use crate::work_log::WorkLog;
use rayon::prelude::*;
use relume_formats::basis::cubemap::FACES;
use relume_scenes::Scene;
use xxhash_rust::xxh3::xxh3_128;

/// Rows of one piece.
const PIECE: usize = 64;
/// Texels of the light where light bounces.
const COARSE: usize = FACES * BOUNCED_FACE_SIZE * BOUNCED_FACE_SIZE;

/// What runs a stage: the log that has all pieces, or `None` if others make some.
type Run<'a> = &'a dyn Fn(&dyn Stage) -> Result<Option<WorkLog>>;

/// What gathering needs at hand.
pub struct Gather<'a> {
    scene: &'a Scene,
    world: World,
    receivers: Vec<Receiver>,
    lights: &'a HeldOutLights,
    texels: Texels,
    rays_per_texel: u32,
}

/// Rows of some receivers, a piece a few of them.
struct Pieces<'a, F> {
    receivers: &'a [Receiver],
    name: String,
    label: &'static str,
    key: u128,
    rows: F,
}

impl<F: Fn(&[Receiver]) -> Vec<u8> + Sync> Stage for Pieces<'_, F> {
    fn name(&self) -> String {
        self.name.clone()
    }

    fn label(&self) -> Option<&'static str> {
        Some(self.label)
    }

    fn key(&self) -> u128 {
        self.key
    }

    fn pieces(&self) -> u32 {
        self.receivers.len().div_ceil(PIECE) as u32
    }

    fn piece(&self, number: u32) -> Result<Vec<u8>> {
        Ok((self.rows)(receivers_of(self.receivers, number)))
    }
}

fn receivers_of(receivers: &[Receiver], piece: u32) -> &[Receiver] {
    let first = piece as usize * PIECE;
    &receivers[first..(first + PIECE).min(receivers.len())]
}

impl<'a> Gather<'a> {
    /// For `scene`, under `lights` that errors are measured by.
    pub fn new(scene: &'a Scene, lights: &'a HeldOutLights, rays_per_texel: u32) -> Self {
        let texels = Texels::new(rays_per_texel.isqrt() as usize);
        Self { scene, world: World::new(scene), receivers: receivers(scene), lights, texels, rays_per_texel }
    }

    /// The key of a stage that reads `parts` of the scene. What cuts holes into surfaces is part of their
    /// textures. How many terms are wanted changes nothing of what is traced.
    fn key(&self, parts: &[Part]) -> u128 {
        let reads = hash_of(self.scene, &[&[Part::Geometry, Part::Textures][..], parts].concat());
        xxh3_128(
            format!("{reads:032x} {} {REVISION} {}", self.rays_per_texel, bounces(self.scene)).as_bytes(),
        )
    }

    /// Rows of direct light.
    pub fn direct(&self, run: Run<'_>) -> Result<Option<Rows>> {
        let weights = importance::weights(FACE_SIZE);
        let rows = |receivers: &[Receiver]| {
            let mut rows = Rows::new(MAX_TERMS, 1);
            let mut row = vec![0.0; weights.len()];
            for receiver in receivers {
                transfer_row(receiver, &self.world, &self.texels, &mut row);
                rows.push_texels(vec![row.clone()], &weights, self.lights, FACE_SIZE);
            }
            rows.encode()
        };
        // Rows bring their exact radiances under the maps with them.
        let key = self.key(&[Part::Maps]);
        let pieces =
            Pieces { receivers: &self.receivers, name: NAME.to_owned(), label: "tracing", key, rows };
        let Some(log) = run(&pieces)? else { return Ok(None) };
        let mut all = Rows::new(MAX_TERMS, 1);
        for piece in 0..pieces.pieces() {
            let count = receivers_of(&self.receivers, piece).len();
            let rows = Rows::decode(&log.read(piece)?, count, MAX_TERMS, 1);
            all.append(
                rows.ok_or_else(|| log.refuse("holds rows of another length; bake again with --force"))?,
            );
        }
        Ok(Some(all))
    }

    /// Rows of direct light and so many `bounces`, in colour.
    pub fn bounced(&self, bounces: u32, run: Run<'_>) -> Result<Option<Rows>> {
        let rows = |receivers: &[Receiver]| {
            let mut row = vec![0.0; self.texels.weights.len()];
            let of = |receiver| {
                transfer_row(receiver, &self.world, &self.texels, &mut row);
                bounce::coarse(&row, FACE_SIZE, BOUNCED_FACE_SIZE)
                    .into_iter()
                    .flat_map(f32::to_le_bytes)
                    .collect::<Vec<u8>>()
            };
            receivers.iter().flat_map(of).collect()
        };
        let pieces = Pieces {
            receivers: &self.receivers,
            name: NAME.to_owned(),
            label: "tracing",
            key: self.key(&[]),
            rows,
        };
        let Some(log) = run(&pieces)? else { return Ok(None) };
        let direct = self.dense_rows(&log, COARSE)?;
        let bouncer = Bouncer::new(self.scene, &self.world);
        let mut arriving = direct.iter().flat_map(|v| [*v; 3]).collect::<Vec<f32>>();
        let mut total = arriving.clone();
        for bounce in 1..=bounces {
            let rows = |receivers: &[Receiver]| {
                let rows = receivers.iter().flat_map(|receiver| bouncer.row(receiver, &arriving, 3 * COARSE));
                rows.flat_map(f32::to_le_bytes).collect()
            };
            let (name, key) = (format!("{NAME}-bounce-{bounce}"), self.key(&[Part::Albedos]));
            let Some(log) = run(&Pieces { receivers: &self.receivers, name, label: "bouncing", key, rows })?
            else {
                return Ok(None);
            };
            arriving = self.dense_rows(&log, 3 * COARSE)?;
            total.iter_mut().zip(&arriving).for_each(|(sum, value)| *sum += value);
        }
        Ok(Some(self.selected(&total)))
    }

    /// All values of the pieces in `log`, rows of `length`.
    fn dense_rows(&self, log: &WorkLog, length: usize) -> Result<Vec<f32>> {
        let mut all = Vec::with_capacity(self.receivers.len() * length);
        for piece in log.finished() {
            all.extend(log.read(piece)?.as_chunks().0.iter().map(|b| f32::from_le_bytes(*b)));
        }
        if all.len() != self.receivers.len() * length {
            return Err(log.refuse("holds rows of another length; bake again with --force").into());
        }
        Ok(all)
    }

    /// The most important terms of `rows`, which are of texels × RGB.
    fn selected(&self, rows: &[f32]) -> Rows {
        let weights = importance::weights(BOUNCED_FACE_SIZE);
        let selected = rows.par_chunks(PIECE * COARSE * 3).map(|piece| {
            let mut selected = Rows::new(MAX_TERMS, 3);
            for row in piece.chunks_exact(COARSE * 3) {
                let planes = (0..3).map(|c| row.iter().skip(c).step_by(3).copied().collect()).collect();
                selected.push_texels(planes, &weights, self.lights, BOUNCED_FACE_SIZE);
            }
            selected
        });
        let mut all = Rows::new(MAX_TERMS, 3);
        selected.collect::<Vec<_>>().into_iter().for_each(|rows| all.append(rows));
        all
    }
}
