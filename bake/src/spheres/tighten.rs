//! Lets spheres that overlap settle: each in turn covers only what no other does.
//!
//! A step never adds volume outside, whatever came before: the others stay, and the one has less to cover
//! than it covered.

use super::ball::Ball;
use super::cluster::Problem;
use super::sphere::{Sphere, total_outside};
use std::sync::Arc;

/// Steps of a refit.
const STEPS: usize = 6;
/// A round that gains less than this share of the volume outside is the last.
const LEAST_GAIN: f64 = 2e-3;

/// Some spheres and all pieces that they must cover between them.
struct Group<'a> {
    problem: &'a Problem<'a>,
    spheres: Vec<Sphere>,
    pieces: Vec<u32>,
    /// Squared reach to each piece, a row for each sphere.
    reaches: Vec<Vec<f64>>,
    /// Number of spheres that hold each piece.
    holders: Vec<u32>,
}

impl Problem<'_> {
    /// Refits spheres, those at `order` in this order, for at most so many rounds. Before and after, they
    /// cover all their pieces between them.
    pub fn tighten(&self, spheres: Vec<Sphere>, order: &[usize], rounds: usize) -> Vec<Sphere> {
        let mut group = Group::new(self, spheres);
        for _ in 0..rounds {
            let before = total_outside(&group.spheres);
            order.iter().for_each(|i| group.tighten(*i));
            if before - total_outside(&group.spheres) < LEAST_GAIN * before {
                break;
            }
        }
        group.finish()
    }
}

impl<'a> Group<'a> {
    fn new(problem: &'a Problem<'a>, spheres: Vec<Sphere>) -> Self {
        let pieces: Vec<u32> = spheres.iter().flat_map(|s| s.cluster.iter()).copied().collect();
        let holders = vec![0; pieces.len()];
        let mut group = Self { problem, reaches: vec![Vec::new(); spheres.len()], spheres, pieces, holders };
        (0..group.spheres.len()).for_each(|i| group.enter(i));
        group
    }

    /// Largest squared reach that sphere `i` holds; a little more than its radius, for pieces that it just
    /// touches.
    fn limit(&self, i: usize) -> f64 {
        let Ball { radius, .. } = self.spheres[i].ball;
        if self.spheres[i].cluster.is_empty() {
            -1.0
        } else {
            ((radius + self.problem.slack) * (1.0 + 1e-12)).powi(2)
        }
    }

    fn enter(&mut self, i: usize) {
        let centre = self.spheres[i].ball.centre;
        self.reaches[i] =
            self.pieces.iter().map(|p| self.problem.pieces.farthest_squared(*p, centre)).collect();
        let limit = self.limit(i);
        self.holders
            .iter_mut()
            .zip(&self.reaches[i])
            .for_each(|(holders, reach)| *holders += u32::from(*reach <= limit));
    }

    fn leave(&mut self, i: usize) {
        let limit = self.limit(i);
        self.holders
            .iter_mut()
            .zip(&self.reaches[i])
            .for_each(|(holders, reach)| *holders -= u32::from(*reach <= limit));
    }

    fn tighten(&mut self, i: usize) {
        let sphere = &self.spheres[i];
        if sphere.outside.volume <= 0.0 || sphere.cluster.is_empty() {
            return;
        }
        let limit = self.limit(i);
        let held = self.reaches[i].iter().zip(&self.holders);
        let alone: Vec<u32> = held
            .zip(&self.pieces)
            .filter(|((reach, holders), _)| **reach <= limit && **holders == 1)
            .map(|(_, p)| *p)
            .collect();
        if sphere.bound.is_some_and(|bound| {
            bound > 0 && bound == self.problem.bound(&sphere.ball, alone.iter().copied())
        }) {
            return;
        }
        let new = if alone.is_empty() {
            Sphere::new(self.problem.solid, sphere.ball, Arc::new(alone))
        } else {
            self.problem.fit(sphere.ball.centre, alone, STEPS)
        };
        if new.cluster.is_empty() || new.outside.volume < sphere.outside.volume {
            self.leave(i);
            self.spheres[i] = new;
            self.enter(i);
        } else {
            self.spheres[i].bound = new.bound;
        }
    }

    /// Gives each piece to the sphere in which it lies deepest.
    fn finish(mut self) -> Vec<Sphere> {
        let limits: Vec<f64> = (0..self.spheres.len()).map(|i| self.limit(i)).collect();
        let mut clusters = vec![Vec::new(); self.spheres.len()];
        for (index, piece) in self.pieces.iter().enumerate() {
            let depth = |i: &usize| self.reaches[*i][index] / limits[*i];
            let holders = (0..limits.len()).filter(|i| self.reaches[*i][index] <= limits[*i]);
            if let Some(owner) = holders.min_by(|a, b| depth(a).total_cmp(&depth(b))) {
                clusters[owner].push(*piece);
            }
        }
        for (sphere, mut cluster) in self.spheres.iter_mut().zip(clusters) {
            cluster.sort_unstable();
            if *sphere.cluster != cluster {
                *sphere = sphere.with_cluster(cluster);
            }
        }
        self.spheres
    }
}
