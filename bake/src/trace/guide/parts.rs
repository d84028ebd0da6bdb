//! How many of the paths follow a guide: as many as would have had the least variance.

use crate::trace::gather::Onward;
use crate::trace::orientation::ORIENTATIONS;
use glam::Vec3A;

/// The choices.
const PARTS: [f32; 5] = [0.0, 0.25, 0.5, 0.7, 0.85];
/// Tiles of the film along a side: wider than those of directions, as this takes more paths to know.
pub(super) const TILES: usize = 8;
/// What a path takes where a guide is asked, in parts of what it takes else.
const COST: f64 = 1.3;
/// How much the whole film counts beside a cell.
const LEANING: f64 = 0.3;

/// What the variance would have been by each choice, place by place.
pub struct Trials {
    /// Of tiles by row, each by orientation; second moments, by choice.
    moments: Vec<[f64; PARTS.len()]>,
}

/// One path as it was traced.
#[derive(Debug, Clone, Copy)]
pub struct Trial<'a> {
    /// The square of what it found, over the density with which it went that way.
    pub moment: f32,
    /// The way that it went.
    pub onward: &'a Onward,
}

impl Default for Trials {
    /// Without any.
    fn default() -> Self {
        Self { moments: vec![[0.0; PARTS.len()]; TILES * TILES * ORIENTATIONS] }
    }
}

impl Trials {
    /// Adds a path from a surface of this unit normal.
    pub fn add(&mut self, normal: Vec3A, trial: &Trial<'_>) {
        let Onward { place, densities: [guide, lobes], of_light, .. } = *trial.onward;
        for (moment, part) in self.moments[cell(place, normal)].iter_mut().zip(PARTS) {
            let density = part * guide + (1.0 - part) * lobes + of_light;
            *moment += f64::from(trial.moment) / f64::from(density.max(f32::MIN_POSITIVE));
        }
    }

    /// The best choice for each place. Cells count more the more light is lost in them, and lean on the film
    /// as a whole, which alone counts where no light was found.
    pub fn parts(&self) -> Parts {
        let mut all = [0.0; PARTS.len()];
        self.moments.iter().for_each(|of| all.iter_mut().zip(of).for_each(|(sum, moment)| *sum += moment));
        let relative = |of: &[f64; PARTS.len()], k: usize| if of[0] > 0.0 { of[k] / of[0] } else { 0.0 };
        let best = |of: &[f64; PARTS.len()]| {
            let leaning = |k: usize| {
                let cost = if k == 0 { 1.0 } else { COST };
                cost * (relative(of, k) + LEANING * relative(&all, k))
            };
            let choice = (0..PARTS.len()).min_by(|a, b| leaning(*a).total_cmp(&leaning(*b)));
            choice.map_or(0.0, |k| PARTS[k])
        };
        Parts(self.moments.iter().map(best).collect())
    }
}

/// The part of the paths that follow a guide, place by place.
pub struct Parts(Vec<f32>);

impl Parts {
    /// Half of them everywhere.
    pub fn half() -> Self {
        Self(vec![0.5; TILES * TILES * ORIENTATIONS])
    }

    /// At a surface of this normal, seen at `place`.
    pub fn at(&self, place: [f32; 2], normal: Vec3A) -> f32 {
        self.0[cell(place, normal)]
    }
}

/// The cell of a place, which may be beyond the film, and of a normal.
fn cell(place: [f32; 2], normal: Vec3A) -> usize {
    super::cell(place, normal, TILES)
}
