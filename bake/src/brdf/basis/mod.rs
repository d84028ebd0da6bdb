//! Linear bases of the spaces of BRDF models, by PCA (thesis §4.1.2).

mod blinn_phong;
mod ggx;

use ndarray::Array2;
use ndarray_linalg::error::LinalgError;
use rayon::prelude::*;
use relume_formats::kinds::brdf_basis::{BasisError, BrdfBasis};
use relume_formats::state::Model;

/// Builds a basis of `bases` functions, the diffuse one included. With `shared_diffuse`, glossy lobes are approximated with the diffuse basis too.
///
/// # Errors
/// If LAPACK fails.
pub fn build(model: Model, bases: usize, shared_diffuse: bool) -> Result<BrdfBasis, LinalgError> {
    match model {
        Model::BlinnPhong => blinn_phong::build(bases, shared_diffuse),
        Model::Ggx => ggx::build(bases, shared_diffuse),
    }
}

/// The matrix that the PCA runs on, a column for each sample, and how each column was made from its lobe.
struct Samples {
    matrix: Array2<f64>,
    /// For each sample: the factor on its lobe.
    scale: Vec<f64>,
    /// For each sample: how much of the diffuse lobe was taken away after scaling.
    diffuse_share: Vec<f64>,
}

impl Samples {
    /// `lobes` gives each sample's lobe, tabulated as `diffuse` is, and its factor.
    fn new(lobes: &[(Vec<f64>, f64)], diffuse: &[f64], shared_diffuse: bool) -> Self {
        let diffuse_squared = dot(diffuse, diffuse);
        let mut matrix = Array2::zeros((diffuse.len(), lobes.len()));
        let (mut scale, mut diffuse_share) = (Vec::new(), Vec::new());
        for (mut column, (lobe, factor)) in matrix.columns_mut().into_iter().zip(lobes) {
            let share = if shared_diffuse { factor * dot(lobe, diffuse) / diffuse_squared } else { 0.0 };
            for (value, (l, d)) in column.iter_mut().zip(lobe.iter().zip(diffuse)) {
                *value = factor * l - share * d;
            }
            scale.push(*factor);
            diffuse_share.push(share);
        }
        Self { matrix, scale, diffuse_share }
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}

fn unmeasured() -> BasisError {
    BasisError { mean: f64::NAN, worst: f64::NAN, worst_at: f64::NAN }
}

/// Mean and worst of `error` over `parameters`.
fn errors_of(parameters: &[f32], error: impl Fn(&f32) -> f64 + Send + Sync) -> BasisError {
    let errors: Vec<f64> = parameters.par_iter().map(error).collect();
    let worse = |w: (f64, f64), (e, at): (&f64, &f32)| if *e > w.0 { (*e, f64::from(*at)) } else { w };
    let (worst, worst_at) = errors.iter().zip(parameters).fold((0.0, 0.0), worse);
    BasisError { mean: errors.iter().sum::<f64>() / errors.len() as f64, worst, worst_at }
}

#[cfg(test)]
mod tests {
    use super::*;
    use relume_formats::Place;
    use relume_formats::container::Stored as _;
    use relume_formats::kinds::brdf_basis::Functions;

    fn assert_taken(model: Model, bases: usize, shared_diffuse: bool) {
        let basis = build(model, bases, shared_diffuse).unwrap();
        let stored = basis.meta.error_at_samples.worst.max(basis.meta.error_between.worst);
        let found = basis.largest_error();
        println!("{} bases of {}, shared {shared_diffuse}: {found:.3e} at nodes, {stored:.3e} stored", bases, model.name());
        // Readers allow 1.25 times what is stored, and a thousandth.
        assert!(found <= 1.2 * stored + 5e-4, "{bases} bases of {}: {found} against {stored}", model.name());
        basis.to_bytes(Place::file("basis")).unwrap();
    }

    /// With room to spare: the bound of readers is larger.
    #[test]
    fn readers_find_the_errors_that_are_stored() {
        for (model, bases, shared) in
            [(Model::BlinnPhong, 2, false), (Model::BlinnPhong, 32, true), (Model::Ggx, 2, true), (Model::Ggx, 32, false)]
        {
            assert_taken(model, bases, shared);
        }
    }

    #[test]
    #[ignore = "takes minutes"]
    fn readers_find_the_errors_that_are_stored_for_any_number_of_bases() {
        for bases in 2..=32 {
            for (model, shared) in [(Model::BlinnPhong, true), (Model::BlinnPhong, false), (Model::Ggx, true), (Model::Ggx, false)] {
                assert_taken(model, bases, shared);
            }
        }
    }

    /// Whatever is of another size or sign than what it belongs to is refused.
    #[test]
    fn tables_that_do_not_make_the_lobes_are_refused() {
        for model in [Model::BlinnPhong, Model::Ggx] {
            let sound = build(model, 6, true).unwrap();
            let changes: [&dyn Fn(&mut f32); 4] = [&|v| *v *= 1000.0, &|v| *v *= 10.0, &|v| *v = -*v, &|v| *v = 0.0];
            for change in changes {
                let (mut scaled, mut other) = (sound.clone(), sound.clone());
                scaled.coefficients.iter_mut().for_each(change);
                match &mut other.functions {
                    Functions::BlinnPhong { lobes } => lobes.iter_mut().for_each(change),
                    Functions::Ggx { weights, .. } => weights.iter_mut().for_each(change),
                }
                let mut row = sound.clone();
                let width = row.bases();
                // A single node in the middle, its largest coefficients among them.
                row.coefficients.chunks_exact_mut(width).skip(200).take(2).flatten().for_each(change);
                let mut reordered = sound.clone();
                reordered.coefficients.reverse();
                for (what, basis) in [("coefficients", scaled), ("functions", other), ("node", row), ("order", reordered)] {
                    let message = basis.to_bytes(Place::file("basis")).unwrap_err().to_string();
                    assert!(message.contains("section `coefficients`") && message.contains("the model's lobes"), "{what}: {message}");
                }
            }
        }
    }
}
