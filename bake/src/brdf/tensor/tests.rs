//! Tensors against the lobes that they stand for.

use super::*;
use crate::brdf::blinn_phong::glossy_albedo;
use relume_formats::Place;
use relume_formats::container::Stored as _;
use relume_formats::state::{BlinnPhong, CookTorrance, Ggx};

/// A few exponents of the space.
fn few() -> Samples {
    Samples::Line(vec![1.0, 4.0, 15.0, 50.0, 120.0, 200.0])
}

fn small() -> Size {
    Size { columns: 5, ranks: [4, 6], ..Size::default() }
}

fn phong(shininess: f32) -> Brdf {
    Brdf::BlinnPhong(BlinnPhong { kd: [0.0; 3], ks: [1.0; 3], shininess })
}

fn lobes_of(model: Model) -> Vec<Brdf> {
    let pairs =
        |values: [f32; 3]| [0.04, 0.3, 1.0].into_iter().flat_map(move |f0| values.map(|rough| (f0, rough)));
    match model {
        Model::BlinnPhong => [1.0, 7.0, 60.0, 200.0].map(phong).to_vec(),
        Model::Ggx => pairs([0.32, 0.5, 1.0])
            .map(|(f0, roughness)| Brdf::Ggx(Ggx { base_color: [f0; 3], metallic: 1.0, roughness }))
            .collect(),
        Model::CookTorrance => pairs([0.1, 0.25, 1.0])
            .map(|(fresnel, roughness)| {
                Brdf::CookTorrance(CookTorrance { kd: [0.0; 3], ks: [1.0; 3], fresnel, roughness })
            })
            .collect(),
    }
}

/// A cone that is all above the surface has an integral of 1, one about a direction in the surface of ½, and
/// the rest of it is not there.
#[test]
fn cones_have_the_integral_of_what_is_above_the_surface() {
    let hemisphere = Hemisphere::new();
    let straight = cones::harmonics(&CONES, DVec3::Z, &hemisphere);
    for (cone, harmonics) in CONES.iter().zip(straight) {
        if cone.width_deg * 5.0 + cone.tilt_deg.abs() + cone.side_deg < 90.0 {
            // Five deviations hold all but e^(-12.5); the points of 3° cones are some 0.6° apart.
            assert!((hemisphere::integral(&harmonics) - 1.0).abs() < 1e-4, "{cone:?}");
        }
    }
    let level = cones::harmonics(&[CONES[0], CONES[8]], outgoing(PI / 2.0), &hemisphere);
    assert!(level.iter().all(|harmonics| (hemisphere::integral(harmonics) - 0.5).abs() < 1e-3));
}

/// What is stored, of nodes that it is read at, is off by the error that the file states, in the metric that
/// it states.
#[test]
fn the_error_that_is_stored_is_that_of_what_is_stored() {
    let space = SpaceTensor::new(Model::BlinnPhong, few());
    let tensor = space.decomposed(&small()).unwrap();
    tensor.to_bytes(Place::file("tensor")).unwrap();
    let profiles: Vec<Vec<f64>> = (0..tensor.orders.len())
        .map(|k| {
            let value = |node: usize| f64::from(tensor.incoming[node * tensor.orders.len() + k]);
            profiles::harmonics(tensor.orders[k] as usize, value, &space.hemisphere)
        })
        .collect();
    let (mut left, mut off, weights) = (0.0, 0.0, node_weights());
    for sample in 0..few().count() {
        let [mut of_sample, mut whole, mut residual] = [0.0; 3];
        let (shares, along) = (tensor.shares_of(&[(sample, 1.0)]), tensor.weights_of(&[(sample, 1.0)]));
        for node in 0..NODES {
            let seen_from = outgoing(seen_from(node));
            let mut rest =
                lobe_harmonics(&lobe_of(Model::BlinnPhong, &few(), sample), seen_from, &space.hemisphere);
            whole += weights[node] * squared(rest.iter());
            let cones = cones::harmonics(&tensor.cones, seen_from, &space.hemisphere);
            for (share, cone) in shares[node * cones.len()..].iter().zip(&cones) {
                rest.iter_mut().zip(cone).for_each(|(rest, value)| *rest -= f64::from(*share) * value);
            }
            residual += weights[node] * squared(rest.iter());
            for (k, profile) in profiles.iter().enumerate() {
                let own = &mut rest[of_order(tensor.orders[k] as usize)];
                let weight = f64::from(along[node * profiles.len() + k]);
                own.iter_mut().zip(profile).for_each(|(rest, value)| *rest -= weight * value);
            }
            of_sample += weights[node] * squared(rest.iter());
        }
        left += residual / whole / few().count() as f64;
        off += of_sample / whole / few().count() as f64;
    }
    let Meta { residual, materials, outgoing, incoming, whole, .. } = tensor.meta;
    assert!((left / residual - 1.0).abs() < 1e-6, "{left}, and {residual} is stored");
    // Single precision, of values a hundred times what is left.
    assert!((off / whole - 1.0).abs() < 1e-3, "{off}, and {whole} is stored");
    assert!(materials.max(outgoing).max(incoming) <= residual && whole <= residual && residual < 0.5);
    assert!(tensor.columns() <= 1 + small().columns);
    // Cones that are fitted again take off what they can.
    assert!(whole < incoming + materials + outgoing, "{whole}, {:?}", tensor.meta);
}

