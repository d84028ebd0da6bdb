//! Where the search starts: clusters of pieces by k-means from seeds that keep their distance (Arthur and
//! Vassilvitskii 2007).

use super::cluster::Problem;
use super::random::unit;
use super::sphere::Sphere;
use glam::DVec3;
use rayon::prelude::*;

/// Lloyd's rounds.
const ROUNDS: usize = 6;
/// Steps of each sphere's first fit.
const STEPS: usize = 20;

/// `n` spheres around the problem's pieces, of which there must be at least `n`.
pub fn start(problem: &Problem<'_>, n: usize, seed: u64) -> Vec<Sphere> {
    let all: Vec<u32> = (0..problem.pieces.len() as u32).collect();
    clusters(problem, &all, n, seed)
        .into_par_iter()
        .map(|(centre, cluster)| problem.fit(centre, cluster, STEPS))
        .collect()
}

/// Parts pieces, of which there must be at least `n`, into `n` clusters, with their means.
pub fn clusters(problem: &Problem<'_>, pieces: &[u32], n: usize, seed: u64) -> Vec<(DVec3, Vec<u32>)> {
    let points: Vec<DVec3> = pieces.iter().map(|p| problem.middle(*p)).collect();
    let mut centres = seeds(&points, n, seed);
    let mut clusters = Vec::new();
    for _ in 0..ROUNDS {
        clusters = nearest_clusters(&points, &centres);
        for (centre, cluster) in centres.iter_mut().zip(&clusters).filter(|(_, cluster)| !cluster.is_empty())
        {
            *centre = cluster.iter().map(|p| points[*p as usize]).sum::<DVec3>() / cluster.len() as f64;
        }
    }
    let named = |cluster: Vec<u32>| cluster.into_iter().map(|p| pieces[p as usize]).collect();
    centres.into_iter().zip(clusters.into_iter().map(named)).collect()
}

fn seeds(points: &[DVec3], n: usize, seed: u64) -> Vec<DVec3> {
    let mut centres = Vec::with_capacity(n);
    let mut distances = vec![1.0; points.len()];
    while centres.len() < n {
        let mut left = unit(seed.wrapping_add(centres.len() as u64)) * distances.iter().sum::<f64>();
        let chosen = distances.iter().position(|d| {
            left -= d;
            left < 0.0
        });
        let centre = points[chosen.unwrap_or(points.len() - 1)];
        let first = centres.is_empty();
        for (distance, point) in distances.iter_mut().zip(points) {
            let new = point.distance_squared(centre);
            *distance = if first { new } else { distance.min(new) };
        }
        centres.push(centre);
    }
    centres
}

fn nearest_clusters(points: &[DVec3], centres: &[DVec3]) -> Vec<Vec<u32>> {
    let nearest = |p: &DVec3| {
        (0..centres.len())
            .min_by(|a, b| centres[*a].distance_squared(*p).total_cmp(&centres[*b].distance_squared(*p)))
    };
    let owners: Vec<usize> = points.par_iter().map(|p| nearest(p).unwrap_or(0)).collect();
    let mut clusters = vec![Vec::new(); centres.len()];
    owners.into_iter().enumerate().for_each(|(p, owner)| clusters[owner].push(p as u32));
    clusters
}
