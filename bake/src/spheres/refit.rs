//! Moves one sphere to where it covers its pieces with the least volume outside the solid.
//!
//! The radius is the distance of the farthest corner, so the volume as a function of the centre has ridges
//! where two corners are equally far, and searches along lines (Powell's, as the source has it) stall on
//! them. Here each step minimises a model that has the same ridges: the volume's derivatives by centre and
//! radius, which its exact evaluation gives for nothing, and the true maximum of distances. That is a
//! smallest enclosing ball under a pull, solved exactly; a step is taken if, perhaps shortened, it lowers the
//! volume.

use super::ball::Ball;
use super::cluster::Problem;
use super::sphere::Sphere;
use glam::DVec3;
use relume_formats::evaluate::sphere_set::pulled_centre;

/// A step that gains less than this share of the volume is the last.
const LEAST_GAIN: f64 = 1e-3;
/// Pieces as far as this from the centre, in radii, are those that bind.
const NEAR: f64 = 0.998;
/// Longest step, in radii: the model is of first order.
const LONGEST: f64 = 0.5;
/// How often a step that does not help is shortened, and to what share.
const SHORTER: (usize, f64) = (6, 0.4);

impl Problem<'_> {
    /// The sphere moved to cover the same pieces with less outside; never with more.
    pub fn refit(&self, sphere: &Sphere, steps: usize) -> Sphere {
        let positions = self.pieces.positions(&sphere.cluster);
        let mut best = sphere.clone();
        for _ in 0..steps {
            let better = self.step(&best, &positions);
            let gain = better.as_ref().map_or(0.0, |better| best.outside.volume - better.outside.volume);
            let enough = gain > LEAST_GAIN * best.outside.volume;
            best = better.unwrap_or(best);
            if !enough {
                best.bound = Some(self.bound(&best.ball, best.cluster.iter().copied()));
                break;
            }
        }
        best
    }

    /// How many of some pieces lie near the sphere's limit.
    pub fn bound(&self, ball: &Ball, pieces: impl Iterator<Item = u32>) -> usize {
        let near = (NEAR * (ball.radius + self.slack)).powi(2);
        pieces.filter(|p| self.pieces.farthest_squared(*p, ball.centre) >= near).count()
    }

    fn step(&self, sphere: &Sphere, positions: &[DVec3]) -> Option<Sphere> {
        let Sphere { ball, outside, .. } = sphere;
        // A sphere within the solid, or one of no size, cannot be bettered.
        if outside.area <= 1e-9 * ball.radius * ball.radius {
            return None;
        }
        let scale = outside.area / (2.0 * ball.radius);
        let mut step = pulled_centre(positions, outside.gradient, scale, ball.centre) - ball.centre;
        step = step.clamp_length_max(LONGEST * ball.radius);
        for _ in 0..SHORTER.0 {
            let moved = self.sphere(ball.centre + step, sphere.cluster.clone(), positions);
            if moved.outside.volume < outside.volume {
                return Some(moved);
            }
            step *= SHORTER.1;
        }
        None
    }
}
