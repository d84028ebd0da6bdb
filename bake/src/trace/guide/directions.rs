//! From which directions light comes: a density over the sphere, by squares of an equal-area map.

use super::sphere::{direction_at, square_at};
use glam::Vec3A;
use std::f32::consts::PI;

/// Squares along a side, and all of them; each is 6° across.
const SIDE: usize = 32;
const BINS: usize = SIDE * SIDE;
/// By how many visits a square leans on what is known around its place.
const LEANING: f32 = 8.0;
/// Parts of a slot: the least that a number in [0, 1) of 24 bits tells apart once a quarter of such numbers
/// has chosen among the slots.
const GRAINS: f64 = 2048.0;

/// What was seen in which direction, square by square.
#[derive(Debug, Clone)]
pub struct Tally {
    squares: Box<[f32; BINS]>,
    visits: Box<[u32; BINS]>,
}

impl Default for Tally {
    fn default() -> Self {
        Self { squares: Box::new([0.0; BINS]), visits: Box::new([0; BINS]) }
    }
}

impl Tally {
    /// Adds the square of what came from `direction`, 0 included.
    pub fn add(&mut self, direction: Vec3A, square: f32) {
        let bin = bin_of(direction);
        self.squares[bin] += square;
        self.visits[bin] += 1;
    }

    /// Adds what `other` has.
    pub fn merge(&mut self, other: &Self) {
        self.squares.iter_mut().zip(other.squares.iter()).for_each(|(sum, square)| *sum += square);
        self.visits.iter_mut().zip(other.visits.iter()).for_each(|(sum, visits)| *sum += visits);
    }

    /// The mean square of every direction; of few visits, that is nearly what is known `around`.
    pub fn mean_squares(&self, around: Option<&MeanSquares>) -> MeanSquares {
        let mean = |bin: usize| {
            let before = around.map_or(0.0, |around| around[bin]);
            (self.squares[bin] + LEANING * before) / (self.visits[bin] as f32 + LEANING)
        };
        Box::new(std::array::from_fn(mean))
    }
}

/// By square.
pub type MeanSquares = Box<[f32; BINS]>;

/// A density over the sphere, even within each square.
#[derive(Debug, Clone)]
pub struct Directions {
    slots: Box<[Slot; BINS]>,
    /// Per steradian.
    densities: Box<[f32; BINS]>,
}

/// One of as many evenly likely choices as there are squares (Walker's alias method): the square of its
/// number up to a share of it, another beyond.
#[derive(Debug, Clone, Copy)]
struct Slot {
    /// In grains.
    share: u16,
    beyond: u16,
}

impl Slot {
    fn share(self) -> f32 {
        f32::from(self.share) / GRAINS as f32
    }
}

impl Directions {
    /// In proportion to the root of mean squares, which of all densities has the least variance. Where all
    /// are 0, all directions are alike.
    pub fn new(squares: &MeanSquares) -> Self {
        let light = squares.iter().map(|square| f64::from(square.sqrt()));
        let total: f64 = light.clone().sum();
        let filled: Vec<f64> =
            light.map(|light| if total > 0.0 { light / total * BINS as f64 } else { 1.0 }).collect();
        let slots = slots(filled);
        // What the slots come to: their shares are rounded.
        let mut chances = [0.0f32; BINS];
        for (bin, slot) in slots.iter().enumerate() {
            chances[bin] += slot.share();
            chances[usize::from(slot.beyond)] += 1.0 - slot.share();
        }
        Self { slots, densities: Box::new(chances.map(|chance| chance / (4.0 * PI))) }
    }

    /// The direction that three numbers in [0, 1) choose, and its density per steradian.
    pub fn sample(&self, choice: f32, [u, v]: [f32; 2]) -> (Vec3A, f32) {
        let at = choice * BINS as f32;
        let number = (at as usize).min(BINS - 1);
        let slot = self.slots[number];
        let bin = if at - (number as f32) < slot.share() { number } else { usize::from(slot.beyond) };
        let [x, y] = [bin % SIDE, bin / SIDE].map(|at| at as f32);
        (direction_at([(x + u) / SIDE as f32, (y + v) / SIDE as f32]), self.densities[bin])
    }

    /// Density per steradian with which [`Directions::sample`] chooses `direction`.
    pub fn density(&self, direction: Vec3A) -> f32 {
        self.densities[bin_of(direction)]
    }
}

/// Pours what squares have beyond the mean of 1 into those that have less.
fn slots(mut filled: Vec<f64>) -> Box<[Slot; BINS]> {
    let mut slots = Box::new([Slot { share: GRAINS as u16, beyond: 0 }; BINS]);
    let (mut low, mut high): (Vec<usize>, Vec<usize>) = (0..BINS).partition(|bin| filled[*bin] < 1.0);
    while let (Some(poor), Some(rich)) = (low.pop(), high.last().copied()) {
        let share = (filled[poor] * GRAINS).round();
        slots[poor] = Slot { share: share as u16, beyond: rich as u16 };
        filled[rich] -= 1.0 - share / GRAINS;
        if filled[rich] < 1.0 {
            high.pop();
            low.push(rich);
        }
    }
    slots
}

