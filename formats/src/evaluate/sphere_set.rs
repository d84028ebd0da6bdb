//! How the spheres of a [`SphereSet`] follow their mesh when it deforms. The source (sphere shadows §3.2)
//! does not say; this is ours.
//!
//! A sphere follows the points of its cluster. Their best similarity from rest to now (rotation, translation,
//! uniform scale) takes the centre along; rigid motion and scaling of the mesh are so followed exactly. If
//! the points then reach farther from the centre than they did at rest, scale allowed for, the centre goes
//! towards that of the smallest ball around them, no farther than it takes to bring all points back within
//! that distance. The way begins at 0, so centres do not jump when a point starts to reach out.
//!
//! The radius covers every point of the cluster, in every pose, plus the *slack* that the sphere has at rest
//! beyond its farthest point, scaled: that keeps covering what lies between points. In a set fitted with
//! [`Meta::tight`](crate::kinds::sphere_set::Meta::tight) above 0, whose spheres may leave their points
//! outside, the radius keeps its share of the farthest point's distance instead. At rest all spheres are
//! those of the file.
//!
//! A sphere without points goes, and grows, with the similarity of the nearest sphere that has some. Two
//! points, or collinear ones, leave a turn about their line open, one point leaves all turns open: of those
//! that fit equally well the smallest is taken.
//!
//! The cost is linear in the points, but for the few rounds in which a smallest ball is found; sums are in
//! f64.

mod enclosing;
mod similarity;

pub use enclosing::pulled_centre;

use crate::error::{Error, Place, Result};
use crate::kinds::SphereSet;
use glam::{DVec3, Vec3};
use similarity::Similarity;
use std::ops::Range;

/// How much farther than at rest points may be before the centre moves: more than f64 sums round.
const TOLERANCE: f64 = 1e-9;
/// Room for roundings to f32, in parts of 2⁻²⁴ of coordinates and distance: a point's own, those of computing
/// its distance, and the radius', make up to 2 of the one and 7 of the other.
const MARGIN: f64 = 8.0 / (1 << 24) as f64;

/// What spheres follow, prepared once.
#[derive(Debug, Clone)]
pub struct Follower {
    mesh: String,
    vertices: usize,
    /// Cluster by cluster.
    points: Vec<Point>,
    /// One for each sphere.
    clusters: Vec<Cluster>,
}

/// A point that a sphere follows.
#[derive(Debug, Clone)]
struct Point {
    vertices: [u32; 3],
    /// Sum 1 to f64 precision.
    weights: [f64; 3],
    /// Place at rest, from the cluster's centroid.
    rest: DVec3,
}

/// A sphere and the points that it follows.
#[derive(Debug, Clone)]
struct Cluster {
    points: Range<usize>,
    /// The sphere whose motion this one shares: itself if it has points.
    leader: usize,
    /// Of the leader's points at rest.
    centroid: DVec3,
    /// Centre at rest, from the centroid.
    centre: DVec3,
    radius: f64,
    /// Distance from the centre of its farthest point at rest.
    farthest: f64,
    /// What the radius is of that distance; 1 unless the points may lie outside.
    share: f64,
}

impl Follower {
    /// Prepares `set`, which must keep the rules of its kind, as one that was read does.
    pub fn new(set: &SphereSet) -> Self {
        let vertices = set.meta.vertices as usize;
        let (order, ranges) = by_cluster(&set.clusters, set.spheres.len());
        let mut points: Vec<Point> =
            order.iter().map(|at| Point::new(set.point_vertices[*at], set.point_weights[*at])).collect();
        let rest = &set.points[..vertices];
        points.iter_mut().for_each(|point| point.rest = point.place(rest));
        let mut clusters: Vec<_> = ranges
            .into_iter()
            .zip(&set.spheres)
            .enumerate()
            .map(|(at, (range, s))| Cluster::new(at, range, s, &points))
            .collect();
        for cluster in &mut clusters {
            let tight = set.meta.tight > 0.0;
            cluster.settle(&mut points, tight);
        }
        join_leaders(&mut clusters);
        Self { mesh: set.meta.mesh.clone(), vertices, points, clusters }
    }

    /// Replaces `spheres` by the spheres (centre and radius) of the pose in which the mesh's vertices stand
    /// at `positions`, mesh units.
    ///
    /// Every point of a cluster lies in the cluster's sphere, also when distances are computed in f32.
    /// Spheres of [`MAX_SPHERES`] follow in order.
    ///
    /// # Errors
    /// `Invalid` unless there is one finite position for every vertex.
    ///
    /// [`MAX_SPHERES`]: crate::kinds::sphere_set::MAX_SPHERES
    pub fn follow(&self, positions: &[[f32; 3]], spheres: &mut Vec<[f32; 4]>) -> Result<()> {
        self.expect_pose(positions)?;
        let mut now = Vec::new();
        let mut motions = Vec::with_capacity(self.clusters.len());
        spheres.clear();
        for cluster in &self.clusters {
            let points = &self.points[cluster.points.clone()];
            now.clear();
            now.extend(points.iter().map(|p| p.place(positions)));
            let motion =
                Similarity::between(cluster.centroid, points.iter().map(|p| p.rest), &now, cluster.centre);
            spheres.push(cluster.covering(&motion, &now));
            motions.push(motion);
        }
        for (cluster, sphere) in
            self.clusters.iter().zip(spheres).filter(|(cluster, _)| cluster.points.is_empty())
        {
            *sphere = cluster.carried(&motions[cluster.leader]);
        }
        Ok(())
    }

