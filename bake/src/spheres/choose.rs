//! Where the search starts: the best n of thousands of ready-made spheres.
//!
//! Around many points within the solid stand spheres of several sizes. To choose n of them that cover all pieces with the least volume outside is a weighted
//! set cover, for which Lagrange multipliers are a good guide (Caprara, Fischetti and Toth 1999): each piece has a price, a sphere is worth the prices of
//! what it covers less its own cost, and prices rise where nobody covers a piece and fall where many do.

use super::ball::Ball;
use super::cluster::Problem;
use glam::DVec3;
use rayon::prelude::*;

/// Sizes of sphere about each point.
const SIZES: usize = 10;
/// Rounds of prices.
const ROUNDS: usize = 200;
/// Rounds from one attempt at a whole set to the next.
const ATTEMPT: usize = 20;

/// Spheres of several sizes about one point; larger ones cover more.
struct Site {
    centre: DVec3,
    radii: [f64; SIZES],
    volumes: [f64; SIZES],
    /// Pieces in the order of their reach, as far as the largest covers them.
    pieces: Vec<u32>,
    /// How many of them each size covers.
    covers: [usize; SIZES],
}

impl Site {
    /// Around `centre`, from the largest ball that fits the solid upwards by `step`s.
    fn new(problem: &Problem<'_>, centre: DVec3, step: f64) -> Self {
        let inner = problem.solid.distance(centre);
        let radii = std::array::from_fn(|i| inner + step * i as f64);
        let volumes = radii.map(|radius| Ball::new(centre, radius).outside(problem.solid).volume);
        let largest = radii[SIZES - 1] + problem.slack;
        let reach = |p: u32| (problem.pieces.farthest_squared(p, centre).sqrt(), p);
        let mut reaches: Vec<(f64, u32)> = (0..problem.pieces.len() as u32).map(reach).filter(|r| r.0 <= largest).collect();
        reaches.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let covers = radii.map(|radius| reaches.partition_point(|r| r.0 <= radius + problem.slack));
        Self { centre, radii, volumes, pieces: reaches.into_iter().map(|r| r.1).collect(), covers }
    }

    /// The size that is worth most at these prices, and its worth.
    fn best(&self, prices: &[f64]) -> (f64, usize) {
        let (mut sum, mut from, mut best) = (0.0, 0, (f64::NEG_INFINITY, 0));
        for size in 0..SIZES {
            sum += self.pieces[from..self.covers[size]].iter().map(|p| prices[*p as usize]).sum::<f64>();
            from = self.covers[size];
            let worth = sum - self.volumes[size];
            if worth > best.0 {
                best = (worth, size);
            }
        }
        best
    }

    fn covered(&self, size: usize) -> &[u32] {
        &self.pieces[..self.covers[size]]
    }
}

