//! A PCA basis of a space of microfacet lobes, GGX's or Cook and Torrance's.
//!
//! A lobe is f₀·A(r) + B(r): A = D·V·(1 − w) and B = D·V·w with Schlick's weight w, each a sample of its own
//! at every roughness. They depend on three angles, so inner products are sums over half and difference
//! angles (Rusinkiewicz 1998), which follow the peak of any lobe, weighted so that they are integrals over
//! both directions with both cosines. Basis functions are stored as the combinations of analytic samples that
//! they are, and no table limits how well they resolve a lobe.

use super::samples::{Samples, dot, dots, errors_of, interleaved, unmeasured};
use crate::compress::linalg::{Svd, first_singular};
use ndarray_linalg::error::LinalgError;
use rayon::prelude::*;
use relume_formats::basis::Angles;
use relume_formats::basis::half_difference::HalfDifference;
use relume_formats::basis::microfacet::{self, Facets};
use relume_formats::kinds::brdf_basis::{BasisError, BrdfBasis, Functions, MAX_BASES, Meta, model_of};

/// Intervals between the roughnesses of the samples, spaced evenly in octaves, of the usual range. Twice as many
/// change no error by a tenth.
const SAMPLED: usize = 15;
/// What B counts beside A, whose norm is made 1. B has the factor 1 in every material and A f₀, from 0.04 to
/// 1; 2 is where metals and dielectrics come off alike. Cook and Torrance's have ks and ks·fresnel.
const SCHLICK_WEIGHT: f64 = 2.0;
/// Intervals of the coefficient table of the usual range. Steps of 0.22 % in roughness, or 0.45 % in slope, make
/// linear interpolation err by about 1e-5 of the lobe.
const INTERVALS: usize = 512;
/// Pairs of directions on which lobes are integrated, and whose lobes these are.
pub(super) struct Grid {
    pairs: HalfDifference,
    facets: Facets,
    /// Of the lobes.
    sharpest: f32,
}

impl Grid {
    pub(super) fn new(facets: Facets, sharpest: f32) -> Self {
        Self { pairs: HalfDifference::new(), facets, sharpest }
    }

    /// Roughnesses from the sharpest lobe's to the roughest's, which is 1, spaced evenly in octaves: as densely
    /// as so many intervals of the usual range.
    fn roughnesses(&self, intervals: usize) -> Vec<f32> {
        let usual = model_of(self.facets).usual_sharpest();
        let intervals = (intervals as f32 * self.sharpest.ln() / usual.ln()).round() as usize;
        (0..=intervals).map(|i| self.sharpest.powf(1.0 - i as f32 / intervals as f32)).collect()
    }

    fn tabulate(&self, f: impl Fn(&Angles) -> f64) -> Vec<f64> {
        self.pairs.angles.iter().zip(&self.pairs.weight).map(|(angles, weight)| weight * f(angles)).collect()
    }

    /// The parts A and B of the lobe, weighted.
    fn lobe(&self, roughness: f32) -> [Vec<f64>; 2] {
        let distribution = |angles: &Angles| f64::from(self.facets.lobe(roughness, angles));
        let schlick = |angles: &Angles| f64::from(microfacet::schlick(angles.cos_difference));
        [
            self.tabulate(|a| distribution(a) * (1.0 - schlick(a))),
            self.tabulate(|a| distribution(a) * schlick(a)),
        ]
    }

    fn diffuse(&self) -> Vec<f64> {
        self.tabulate(|angles| f64::from(self.facets.diffuse(microfacet::schlick(angles.cos_difference))))
    }
}

/// The parts A(r₀), B(r₀), A(r₁), … of the lobes of all roughnesses, with their factors.
fn weighed_parts(grid: &Grid, roughness: &[f32]) -> Vec<(Vec<f64>, f64)> {
    let of = |r: &f32| {
        let parts = grid.lobe(*r);
        let unit = 1.0 / dot(&parts[0], &parts[0]).sqrt();
        parts.into_iter().zip([unit, SCHLICK_WEIGHT * unit])
    };
    roughness.par_iter().flat_map_iter(of).collect()
}

