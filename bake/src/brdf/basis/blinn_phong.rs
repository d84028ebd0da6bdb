//! A PCA basis of the Blinn-Phong space (thesis §4.1.2).
//!
//! Samples are the glossy lobes of exponents 1..=200 on the angle grid, each scaled to unit norm, no mean
//! taken away; the diffuse lobe is a basis of its own. Every basis function is a known linear combination of
//! the analytic samples, so it can be evaluated exactly at any half angle: that fills the fine tables, and
//! the coarse grid serves for inner products only.
//!
//! Sharper lobes, which that grid cannot tell from one another, are integrated over half angles that crowd
//! towards the peak, with both cosines, and sampled evenly in octaves, which is how they are perceived.

use super::samples::{Samples, dot, dots, errors_of, interleaved, unmeasured};
use crate::compress::linalg::{Svd, first_singular};
use ndarray_linalg::error::LinalgError;
use rayon::prelude::*;
use relume_formats::basis::half_difference::half_angles;
use relume_formats::basis::{Angles, brdf_grid, lobe_table};
use relume_formats::kinds::brdf_basis::{BasisError, BrdfBasis, Functions, MAX_BASES, Meta};
use relume_formats::state::{SHININESS_MAX, SHININESS_MIN};
use std::borrow::Cow;
use std::f64::consts::{FRAC_1_PI, TAU};

/// Sharper ones than usual are sampled at so many exponents an octave.
const SAMPLES_PER_OCTAVE: f32 = 8.0;
/// Nodes of the coefficient table per octave of exponents, as long as that is finer than every integer unless
/// lobes are sharper than usual.
/// Linear interpolation then errs by about (1/64)²/8 = 3e-5 of the lobe, which stays below the error of any
/// basis worth baking.
const NODES_PER_OCTAVE: f32 = 64.0;

/// What lobes are tabulated on, and the samples.
pub(super) struct Grid {
    cos_delta: Vec<f64>,
    /// Square root of the weight of each.
    weight: Vec<f64>,
    /// Root of the sum of all weights: the norm of 1.
    norm: f64,
    /// Exponents of the samples, increasing to that of the sharpest lobe.
    exponents: Vec<f32>,
    /// The unit glossy lobe of every sampled exponent at every node, sr⁻¹.
    samples: Vec<Vec<f64>>,
}

impl Grid {
    /// For exponents up to `sharpest`.
    pub(super) fn new(sharpest: f32) -> Self {
        if sharpest <= SHININESS_MAX { Self::of_angles() } else { Self::of_half_angles(sharpest) }
    }

    /// The half angles of the angle grid, each pair of mirrored nodes (θi, θo), (θo, θi) once, with the square
    /// root of how often it occurs. Exponents are, as in the thesis, all integers.
    fn of_angles() -> Self {
        let (mut cos_delta, mut weight) = (Vec::new(), Vec::new());
        for i in 0..brdf_grid::THETA_NODES {
            for o in i..brdf_grid::THETA_NODES {
                for p in 0..brdf_grid::PHI_NODES {
                    cos_delta.push(brdf_grid::cos_half_angle(i, o, p));
                    weight.push(if i == o { 1.0 } else { std::f64::consts::SQRT_2 });
                }
            }
        }
        let exponents = (1..=SHININESS_MAX as usize).map(|s| s as f32).collect();
        Self::sampled(cos_delta, weight, (brdf_grid::NODES as f64).sqrt(), exponents)
    }

    fn of_half_angles(sharpest: f32) -> Self {
        let (cos_delta, weights): (Vec<f64>, Vec<f64>) = half_angles().into_iter().unzip();
        let norm = weights.iter().sum::<f64>().sqrt();
        let intervals = (sharpest.log2() * SAMPLES_PER_OCTAVE).ceil() as usize;
        let exponents = (0..=intervals).map(|i| sharpest.powf(i as f32 / intervals as f32)).collect();
        Self::sampled(cos_delta, weights.iter().map(|w| w.sqrt()).collect(), norm, exponents)
    }

    fn sampled(cos_delta: Vec<f64>, weight: Vec<f64>, norm: f64, exponents: Vec<f32>) -> Self {
        let samples = exponents.par_iter().map(|s| lobe(f64::from(*s), &cos_delta)).collect();
        Self { cos_delta, weight, norm, exponents, samples }
    }

    /// The unit glossy lobe of exponent `s` at every node.
    fn lobe(&self, s: f32) -> Cow<'_, [f64]> {
        let sample = self.exponents.binary_search_by(|e| e.total_cmp(&s)).ok().map(|at| &self.samples[at]);
        sample.map_or_else(|| lobe(f64::from(s), &self.cos_delta).into(), |sample| sample.into())
    }

    fn weighted(&self, values: &[f64]) -> Vec<f64> {
        self.weight.iter().zip(values).map(|(w, v)| w * v).collect()
    }

    fn sharpest(&self) -> f32 {
        self.exponents[self.exponents.len() - 1]
    }

    fn diffuse(&self) -> Vec<f64> {
        self.weight.iter().map(|w| w * FRAC_1_PI).collect()
    }
}

