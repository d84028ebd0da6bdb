//! Which cones stand for most of a lobe, and their shares.

use super::hemisphere::{self, Hemisphere};
use glam::{DVec3, Vec3A};
use relume_formats::kinds::brdf_tensor::Cone;
use relume_formats::kinds::brdf_tensor::angles::NODES;
use std::f64::consts::{PI, TAU};

const fn cone(width_deg: f32, tilt_deg: f32, side_deg: f32) -> Cone {
    Cone { width_deg, tilt_deg, side_deg }
}

/// The cones of files: of each width one about the mirror direction, some towards the surface and away from it, for
/// lobes lean and spread in the plane of incidence, and two to the sides, for blunt lobes are wider than a cone.
pub const CONES: [Cone; 16] = [
    cone(3.0, 0.0, 0.0),
    cone(3.0, 5.0, 0.0),
    cone(3.0, -5.0, 0.0),
    cone(6.0, 0.0, 0.0),
    cone(6.0, 10.0, 0.0),
    cone(6.0, -10.0, 0.0),
    cone(6.0, 0.0, 10.0),
    cone(6.0, -20.0, 0.0),
    cone(12.0, 0.0, 0.0),
    cone(12.0, 20.0, 0.0),
    cone(12.0, -20.0, 0.0),
    cone(12.0, 0.0, 20.0),
    cone(12.0, -40.0, 0.0),
    cone(24.0, 0.0, 0.0),
    cone(24.0, -40.0, 0.0),
    cone(24.0, 0.0, 40.0),
];

/// The source's mirror terms (thesis §5.3.1): 0°, 7°, 14° and 21°, where 0° is a texel of a cube of 64 × 64 a face.
pub const SOURCE_CONES: [Cone; 4] =
    [cone(1.4, 0.0, 0.0), cone(7.0, 0.0, 0.0), cone(14.0, 0.0, 0.0), cone(21.0, 0.0, 0.0)];

/// A Gaussian of the angle from its middle, of integral 1 over the sphere.
pub struct Gaussian {
    deviation: f64,
    scale: f64,
}

impl Gaussian {
    /// Of this standard deviation in degrees.
    pub fn of_width(deg: f64) -> Self {
        const STEPS: usize = 4096;
        let deviation = deg.to_radians();
        // Beyond eight deviations there is nothing.
        let end = (8.0 * deviation).min(PI);
        let step = end / STEPS as f64;
        let ring = |at: usize| {
            let angle = (at as f64 + 0.5) * step;
            (-0.5 * (angle / deviation).powi(2)).exp() * angle.sin()
        };
        let integral: f64 = TAU * step * (0..STEPS).map(ring).sum::<f64>();
        Self { deviation, scale: 1.0 / integral }
    }

    /// Its value at a unit vector, sr⁻¹.
    fn about(&self, middle: Vec3A, direction: Vec3A) -> f64 {
        // From the chord, for the cosine of a small angle says little in single precision.
        let angle = 2.0 * f64::from((0.5 * (middle - direction).length()).min(1.0)).asin();
        self.scale * (-0.5 * (angle / self.deviation).powi(2)).exp()
    }
}

/// The harmonics of every cone seen from `outgoing`, of what of it is above the surface.
pub fn harmonics(cones: &[Cone], outgoing: DVec3, hemisphere: &Hemisphere) -> Vec<Vec<f64>> {
    let of_cone = |cone: &Cone| {
        let gaussian = Gaussian::of_width(f64::from(cone.width_deg));
        let middles: Vec<Vec3A> = cone.directions(outgoing.as_vec3()).map(Vec3A::from).collect();
        // Of a pair the two sides have the same harmonics of cos mφ: the mean of both is as a lobe must be.
        let share = 1.0 / middles.len().max(1) as f64;
        hemisphere.harmonics(|d| middles.iter().map(|middle| share * gaussian.about(*middle, d)).sum())
    };
    cones.iter().map(of_cone).collect()
}

/// [`harmonics`] at every node.
pub fn at_nodes(cones: &[Cone], hemisphere: &Hemisphere) -> Vec<Vec<Vec<f64>>> {
    use rayon::prelude::*;
    let seen_from = |node: usize| hemisphere::outgoing(hemisphere::seen_from(node));
    (0..NODES).into_par_iter().map(|node| harmonics(cones, seen_from(node), hemisphere)).collect()
}
