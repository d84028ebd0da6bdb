//! The fragments of all tiles in a log, with the sums of their channels.

use super::tiles::{Tile, TileFragment};
use crate::error::Result;
use crate::filter::{Film, LAYERS};
use crate::interrupted::Interrupted;
use crate::job::{Job, Progress};
use crate::work_log::WorkLog;
use rayon::prelude::*;
use std::ops::Range;

/// Tiles that are in memory at a time.
const BATCH: u32 = 64;

/// What the channels of a fragment are.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Channels {
    /// Their number.
    pub count: usize,
    /// Those of each layer of light, which noise is filtered out of.
    pub layers: [Vec<Range<usize>>; LAYERS],
}

/// A fragment with the sums of its channels.
pub type Record<'a> = (TileFragment, &'a [f32]);

/// A log that has all tiles.
#[derive(Clone, Copy)]
pub struct Records<'a> {
    /// Where they are.
    pub log: &'a WorkLog,
    /// Their number.
    pub tiles: u32,
    /// What channels fragments of materials that vary have, and those of fixed ones.
    pub channels: &'a [Channels; 2],
    /// The class of everything fixed.
    pub fixed: u16,
    /// How many samples pixels have.
    pub samples: &'a (dyn Fn(u32) -> u32 + Sync),
}

impl Records<'_> {
    /// What is seen of all fragments beside their channels.
    ///
    /// # Errors
    /// If the log cannot be read or the job is interrupted.
    pub fn film(&self, width: u32, job: &Job) -> Result<Film> {
        let progress = job.progress("reading", u64::from(self.tiles));
        let mut seen = Vec::new();
        self.for_each_batch(
            &progress,
            |_| true,
            |records| {
                seen.extend(records.iter().map(|(f, _)| (f.pixel, f.class, f.seen)));
            },
        )?;
        Ok(Film::new(width, self.samples, seen.into_iter()))
    }

    /// Tile number `tile`, as it was traced or filtered: what surfaces emit is not in the sums.
    ///
    /// # Errors
    /// If the log cannot be read.
    pub fn tile(&self, tile: u32) -> Result<Tile> {
        Ok(Tile::decode(&self.log.read(tile)?))
    }

    /// The same in means over samples, with what surfaces emit in the first channels of the fixed class.
    ///
    /// # Errors
    /// If the log cannot be read.
    pub fn mean_tile(&self, tile: u32) -> Result<Tile> {
        Ok(self.means(self.tile(tile)?))
    }

    /// The records of `tile`.
    ///
    /// # Errors
    /// If it is of another layout.
    pub fn of<'t>(&self, tile: &'t Tile) -> Result<Vec<Record<'t>>> {
        let mut values = tile.values.as_slice();
        let mut record = |fragment: &TileFragment| {
            let (record, rest) =
                values.split_at_checked(self.channels_of(fragment).count).ok_or_else(|| {
                    self.log.refuse("holds a tile that does not fit the layout; bake again with --force")
                })?;
            values = rest;
            Ok((*fragment, record))
        };
        tile.fragments.iter().map(&mut record).collect()
    }

    /// Those of a fragment.
    pub(super) fn channels_of(&self, fragment: &TileFragment) -> &Channels {
        &self.channels[usize::from(self.is_fixed(fragment))]
    }

    fn is_fixed(&self, fragment: &TileFragment) -> bool {
        fragment.class == self.fixed
    }

    /// Hands over the records of some tiles at a time, in their order, as far as they are `wanted`; means over
    /// samples now, in the first channels of which is what surfaces emit.
    ///
    /// # Errors
    /// If the log cannot be read or the job is interrupted.
    pub fn for_each_batch(
        &self,
        progress: &Progress,
        wanted: impl Fn(&TileFragment) -> bool,
        mut each: impl FnMut(&[Record<'_>]),
    ) -> Result<()> {
        for first in (0..self.tiles).step_by(BATCH as usize) {
            progress.check().map_err(|Interrupted| Interrupted)?;
            let batch = first..self.tiles.min(first + BATCH);
            let read = |id: u32| self.mean_tile(id);
            let tiles = batch.clone().into_par_iter().map(read).collect::<Result<Vec<Tile>>>()?;
            let mut records = Vec::new();
            for tile in &tiles {
                records.extend(self.of(tile)?.into_iter().filter(|(fragment, _)| wanted(fragment)));
            }
            each(&records);
            progress.advance(u64::from(batch.end - batch.start));
        }
        Ok(())
    }

    /// Means over samples, with what surfaces emit in the first channels of the fixed class.
    fn means(&self, mut tile: Tile) -> Tile {
        let mut values = tile.values.as_mut_slice();
        for fragment in &tile.fragments {
            // Of another layout: refused as it is read.
            let Some((record, rest)) = values.split_at_mut_checked(self.channels_of(fragment).count) else {
                break;
            };
            if self.is_fixed(fragment) {
                record.iter_mut().zip(fragment.seen.emitted).for_each(|(sum, emitted)| *sum += emitted);
            }
            let samples = (self.samples)(fragment.pixel) as f32;
            record.iter_mut().for_each(|value| *value /= samples);
            values = rest;
        }
        tile
    }
}
