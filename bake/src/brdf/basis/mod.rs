//! Linear bases of the spaces of BRDF models, by PCA (thesis §4.1.2).

mod blinn_phong;
mod microfacet;
mod samples;

use ndarray_linalg::error::LinalgError;
use relume_formats::basis::microfacet::Facets;
use relume_formats::kinds::brdf_basis::{BrdfBasis, Functions};
use relume_formats::state::Model;

/// The functions of a model's space, those that count most first: the beginning of them, however long, is a
/// basis.
pub struct Space {
    whole: BrdfBasis,
    grid: Grid,
}

/// What a model's lobes are tabulated on.
enum Grid {
    BlinnPhong(blinn_phong::Grid),
    Microfacet(microfacet::Grid),
}

impl Space {
    /// The first `bases` functions, the diffuse one included, for lobes of `model` up to `sharpest`, an exponent,
    /// roughness or slope. With `shared_diffuse`, glossy lobes are approximated with the diffuse basis too.
    ///
    /// # Errors
    /// If LAPACK fails.
    pub fn new(model: Model, sharpest: f32, bases: usize, shared_diffuse: bool) -> Result<Self, LinalgError> {
        let of_facets = |facets| -> Result<_, LinalgError> {
            let grid = microfacet::Grid::new(facets, sharpest);
            Ok((microfacet::build(bases, shared_diffuse, &grid)?, Grid::Microfacet(grid)))
        };
        let (whole, grid) = match model {
            Model::BlinnPhong => {
                let grid = blinn_phong::Grid::new(sharpest);
                (blinn_phong::build(bases, shared_diffuse, &grid)?, Grid::BlinnPhong(grid))
            }
            Model::Ggx => of_facets(Facets::Ggx)?,
            Model::CookTorrance => of_facets(Facets::CookTorrance)?,
        };
        Ok(Self { whole, grid })
    }

    /// All functions, as a basis whose errors are not measured.
    pub fn whole(&self) -> &BrdfBasis {
        &self.whole
    }

    /// The basis of the first `bases` functions, at most as many as there are.
    pub fn basis(&self, bases: usize) -> BrdfBasis {
        let mut basis = first(&self.whole, bases);
        let [at_samples, between] = match &self.grid {
            Grid::BlinnPhong(grid) => blinn_phong::errors(&basis, grid),
            Grid::Microfacet(grid) => microfacet::errors(&basis, grid),
        };
        (basis.meta.error_at_samples, basis.meta.error_between) = (at_samples, between);
        basis
    }
}

/// The first `bases` of `whole`.
fn first(whole: &BrdfBasis, bases: usize) -> BrdfBasis {
    let per_function = |values: &[f32]| values.len() / (whole.bases() - 1).max(1);
    let beginning = |values: &[f32]| values[..(bases - 1) * per_function(values)].to_vec();
    let functions = match &whole.functions {
        Functions::BlinnPhong { lobes } => Functions::BlinnPhong { lobes: beginning(lobes) },
        Functions::Microfacet { facets, roughness, weights } => Functions::Microfacet {
            facets: *facets,
            roughness: roughness.clone(),
            weights: beginning(weights),
        },
    };
    let rows = whole.coefficients.chunks_exact(whole.bases());
    let coefficients = rows.flat_map(|row| &row[..bases]).copied().collect();
    BrdfBasis { meta: whole.meta.clone(), parameters: whole.parameters.clone(), coefficients, functions }
}

/// Builds a basis of `bases` functions for lobes that are no sharper than usual; see [`Space::new`].
///
/// # Errors
/// If LAPACK fails.
pub fn build(model: Model, bases: usize, shared_diffuse: bool) -> Result<BrdfBasis, LinalgError> {
    Ok(Space::new(model, model.usual_sharpest(), bases, shared_diffuse)?.basis(bases))
}

#[cfg(test)]
mod tests {
    use super::*;
    use relume_formats::Place;
    use relume_formats::container::Stored as _;

    fn assert_taken(model: Model, sharpest: f32, bases: usize, shared_diffuse: bool) {
        let basis = Space::new(model, sharpest, bases, shared_diffuse).unwrap().basis(bases);
        let stored = basis.meta.error_at_samples.worst.max(basis.meta.error_between.worst);
        let found = basis.largest_error();
        println!(
            "{bases} bases of {} to {sharpest}, shared {shared_diffuse}: {found:.3e} at nodes, {stored:.3e} stored",
            model.name()
        );
        // Readers allow 1.25 times what is stored, and a thousandth.
        assert!(found <= 1.2 * stored + 5e-4, "{bases} bases of {}: {found} against {stored}", model.name());
        basis.to_bytes(Place::file("basis")).unwrap();
    }

