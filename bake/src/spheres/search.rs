//! The search for a set with little outside: polishing until nothing falls, then teleports. The total never rises.

use super::cluster::{Problem, Sphere, total_outside};
use super::moves::{Move, neighbours, polished_with};
use rayon::prelude::*;
use std::collections::HashSet;

/// Teleports tried side by side; a constant, so that the result does not depend on the number of threads.
const BATCH: usize = 8;
/// By what shares of their radii spheres are grown, to see whether their neighbours gain more.
const GROWTHS: [f64; 4] = [0.02, 0.05, 0.1, 0.2];
/// Teleports in a row that fail before the search is over, in spheres.
const PATIENCE: usize = 6;

/// A set under way.
pub struct Search<'a> {
    pub problem: Problem<'a>,
    /// The spheres; their clusters hold every piece once.
    pub spheres: Vec<Sphere>,
    /// Spheres around which something has changed since they were polished.
    dirty: Vec<bool>,
    /// What splitting and what deleting each sphere would bring, where known.
    split_gains: Vec<Option<f64>>,
    deletion_costs: Vec<Option<f64>>,
    /// Teleports that failed since either sphere's neighbourhood changed.
    failed: HashSet<(usize, usize)>,
    failures: usize,
    /// Spheres that have been grown in vain since something changed around them, by how many of [`GROWTHS`].
    grown: Vec<usize>,
    shakes: u64,
    pub threshold: f64,
    pub stats: [(f64, f64, usize); 5],
}

impl<'a> Search<'a> {
    /// Starts from `spheres`.
    pub fn new(problem: Problem<'a>, spheres: Vec<Sphere>) -> Self {
        let n = spheres.len();
        Self {
            problem,
            spheres,
            dirty: vec![true; n],
            split_gains: vec![None; n],
            deletion_costs: vec![None; n],
            failed: HashSet::new(),
            failures: 0,
            grown: vec![0; n],
            shakes: 0,
            threshold: 0.0,
            stats: [(0.0, 0.0, 0); 5],
        }
    }

    /// Volume outside.
    pub fn outside(&self) -> f64 {
        total_outside(&self.spheres)
    }

    /// One round; false if nothing is left to try.
    pub fn round(&mut self) -> bool {
        {
            let t = std::time::Instant::now();
            let before = self.outside();
            let kind = if self.polish_round() { 0 } else if self.teleport(1e-3 * before) { 1 } else if self.growth_round() { 2 } else if self.shake_round() { 3 } else { 4 };
            self.stats[kind].0 += before - self.outside();
            self.stats[kind].1 += t.elapsed().as_secs_f64();
            self.stats[kind].2 += 1;
            kind < 4
        }
    }

    /// Polishes some dirty spheres; false if there are none.
    pub fn polish_round(&mut self) -> bool {
        let mut dirty: Vec<usize> = (0..self.spheres.len()).filter(|i| self.dirty[*i]).collect();
        if dirty.is_empty() {
            return false;
        }
        dirty.sort_by(|a, b| self.spheres[*b].outside.volume.total_cmp(&self.spheres[*a].outside.volume));
        let independent = self.independent(dirty);
        independent.iter().for_each(|i| self.dirty[*i] = false);
        let moves = independent.into_par_iter().map(|i| self.problem.polish(&self.spheres, i)).collect();
        self.apply(moves);
        true
    }

    /// Grows some spheres; false if all have been tried.
    fn growth_round(&mut self) -> bool {
        let mut untried: Vec<usize> = (0..self.spheres.len()).filter(|i| self.grown[*i] < GROWTHS.len()).collect();
        if untried.is_empty() {
            return false;
        }
        untried.sort_by_key(|i| self.grown[*i]);
        let independent = self.independent(untried);
        let moves = independent.par_iter().map(|i| self.problem.grow(&self.spheres, *i, GROWTHS[self.grown[*i]])).collect();
        independent.iter().for_each(|i| self.grown[*i] += 1);
        self.apply(moves);
        true
    }

    fn shake_round(&mut self) -> bool {
        let n = self.spheres.len();
        let mut order: Vec<usize> = (0..n).collect();
        let key = |i: &usize| super::start::hash(self.shakes * 1_000_003 + *i as u64);
        order.sort_by_key(key);
        order.truncate(BATCH);
        let count = 2 + (self.shakes % 4) as usize;
        let moves: Vec<Move> = order.par_iter().filter_map(|i| self.problem.shake(&self.spheres, *i, count, super::start::hash(self.shakes * 64 + *i as u64))).collect();
        self.shakes += 1;
        self.failures = if self.apply(moves) { 0 } else { self.failures + BATCH };
        self.failures < PATIENCE * n
    }

