//! Small parts of a film on which the filter is tried.

use super::{Pilot, TILE, WINDOW};
use crate::filter::seen::{Seen, half_of};
use crate::filter::{self, Film, Fragment};
use crate::interrupted::Interrupted;
use crate::job::{Job, Progress, ProgressMode};
use crate::trace::gather::GatherPath;
use crate::trace::tile_counts::TileCounts;
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::ops::Range;

/// A few tiles on which the filter is tried.
pub struct Window {
    /// How often it was found.
    weight: f64,
    /// From which pixels to which all neighbours that there are in the film are in it, too.
    whole: [Range<i32>; 2],
    /// Its pixels, with what is seen of each class so far, and by how many samples.
    pixels: Vec<(u32, BTreeMap<usize, Seen>, u32)>,
}

impl Window {
    /// The one whose upper left tile is at `place`, in tiles of a film of `size` pixels.
    pub fn new(place: [u32; 2], weight: f64, size: [u32; 2]) -> Self {
        let [xs, ys] = [0, 1].map(|k| place[k] * TILE..((place[k] + WINDOW) * TILE).min(size[k]));
        let whole = [(&xs, size[0]), (&ys, size[1])].map(|(side, all)| {
            let within = |is_end: bool| if is_end { 0 } else { filter::RADIUS };
            let [from, to] = [side.start, side.end].map(|end| end as i32);
            from + within(from == 0)..to - within(side.end == all)
        });
        let pixels = ys.flat_map(|y| xs.clone().map(move |x| (y * size[0] + x, BTreeMap::new(), 0)));
        Self { weight, whole, pixels: pixels.collect() }
    }

    /// Traces as many more samples as are missing. What there was becomes the first half.
    ///
    /// # Errors
    /// If the job is interrupted.
    pub fn trace(
        &mut self,
        pilot: &Pilot<'_>,
        counts: &TileCounts,
        progress: &Progress,
    ) -> Result<(), Interrupted> {
        self.pixels.par_iter_mut().try_for_each(|(pixel, classes, traced)| {
            progress.check()?;
            let wanted = counts.of(*pixel);
            let known = *traced;
            classes.values_mut().for_each(Seen::join_halves);
            let mut number = 0;
            pilot.gather.some_of_pixel(*pixel, known..wanted, |path| {
                if let GatherPath::Surface(eye) = path {
                    let seen = classes.entry(pilot.class(eye.spot.material)).or_default();
                    let half = if known > 0 { 1 } else { half_of(number, wanted) };
                    pilot.watcher.add(path, half, seen);
                }
                number += 1;
            });
            *traced = wanted;
            Ok(())
        })
    }

    /// Its weight, and what part of its noise, squared, the filter leaves; `None` in the dark.
    ///
    /// # Errors
    /// If the job is interrupted.
    pub fn left(&self, width: u32, counts: &TileCounts) -> Result<Option<(f64, f64)>, Interrupted> {
        let seen = self.pixels.iter().flat_map(|(pixel, classes, _)| {
            classes.iter().map(|(class, seen)| (*pixel, *class as u16, *seen))
        });
        let film = Film::new(width, |pixel| counts.of(pixel), seen);
        let is_whole = |fragment: &Fragment| {
            let pixel = film.pixel(fragment);
            self.whole.iter().zip(pixel).all(|(range, at)| range.contains(&at))
        };
        let noise = filter::noise_of(&film, is_whole, &Job::new(ProgressMode::None))?;
        let part = noise.filter(|noise| noise.before > 0.0).map(|noise| (noise.after / noise.before).powi(2));
        Ok(part.map(|part| (self.weight, part)))
    }
}
