//! Mirror terms of lobes (thesis §5.3.1): Gaussians about the mirror direction, whose shares are found by
//! expectation maximisation, or by least squares.
//!
//! What is fitted is what arrives from each direction, BRDF times cosine. Beside the mirror terms there is a
//! background, broad Gaussians and a cosine lobe, which takes what is no mirror's and stays in the rest. All
//! shapes are given and only their shares are sought, so that the best fit is unique and moves little from
//! material to material: expectation maximisation minimises a convex function, and ends after so many rounds, not
//! where it stands nearly still.

use super::table::Points;
use glam::DVec3;
use relume_formats::basis::disc::{self, AZIMUTHS, RINGS};
use relume_formats::kinds::brdf_tensor::{TERMS, WIDTHS_DEG};
use std::f64::consts::{FRAC_1_PI, PI, TAU};

/// How the shares are found.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Fit {
    /// Expectation maximisation, as in the source: least Kullback-Leibler divergence.
    Expectation,
    /// Least squares over solid angle with shares of at least 0.
    LeastSquares,
}

/// Which mirror terms are set apart.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Separation {
    /// How many, the narrowest first: 0 to [`TERMS`].
    pub terms: usize,
    /// How.
    pub fit: Fit,
}

impl Default for Separation {
    fn default() -> Self {
        Self { terms: TERMS, fit: Fit::Expectation }
    }
}

/// Rounds of either fit.
const ROUNDS: usize = 200;
/// Standard deviation of what stands for a mirror: a texel of a cube of 64 × 64 a face, degrees.
const TEXEL_DEG: f64 = 1.4;
/// Standard deviations of the background's Gaussians, degrees.
const BACKGROUND_DEG: [f64; 3] = [30.0, 45.0, 60.0];

/// What fits are made of, tabulated for every ring of outgoing directions.
pub struct Separator {
    separation: Separation,
    rings: Vec<Shapes>,
}

/// The shapes about one outgoing direction.
struct Shapes {
    /// For each shape its integral over what is around each point; mirror terms first.
    integrals: Vec<Vec<f64>>,
    /// Of each, over all points.
    sums: Vec<f64>,
    /// Products over solid angle of any two.
    products: Vec<Vec<f64>>,
    /// One over the solid angle of points.
    per_solid_angle: Vec<f64>,
}

impl Separator {
    /// For the points of lobes.
    pub fn new(points: &Points, separation: Separation) -> Self {
        let terms = separation.terms.min(TERMS);
        let rings = if terms == 0 { 0 } else { RINGS };
        let rings = (0..rings).map(|ring| Shapes::new(points, ring, terms)).collect();
        Self { separation: Separation { terms, ..separation }, rings }
    }