/// The square that a direction falls in.
fn bin_of(direction: Vec3A) -> usize {
    let [x, y] = square_at(direction).map(|s| ((s * SIDE as f32) as usize).min(SIDE - 1));
    y * SIDE + x
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::trace::sampler::PixelSampler;

    /// A bright cap of 20° around `axis`, seen by evenly spread looks.
    fn cap(axis: Vec3A, looks: u32) -> Tally {
        let (sampler, mut tally) = (PixelSampler::new(5, 0), Tally::default());
        for look in 0..looks {
            let direction = direction_at(sampler.sample(look).pair(0));
            tally.add(direction, if direction.dot(axis) > 0.94 { 9.0 } else { 0.0 });
        }
        tally
    }

    /// Of every density the mean over the sphere is 1 / 4π, and the mean of 1 / density over its samples the
    /// part of the sphere that it is not 0 on, times 4π.
    #[test]
    fn samples_follow_the_density() {
        let axis = Vec3A::new(0.3, -0.8, 0.5).normalize();
        let squares = cap(axis, 1 << 16).mean_squares(None);
        let directions = Directions::new(&squares);
        let sampler = PixelSampler::new(1, 0);
        let points = (0..1 << 16).map(|k| (sampler.sample(k).pair(1)[0], sampler.sample(k).pair(0)));
        let (mut mean, mut inverse, mut inside, mut others) = (0.0f64, 0.0f64, 0, 0);
        for (choice, point) in points.clone() {
            mean += f64::from(directions.density(direction_at(point)));
            let (direction, density) = directions.sample(choice, point);
            others += u32::from((directions.density(direction) - density).abs() > 1e-4 * density);
            inverse += f64::from(density).recip();
            inside += u32::from(direction.dot(axis) > 0.85);
        }
        let n = points.len() as f64;
        assert!((mean / n * f64::from(4.0 * PI) - 1.0).abs() < 1e-3, "{mean}");
        let part = squares.iter().filter(|square| **square > 0.0).count() as f64 / BINS as f64;
        assert!((inverse / n / f64::from(4.0 * PI) / part - 1.0).abs() < 0.01, "{inverse} {part}");
        assert!(f64::from(inside) > 0.999 * n, "{inside}");
        // A direction on a square's edge may round into the next one.
        assert!(f64::from(others) < 1e-4 * n, "{others}");
    }

    /// Every square is chosen as often as its density says, though its share of a slot is rounded: choices
    /// are as fine as those of a quarter of the samples.
    #[test]
    fn squares_are_chosen_as_their_densities_say() {
        let squares: MeanSquares = Box::new(std::array::from_fn(|bin| (1e-4 * (bin * bin) as f32).powi(2)));
        let directions = Directions::new(&squares);
        let mut hits = [0.0f64; BINS];
        let choices = 1 << 22;
        for k in 0..choices {
            let (direction, _) = directions.sample(k as f32 / choices as f32, [0.5; 2]);
            hits[bin_of(direction)] += 1.0;
        }
        for (bin, hits) in hits.iter().enumerate() {
            let said = f64::from(directions.densities[bin] * 4.0 * PI) / BINS as f64;
            assert!((hits / f64::from(choices) - said).abs() < 1e-9, "{bin}: {hits} {said}");
        }
    }

    /// The root of the mean square: what is four times as bright in the square is looked at twice as often.
    #[test]
    fn density_goes_by_the_root() {
        let mut squares: MeanSquares = Box::new([0.0; BINS]);
        (squares[7], squares[1000]) = (1.0, 4.0);
        let directions = Directions::new(&squares);
        let sampler = PixelSampler::new(2, 0);
        let hits = |bin| {
            (0..30_000)
                .filter(|k| {
                    bin_of(directions.sample(sampler.sample(*k).pair(1)[0], sampler.sample(*k).pair(0)).0)
                        == bin
                })
                .count()
        };
        let (one, two) = (hits(7), hits(1000));
        assert!((one as f64 / 10_000.0 - 1.0).abs() < 0.02 && one + two > 29_900, "{one} {two}");
    }

    #[test]
    fn few_visits_lean_on_what_is_around() {
        let axis = Vec3A::Y;
        let around = cap(axis, 1 << 16).mean_squares(None);
        let nothing = Tally::default().mean_squares(Some(&around));
        assert_eq!(nothing, around);
        let other = cap(-axis, 1 << 16).mean_squares(Some(&around));
        assert!(other[bin_of(-axis)] > 5.0 && other[bin_of(axis)] < 1.0);
        // Nothing at all was seen: all directions are alike.
        let even = Directions::new(&Tally::default().mean_squares(None));
        assert!((even.density(axis) * 4.0 * PI - 1.0).abs() < 1e-6);
    }
}