/// The unit glossy lobe, sr⁻¹.
fn glossy(s: f64, cos_delta: f64) -> f64 {
    (s + 2.0) / TAU * cos_delta.powf(s)
}

fn lobe(s: f64, cos_delta: &[f64]) -> Vec<f64> {
    cos_delta.iter().map(|c| glossy(s, *c)).collect()
}

/// See [`super::Space::new`]; errors are not measured.
pub(super) fn build(bases: usize, shared_diffuse: bool, grid: &Grid) -> Result<BrdfBasis, LinalgError> {
    let samples = Samples::new(&unit_lobes(grid), &grid.diffuse(), shared_diffuse);
    // All that could be asked for, so that rounding does not depend on how many are.
    let Svd { u, s, vt } = first_singular(&samples.matrix, MAX_BASES - 1)?;
    // Root mean square 1 over the grid, so that coefficients are of the order of the BRDF.
    let combinations: Vec<(Vec<f64>, f64)> =
        (0..bases - 1).map(|j| (vt.row(j).to_vec(), grid.norm / s[j])).collect();
    let lobes = samples.lobe_tables(&combinations, &grid.exponents);

    let on_grid: Vec<Vec<f64>> = u.columns().into_iter().take(bases - 1).map(|c| c.to_vec()).collect();
    let parameters = coefficient_nodes(grid.sharpest());
    let coefficients = project(grid, &on_grid, &parameters, shared_diffuse);
    let meta = Meta { shared_diffuse, error_at_samples: unmeasured(), error_between: unmeasured() };
    Ok(BrdfBasis { meta, parameters, coefficients, functions: Functions::BlinnPhong { lobes } })
}

/// The lobe of every sampled exponent, weighted, with the factor that makes its norm 1.
fn unit_lobes(grid: &Grid) -> Vec<(Vec<f64>, f64)> {
    let unit = |sample: &Vec<f64>| {
        let lobe = grid.weighted(sample);
        let factor = 1.0 / dot(&lobe, &lobe).sqrt();
        (lobe, factor)
    };
    grid.samples.par_iter().map(unit).collect()
}

impl Samples {
    /// The combinations Σ weights·samples, each times its factor, at the nodes of a lobe table, one table
    /// after the other.
    fn lobe_tables(&self, combinations: &[(Vec<f64>, f64)], exponents: &[f32]) -> Vec<f32> {
        let at_node = |node: usize| -> Vec<f32> {
            let c = lobe_table::cos_delta(node);
            let lobes = self.scale.iter().zip(&self.diffuse_share).zip(exponents);
            let lobes: Vec<f64> = lobes
                .map(|((scale, share), s)| scale * glossy(f64::from(*s), c) - share * FRAC_1_PI)
                .collect();
            combinations.iter().map(|(weights, factor)| (factor * dot(weights, &lobes)) as f32).collect()
        };
        let nodes: Vec<Vec<f32>> = (0..lobe_table::NODES).into_par_iter().map(at_node).collect();
        (0..combinations.len()).flat_map(|table| nodes.iter().map(move |node| node[table])).collect()
    }
}

/// Exponents at which coefficients are stored: as many as [`NODES_PER_OCTAVE`] asks, and where lobes are not
/// sharper than usual, every integer.
fn coefficient_nodes(sharpest: f32) -> Vec<f32> {
    let widest = if sharpest <= SHININESS_MAX { 1.0 } else { f32::INFINITY };
    let mut nodes = vec![SHININESS_MIN];
    let mut last = SHININESS_MIN;
    while last < sharpest {
        // A power of two within the octave, so that every integer is met exactly.
        last += (last.log2().floor().exp2() / NODES_PER_OCTAVE).min(widest);
        last = last.min(sharpest);
        nodes.push(last);
    }
    nodes
}

/// Coefficients of the unit glossy lobe of each exponent: row-major [nodes, bases].
fn project(grid: &Grid, on_grid: &[Vec<f64>], shininess: &[f32], shared_diffuse: bool) -> Vec<f32> {
    let diffuse = grid.diffuse();
    let diffuse_squared = dot(&diffuse, &diffuse);
    let columns = interleaved(on_grid);
    let row = |s: &f32| {
        let lobe = grid.weighted(&grid.lobe(*s));
        let diffuse_part = if shared_diffuse { dot(&lobe, &diffuse) / diffuse_squared } else { 0.0 };
        // The columns are orthonormal, and orthogonal to the diffuse lobe if that is shared: projection is
        // the least-squares fit.
        let mut row = vec![diffuse_part as f32];
        row.extend(dots(&lobe, &columns, on_grid.len()).iter().map(|dot| (dot / grid.norm) as f32));
        row
    };
    shininess.par_iter().flat_map_iter(row).collect()
}

