//! The search for a set of spheres with little outside the solid.
//!
//! Each round changes several small groups of spheres that do not meet, side by side; what is kept of the
//! changes depends on their gain alone. At first, changes that lose a little are kept too, so that the search
//! leaves poor valleys (threshold accepting, Dueck and Scheuer 1990); what counts is the best complete set
//! that it has seen, and that never gets worse.

use super::cluster::Problem;
use super::moves::{Move, group, neighbours};
use super::random::{hash, unit};
use super::sphere::Sphere;
use super::voids;
use rayon::prelude::*;

/// Teleports tried side by side; a constant, so that the result does not depend on the number of threads.
const BATCH: usize = 8;
/// Spheres of which it is found out what splitting or deleting them would bring, each time.
const CANDIDATES: usize = 2 * BATCH;
/// What a round of small changes must gain to be worth a follow-up, in parts of the mean volume outside of a
/// sphere.
const LEAST_GAIN: f64 = 0.02;
/// Pieces as far as this from the centre, in radii, are reached out for.
const BINDS: f64 = 0.99;
/// By what shares of their radii spheres are grown, to see whether their neighbours gain more.
const GROWTHS: [f64; 4] = [0.02, 0.05, 0.1, 0.2];

/// No more pieces are split when there are so many, and so many a sphere: where a surface hugs its spheres,
/// as a ball's does, all of it binds.
const MOST_PIECES: (usize, usize) = (20_000, 200);
/// Most rounds of polishing in a row.
const POLISHES: usize = 200;

/// A set under way.
pub struct Search<'a> {
    /// What it works on.
    pub problem: Problem<'a>,
    /// The spheres; their clusters hold every piece once.
    spheres: Vec<Sphere>,
    /// The best complete set so far, and its volume outside.
    best: (Vec<Sphere>, f64),
    /// Spheres around which something has changed since they were polished.
    dirty: Vec<bool>,
    /// What splitting and what deleting each sphere would bring, where known.
    split_gains: Vec<Option<f64>>,
    deletion_costs: Vec<Option<f64>>,
    seed: u64,
    rounds: u64,
}

impl<'a> Search<'a> {
    /// Starts from `spheres`.
    pub fn new(problem: Problem<'a>, spheres: Vec<Sphere>, seed: u64) -> Self {
        let n = spheres.len();
        let best = (spheres.clone(), f64::INFINITY);
        let unknown = vec![None; n];
        let mut search = Self {
            problem,
            spheres,
            best,
            dirty: vec![true; n],
            split_gains: unknown.clone(),
            deletion_costs: unknown,
            seed,
            rounds: 0,
        };
        search.polish();
        search.keep_best();
        search
    }

    /// The best complete set.
    pub fn best(&self) -> &[Sphere] {
        &self.best.0
    }

    /// Its volume outside.
    pub fn lowest(&self) -> f64 {
        self.best.1
    }

    /// One round: keeps changes that lose less than `loss`, in parts of the mean volume outside of a sphere.
    pub fn round(&mut self, loss: f64) {
        if self.spheres.len() < 2 {
            return;
        }
        let mean = self.problem.cost(&self.spheres) / self.spheres.len() as f64;
        let moves = match self.rounds % 4 {
            0 => self.teleports(loss),
            1 => self.growths(),
            _ => self.shakes(),
        };
        self.rounds += 1;
        self.apply(moves, if loss > 0.0 { -loss * mean } else { 1e-3 * mean });
        if loss == 0.0 {
            self.polish();
        }
        self.keep_best();
    }

    /// Goes back to the best set and splits the pieces there that spheres must reach out for, if they are
    /// larger than `size`; others are put together again.
    pub fn refine(&mut self, size: f64) {
        self.spheres.clone_from(&self.best.0);
        let most = MOST_PIECES.0 + MOST_PIECES.1 * self.spheres.len();
        let mut room = most.saturating_sub(self.spheres.iter().map(|s| s.cluster.len()).sum());
        for sphere in &mut self.spheres {
            let pieces = &mut self.problem.pieces;
            let limit = (BINDS * (sphere.ball.radius + self.problem.slack)).powi(2);
            let mut cluster = Vec::new();
            for piece in pieces
                .merged(&sphere.cluster, |pieces, p| pieces.farthest_squared(p, sphere.ball.centre) <= limit)
            {
                let binds =
                    pieces.extent(piece) > size && pieces.farthest_squared(piece, sphere.ball.centre) > limit;
                let parts = if binds && room > 0 { pieces.split(piece) } else { Vec::new() };
                room = room.saturating_sub(parts.len());
                if parts.is_empty() { cluster.push(piece) } else { cluster.extend(parts) }
            }
            cluster.sort_unstable();
            if *sphere.cluster != cluster {
                *sphere = sphere.with_cluster(cluster);
            }
        }
        self.best.0.clone_from(&self.spheres);
        (0..self.spheres.len()).for_each(|i| self.touch(i));
        self.polish();
        self.keep_best();
    }

    /// Lets all spheres around which something has changed settle with their neighbours.
    fn polish(&mut self) {
        for _ in 0..POLISHES {
            let mut dirty: Vec<usize> = (0..self.spheres.len()).filter(|i| self.dirty[*i]).collect();
            if dirty.is_empty() {
                break;
            }
            dirty.sort_by(|a, b| self.spheres[*b].outside.volume.total_cmp(&self.spheres[*a].outside.volume));
            let independent = self.independent(dirty);
            independent.iter().for_each(|i| self.dirty[*i] = false);
            let moves = independent.into_par_iter().map(|i| self.problem.polish(&self.spheres, i)).collect();
            self.apply(moves, LEAST_GAIN * self.problem.cost(&self.spheres) / self.spheres.len() as f64);
        }
    }

