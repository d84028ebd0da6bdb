//! How far a basis is from the lobes that it stands for, measured again by whoever reads it.
//!
//! A basis stores the largest relative L2 error that its bake measured at some parameters and between them.
//! At every node of its table the lobe is analytic, so that coefficients and functions that do not belong
//! together, or are of another size or sign, are told by an error beyond what is stored.

use super::{BrdfBasis, Functions};
use crate::basis::half_difference::{HalfDifference, half_angles};
use crate::basis::microfacet::Facets;
use crate::basis::{Angles, brdf_grid, lobe_table, microfacet};
use crate::state::SHININESS_MAX;
use std::f64::consts::TAU;
use std::sync::LazyLock;

/// How much larger than the largest error that is stored the error at a node may be. The bake does not
/// measure at all of them: bases of 2 to 32 functions of all models have up to 1.18 times the error at some
/// node in between, where it is 10⁻⁵ and more.
const FACTOR: f64 = 1.25;
/// What may be added for roundings to single precision, and for the tables' interpolation; no picture shows
/// it.
const ROUNDING: f64 = 1e-3;

/// What is wrong with a basis whose lobes are farther from the analytic ones than it says.
pub(super) fn fault(basis: &BrdfBasis) -> Option<String> {
    let stored = basis.meta.error_at_samples.worst.max(basis.meta.error_between.worst);
    let found = largest(basis);
    let fits = found <= FACTOR * stored + ROUNDING;
    // NaN fits nowhere.
    (!fits).then(|| format!("coefficients and functions miss the model's lobes by {found:.3e} of them, the basis says {stored:.3e}"))
}

/// Over all nodes the largest error of a lobe, in parts of its norm. A part of a lobe may err by as much as
/// its own norm besides, for a basis is made for whole lobes, and nothing that is fitted errs by more than it
/// is.
pub(super) fn largest(basis: &BrdfBasis) -> f64 {
    let space = Space::of(basis);
    let (bases, parts) = (basis.bases(), basis.functions.parts());
    let mut error = 0.0f64;
    for (parameter, rows) in basis.parameters.iter().zip(basis.coefficients.chunks_exact(bases * parts)) {
        let sums = space.sums(*parameter, rows);
        let norm = sums.whole.truth.sqrt();
        let of_parts = sums.parts.iter().map(|part| part.difference.sqrt() - part.truth.sqrt());
        for e in of_parts.chain([sums.whole.difference.sqrt()]) {
            // `max` would pass over NaN.
            error = if error.is_nan() || e / norm <= error { error } else { e / norm };
        }
    }
    error
}

/// Squares over all directions.
#[derive(Default, Clone, Copy)]
struct Squares {
    truth: f64,
    difference: f64,
}

impl Squares {
    fn add(&mut self, weight: f64, truth: f32, difference: f32) {
        self.truth += weight * f64::from(truth).powi(2);
        self.difference += weight * f64::from(difference).powi(2);
    }
}

/// Of a lobe, and of each of its parts if it has several.
struct Sums {
    whole: Squares,
    parts: Vec<Squares>,
}

/// The directions that a model's lobes are compared in, and the basis functions there.
struct Space {
    directions: Directions,
    /// A row for each basis function.
    values: Vec<Vec<f32>>,
}