    /// With room to spare: the bound of readers is larger.
    #[test]
    fn readers_find_the_errors_that_are_stored() {
        for (model, bases, shared) in [
            (Model::BlinnPhong, 2, false),
            (Model::BlinnPhong, 32, true),
            (Model::Ggx, 2, true),
            (Model::Ggx, 32, false),
            (Model::CookTorrance, 2, false),
            (Model::CookTorrance, 32, true),
        ] {
            for sharpest in [model.usual_sharpest(), model.most_sharpest()] {
                assert_taken(model, sharpest, bases, shared);
            }
        }
    }

    #[test]
    #[ignore = "takes minutes"]
    fn readers_find_the_errors_that_are_stored_for_any_number_of_bases() {
        for bases in 2..=32 {
            for (model, shared) in [
                (Model::BlinnPhong, true),
                (Model::BlinnPhong, false),
                (Model::Ggx, true),
                (Model::Ggx, false),
                (Model::CookTorrance, true),
                (Model::CookTorrance, false),
            ] {
                for sharpest in [model.usual_sharpest(), model.most_sharpest()] {
                    assert_taken(model, sharpest, bases, shared);
                }
            }
        }
    }

    /// Lobes sharper than usual cost bases. Ceilings a third above what was measured, for a mean and a worst lobe.
    #[test]
    fn sharper_lobes_take_more_bases() {
        for (model, sharpest, ceilings) in [
            (Model::BlinnPhong, 500.0, [(8, 0.0054, 0.0144), (10, 0.0012, 0.003), (16, 2e-5, 3e-5)]),
            (Model::BlinnPhong, 2000.0, [(8, 0.0145, 0.0385), (10, 0.0042, 0.011), (16, 1.1e-4, 2.2e-4)]),
            (Model::BlinnPhong, 5000.0, [(8, 0.0235, 0.062), (10, 0.0078, 0.021), (16, 2.8e-4, 6e-4)]),
            (Model::Ggx, 0.2, [(8, 0.063, 0.112), (10, 0.028, 0.044), (16, 0.0019, 0.0032)]),
            (Model::Ggx, 0.14, [(8, 0.093, 0.26), (10, 0.046, 0.082), (16, 0.0048, 0.0081)]),
            (Model::CookTorrance, 0.02, [(8, 0.181, 0.452), (10, 0.103, 0.231), (16, 0.0225, 0.0355)]),
        ] {
            let space = Space::new(model, sharpest, 16, true).unwrap();
            for (bases, mean, worst) in ceilings {
                let basis = space.basis(bases);
                let [error_at_samples, error_between] =
                    [basis.meta.error_at_samples, basis.meta.error_between];
                println!(
                    "{} {sharpest}, {bases} bases: {error_at_samples:?} {error_between:?}",
                    model.name()
                );
                for error in [error_at_samples, error_between] {
                    assert!(error.mean <= mean && error.worst <= worst, "{bases} bases: {error:?}");
                }
                assert_eq!(basis.sharpest(), sharpest);
                let usual = build(model, bases, true).unwrap().meta.error_between.mean;
                assert!(error_between.mean > usual, "{bases} bases: {error_between:?}");
            }
        }
    }

    /// Charts cut bundles of fewer bases out of one bake.
    #[test]
    fn a_smaller_basis_is_the_beginning_of_a_larger_one_bit_for_bit() {
        for (model, shared) in [(Model::BlinnPhong, true), (Model::Ggx, false), (Model::CookTorrance, true)] {
            let space = Space::new(model, model.usual_sharpest(), 16, shared).unwrap();
            for bases in [2, 6] {
                assert_eq!(space.basis(bases), build(model, bases, shared).unwrap(), "{}", model.name());
            }
        }
    }

    /// Whatever is of another size or sign than what it belongs to is refused.
    #[test]
    fn tables_that_do_not_make_the_lobes_are_refused() {
        for model in [Model::BlinnPhong, Model::Ggx, Model::CookTorrance] {
            let sound = build(model, 6, true).unwrap();
            let changes: [&dyn Fn(&mut f32); 4] =
                [&|v| *v *= 1000.0, &|v| *v *= 10.0, &|v| *v = -*v, &|v| *v = 0.0];
            for change in changes {
                let (mut scaled, mut other) = (sound.clone(), sound.clone());
                scaled.coefficients.iter_mut().for_each(change);
                match &mut other.functions {
                    Functions::BlinnPhong { lobes } => lobes.iter_mut().for_each(change),
                    Functions::Microfacet { weights, .. } => weights.iter_mut().for_each(change),
                }
                let mut row = sound.clone();
                let width = row.bases();
                // A single node in the middle, its largest coefficients among them.
                row.coefficients.chunks_exact_mut(width).skip(200).take(2).flatten().for_each(change);
                let mut reordered = sound.clone();
                reordered.coefficients.reverse();
                for (what, basis) in
                    [("coefficients", scaled), ("functions", other), ("node", row), ("order", reordered)]
                {
                    let message = basis.to_bytes(Place::file("basis")).unwrap_err().to_string();
                    assert!(
                        message.contains("section `coefficients`") && message.contains("the model's lobes"),
                        "{what}: {message}"
                    );
                }
            }
        }
    }
}