    /// Teleports that promise most, with a little chance.
    fn teleports(&mut self, loss: f64) -> Vec<Move> {
        let mean = self.problem.cost(&self.spheres) / self.spheres.len() as f64;
        // A split gains no more than there is, so large ones are tried first; which sphere is easily done
        // without is not seen from outside, unless it covers nothing.
        let volume = |i: usize| self.spheres[i].outside.volume + mean * self.chance(4 * i as u64);
        let splits = most((0..self.spheres.len()).collect(), CANDIDATES, volume);
        let idle = |i: usize| f64::from(u8::from(self.spheres[i].cluster.is_empty()));
        let deletions =
            most((0..self.spheres.len()).collect(), CANDIDATES, |i| idle(i) + self.chance(4 * i as u64 + 1));
        let Self { problem, spheres, split_gains, deletion_costs, .. } = self;
        let (problem, spheres) = (&*problem, &*spheres);
        let fill = |known: &mut Vec<Option<f64>>, wanted: &[usize], value: &(dyn Fn(usize) -> f64 + Sync)| {
            let values: Vec<f64> =
                wanted.par_iter().map(|i| known[*i].unwrap_or_else(|| value(*i))).collect();
            wanted.iter().zip(values).for_each(|(i, value)| known[*i] = Some(value));
        };
        fill(split_gains, &splits, &|i| problem.split_gain(spheres, i));
        fill(deletion_costs, &deletions, &|i| problem.deletion_cost(spheres, i));
        let chance = |i: usize, salt: u64| (0.5 * loss + 0.1) * mean * self.chance(4 * i as u64 + salt);
        let splits = most(splits, BATCH, |i| self.split_gains[i].unwrap_or(0.0) + chance(i, 2));
        let deletions = most(deletions, BATCH, |i| chance(i, 3) - self.deletion_costs[i].unwrap_or(0.0));
        let pairs: Vec<(usize, usize)> = splits.into_iter().zip(deletions).filter(|(s, d)| s != d).collect();
        let (problem, spheres) = (&self.problem, &self.spheres);
        pairs.par_iter().filter_map(|(s, d)| problem.teleport(spheres, *s, *d)).collect()
    }

    fn growths(&self) -> Vec<Move> {
        let share = |i: usize| GROWTHS[(hash(self.key(i as u64)) % GROWTHS.len() as u64) as usize];
        self.shuffled().par_iter().map(|i| self.problem.grow(&self.spheres, *i, share(*i))).collect()
    }

    fn shakes(&self) -> Vec<Move> {
        let count = 2 + (self.rounds % 3) as usize;
        self.shuffled()
            .par_iter()
            .filter_map(|i| self.problem.shake(&self.spheres, *i, count, self.key(*i as u64)))
            .collect()
    }

    /// Spheres whose groups do not meet, by chance.
    fn shuffled(&self) -> Vec<usize> {
        let mut order: Vec<usize> = (0..self.spheres.len()).collect();
        order.sort_by_key(|i| hash(self.key(*i as u64 + (1 << 32))));
        self.independent(order)
    }

    /// A number for each use of chance.
    fn key(&self, salt: u64) -> u64 {
        hash(self.seed ^ hash(self.rounds)).wrapping_add(salt)
    }

    /// From 0 to below 1.
    fn chance(&self, salt: u64) -> f64 {
        unit(self.key(salt))
    }

    /// Those of `wanted`, in their order, whose groups do not meet those of earlier ones.
    fn independent(&self, wanted: Vec<usize>) -> Vec<usize> {
        let mut taken = vec![false; self.spheres.len()];
        let mut is_free = |i: &usize| {
            let group = group(&self.spheres, *i);
            let free = group.iter().all(|j| !taken[*j]);
            if free {
                group.into_iter().for_each(|j| taken[j] = true);
            }
            free
        };
        wanted.into_iter().filter(|i| is_free(i)).collect()
    }

    /// Carries out the moves that gain more than `least`, the best first, each unless a better one has
    /// changed its spheres.
    fn apply(&mut self, mut moves: Vec<Move>, least: f64) {
        moves.retain(|m| m.gain > least);
        moves.sort_by(|a, b| b.gain.total_cmp(&a.gain));
        let mut taken = vec![false; self.spheres.len()];
        let mut changed = Vec::new();
        for Move { indices, spheres, .. } in moves {
            if indices.iter().any(|i| taken[*i]) {
                continue;
            }
            for (i, sphere) in indices.into_iter().zip(spheres) {
                taken[i] = true;
                if self.spheres[i].ball != sphere.ball {
                    changed.push(i);
                }
                self.spheres[i] = sphere;
            }
        }
        for i in changed {
            self.touch(i);
            neighbours(&self.spheres, i, usize::MAX).into_iter().for_each(|j| self.touch(j));
        }
    }

    fn touch(&mut self, i: usize) {
        self.dirty[i] = true;
        self.split_gains[i] = None;
        self.deletion_costs[i] = None;
    }

    /// Remembers the set if it is the best so far, with what it takes to leave no void within the solid.
    fn keep_best(&mut self) {
        if self.problem.cost(&self.spheres) >= self.best.1 {
            return;
        }
        let filled = voids::fill(&mut self.problem, &mut self.spheres);
        filled.into_iter().for_each(|i| self.touch(i));
        let outside = self.problem.cost(&self.spheres);
        if outside < self.best.1 {
            self.best = (self.spheres.clone(), outside);
        }
    }
}

/// The `count` of some spheres with the highest value, in falling order.
fn most(mut spheres: Vec<usize>, count: usize, value: impl Fn(usize) -> f64) -> Vec<usize> {
    spheres.sort_by(|a, b| value(*b).total_cmp(&value(*a)).then(a.cmp(b)));
    spheres.truncate(count);
    spheres
}