impl Samples {
    /// Row of the stored weights for the combination Σ combination·column, times `factor`.
    fn weights(&self, combination: &[f64], factor: f64) -> Vec<f32> {
        let diffuse: f64 = combination.iter().zip(&self.diffuse_share).map(|(c, share)| -c * share).sum();
        let of_part = |part: usize| {
            combination.iter().zip(&self.scale).skip(part).step_by(2).map(|(c, scale)| c * scale)
        };
        std::iter::once(diffuse).chain(of_part(0)).chain(of_part(1)).map(|w| (factor * w) as f32).collect()
    }
}

/// See [`super::Space::new`]; errors are not measured.
pub(super) fn build(bases: usize, shared_diffuse: bool, grid: &Grid) -> Result<BrdfBasis, LinalgError> {
    let diffuse = grid.diffuse();
    let roughness = grid.roughnesses(SAMPLED);
    let samples = Samples::new(&weighed_parts(grid, &roughness), &diffuse, shared_diffuse);
    // All that could be asked for, so that rounding does not depend on how many are.
    let Svd { u, s, vt } = first_singular(&samples.matrix, MAX_BASES - 1)?;
    // The norm of the diffuse lobe, so that coefficients are of the order of the BRDF.
    let norm = dot(&diffuse, &diffuse).sqrt();
    let weights = (0..bases - 1).flat_map(|j| samples.weights(&vt.row(j).to_vec(), norm / s[j])).collect();
    let on_grid: Vec<Vec<f64>> = u.columns().into_iter().take(bases - 1).map(|c| c.to_vec()).collect();
    let columns = interleaved(&on_grid);

    let parameters = grid.roughnesses(INTERVALS);
    let part_coefficients = |part: Vec<f64>| {
        let diffuse_part = if shared_diffuse { dot(&part, &diffuse) / (norm * norm) } else { 0.0 };
        let glossy = dots(&part, &columns, on_grid.len()).into_iter().map(|dot| (dot / norm) as f32);
        std::iter::once(diffuse_part as f32).chain(glossy)
    };
    let of_lobe = |r: &f32| grid.lobe(*r).into_iter().flat_map(part_coefficients);
    let coefficients = parameters.par_iter().flat_map_iter(of_lobe).collect();
    let functions = Functions::Microfacet { facets: grid.facets, roughness, weights };
    let meta = Meta { shared_diffuse, error_at_samples: unmeasured(), error_between: unmeasured() };
    Ok(BrdfBasis { meta, parameters, coefficients, functions })
}