/// Half angles integrate to the closed form, seen from straight above.
#[test]
fn tabulated_lobes_have_the_albedo_of_the_closed_form() {
    let hemisphere = Hemisphere::new();
    for shininess in [1.0, 5.0, 40.0, 200.0] {
        let found = hemisphere::integral(&lobe_harmonics(&phong(shininess), DVec3::Z, &hemisphere));
        let expected = f64::from(glossy_albedo(shininess));
        // Five points of Gauss's in 3° of lobes of 8° and more; lobes are in single precision.
        assert!((found / expected - 1.0).abs() < 1e-5, "{shininess}: {found} for {expected}");
    }
}

/// A white sky shows what it should, from straight above to 5° from the surface: to 2 % of the brightest that
/// the lobe is, and to 4 % beyond 80°, where sharp lobes are narrower across than any cone and their
/// brightness is traded for their shape.
#[test]
fn a_white_sky_shows_the_albedo() {
    let mut beyond = Vec::new();
    for model in [Model::BlinnPhong, Model::Ggx, Model::CookTorrance] {
        let tensor = make(model).unwrap();
        let comparison = Comparison::new(&tensor);
        for lobe in lobes_of(model) {
            let seen = |degrees: f64| comparison.albedos(&lobe, degrees.to_radians()).unwrap();
            let brightest = [0.0, 85.0].map(|degrees| seen(degrees)[0]).into_iter().fold(0.0, f64::max);
            for degrees in [0.0, 1.5, 20.0, 43.0, 60.0, 70.0, 80.0, 85.0] {
                let [brdf, stored] = seen(degrees);
                let off = (stored - brdf).abs() / brightest;
                println!(
                    "{lobe:?} at {degrees}°: {stored:.4} for {brdf:.4}, off by {off:.4} of {brightest:.4}"
                );
                if off > if degrees > 80.0 { 0.04 } else { 0.02 } {
                    beyond.push(format!("{lobe:?} at {degrees}°: {stored} for {brdf}"));
                }
            }
        }
        let other = if model == Model::Ggx { phong(3.0) } else { lobes_of(Model::Ggx)[0] };
        assert!(comparison.error(&other).is_none());
    }
    assert!(beyond.is_empty(), "{beyond:#?}");
}

/// What lies between samples errs as they do: the mixture of neighbours differs little from the lobe.
#[test]
fn between_samples_errors_are_those_of_samples() {
    let tensor = make(Model::BlinnPhong).unwrap();
    let comparison = Comparison::new(&tensor);
    let Samples::Line(exponents) = &tensor.samples else { panic!() };
    for pair in exponents.windows(2).step_by(6) {
        let [before, between, after] =
            [pair[0], 0.5 * (pair[0] + pair[1]), pair[1]].map(|s| comparison.error(&phong(s)).unwrap());
        // Widths differ by 6 %, and the middle of two lobes is off the lobe by an eighth of the bend: 1e-3
        // or so.
        assert!(between < before.max(after) + 2e-3, "{pair:?}: {before}, {between}, {after}");
    }
}

#[test]
fn more_columns_and_tilted_cones_err_less() {
    let space = SpaceTensor::new(Model::BlinnPhong, few());
    let [none, source, ours] = [&[][..], &SOURCE_CONES, &CONES].map(|cones| space.errors(cones, 8).unwrap());
    assert!((none[0] - 1.0).abs() < 1e-9, "{none:?}");
    for columns in 0..=8 {
        assert!(ours[columns] < source[columns] && source[columns] < none[columns], "{columns} columns");
    }
    for errors in [none, source, ours] {
        assert!(errors.windows(2).all(|pair| pair[1] <= pair[0]), "{errors:?}");
    }
    let ranks = |ranks| space.decomposed(&Size { ranks, ..small() }).unwrap().meta.whole;
    assert!(ranks([2, 3]) > ranks([4, 6]));
}

/// GGX's diffuse lobe, seen from straight above, is (1 − (1 − cos θ/2)⁵)/π: by the midpoint rule over θ.
#[test]
fn what_a_diffuse_surface_reflects_is_its_integral() {
    let hemisphere = Hemisphere::new();
    assert_eq!(even(Model::CookTorrance, &hemisphere), vec![1.0; NODES]);
    let even = even(Model::Ggx, &hemisphere);
    let steps = 10_000;
    let at = |step: usize| {
        let theta = PI / 2.0 * (step as f64 + 0.5) / f64::from(steps);
        2.0 * theta.sin() * theta.cos() * (1.0 - (1.0 - (0.5 * theta).cos()).powi(5))
    };
    let expected: f64 = (0..steps as usize).map(at).sum::<f64>() * PI / 2.0 / f64::from(steps);
    assert!((f64::from(even[0]) - expected).abs() < 1e-5, "{} for {expected}", even[0]);
    assert!(even.is_sorted_by(|a, b| a >= b) && even[NODES - 1] > 0.7, "{even:?}");
}

/// Schlick's reflectance is linear in what is reflected at normal incidence, so between samples of one slope
/// lobes are their mixtures.
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
        let incoming = DVec3::new(-0.5, 0.1, 0.8).normalize().as_vec3a();
        let angles = brdf::angles(incoming, DVec3::new(0.6, 0.0, 0.8).as_vec3a(), Vec3A::Z);
        let value = |sample| brdf::evaluate(&lobe_of(model, &samples, sample), Vec3A::ONE, &angles).x;
        // The second row has reflectances of 0, ½ and 1.
        let [none, half, full] = [4, 5, 6].map(value);
        assert!((0.5 * (none + full) - half).abs() < 1e-5 * full, "{none} {half} {full}");
    }
}

#[test]
fn threads_do_not_change_a_bit() {
    let on = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| SpaceTensor::new(Model::BlinnPhong, few()).decomposed(&small()))
    };
    assert_eq!(on(1).unwrap(), on(2).unwrap());
}