#[derive(Clone, Copy)]
enum Directions {
    HalfAngles(&'static HalfAngles),
    Pairs(Facets, &'static Pairs),
}

/// Half angles that Blinn-Phong lobes are compared at: cosines and their logarithms.
struct HalfAngles {
    cosines: Vec<f32>,
    log_cosines: Vec<f32>,
    weights: Vec<f64>,
}

impl HalfAngles {
    fn new(of: impl IntoIterator<Item = (f64, f64)>) -> Self {
        let (cosines, weights): (Vec<f64>, Vec<f64>) = of.into_iter().unzip();
        let log_cosines = cosines.iter().map(|cosine| cosine.ln() as f32).collect();
        Self { cosines: cosines.into_iter().map(|cosine| cosine as f32).collect(), log_cosines, weights }
    }
}

/// Pairs of directions, with Schlick's weight.
struct Pairs {
    angles: Vec<Angles>,
    schlick: Vec<f32>,
    weights: Vec<f64>,
}

/// The angle grid of the Blinn-Phong bake, each node shared out to the two nodes of the lobe table between
/// which it falls.
static TABLE: LazyLock<HalfAngles> = LazyLock::new(|| {
    let mut all = vec![0.0; lobe_table::NODES];
    for (i, o) in (0..brdf_grid::THETA_NODES).flat_map(|i| (i..brdf_grid::THETA_NODES).map(move |o| (i, o))) {
        let times = if i == o { 1.0 } else { 2.0 };
        for p in 0..brdf_grid::PHI_NODES {
            let (node, mix) = lobe_table::locate(brdf_grid::cos_half_angle(i, o, p) as f32);
            for (at, share) in [(node, 1.0 - mix), (node + 1, mix)] {
                if let Some(weight) = all.get_mut(at) {
                    *weight += times * f64::from(share);
                }
            }
        }
    }
    let used = all.into_iter().enumerate().filter(|(_, weight)| *weight > 0.0);
    HalfAngles::new(used.map(|(node, weight)| (lobe_table::cos_delta(node), weight)))
});

/// That grid cannot tell sharper lobes from one another.
static SHARP: LazyLock<HalfAngles> = LazyLock::new(|| HalfAngles::new(half_angles()));

static PAIRS: LazyLock<Pairs> = LazyLock::new(|| {
    let HalfDifference { angles, weight } = HalfDifference::new();
    let schlick = angles.iter().map(|angles| microfacet::schlick(angles.cos_difference)).collect();
    Pairs { angles, schlick, weights: weight.iter().map(|w| w * w).collect() }
});

impl Space {
    fn of(basis: &BrdfBasis) -> Self {
        let directions = match basis.functions {
            Functions::BlinnPhong { .. } if basis.sharpest() > SHININESS_MAX => {
                Directions::HalfAngles(&SHARP)
            }
            Functions::BlinnPhong { .. } => Directions::HalfAngles(&TABLE),
            Functions::Microfacet { facets, .. } => Directions::Pairs(facets, &PAIRS),
        };
        let at = |cosine: &f32| Angles { cos_half: *cosine, cos_difference: 1.0, cos_in: 1.0, cos_out: 1.0 };
        let angles = match directions {
            Directions::HalfAngles(all) => &all.cosines.iter().map(at).collect(),
            Directions::Pairs(_, pairs) => &pairs.angles,
        };
        let mut values = vec![vec![0.0; angles.len()]; basis.bases()];
        let mut here = vec![0.0; basis.bases()];
        for (at, angles) in angles.iter().enumerate() {
            basis.evaluate(angles, &mut here);
            for (row, value) in values.iter_mut().zip(&here) {
                if let Some(place) = row.get_mut(at) {
                    *place = *value;
                }
            }
        }
        Self { directions, values }
    }

    /// What `coefficients` make of the basis functions.
    fn approximation(&self, coefficients: &[f32]) -> Vec<f32> {
        let mut sum = vec![0.0; self.values.first().map_or(0, Vec::len)];
        for (coefficient, values) in coefficients.iter().zip(&self.values) {
            sum.iter_mut().zip(values).for_each(|(sum, value)| *sum += coefficient * value);
        }
        sum
    }

    /// The squares of the lobe of `parameter` and of what `rows` of coefficients, one for each part, make of
    /// it.
    fn sums(&self, parameter: f32, rows: &[f32]) -> Sums {
        let mut sums = Sums { whole: Squares::default(), parts: Vec::new() };
        match self.directions {
            Directions::HalfAngles(HalfAngles { log_cosines, weights, .. }) => {
                let peak = (f64::from(parameter) + 2.0) / TAU;
                let approximation = self.approximation(rows);
                for ((log_cosine, weight), value) in log_cosines.iter().zip(weights).zip(approximation) {
                    let truth = peak as f32 * (parameter * log_cosine).exp();
                    sums.whole.add(*weight, truth, value - truth);
                }
            }
            Directions::Pairs(facets, Pairs { angles, schlick, weights }) => {
                let (at_f0, grazing) = rows.split_at(rows.len() / 2);
                let [a, b] = [at_f0, grazing].map(|row| self.approximation(row));
                let [mut first, mut second] = [Squares::default(); 2];
                for (((angles, w), weight), (a, b)) in
                    angles.iter().zip(schlick).zip(weights).zip(a.iter().zip(&b))
                {
                    let lobe = facets.lobe(parameter, angles);
                    let [of_a, of_b] = [a - lobe * (1.0 - w), b - lobe * w];
                    first.add(*weight, lobe * (1.0 - w), of_a);
                    second.add(*weight, lobe * w, of_b);
                    sums.whole.add(*weight, lobe, of_a + of_b);
                }
                sums.parts = vec![first, second];
            }
        }
        sums
    }
}