/// Relative L2 errors of the lobe of f₀ = 1, which is a white metal's, at the sampled roughnesses and between them.
pub(super) fn errors(basis: &BrdfBasis, grid: &Grid) -> [BasisError; 2] {
    let values: Vec<Vec<f32>> = grid
        .pairs
        .angles
        .par_iter()
        .map(|angles| {
            let mut values = vec![0.0; basis.bases()];
            basis.evaluate(angles, &mut values);
            values
        })
        .collect();
    let error = |r: &f32| {
        let [at_f0, schlick] = [0, 1].map(|part| basis.lobe_coefficients(part, *r));
        let [a, b] = grid.lobe(*r);
        let (mut difference, mut norm) = (0.0, 0.0);
        for ((truth, weight), value) in
            a.iter().zip(&b).map(|(a, b)| a + b).zip(&grid.pairs.weight).zip(&values)
        {
            let sum: f64 = value
                .iter()
                .zip(at_f0.iter().zip(&schlick))
                .map(|(v, (c, e))| f64::from(*v) * f64::from(c + e))
                .sum();
            difference += (weight * sum - truth).powi(2);
            norm += truth * truth;
        }
        (difference / norm).sqrt()
    };
    let roughness = grid.roughnesses(SAMPLED);
    let between: Vec<f32> = roughness.windows(2).map(|w| (w[0] * w[1]).sqrt() * 1.001).collect();
    [roughness, between].map(|roughness| errors_of(&roughness, error))
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3A;
    use relume_formats::state::{Brdf, CookTorrance, Ggx, Model};

    /// Ceilings a third above what was measured.
    #[test]
    fn errors_fall_with_every_base() {
        for (model, ceilings) in [
            (Model::Ggx, [(6, 0.065, 0.13), (9, 0.01, 0.03), (12, 0.0025, 0.005), (16, 0.0003, 0.0006)]),
            (
                Model::CookTorrance,
                [(6, 0.13, 0.29), (9, 0.05, 0.12), (12, 0.013, 0.021), (16, 0.0029, 0.0047)],
            ),
        ] {
            let mut last = f64::INFINITY;
            for (bases, mean, worst) in ceilings {
                let meta = super::super::build(model, bases, true).unwrap().meta;
                println!("{} bases of {}: {:?}", bases, model.name(), meta.error_between);
                for error in [meta.error_at_samples, meta.error_between] {
                    assert!(error.mean <= mean && error.worst <= worst, "{bases} bases: {error:?}");
                }
                assert!(meta.error_between.mean < last);
                last = meta.error_between.mean;
            }
        }
    }

    /// Independent of the quadrature: with many bases the sum must converge to the analytic BRDF, for metals,
    /// dielectrics and what is between.
    #[test]
    fn many_bases_reproduce_the_analytic_brdf() {
        for (facets, sharpest, bases, bounds) in [
            (Facets::Ggx, 0.32, 24, [2e-3, 3e-4]),
            (Facets::CookTorrance, 0.1, 24, [2e-3, 3e-4]),
            (Facets::Ggx, 0.14, 32, [5e-3, 5e-4]),
            (Facets::CookTorrance, 0.02, 32, [5e-3, 5e-4]),
        ] {
            let basis = build(bases, true, &Grid::new(facets, sharpest)).unwrap();
            for (share, sharpness) in [(1.0, 0.0), (0.0, 0.08), (0.5, 0.35), (1.0, 0.77), (0.0, 1.0)] {
                let roughness = sharpest.powf(1.0 - sharpness);
                assert_reproduced(&basis, &material(facets, share, roughness), bounds);
            }
        }
    }

    /// `share` is of metal, or how much is reflected at normal incidence.
    fn material(facets: Facets, share: f32, roughness: f32) -> Brdf {
        let colour = [0.9, 0.5, 0.1];
        match facets {
            Facets::Ggx => Brdf::Ggx(Ggx { base_color: colour, metallic: share, roughness }),
            Facets::CookTorrance => {
                let kd = colour.map(|c| (1.0 - c) * (1.0 - share));
                Brdf::CookTorrance(CookTorrance { kd, ks: colour, fresnel: share, roughness })
            }
        }
    }

    fn assert_reproduced(basis: &BrdfBasis, material: &Brdf, [of_peak, of_ridge]: [f32; 2]) {
        let direction =
            |theta: f32, phi: f32| Vec3A::new(theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos());
        let analytic = |angles: &Angles| crate::brdf::evaluate(material, Vec3A::ONE, angles);
        let mut values = vec![0.0; basis.bases()];
        let coefficients = basis.coefficients_of(material).unwrap();
        let peak = analytic(&crate::brdf::angles(Vec3A::Z, Vec3A::Z, Vec3A::Z)).max_element();
        for step in 0..2000 {
            let [u, v, w] = [0.618_034, 0.414_214, 0.732_051].map(|g: f32| (step as f32 * g).fract());
            // Anywhere, or near the mirrored direction, where sharp lobes are.
            let (polar, azimuth) =
                if step % 2 == 0 { (1.5 * v, w) } else { (1.5 * u + 0.05 * (v - 0.5), 1.0 - 0.02 * w) };
            let (i, o) = (direction(1.5 * u, 0.0), direction(polar, std::f32::consts::PI * azimuth));
            let angles = crate::brdf::angles(i, o, Vec3A::Z);
            basis.evaluate(&angles, &mut values);
            let truth = analytic(&angles) * angles.cos_in;
            // Where a half vector is the normal a lobe is as high as it gets for this difference angle; at grazing
            // angles that is hundreds of times as high as for `peak`.
            let mirrored = angles.cos_difference;
            let mirrored =
                Angles { cos_half: 1.0, cos_difference: mirrored, cos_in: mirrored, cos_out: mirrored };
            let ridge = analytic(&mirrored) * angles.cos_in;
            for channel in 0..3 {
                let sum: f32 = coefficients.iter().zip(&values).map(|(c, b)| c[channel] * b).sum::<f32>()
                    * angles.cos_in;
                assert!(
                    (sum - truth[channel]).abs() < of_peak * peak + of_ridge * ridge[channel],
                    "{material:?} {angles:?}: {sum} against {}",
                    truth[channel]
                );
            }
        }
    }
}