    pub fn show(&mut self) {
        self.split_gains.fill(None); self.deletion_costs.fill(None);
        self.promising(f64::NEG_INFINITY);
        let v = self.problem.solid.nodes[0].moment / 3.0;
        let mut a: Vec<f64> = self.split_gains.iter().map(|x| x.unwrap() / v).collect();
        let mut b: Vec<f64> = self.deletion_costs.iter().map(|x| x.unwrap() / v).collect();
        a.sort_by(|a, b| b.total_cmp(a)); b.sort_by(f64::total_cmp);
        println!("gains {:.4?}\ncosts {:.4?}", &a[..8], &b[..8]);
        let mut seen = vec![0; self.problem.pieces.len()];
        for s in &self.spheres { for p in s.cluster.iter() { seen[*p as usize] += 1; let d = self.problem.pieces.farthest_squared(*p, s.ball.centre).sqrt(); if d > s.ball.radius * (1.0 + 1e-9) { println!("outside {d} {}", s.ball.radius); } } }
    }

    /// Anneal
    pub fn anneal(&mut self, rounds: u64, heat: f64) {
        let n = self.spheres.len();
        let mut best = self.spheres.clone();
        let mut lowest = self.outside();
        for round in 0..rounds {
            let t = 1.0 - round as f64 / rounds as f64;
            self.threshold = -heat * t * t * lowest / n as f64;
            let hash = |k: u64| super::start::hash(round * 1_000_003 + k);
            let moves: Vec<Move> = if round % 4 == 0 {
                self.promising(f64::NEG_INFINITY);
                let gains: Vec<f64> = self.split_gains.iter().map(|g| g.unwrap_or(0.0)).collect();
                let costs: Vec<f64> = self.deletion_costs.iter().map(|g| g.unwrap_or(0.0)).collect();
                let noise = |k: u64| (hash(k) >> 11) as f64 / (1_u64 << 53) as f64 * 0.5 * lowest / n as f64;
                let mut s: Vec<usize> = (0..n).collect();
                let mut d: Vec<usize> = (0..n).collect();
                s.sort_by(|a, b| (gains[*b] + noise(*b as u64)).total_cmp(&(gains[*a] + noise(*a as u64))));
                d.sort_by(|a, b| (costs[*a] + noise(1000 + *a as u64)).total_cmp(&(costs[*b] + noise(1000 + *b as u64))));
                let pairs: Vec<(usize, usize)> = s.into_iter().zip(d).filter(|(a, b)| a != b).take(BATCH).collect();
                pairs.par_iter().filter_map(|(s, d)| self.problem.teleport(&self.spheres, *s, *d)).collect()
            } else {
                let mut order: Vec<usize> = (0..n).collect();
                order.sort_by_key(|i| hash(*i as u64));
                let chosen = self.independent(order);
                let count = 2 + (round % 3) as usize;
                if round % 4 == 1 {
                    chosen.par_iter().map(|i| self.problem.grow(&self.spheres, *i, GROWTHS[(hash(7 + *i as u64) % 4) as usize])).collect()
                } else {
                    chosen.par_iter().filter_map(|i| self.problem.shake(&self.spheres, *i, count, hash(64 + *i as u64))).collect()
                }
            };
            self.apply(moves);
            if self.outside() < lowest {
                lowest = self.outside();
                best = self.spheres.clone();
            }
        }
        self.threshold = 0.0;
        self.spheres = best;
        self.dirty.fill(true);
        self.split_gains.fill(None);
        self.deletion_costs.fill(None);
        self.failed.clear();
        self.grown.fill(0);
        self.failures = 0;
    }

    /// Those of `wanted`, in their order, whose neighbourhoods do not meet those of earlier ones.
    fn independent(&self, wanted: Vec<usize>) -> Vec<usize> {
        let mut taken = vec![false; self.spheres.len()];
        let mut free = |i: &usize| {
            let group = polished_with(&self.spheres, *i);
            let free = group.iter().all(|j| !taken[*j]);
            if free {
                group.into_iter().for_each(|j| taken[j] = true);
            }
            free
        };
        wanted.into_iter().filter(|i| free(i)).collect()
    }

