//! Mirror terms of lobes (thesis §5.3.1): Gaussians about the mirror direction, whose shares are found by
//! least squares.
//!
//! What is fitted is what arrives from each direction, BRDF times cosine. Beside the mirror terms there is a
//! background, broad Gaussians and a cosine lobe, which takes what is no mirror's and stays in the rest. All
//! shapes are given and only their shares are sought, so that the best fit is unique and moves little from
//! material to material. The source has expectation maximisation, which takes more rounds than it is worth:
//! example `brdf_tensor` compares.

use super::table::Points;
use glam::DVec3;
use relume_formats::basis::disc::{self, AZIMUTHS, RINGS};
use relume_formats::basis::lanes::dot;
use std::f64::consts::{FRAC_1_PI, PI, TAU};

/// Standard deviations of the source's mirror terms, degrees.
pub const SOURCE_WIDTHS_DEG: [f32; 4] = [0.0, 7.0, 14.0, 21.0];

/// How shares of shapes are found of what arrives from each point: of each of [`Shapes::integrals`], at least
/// 0.
pub type Fit = fn(&Shapes, &[f64]) -> Vec<f64>;

/// Which mirror terms are set apart, and how.
#[derive(Debug, Clone)]
pub struct Separation {
    /// Standard deviations, degrees, the narrowest first; none for lobes that stay whole.
    pub widths_deg: Vec<f32>,
    /// How.
    pub fit: Fit,
}

impl Default for Separation {
    fn default() -> Self {
        Self { widths_deg: SOURCE_WIDTHS_DEG.to_vec(), fit: least_squares }
    }
}

/// Rounds of the fit by least squares, which ends after so many, not where it stands nearly still: shares
/// then do not jump between materials.
const ROUNDS: usize = 20_000;
/// Standard deviation of what stands for a mirror: a texel of a cube of 64 × 64 a face, degrees.
const TEXEL_DEG: f64 = 1.4;
/// Standard deviations of the background's Gaussians, degrees.
const BACKGROUND_DEG: [f64; 3] = [30.0, 45.0, 60.0];

/// What fits are made of, tabulated for every ring of outgoing directions.
pub struct Separator {
    terms: usize,
    fit: Fit,
    rings: Vec<Shapes>,
}

/// The shapes about one outgoing direction: mirror terms, then the background.
#[derive(Debug)]
pub struct Shapes {
    integrals: Vec<Vec<f64>>,
    /// Products over solid angle of any two.
    products: Vec<Vec<f64>>,
    /// One over the solid angle of points.
    per_solid_angle: Vec<f64>,
}

impl Separator {
    /// For the points of lobes.
    pub fn new(points: &Points, separation: &Separation) -> Self {
        let widths = &separation.widths_deg;
        let rings = if widths.is_empty() { 0 } else { RINGS };
        let rings = (0..rings).map(|ring| Shapes::new(points, ring, widths)).collect();
        Self { terms: widths.len(), fit: separation.fit, rings }
    }

    /// The shares of the mirror terms of what arrives from each point, seen from the node of `ring`, and what
    /// they leave of it. Shares are rounded as they are stored before they are taken away.
    pub fn split(&self, ring: usize, arriving: &[f64]) -> (Vec<f32>, Vec<f64>) {
        let mut rest = arriving.to_vec();
        let Some(shapes) = self.rings.get(ring) else { return (Vec::new(), rest) };
        let found = (self.fit)(shapes, arriving);
        let shares: Vec<f32> = found.into_iter().take(self.terms).map(|share| share as f32).collect();
        for (share, term) in shares.iter().zip(&shapes.integrals) {
            rest.iter_mut().zip(term).for_each(|(rest, value)| *rest -= f64::from(*share) * value);
        }
        (shares, rest)
    }
}

#[cfg(test)]
impl Separator {
    /// What arrives of these shares of mirror terms, then background, about the mirror direction of `ring`.
    pub fn mixture(&self, ring: usize, shares: &[f64]) -> Vec<f64> {
        let mut sum = vec![0.0; self.rings[ring].per_solid_angle.len()];
        for (share, shape) in shares.iter().zip(&self.rings[ring].integrals) {
            sum.iter_mut().zip(shape).for_each(|(sum, value)| *sum += share * value);
        }
        sum
    }
}

impl Shapes {
    fn new(points: &Points, ring: usize, widths_deg: &[f32]) -> Self {
        let seen_from = disc::direction(ring * AZIMUTHS);
        let widths = widths_deg.iter().map(|deg| f64::from(*deg)).chain(BACKGROUND_DEG);
        let over_points = |deg: f64| -> Vec<f64> {
            let gaussian = Gaussian::of_width(deg);
            let value = |(d, dw): (&DVec3, &f64)| gaussian.about_mirror(seen_from, *d) * dw;
            points.directions.iter().zip(&points.solid_angle).map(value).collect()
        };
        let mut integrals: Vec<Vec<f64>> = widths.map(over_points).collect();
        let cosine = points.directions.iter().zip(&points.solid_angle);
        integrals.push(cosine.map(|(d, dw)| FRAC_1_PI * d.z * dw).collect());
        let per_solid_angle: Vec<f64> = points.solid_angle.iter().map(|dw| 1.0 / dw).collect();
        let product = |a: &[f64], b: &[f64]| weighted(a, b, &per_solid_angle);
        let products = integrals.iter().map(|a| integrals.iter().map(|b| product(a, b)).collect()).collect();
        Self { integrals, products, per_solid_angle }
    }

    /// Of each shape its integral over what is around each point.
    pub fn integrals(&self) -> &[Vec<f64>] {
        &self.integrals
    }
}

/// The shares whose sum of `shapes` is nearest to what arrives, over solid angle: by coordinate descent,
/// which needs products alone.
pub fn least_squares(shapes: &Shapes, arriving: &[f64]) -> Vec<f64> {
    let wanted = |shape: &Vec<f64>| weighted(shape, arriving, &shapes.per_solid_angle);
    let wanted: Vec<f64> = shapes.integrals.iter().map(wanted).collect();
    let mut shares = vec![0.0; wanted.len()];
    for _ in 0..ROUNDS {
        for (k, (row, wanted)) in shapes.products.iter().zip(&wanted).enumerate() {
            let (Some(share), Some(own)) = (shares.get(k).copied(), row.get(k)) else { continue };
            let better = (share + (wanted - dot(row, &shares)) / own).max(0.0);
            if let Some(share) = shares.get_mut(k) {
                *share = better;
            }
        }
    }
    shares
}

fn weighted(a: &[f64], b: &[f64], weights: &[f64]) -> f64 {
    a.iter().zip(b).zip(weights).map(|((a, b), weight)| a * b * weight).sum()
}

/// A Gaussian of the angle from its middle, of integral 1 over the sphere.
pub struct Gaussian {
    deviation: f64,
    scale: f64,
}

impl Gaussian {
    /// Of this standard deviation in degrees; of one texel for 0, which stands for a mirror.
    pub fn of_width(deg: f64) -> Self {
        const STEPS: usize = 4096;
        let deviation = if deg == 0.0 { TEXEL_DEG } else { deg }.to_radians();
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

    /// Its value at `incoming` about the mirror direction of `outgoing`, sr⁻¹; unit vectors about the normal
    /// +Z.
    pub fn about_mirror(&self, outgoing: DVec3, incoming: DVec3) -> f64 {
        let angle = incoming.angle_between(DVec3::new(-outgoing.x, -outgoing.y, outgoing.z));
        self.scale * (-0.5 * (angle / self.deviation).powi(2)).exp()
    }
}
