//! How pieces are dealt to spheres.

use super::ball::Ball;
use super::growth::Growth;
use super::motion::Motion;
use super::pieces::Pieces;
use super::sphere::Sphere;
use super::triangle_tree::TriangleTree;
use glam::DVec3;
use std::sync::Arc;

/// What spheres are fitted to.
pub struct Problem<'a> {
    /// Boundary of the solid.
    pub solid: &'a TriangleTree,
    /// What must be covered.
    pub pieces: Pieces<'a>,
    /// How far outside its sphere a piece may reach; 0 for complete coverage.
    pub slack: f64,
    /// How the solid moves.
    pub motion: &'a Motion,
}

/// A sphere while pieces are dealt.
struct Bidder<'a> {
    growth: &'a Growth,
    centre: DVec3,
    radius: f64,
    volume: f64,
    won: Vec<u32>,
}

impl<'a> Bidder<'a> {
    fn of(sphere: &'a Sphere, solid: &TriangleTree) -> Self {
        let (radius, volume) =
            if sphere.cluster.is_empty() { (0.0, 0.0) } else { (sphere.ball.radius, sphere.outside.volume) };
        Self { growth: sphere.growth(solid), centre: sphere.ball.centre, radius, volume, won: Vec::new() }
    }

    /// What reaching so far would add to the volume outside.
    fn cost(&self, distance: f64) -> f64 {
        if distance <= self.radius { 0.0 } else { (self.growth.volume(distance) - self.volume).max(0.0) }
    }

    fn win(&mut self, piece: u32, distance: f64) {
        self.won.push(piece);
        if distance > self.radius {
            self.radius = distance;
            self.volume = self.volume.max(self.growth.volume(distance));
        }
    }
}

impl Problem<'_> {
    /// What the search lowers: volume outside, each sphere by itself, in the mean over rest and poses.
    pub fn cost(&self, spheres: &[Sphere]) -> f64 {
        spheres
            .iter()
            .map(|s| *s.mean_outside.get_or_init(|| self.motion.mean_outside(s, &self.pieces)))
            .sum()
    }

    /// The sphere about `centre` that just covers some pieces, whose corners are `positions`.
    pub fn sphere(&self, centre: DVec3, cluster: Arc<Vec<u32>>, positions: &[DVec3]) -> Sphere {
        let farthest = positions.iter().map(|p| p.distance_squared(centre)).fold(0.0, f64::max).sqrt();
        Sphere::new(self.solid, Ball::new(centre, (farthest - self.slack).max(0.0)), cluster)
    }

    /// Deals the `loose` pieces to spheres whose centres stay: each goes where the volume outside grows
    /// least. First come the pieces that are costliest even to the sphere that takes them most cheaply, since
    /// somebody must cover those, and what is covered then costs nothing. A sphere without pieces starts from
    /// no radius.
    pub fn deal(&self, spheres: &[Sphere], loose: &[u32]) -> Vec<Sphere> {
        let mut bidders: Vec<Bidder<'_>> = spheres.iter().map(|s| Bidder::of(s, self.solid)).collect();
        let count = bidders.len();
        let mut reaches = Vec::with_capacity(loose.len() * count);
        for piece in loose {
            let reach = |b: &Bidder<'_>| {
                (self.pieces.farthest_squared(*piece, b.centre).sqrt() - self.slack).max(0.0)
            };
            reaches.extend(bidders.iter().map(reach));
        }
        let row = |index: usize| &reaches[index * count..(index + 1) * count];
        let least = |index: usize| {
            bidders.iter().zip(row(index)).map(|(b, reach)| b.cost(*reach)).fold(f64::INFINITY, f64::min)
        };
        let (mut costly, mut free) = (Vec::new(), Vec::new());
        for index in 0..loose.len() {
            let cost = least(index);
            if cost > 0.0 { costly.push((cost, index)) } else { free.push((cost, index)) }
        }
        costly.sort_unstable_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
        for (_, index) in costly.into_iter().chain(free) {
            // Among those that need not grow, the one in which the piece lies deepest.
            let mut winner = (f64::INFINITY, f64::INFINITY, 0, 0.0);
            for (i, (bidder, reach)) in bidders.iter().zip(row(index)).enumerate() {
                let depth = reach - bidder.radius;
                if winner.0 > 0.0 || depth < winner.1 {
                    let cost = bidder.cost(*reach);
                    if (cost, depth) < (winner.0, winner.1) {
                        winner = (cost, depth, i, *reach);
                    }
                }
            }
            bidders[winner.2].win(loose[index], winner.3);
        }
        let won: Vec<Vec<u32>> = bidders.into_iter().map(|b| b.won).collect();
        spheres.iter().zip(won).map(|(sphere, won)| self.with_more(sphere, won)).collect()
    }

    fn with_more(&self, sphere: &Sphere, mut won: Vec<u32>) -> Sphere {
        if won.is_empty() && !sphere.cluster.is_empty() {
            return sphere.clone();
        }
        won.extend(sphere.cluster.iter());
        won.sort_unstable();
        let positions = self.pieces.positions(&won);
        let moved = self.sphere(sphere.ball.centre, Arc::new(won), &positions);
        // The centre is the same, and so is what its growth costs.
        Sphere { growth: sphere.growth.clone(), ..moved }
    }
}
