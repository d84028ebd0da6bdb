//! What it costs a sphere to grow: its outside volume as a function of its radius, for a fixed centre.

use super::ball::Ball;
use super::triangle_tree::TriangleTree;
use glam::DVec3;
use std::f64::consts::PI;

/// Radii at which the volume is evaluated.
const KNOTS: usize = 8;

/// Outside volume by radius: exact at the knots, with exact slopes, cubic between.
#[derive(Debug, Clone)]
pub struct Growth {
    radii: [f64; KNOTS],
    volumes: [f64; KNOTS],
    areas: [f64; KNOTS],
}

impl Growth {
    /// Of a sphere at `centre`, most exact between a third of `radius` and half as much again.
    pub fn new(mesh: &TriangleTree, centre: DVec3, radius: f64) -> Self {
        let (mut radii, mut volumes, mut areas) = ([0.0; KNOTS], [0.0; KNOTS], [0.0; KNOTS]);
        for i in 0..KNOTS {
            radii[i] = radius * (0.3 + 1.2 * i as f64 / (KNOTS - 1) as f64);
            let outside = Ball::new(centre, radii[i]).outside(mesh);
            (volumes[i], areas[i]) = (outside.volume, outside.area);
        }
        Self { radii, volumes, areas }
    }

    /// The outside volume at `radius`.
    pub fn volume(&self, radius: f64) -> f64 {
        let last = KNOTS - 1;
        if radius >= self.radii[last] {
            return self.volumes[last] + 4.0 / 3.0 * PI * (radius.powi(3) - self.radii[last].powi(3));
        }
        if radius <= self.radii[0] {
            return self.volumes[0] * (radius / self.radii[0]).powi(3);
        }
        let step = self.radii[1] - self.radii[0];
        let place = (radius - self.radii[0]) / step;
        let i = (place as usize).min(last - 1);
        let t = place - i as f64;
        let (from, to) = (self.volumes[i], self.volumes[i + 1]);
        let (s, e) = (self.areas[i] * step, self.areas[i + 1] * step);
        let cubic = from + t * (s + t * (3.0 * (to - from) - 2.0 * s - e + t * (2.0 * (from - to) + s + e)));
        cubic.clamp(from, to.max(from))
    }
}
