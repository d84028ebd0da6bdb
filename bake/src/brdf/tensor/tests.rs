//! Mirror terms against mixtures that are known, tensors against the lobes that they stand for.

use super::*;
use crate::brdf::blinn_phong::glossy_albedo;
use glam::DVec3;
use relume_formats::Place;
use relume_formats::container::Stored as _;
use std::f64::consts::PI;

/// A few exponents of the space.
fn few() -> Samples {
    Samples::Line(vec![1.0, 4.0, 15.0, 50.0, 120.0, 200.0])
}

const NONE: Separation = Separation { terms: 0, fit: Fit::Expectation };

#[test]
fn points_cover_half_of_all_directions() {
    let points = Points::new();
    assert!((points.solid_angle.iter().sum::<f64>() - 2.0 * PI).abs() < 1e-12);
    // Of unit radiance through every cell arrives its area, and over it that is 1.
    let ones: Vec<f64> = points.over_cells(&points.area);
    assert!(ones.iter().all(|mean| (mean - 1.0).abs() < 1e-12));
    assert_eq!(ones.len(), RINGS * HALF);
}

/// A mixture of the very shapes that fits are made of is found again, by least squares to rounding, by expectation
/// maximisation as far as so many rounds go: Gaussians overlap, and what the one lacks its neighbours have, up to a
/// tenth of what is reflected.
#[test]
fn a_mixture_of_the_shapes_is_found_again() {
    let points = Points::new();
    let shares = [0.0, 0.4, 0.0, 0.3];
    for (fit, bound) in [(Fit::LeastSquares, 1e-6), (Fit::Expectation, 0.1)] {
        let separator = Separator::new(&points, Separation { terms: TERMS, fit });
        for ring in [0, 5, RINGS - 1] {
            let mixture = separator.mixture(ring, &[0.0, 0.4, 0.0, 0.3, 0.0, 0.0, 0.0, 0.2]);
            let (found, left) = separator.split(ring, &mixture);
            for (found, share) in found.iter().zip(shares) {
                assert!((found - share).abs() < bound, "{fit:?}, ring {ring}: {found} for {share}");
            }
            let rest: f64 = left(&found.map(|share| share as f32)).iter().sum();
            let cosine = separator.mixture(ring, &[0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.2]);
            assert!((rest - cosine.iter().sum::<f64>()).abs() < 2.0 * bound);
        }
    }
}

/// Mirror terms and the rest are the lobe, whatever they are, and rests of lobes are smaller.
#[test]
fn parts_of_a_lobe_add_up_to_it() {
    let points = Points::new();
    let plain = Separator::new(&points, NONE);
    for fit in [Fit::Expectation, Fit::LeastSquares] {
        let separator = Separator::new(&points, Separation { terms: TERMS, fit });
        for sample in 0..few().count() {
            let lobe = lobe_of(Model::BlinnPhong, &few(), sample);
            let [whole, split] =
                [&plain, &separator].map(|by| Lobe::new(Model::BlinnPhong, &few(), sample, &points, by));
            assert!(whole.mirror.as_flattened().iter().all(|share| *share == 0.0));
            assert!((whole.norm - split.norm).abs() < 1e-12 * whole.norm);
            for (ring, shares) in split.mirror.iter().enumerate() {
                let terms = shares.map(f64::from);
                let mirror = points.over_cells(&separator.mixture(ring, &terms));
                let row = ring * RINGS * HALF..(ring + 1) * RINGS * HALF;
                for ((rest, mirror), whole) in
                    split.rest[row.clone()].iter().zip(mirror).zip(&whole.rest[row])
                {
                    assert!((rest + mirror - whole).abs() < 1e-9 * whole.abs().max(1.0), "{lobe:?}");
                }
            }
            // What is as broad as the background has no mirror's part.
            let sharp = sample > 2;
            assert!(!sharp || split.rest_norm_squared() < whole.rest_norm_squared(), "sample {sample}");
        }
    }
}

/// Materials between samples are mixtures of them, so shares must not jump from one to the next.
#[test]
fn shares_change_little_from_exponent_to_exponent() {
    let points = Points::new();
    let separator = Separator::new(&points, Separation::default());
    let shares = |s: f32| {
        let samples = Samples::Line(vec![1.0, s]);
        Lobe::new(Model::BlinnPhong, &samples, 1, &points, &separator).mirror
    };
    for s in [10.0f32, 60.0, 150.0] {
        let three = [s, s + 1.0, s + 2.0].map(shares);
        for (ring, term) in (0..RINGS).flat_map(|ring| (0..TERMS).map(move |term| (ring, term))) {
            let [a, b, c] = [0, 1, 2].map(|at: usize| three[at][ring][term]);
            // The whole lobe changes by about 1/s of it, and a mixture errs by half the bend: a hundredth at most.
            assert!((b - a).abs() < 4.0 / s && (a - 2.0 * b + c).abs() < 0.02, "{s}: {a}, {b}, {c}");
        }
    }
}