/// Relative L2 errors over the angle grid of the stored basis, at the sampled exponents and between them.
pub(super) fn errors(basis: &BrdfBasis, grid: &Grid) -> [BasisError; 2] {
    let values: Vec<Vec<f32>> = grid
        .cos_delta
        .par_iter()
        .map(|c| {
            let mut out = vec![0.0; basis.bases()];
            basis.evaluate(&at_half_angle(*c as f32), &mut out);
            out
        })
        .collect();
    let error = |s: &f32| {
        let coefficients = basis.lobe_coefficients(0, *s);
        let (mut difference, mut norm) = (0.0, 0.0);
        for ((truth, weight), value) in grid.lobe(*s).iter().zip(&grid.weight).zip(&values) {
            let approximation: f64 =
                coefficients.iter().zip(value).map(|(c, b)| f64::from(*c) * f64::from(*b)).sum();
            difference += (weight * (approximation - truth)).powi(2);
            norm += (weight * truth).powi(2);
        }
        (difference / norm).sqrt()
    };
    // Nodes are dyadic fractions apart, so this share of the way meets none of them.
    let between: Vec<f32> = grid.exponents.windows(2).map(|s| s[0] + 0.371 * (s[1] - s[0])).collect();
    [&grid.exponents, &between].map(|shininess| errors_of(shininess, error))
}

/// Blinn-Phong lobes depend on the half angle alone.
fn at_half_angle(cos_half: f32) -> Angles {
    Angles { cos_half, cos_difference: 1.0, cos_in: 1.0, cos_out: 1.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3A;
    use relume_formats::state::{BlinnPhong, Brdf, Model};

    /// The figures of the thesis, under the metric that reproduces them, are ceilings.
    #[test]
    fn errors_stay_below_the_published_figures() {
        for (bases, shared, mean, worst) in [
            (6, true, 0.0065, 0.050),
            (6, false, 0.0090, 0.068),
            (4, false, 0.048, 1.0),
            (9, true, 0.0007, 0.005),
        ] {
            let meta = super::super::build(Model::BlinnPhong, bases, shared).unwrap().meta;
            for error in [meta.error_at_samples, meta.error_between] {
                assert!(
                    error.mean <= mean && error.worst <= worst,
                    "{bases} bases, shared {shared}: {error:?}"
                );
            }
        }
    }

    /// Independent of the grid metric: with many bases the look-up must converge to the analytic lobe
    /// everywhere.
    #[test]
    fn many_bases_reproduce_the_analytic_brdf() {
        assert_reproduced(SHININESS_MAX, 16, 5e-4, &[1.0, 1.618, 5.5, 40.25, 180.7, 200.0]);
        // Both directions graze where δ nears 90 degrees, and cosines leave little of what is wrong there.
        assert_reproduced(5000.0, 24, 2e-3, &[1.0, 1.618, 5.5, 40.25, 180.7, 1234.5, 4900.0, 5000.0]);
    }

    fn assert_reproduced(sharpest: f32, bases: usize, bound: f32, exponents: &[f32]) {
        let basis = build(bases, true, &Grid::new(sharpest)).unwrap();
        let mut values = vec![0.0; bases];
        for &s in exponents {
            let material = BlinnPhong { kd: [0.0, 0.3, 0.0], ks: [1.0, 0.7, 0.0], shininess: s };
            let coefficients = basis.coefficients_of(&Brdf::BlinnPhong(material)).unwrap();
            let peak = glossy(f64::from(s), 1.0) as f32;
            for step in 0..=200 {
                // The upper half crowds towards the peak.
                let cos_delta =
                    if step <= 100 { step as f32 / 100.0 } else { (1e-3 * (step - 100) as f32).cos() };
                basis.evaluate(&at_half_angle(cos_delta), &mut values);
                let truth = crate::brdf::blinn_phong::evaluate(&material, Vec3A::ONE, cos_delta);
                for channel in 0..3 {
                    let sum: f32 = coefficients.iter().zip(&values).map(|(c, b)| c[channel] * b).sum();
                    // Powers that are no integers have a singular derivative at cos δ = 0, where integer
                    // powers follow them slowly.
                    assert!(
                        (sum - truth[channel]).abs() < bound * peak.max(1.0),
                        "s {s}, cos δ {cos_delta}: {sum} against {}",
                        truth[channel]
                    );
                }
            }
        }
    }

    #[test]
    fn every_integer_exponent_is_a_node() {
        let nodes = coefficient_nodes(SHININESS_MAX);
        assert!((1..=200).all(|s| nodes.contains(&(s as f32))));
        assert!(nodes.windows(2).all(|w| w[1] - w[0] <= 1.0 && w[1] / w[0] < 1.03));
        assert_eq!(nodes.last(), Some(&200.0));
    }
}
