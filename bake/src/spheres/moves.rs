//! The moves of the search: each takes a few spheres of a set and gives back as many, covering the same
//! pieces.

use super::ball::Ball;
use super::cluster::Problem;
use super::sphere::{Sphere, total_outside};
use super::start::clusters;
use glam::DVec3;
use std::sync::Arc;

/// Steps that refit a sphere after its pieces have changed.
const REFIT_STEPS: usize = 8;
/// Most rounds in which spheres settle.
const SETTLING: usize = 6;
/// The same for halves that are only compared.
const TRIAL_STEPS: usize = 3;
/// Most neighbours that a move may change with a sphere.
const NEIGHBOURS: usize = 7;

/// How far from a sphere's centre the planes lie that split it, in radii.
const OFFSETS: [f64; 3] = [0.0, 0.4, 0.75];
/// Most directions in which a sphere is split.
const MOST_EXTREMES: usize = 4;

/// New spheres in place of some.
pub struct Move {
    /// Which spheres of the set.
    pub indices: Vec<usize>,
    /// What stands in their place.
    pub spheres: Vec<Sphere>,
    /// By how much the volume outside falls; negative if it rises.
    pub gain: f64,
}

/// Spheres that overlap sphere `i`, the deepest first.
pub fn neighbours(spheres: &[Sphere], i: usize, most: usize) -> Vec<usize> {
    let ball = spheres[i].ball;
    let gap = |other: Ball| (other.centre - ball.centre).length() - other.radius - ball.radius;
    let others = (0..spheres.len()).filter(|j| *j != i).map(|j| (gap(spheres[j].ball), j));
    let mut near: Vec<(f64, usize)> = others.filter(|(gap, _)| *gap < 0.0).collect();
    near.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    near.truncate(most);
    near.into_iter().map(|(_, j)| j).collect()
}

/// A sphere and the neighbours that moves change with it.
pub fn group(spheres: &[Sphere], i: usize) -> Vec<usize> {
    let mut indices = neighbours(spheres, i, NEIGHBOURS);
    indices.insert(0, i);
    indices
}

/// Adds those of `more` that are not there yet.
fn join(indices: &mut Vec<usize>, more: Vec<usize>) {
    for i in more {
        if !indices.contains(&i) {
            indices.push(i);
        }
    }
}