/// What is stored, read at nodes, against the lobes over cells: the error of the file is the one that it states.
#[test]
fn the_error_that_is_stored_is_that_of_what_is_stored() {
    let space = SpaceTensor::new(Model::BlinnPhong, few(), Separation::default());
    let (tensor, _) = space.decomposed([3, 8, 8]).unwrap();
    tensor.to_bytes(Place::file("tensor")).unwrap();
    let errors = space.errors_of(&tensor);
    let mean = |of: usize| errors.iter().map(|errors| errors[of].powi(2)).sum::<f64>() / errors.len() as f64;
    // Single precision, of values that are subtracted.
    assert!((mean(0) / tensor.meta.residual - 1.0).abs() < 1e-9);
    assert!((mean(1) / tensor.meta.whole - 1.0).abs() < 1e-4, "{} and {}", mean(1), tensor.meta.whole);
    // Read as a player does, at nodes of one azimuth.
    let mut lost = 0.0;
    for out in (0..CELLS).step_by(AZIMUTHS) {
        let core = tensor.core_of(&[(3, 1.0)]);
        for from in 0..CELLS {
            let root = (disc::weight(out / AZIMUTHS) * disc::weight(from / AZIMUTHS)).sqrt();
            let value = f64::from(tensor.residual(&core, disc::direction(out), disc::direction(from)));
            lost += AZIMUTHS as f64 * (value * root / space.norms[3] - space.rests[[3, out, from]]).powi(2);
        }
    }
    // Azimuths are alike but for where the columns' rank cuts a pair in two.
    assert!((lost.sqrt() / errors[3][1] - 1.0).abs() < 0.1, "{} and {}", lost.sqrt(), errors[3][1]);
    let Meta { residual, materials, outgoing, incoming, whole, .. } = tensor.meta;
    assert!(materials.max(outgoing).max(incoming) <= whole && whole <= residual && residual < 0.5);
}

/// Under a white sky from above, mirror terms and what is left of rank reflect what the lobe does.
#[test]
fn a_white_sky_shows_the_albedo() {
    let space = SpaceTensor::new(Model::BlinnPhong, few(), Separation::default());
    let (tensor, _) = space.decomposed([5, 24, 24]).unwrap();
    let Samples::Line(exponents) = few() else { panic!() };
    for (sample, s) in exponents.into_iter().enumerate() {
        let (mixture, above) = ([(sample, 1.0)], disc::direction(0));
        let core = tensor.core_of(&mixture);
        let rest: f64 = (0..CELLS)
            .map(|cell| {
                let value = f64::from(tensor.residual(&core, above, disc::direction(cell)));
                value * disc::weight(cell / AZIMUTHS)
            })
            .sum();
        let albedo = rest + tensor.shares(&mixture, above).iter().map(|share| f64::from(*share)).sum::<f64>();
        let expected = f64::from(glossy_albedo(s));
        // Seen from 2.4° off the normal, and broad Gaussians reach below the surface.
        assert!((albedo / expected - 1.0).abs() < 0.05, "s {s}: {albedo} for {expected}");
    }
}

#[test]
fn more_columns_err_less_and_mirror_terms_help() {
    let plain = SpaceTensor::new(Model::BlinnPhong, few(), NONE);
    let split = SpaceTensor::new(Model::BlinnPhong, few(), Separation::default());
    assert!((plain.residual() - 1.0).abs() < 1e-9);
    let error = |space: &SpaceTensor, ranks| space.decomposed(ranks).unwrap().0.meta.whole;
    let mut last = [f64::INFINITY; 2];
    for n in [1, 4, 8, 16] {
        let errors = [&plain, &split].map(|space| error(space, [3, n, n]));
        assert!(errors[1] < errors[0] && errors[0] < last[0] && errors[1] < last[1], "{n}: {errors:?}");
        last = errors;
    }
}

/// Schlick's reflectance is linear in what is reflected at normal incidence, so between samples of one slope
/// nothing is lost; and a tensor has what is between as the mixture.
#[test]
fn planes_are_triangulated_and_linear_in_reflectance() {
    for model in [Model::Ggx, Model::CookTorrance] {
        let samples = samples_of(model);
        let Samples::Plane { points, triangles } = &samples else { panic!() };
        assert!(points.len() > 80 && triangles.len() > points.len());
        for sample in 0..points.len() {
            let mixture = samples.mixture(&lobe_of(model, &samples, sample), 0).unwrap();
            let own: f32 = mixture.iter().filter(|(at, _)| *at == sample).map(|(_, share)| share).sum();
            assert!(own > 0.999, "{model:?} {sample}: {mixture:?}");
        }
        let angles = crate::brdf::angles(
            DVec3::new(0.6, 0.0, 0.8).as_vec3a(),
            DVec3::new(-0.5, 0.1, 0.8).normalize().as_vec3a(),
            glam::Vec3A::Z,
        );
        let value =
            |sample| crate::brdf::evaluate(&lobe_of(model, &samples, sample), glam::Vec3A::ONE, &angles).x;
        // The second row has reflectances of 0, ½ and 1.
        let [none, half, full] = [4, 5, 6].map(value);
        assert!((0.5 * (none + full) - half).abs() < 1e-5 * full, "{none} {half} {full}");
    }
}

#[test]
fn threads_do_not_change_a_bit() {
    let on = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let samples = Samples::Line(vec![1.0, 30.0, 200.0]);
        pool.install(|| {
            SpaceTensor::new(Model::BlinnPhong, samples, Separation::default()).decomposed([2, 4, 4])
        })
    };
    assert_eq!(on(1).unwrap().0, on(2).unwrap().0);
}