    fn teleport(&mut self, least: f64) -> bool {
        let pairs = self.promising(least);
        if pairs.is_empty() || self.failures > PATIENCE * self.spheres.len() {
            return false;
        }
        let moves = pairs.par_iter().filter_map(|(s, d)| self.problem.teleport(&self.spheres, *s, *d)).collect();
        self.failed.extend(&pairs);
        self.failures = if self.apply(moves) { 0 } else { self.failures + pairs.len() };
        true
    }

    /// The teleports that promise most, of those that have not failed yet.
    fn promising(&mut self, least: f64) -> Vec<(usize, usize)> {
        let Self { problem, spheres, split_gains, deletion_costs, .. } = self;
        let problem = &*problem;
        split_gains.par_iter_mut().enumerate().for_each(|(i, gain)| *gain = gain.or_else(|| Some(problem.split_gain(spheres, i))));
        deletion_costs.par_iter_mut().enumerate().for_each(|(i, cost)| *cost = cost.or_else(|| Some(problem.deletion_cost(spheres, i))));
        let n = self.spheres.len();
        let promise = |(s, d): &(usize, usize)| self.split_gains[*s].unwrap_or(0.0) - self.deletion_costs[*d].unwrap_or(0.0);
        let pairs = (0..n * n).map(|k| (k / n, k % n)).filter(|(s, d)| s != d && !self.failed.contains(&(*s, *d)));
        let mut pairs: Vec<(f64, (usize, usize))> = pairs.map(|pair| (promise(&pair), pair)).collect();
        pairs.retain(|p| p.0 > least);
        pairs.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
        pairs.truncate(BATCH);
        pairs.into_iter().map(|(_, pair)| pair).collect()
    }

    /// Carries out the moves that gain, the best first, each unless a better one has changed its spheres. True if there was one.
    fn apply(&mut self, mut moves: Vec<Move>) -> bool {
        let least = 0.02 * self.outside() / self.spheres.len() as f64;
        moves.retain(|m| m.gain > if self.threshold < 0.0 { self.threshold } else { least });
        moves.sort_by(|a, b| b.gain.total_cmp(&a.gain));
        let mut changed = vec![false; self.spheres.len()];
        for Move { indices, spheres, .. } in moves {
            if indices.iter().any(|i| changed[*i]) {
                continue;
            }
            for (i, sphere) in indices.into_iter().zip(spheres) {
                changed[i] = self.spheres[i].ball != sphere.ball;
                self.spheres[i] = sphere;
            }
        }
        for i in (0..changed.len()).filter(|i| changed[*i]) {
            self.touch(i);
            neighbours(&self.spheres, i, usize::MAX).into_iter().for_each(|j| self.touch(j));
        }
        changed.contains(&true)
    }

    fn touch(&mut self, i: usize) {
        self.dirty[i] = true;
        self.split_gains[i] = None;
        self.deletion_costs[i] = None;
        self.grown[i] = 0;
        self.failed.retain(|(s, d)| *s != i && *d != i);
    }

    /// Splits the pieces that spheres must reach out for, if they are larger than `size`. Nothing else changes; true if there were any.
    pub fn refine(&mut self, size: f64) -> bool {
        let mut any = false;
        for (i, sphere) in self.spheres.iter_mut().enumerate() {
            let pieces = &mut self.problem.pieces;
            let mut cluster = Vec::new();
            for piece in sphere.cluster.iter() {
                let extent = pieces.extent(*piece);
                let reach = pieces.farthest_squared(*piece, sphere.ball.centre).sqrt() - self.problem.slack;
                let parts = if extent > size && reach > 0.99 * sphere.ball.radius { pieces.split(*piece) } else { Vec::new() };
                if parts.is_empty() { cluster.push(*piece) } else { cluster.extend(parts) }
            }
            if cluster.len() != sphere.cluster.len() {
                cluster.sort_unstable();
                *sphere = sphere.with_cluster(cluster);
                any = true;
                self.dirty[i] = true;
                self.split_gains[i] = None;
                self.deletion_costs[i] = None;
            }
        }
        self.failed.clear();
        self.failures = 0;
        self.grown.fill(0);
        any
    }

    /// From now on with other insets: spheres grow or shrink to what their pieces need.
    pub fn set_inset(&mut self, inset: f64) {
        self.problem.pieces.set_inset(inset);
        let problem = &self.problem;
        let again = |s: &Sphere| problem.fit(s.ball.centre, s.cluster.to_vec(), 8);
        self.spheres = self.spheres.par_iter().map(again).collect();
        self.dirty.fill(true);
        self.split_gains.fill(None);
        self.deletion_costs.fill(None);
        self.failed.clear();
        self.failures = 0;
        self.grown.fill(0);
    }
}
