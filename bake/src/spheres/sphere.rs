//! A sphere with the pieces that it must cover.

use super::ball::{Ball, Outside};
use super::growth::Growth;
use super::triangle_tree::TriangleTree;
use std::sync::{Arc, OnceLock};

/// A sphere and its cluster: the pieces that it must cover.
#[derive(Debug, Clone)]
pub struct Sphere {
    /// The sphere.
    pub ball: Ball,
    /// What of it lies outside the solid.
    pub outside: Outside,
    /// Its pieces, ascending.
    pub cluster: Arc<Vec<u32>>,
    /// Once refitting has ended: how many of its pieces it just reaches. As long as it must reach all of
    /// those, it stays where it is.
    pub bound: Option<usize>,
    pub(super) growth: OnceLock<Growth>,
    /// Mean volume outside over rest and poses.
    pub(super) mean_outside: OnceLock<f64>,
}

impl Sphere {
    /// A sphere of this size whatever its pieces.
    pub fn new(solid: &TriangleTree, ball: Ball, cluster: Arc<Vec<u32>>) -> Self {
        let ball = if cluster.is_empty() { Ball::new(ball.centre, 0.0) } else { ball };
        Self {
            ball,
            outside: ball.outside(solid),
            cluster,
            bound: None,
            growth: OnceLock::new(),
            mean_outside: OnceLock::new(),
        }
    }

    /// The same sphere with other names for its pieces, or none for now.
    pub fn with_cluster(&self, cluster: Vec<u32>) -> Self {
        Self { cluster: Arc::new(cluster), mean_outside: OnceLock::new(), ..self.clone() }
    }

    /// What growing about the same centre costs.
    pub(super) fn growth(&self, solid: &TriangleTree) -> &Growth {
        self.growth.get_or_init(|| Growth::new(solid, self.ball.centre, self.ball.radius))
    }
}

/// Volume outside the solid, each sphere by itself.
pub fn total_outside(spheres: &[Sphere]) -> f64 {
    spheres.iter().map(|s| s.outside.volume).sum()
}