    fn expect_pose(&self, positions: &[[f32; 3]]) -> Result<()> {
        let place = Place::file(&self.mesh);
        if positions.len() != self.vertices {
            let reason = format!(
                "{} vertices, its spheres were fitted to {}; fit them to this mesh",
                positions.len(),
                self.vertices
            );
            return Err(Error::invalid(&place, reason));
        }
        match positions.iter().position(|p| p.iter().any(|x| !x.is_finite())) {
            None => Ok(()),
            Some(at) => Err(Error::invalid(
                &place,
                format!("vertex {at} is not at a finite place; mend the deformation"),
            )),
        }
    }
}

/// The points in the order of their clusters, and each cluster's range of them.
fn by_cluster(clusters: &[u32], count: usize) -> (Vec<usize>, Vec<Range<usize>>) {
    let mut order: Vec<usize> = (0..clusters.len()).collect();
    order.sort_by_key(|point| clusters[*point]);
    let mut ends = vec![0; count];
    clusters.iter().for_each(|cluster| ends[*cluster as usize] += 1);
    let mut start = 0;
    let ranges = ends.into_iter().map(|length| {
        start += length;
        start - length..start
    });
    let ranges = ranges.collect();
    (order, ranges)
}

/// Clusters without points join the nearest sphere that has some, the first of equally near ones.
fn join_leaders(clusters: &mut [Cluster]) {
    let leaders: Vec<_> = clusters
        .iter()
        .filter(|c| !c.points.is_empty())
        .map(|c| (c.leader, c.centroid, c.centroid + c.centre))
        .collect();
    for cluster in clusters.iter_mut().filter(|c| c.points.is_empty()) {
        let place = cluster.centre;
        let nearest =
            leaders.iter().min_by(|a, b| a.2.distance_squared(place).total_cmp(&b.2.distance_squared(place)));
        if let Some((leader, centroid, _)) = nearest {
            (cluster.leader, cluster.centroid, cluster.centre) = (*leader, *centroid, place - centroid);
        }
    }
}

impl Point {
    /// Not yet anywhere.
    fn new(vertices: [u32; 3], weights: [f32; 3]) -> Self {
        let weights = weights.map(f64::from);
        let sum: f64 = weights.iter().sum();
        Self { vertices, weights: weights.map(|w| w / sum), rest: DVec3::ZERO }
    }

    fn place(&self, positions: &[[f32; 3]]) -> DVec3 {
        self.vertices
            .iter()
            .zip(self.weights)
            .map(|(v, w)| Vec3::from(positions[*v as usize]).as_dvec3() * w)
            .sum()
    }
}

impl Cluster {
    /// `points` are all points, their `rest` in mesh units.
    fn new(leader: usize, range: Range<usize>, &[x, y, z, radius]: &[f32; 4], points: &[Point]) -> Self {
        let centre = Vec3::new(x, y, z).as_dvec3();
        let own = &points[range.clone()];
        let farthest = own.iter().map(|p| p.rest.distance(centre)).fold(0.0, f64::max);
        let centroid = own.iter().map(|p| p.rest).sum::<DVec3>() / own.len().max(1) as f64;
        Self {
            points: range,
            leader,
            centroid,
            centre: centre - centroid,
            radius: radius.into(),
            farthest,
            share: 1.0,
        }
    }

    /// Moves the cluster's points to where they are from its centroid, and decides what becomes of points
    /// outside the sphere.
    fn settle(&mut self, points: &mut [Point], tight: bool) {
        points[self.points.clone()].iter_mut().for_each(|point| point.rest -= self.centroid);
        if tight && self.radius < self.farthest {
            self.share = self.radius / self.farthest;
        }
    }

    /// The sphere that covers its points where they are `now`.
    fn covering(&self, motion: &Similarity, now: &[DVec3]) -> [f32; 4] {
        let centre = nearer(motion.apply(self.centre), motion.scale * self.farthest, now).as_vec3();
        // To the centre as it is stored.
        let distance = farthest(centre.as_dvec3(), now);
        let margin = MARGIN * (f64::from(centre.abs().max_element()) + distance);
        let slack = (self.radius - self.farthest).max(0.0) * motion.scale;
        centre.extend((distance * self.share + slack.max(margin)) as f32).to_array()
    }

    /// The sphere moved along, for one without points.
    fn carried(&self, motion: &Similarity) -> [f32; 4] {
        motion.apply(self.centre).as_vec3().extend((self.radius * motion.scale) as f32).to_array()
    }
}

/// The first centre on the way from `start` to that of the smallest ball around `points` that has all of them
/// within `wanted`; the latter if none has.
fn nearer(start: DVec3, wanted: f64, points: &[DVec3]) -> DVec3 {
    let wanted = wanted * (1.0 + TOLERANCE);
    if farthest(start, points) <= wanted {
        return start;
    }
    let smallest = pulled_centre(points, DVec3::ZERO, 1.0, start);
    if farthest(smallest, points) >= wanted {
        return smallest;
    }
    // Each point lies within the distance on a stretch of the way; these stretches all reach the end.
    let way = smallest - start;
    let entry = |point: &DVec3| {
        let offset = start - *point;
        let (a, b, c) = (way.length_squared(), offset.dot(way), offset.length_squared() - wanted * wanted);
        if c <= 0.0 { 0.0 } else { (-b - (b * b - a * c).max(0.0).sqrt()) / a }
    };
    start + way * points.iter().map(entry).fold(0.0, f64::max).min(1.0)
}

/// Distance from `centre` of the point farthest from it; 0 if there are no points.
fn farthest(centre: DVec3, points: &[DVec3]) -> f64 {
    points.iter().map(|point| point.distance_squared(centre)).fold(0.0, f64::max).sqrt()
}

#[cfg(test)]
mod enclosing_tests;