impl Problem<'_> {
    /// Lets a sphere and its neighbours settle.
    pub fn polish(&self, set: &[Sphere], i: usize) -> Move {
        self.settled(set, group(set, i), |spheres| spheres, 0)
    }

    /// Lets a sphere grow by a share of its radius and its neighbours shrink to what it leaves them, then
    /// settles all.
    pub fn grow(&self, set: &[Sphere], i: usize, share: f64) -> Move {
        let change = |mut spheres: Vec<Sphere>| {
            let Ball { centre, radius } = spheres[0].ball;
            spheres[0] = Sphere::new(
                self.solid,
                Ball::new(centre, radius * (1.0 + share)),
                spheres[0].cluster.clone(),
            );
            spheres
        };
        self.settled(set, group(set, i), change, 1)
    }

    /// Throws a sphere and its nearest neighbours, `count` in all, away and starts them anew from random
    /// clusters of their pieces.
    pub fn shake(&self, set: &[Sphere], i: usize, count: usize, seed: u64) -> Option<Move> {
        let mut indices = group(set, i);
        let count = count.min(indices.len());
        let around: Vec<usize> = indices[1..count].iter().flat_map(|j| neighbours(set, *j, 4)).collect();
        join(&mut indices, around);
        let loose: Vec<u32> = indices[..count].iter().flat_map(|j| set[*j].cluster.iter()).copied().collect();
        if loose.len() < count {
            return None;
        }
        let clusters = clusters(self, &loose, count, seed);
        let replace = |mut spheres: Vec<Sphere>| {
            spheres.splice(
                ..count,
                clusters.into_iter().map(|(centre, cluster)| self.fit(centre, cluster, REFIT_STEPS)),
            );
            spheres
        };
        Some(self.settled(set, indices, replace, 0))
    }

    /// Splits one sphere and deletes another, whose neighbours take over its pieces.
    pub fn teleport(&self, set: &[Sphere], split: usize, delete: usize) -> Option<Move> {
        let mut indices = vec![split, delete];
        join(&mut indices, neighbours(set, delete, NEIGHBOURS));
        join(&mut indices, neighbours(set, split, NEIGHBOURS));
        let mut parts: Vec<Sphere> = indices.iter().map(|j| set[*j].clone()).collect();
        self.shed(&mut parts, 0);
        let halves = self.halves(&parts[0])?;
        let replace = |_| {
            let mut spheres = parts;
            let loose = spheres[1].cluster.clone();
            spheres.splice(..2, halves);
            self.refitted(&spheres, self.deal(&spheres, &loose))
        };
        Some(self.settled(set, indices, replace, 0))
    }

    /// What splitting a sphere gains.
    pub fn split_gain(&self, set: &[Sphere], i: usize) -> f64 {
        let mut parts: Vec<Sphere> = group(set, i).into_iter().map(|j| set[j].clone()).collect();
        self.shed(&mut parts, 0);
        self.halves(&parts[0])
            .map_or(f64::NEG_INFINITY, |halves| set[i].outside.volume - total_outside(&halves))
    }

    /// Gives the pieces of one sphere that others hold too to those.
    fn shed(&self, spheres: &mut [Sphere], i: usize) {
        let limits: Vec<f64> = spheres
            .iter()
            .map(|s| if s.cluster.is_empty() { -1.0 } else { (s.ball.radius + self.slack).powi(2) })
            .collect();
        let mut clusters: Vec<Vec<u32>> = vec![Vec::new(); spheres.len()];
        for piece in spheres[i].cluster.iter() {
            let holds = |j: &usize| {
                *j != i && self.pieces.farthest_squared(*piece, spheres[*j].ball.centre) <= limits[*j]
            };
            clusters[(0..limits.len()).find(holds).unwrap_or(i)].push(*piece);
        }
        for (j, (sphere, mut cluster)) in spheres.iter_mut().zip(clusters).enumerate() {
            if j == i {
                *sphere = sphere.with_cluster(cluster);
            } else if !cluster.is_empty() {
                cluster.extend(sphere.cluster.iter());
                cluster.sort_unstable();
                *sphere = sphere.with_cluster(cluster);
            }
        }
    }

    /// What deleting a sphere costs.
    pub fn deletion_cost(&self, set: &[Sphere], i: usize) -> f64 {
        if set[i].cluster.is_empty() {
            return 0.0;
        }
        let near = neighbours(set, i, NEIGHBOURS);
        if near.is_empty() {
            return f64::INFINITY;
        }
        let spheres: Vec<Sphere> = near.into_iter().map(|j| set[j].clone()).collect();
        let after = self.refitted(&spheres, self.deal(&spheres, &set[i].cluster));
        total_outside(&after) - total_outside(&spheres) - set[i].outside.volume
    }

    /// `change`s some spheres and lets them settle; the first `last` of them come last in every round.
    fn settled(
        &self,
        set: &[Sphere],
        indices: Vec<usize>,
        change: impl FnOnce(Vec<Sphere>) -> Vec<Sphere>,
        last: usize,
    ) -> Move {
        let old: Vec<Sphere> = indices.iter().map(|i| set[*i].clone()).collect();
        let before = self.cost(&old);
        let spheres = change(old);
        let mut order: Vec<usize> = (0..spheres.len()).collect();
        order.sort_by(|a, b| spheres[*b].outside.volume.total_cmp(&spheres[*a].outside.volume));
        order.sort_by_key(|i| *i < last);
        let spheres = self.tighten(spheres, &order, SETTLING);
        let gain = before - self.cost(&spheres);
        Move { indices, spheres, gain }
    }

    /// Refits those of the `new` spheres whose pieces are not the `old` ones'.
    fn refitted(&self, old: &[Sphere], new: Vec<Sphere>) -> Vec<Sphere> {
        let refit = |(old, new): (&Sphere, Sphere)| {
            if old.cluster == new.cluster { old.clone() } else { self.refit(&new, REFIT_STEPS) }
        };
        old.iter().zip(new).map(refit).collect()
    }

    /// The two spheres with the least outside that share a sphere's pieces, parted by a plane; `None` if
    /// there is none.
    ///
    /// Half of a ball needs a sphere as large as the whole, so planes that cut off caps matter more than
    /// those through the middle.
    fn halves(&self, sphere: &Sphere) -> Option<[Sphere; 2]> {
        let Ball { centre, radius } = sphere.ball;
        let middles: Vec<DVec3> = sphere.cluster.iter().map(|p| self.middle(*p)).collect();
        let parted = |(normal, offset): (DVec3, f64)| {
            let beyond = |middle: &DVec3| (*middle - centre).dot(normal) > offset * radius;
            let half = |wanted: bool| {
                let chosen =
                    sphere.cluster.iter().zip(&middles).filter(|(_, middle)| beyond(middle) == wanted);
                let (cluster, middles): (Vec<u32>, Vec<DVec3>) = chosen.map(|(p, m)| (*p, *m)).unzip();
                let start =
                    if wanted { middles.iter().sum::<DVec3>() / middles.len().max(1) as f64 } else { centre };
                (!cluster.is_empty()).then(|| self.fit(start, cluster, TRIAL_STEPS))
            };
            Some([half(false)?, half(true)?])
        };
        let planes =
            self.extremes(sphere).into_iter().flat_map(|normal| OFFSETS.map(|offset| (normal, offset)));
        let best = planes.filter_map(parted).min_by(|a, b| total_outside(a).total_cmp(&total_outside(b)))?;
        Some(best.map(|half| self.refit(&half, REFIT_STEPS)))
    }

    /// Directions in which a sphere must reach out farthest, apart from each other.
    fn extremes(&self, sphere: &Sphere) -> Vec<DVec3> {
        let limit = (0.98 * (sphere.ball.radius + self.slack)).powi(2);
        let binding =
            sphere.cluster.iter().filter(|p| self.pieces.farthest_squared(**p, sphere.ball.centre) >= limit);
        let directions: Vec<DVec3> =
            binding.map(|p| (self.middle(*p) - sphere.ball.centre).normalize_or_zero()).collect();
        let mut chosen: Vec<DVec3> = directions.first().copied().into_iter().collect();
        while chosen.len() < MOST_EXTREMES {
            let nearest = |d: &DVec3| chosen.iter().map(|c| c.dot(*d)).fold(-1.0, f64::max);
            let Some(next) = directions
                .iter()
                .min_by(|a, b| nearest(a).total_cmp(&nearest(b)))
                .filter(|d| nearest(d) < 0.9)
            else {
                break;
            };
            chosen.push(*next);
        }
        chosen
    }

    /// A sphere fitted to some pieces, starting from `centre`.
    pub fn fit(&self, centre: DVec3, cluster: Vec<u32>, steps: usize) -> Sphere {
        let positions = self.pieces.positions(&cluster);
        self.refit(&self.sphere(centre, Arc::new(cluster), &positions), steps)
    }

    /// The mean of a piece's corners.
    pub fn middle(&self, piece: u32) -> DVec3 {
        let corners = self.pieces.corners(piece);
        corners.iter().map(|c| self.pieces.point(*c)).sum::<DVec3>() / corners.len() as f64
    }
}