/// `n` balls about some of `centres` that cover nearly all pieces; sizes differ by `step`.
pub fn choose(problem: &Problem<'_>, centres: &[DVec3], n: usize, step: f64) -> Vec<Ball> {
    let sites: Vec<Site> = centres.par_iter().map(|c| Site::new(problem, *c, step)).collect();
    let pieces = problem.pieces.len();
    // A first guess: what it would cost per piece if all spheres were like the best.
    let rate = |site: &Site| site.volumes.iter().zip(site.covers).skip(1).map(|(v, c)| v / c.max(1) as f64).fold(f64::INFINITY, f64::min);
    let mut prices = vec![sites.iter().map(rate).fold(f64::INFINITY, f64::min).max(1e-12); pieces];
    let mut best: Option<(f64, Vec<(usize, usize)>)> = None;
    let mut pace = 1.0;
    let mut bound = f64::NEG_INFINITY;
    let mut stale = 0;
    for round in 0..ROUNDS {
        let worths: Vec<(f64, usize)> = sites.par_iter().map(|s| s.best(&prices)).collect();
        let mut order: Vec<usize> = (0..sites.len()).collect();
        order.sort_unstable_by(|a, b| worths[*b].0.total_cmp(&worths[*a].0).then(a.cmp(b)));
        let mut holders = vec![0_i32; pieces];
        for i in &order[..n.min(order.len())] {
            sites[*i].covered(worths[*i].1).iter().for_each(|p| holders[*p as usize] += 1);
        }
        let lower = prices.iter().sum::<f64>() - order[..n.min(order.len())].iter().map(|i| worths[*i].0).sum::<f64>();
        if round % ATTEMPT == 0 {
            let attempt = attempt(&sites, &prices, n);
            if best.as_ref().is_none_or(|b| attempt.0 < b.0) {
                best = Some(attempt);
            }
        }
        if lower > bound { bound = lower; stale = 0 } else { stale += 1 }
        if stale == 10 {
            pace *= 0.6;
            stale = 0;
        }
        let target = best.as_ref().map_or(0.0, |b| b.0);
        let slope: f64 = holders.iter().map(|h| f64::from((1 - h) * (1 - h))).sum();
        let step = pace * (1.05 * target - lower).max(0.0) / slope.max(1.0);
        prices.iter_mut().zip(&holders).for_each(|(price, holders)| *price = (*price + step * f64::from(1 - holders)).max(0.0));
    }
    if std::env::var("DEBUG_CHOOSE").is_ok() { println!("bound {bound} best {}", best.as_ref().unwrap().0); }
    let chosen = best.map(|b| b.1).unwrap_or_default();
    chosen.into_iter().map(|(site, size)| Ball::new(sites[site].centre, sites[site].radii[size])).collect()
}

/// A set of `n` spheres, picked one by one for what they are worth where nothing covers yet, then grown until all that can be is covered; and its volume
/// outside.
fn attempt(sites: &[Site], prices: &[f64], n: usize) -> (f64, Vec<(usize, usize)>) {
    let mut open = prices.to_vec();
    let mut covered = vec![false; prices.len()];
    // A little worth in every piece, so that none is free.
    let least = prices.iter().sum::<f64>() / prices.len() as f64 * 1e-3;
    open.iter_mut().for_each(|p| *p += least);
    let mut worths: Vec<(f64, usize, usize)> = sites.iter().enumerate().map(|(i, s)| (s.best(&open), i)).map(|((w, size), i)| (w, size, i)).collect();
    let mut chosen: Vec<(usize, usize)> = Vec::new();
    while chosen.len() < n && !worths.is_empty() {
        // Worths only fall, so the first whose fresh worth is still the highest is the best.
        worths.sort_unstable_by(|a, b| b.0.total_cmp(&a.0).then(a.2.cmp(&b.2)));
        let mut k = 0;
        let mut top = (f64::NEG_INFINITY, 0, 0, 0);
        while k < worths.len() && worths[k].0 > top.0 {
            let i = worths[k].2;
            let (worth, size) = sites[i].best(&open);
            worths[k] = (worth, size, i);
            if worth > top.0 {
                top = (worth, size, i, k);
            }
            k += 1;
        }
        worths.swap_remove(top.3);
        for p in sites[top.2].covered(top.1) {
            open[*p as usize] = 0.0;
            covered[*p as usize] = true;
        }
        chosen.push((top.2, top.1));
    }
    grow(sites, &mut chosen, &mut covered);
    let volume = chosen.iter().map(|(i, size)| sites[*i].volumes[*size]).sum();
    (volume, chosen)
}

/// Grows chosen spheres, the cheapest for each piece, until they cover all that they can.
fn grow(sites: &[Site], chosen: &mut [(usize, usize)], covered: &mut [bool]) {
    for piece in 0..covered.len() {
        if covered[piece] {
            continue;
        }
        let needed = |(i, size): (usize, usize)| {
            let site = &sites[i];
            let place = site.pieces.iter().position(|p| *p as usize == piece)?;
            let to = (size..SIZES).find(|s| site.covers[*s] > place)?;
            Some((site.volumes[to] - site.volumes[size], to))
        };
        let options = chosen.iter().enumerate().filter_map(|(k, c)| needed(*c).map(|(cost, to)| (cost, k, to)));
        if let Some((_, k, to)) = options.min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1))) {
            chosen[k].1 = to;
            sites[chosen[k].0].covered(to).iter().for_each(|p| covered[*p as usize] = true);
        }
    }
}