    /// The shares of the mirror terms of what arrives from each point, seen from the node of `ring`, and what takes
    /// given shares away from it.
    pub fn split<'a>(
        &'a self,
        ring: usize,
        arriving: &'a [f64],
    ) -> ([f64; TERMS], impl Fn(&[f32; TERMS]) -> Vec<f64> + use<'a>) {
        let shapes = self.rings.get(ring);
        let found = shapes.map_or_else(Vec::new, |shapes| match self.separation.fit {
            Fit::Expectation => shapes.by_expectation(arriving),
            Fit::LeastSquares => shapes.by_least_squares(arriving),
        });
        let mut shares = [0.0; TERMS];
        shares
            .iter_mut()
            .zip(found.into_iter().take(self.separation.terms))
            .for_each(|(to, from)| *to = from);
        let left = move |shares: &[f32; TERMS]| {
            let mut rest = arriving.to_vec();
            let terms = shapes.into_iter().flat_map(|shapes| &shapes.integrals);
            for (share, term) in shares.iter().zip(terms) {
                rest.iter_mut().zip(term).for_each(|(rest, value)| *rest -= f64::from(*share) * value);
            }
            rest
        };
        (shares, left)
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
    fn new(points: &Points, ring: usize, terms: usize) -> Self {
        let seen_from = disc::direction(ring * AZIMUTHS);
        let mirror = DVec3::new(-seen_from.x, -seen_from.y, seen_from.z);
        let width = |deg: f64| if deg == 0.0 { TEXEL_DEG } else { deg };
        let widths = WIDTHS_DEG.iter().take(terms).map(|deg| width(*deg)).chain(BACKGROUND_DEG);
        let gaussian = |deg: f64| -> Vec<f64> {
            let gaussian = Gaussian::new(deg.to_radians());
            let value = |(d, dw): (&DVec3, &f64)| gaussian.at(d.angle_between(mirror)) * dw;
            points.directions.iter().zip(&points.solid_angle).map(value).collect()
        };
        let mut integrals: Vec<Vec<f64>> = widths.map(gaussian).collect();
        let cosine = points.directions.iter().zip(&points.solid_angle);
        integrals.push(cosine.map(|(d, dw)| FRAC_1_PI * d.z * dw).collect());
        let per_solid_angle: Vec<f64> = points.solid_angle.iter().map(|dw| 1.0 / dw).collect();
        let product = |a: &[f64], b: &[f64]| weighted(a, b, &per_solid_angle);
        let products = integrals.iter().map(|a| integrals.iter().map(|b| product(a, b)).collect()).collect();
        let sums = integrals.iter().map(|shape| shape.iter().sum()).collect();
        Self { integrals, sums, products, per_solid_angle }
    }

    fn by_expectation(&self, arriving: &[f64]) -> Vec<f64> {
        let whole: f64 = arriving.iter().sum();
        let mut shares = vec![whole / self.integrals.len() as f64; self.integrals.len()];
        let (mut model, mut ratio) = (vec![0.0; arriving.len()], vec![0.0; arriving.len()]);
        for _ in 0..ROUNDS {
            model.fill(0.0);
            for (share, shape) in shares.iter().zip(&self.integrals) {
                model.iter_mut().zip(shape).for_each(|(sum, value)| *sum += share * value);
            }
            // Where nothing arrives nothing is asked for, and far from all Gaussians the cosine lobe is above 0.
            for ((ratio, model), arriving) in ratio.iter_mut().zip(&model).zip(arriving) {
                *ratio = if *model > 0.0 { arriving / model } else { 0.0 };
            }
            for ((share, shape), sum) in shares.iter_mut().zip(&self.integrals).zip(&self.sums) {
                *share *= dot(shape, &ratio) / sum;
            }
        }
        shares
    }

    /// By coordinate descent, which needs products alone.
    fn by_least_squares(&self, arriving: &[f64]) -> Vec<f64> {
        let wanted: Vec<f64> =
            self.integrals.iter().map(|shape| weighted(shape, arriving, &self.per_solid_angle)).collect();
        let mut shares = vec![0.0; wanted.len()];
        for _ in 0..100 * ROUNDS {
            for (k, (row, wanted)) in self.products.iter().zip(&wanted).enumerate() {
                let (Some(share), Some(own)) = (shares.get(k).copied(), row.get(k)) else { continue };
                let better = (share + (wanted - dot(row, &shares)) / own).max(0.0);
                if let Some(share) = shares.get_mut(k) {
                    *share = better;
                }
            }
        }
        shares
    }
}

/// The inner product, summed in four lanes, which vector units do at once.
fn dot(a: &[f64], b: &[f64]) -> f64 {
    let mut lanes = [0.0; 4];
    let (a4, a_rest) = a.as_chunks::<4>();
    let (b4, b_rest) = b.as_chunks::<4>();
    for (a, b) in a4.iter().zip(b4) {
        for k in 0..4 {
            lanes[k] += a[k] * b[k];
        }
    }
    let rest: f64 = a_rest.iter().zip(b_rest).map(|(a, b)| a * b).sum();
    (lanes[0] + lanes[1]) + (lanes[2] + lanes[3]) + rest
}

fn weighted(a: &[f64], b: &[f64], weights: &[f64]) -> f64 {
    a.iter().zip(b).zip(weights).map(|((a, b), weight)| a * b * weight).sum()
}

/// A Gaussian of the angle from its middle, of integral 1 over the sphere.
struct Gaussian {
    deviation: f64,
    scale: f64,
}

impl Gaussian {
    fn new(deviation: f64) -> Self {
        const STEPS: usize = 4096;
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

    fn at(&self, angle: f64) -> f64 {
        self.scale * (-0.5 * (angle / self.deviation).powi(2)).exp()
    }
}
