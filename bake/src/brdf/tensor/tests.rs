//! Mirror terms against mixtures that are known, tensors against the lobes that they stand for.

use super::*;
use crate::brdf::blinn_phong::glossy_albedo;
use glam::DVec3;
use relume_formats::Place;
use relume_formats::container::Stored as _;
use relume_formats::state::{BlinnPhong, Brdf};
use std::f64::consts::PI;

/// A few exponents of the space.
fn few() -> Samples {
    Samples::Line(vec![1.0, 4.0, 15.0, 50.0, 120.0, 200.0])
}

fn none() -> Separation {
    Separation { widths_deg: Vec::new(), fit: least_squares }
}

/// The source's mirror terms.
fn source() -> Separation {
    Separation { widths_deg: SOURCE_WIDTHS_DEG.to_vec(), fit: least_squares }
}

#[test]
fn points_cover_half_of_all_directions() {
    let points = Points::new();
    assert!((points.solid_angle.iter().sum::<f64>() - 2.0 * PI).abs() < 1e-12);
    // Of unit radiance through every cell arrives its area, and over it that is 1.
    let ones: Vec<f64> = points.over_cells(&points.area);
    assert!(ones.iter().all(|mean| (mean - 1.0).abs() < 1e-12));
    assert_eq!(ones.len(), RINGS * HALF);
}

/// A mixture of the very shapes that fits are made of is found again: normal equations of a condition of
/// about 10⁴ at worst, descended until a share moves by less than 10⁻⁶.
#[test]
fn a_mixture_of_the_shapes_is_found_again() {
    let points = Points::new();
    let separator = Separator::new(&points, &source());
    for ring in [0, 5, RINGS - 1] {
        let mixture = separator.mixture(ring, &[0.0, 0.4, 0.0, 0.3, 0.0, 0.0, 0.0, 0.2]);
        let (found, left) = separator.split(ring, &mixture);
        for (found, share) in found.iter().zip([0.0, 0.4, 0.0, 0.3]) {
            assert!((found - share).abs() < 1e-6, "ring {ring}: {found} for {share}");
        }
        let cosine = separator.mixture(ring, &[0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.2]);
        let off: f64 = left.iter().zip(&cosine).map(|(left, cosine)| (left - cosine).abs()).sum();
        assert!(off < 4.0 * 1e-6, "ring {ring}: {off}");
    }
}

/// Mirror terms and the rest are the lobe, whatever they are, and rests of lobes are smaller.
#[test]
fn parts_of_a_lobe_add_up_to_it() {
    let points = Points::new();
    let [plain, separator] = [none(), source()].map(|separation| Separator::new(&points, &separation));
    for sample in 0..few().count() {
        let lobe = lobe_of(Model::BlinnPhong, &few(), sample);
        let [whole, split] =
            [&plain, &separator].map(|by| Lobe::new(Model::BlinnPhong, &few(), sample, &points, by));
        assert!(whole.mirror.is_empty());
        assert!((whole.norm - split.norm).abs() < 1e-12 * whole.norm);
        for (ring, shares) in split.mirror.chunks_exact(SOURCE_WIDTHS_DEG.len()).enumerate() {
            let terms: Vec<f64> = shares.iter().map(|share| f64::from(*share)).collect();
            let mirror = points.over_cells(&separator.mixture(ring, &terms));
            let row = ring * RINGS * HALF..(ring + 1) * RINGS * HALF;
            for ((rest, mirror), whole) in split.rest[row.clone()].iter().zip(mirror).zip(&whole.rest[row]) {
                assert!((rest + mirror - whole).abs() < 1e-9 * whole.abs().max(1.0), "{lobe:?}");
            }
        }
        // What is as broad as the background has no mirror's part.
        let sharp = sample > 2;
        assert!(!sharp || split.rest_norm_squared() < whole.rest_norm_squared(), "sample {sample}");
    }
}

/// Materials between samples are mixtures of them, so shares must not jump from one to the next.
#[test]
fn shares_change_little_from_exponent_to_exponent() {
    let points = Points::new();
    let separation = Separation::default();
    let terms = separation.widths_deg.len();
    let separator = Separator::new(&points, &separation);
    let shares = |s: f32| {
        let samples = Samples::Line(vec![1.0, s]);
        Lobe::new(Model::BlinnPhong, &samples, 1, &points, &separator).mirror
    };
    for s in [10.0f32, 60.0, 150.0] {
        let three = [s, s + 1.0, s + 2.0].map(shares);
        for (ring, term) in (0..RINGS).flat_map(|ring| (0..terms).map(move |term| (ring, term))) {
            let [a, b, c] = [0, 1, 2].map(|at: usize| three[at][ring * terms + term]);
            // Lobes of the next width have 2.2 times the exponent or more (21° and 14° are s = 30 and 67), so
            // a share, which is at most 4, goes over while s grows by more than half of itself. It has a kink
            // where another one leaves 0, and differs by half the bend from the mean of its neighbours: by a
            // hundredth of 4 at most.
            assert!((b - a).abs() < 8.0 / s && (a - 2.0 * b + c).abs() < 0.08, "{s}: {a}, {b}, {c}");
        }
    }
}

/// What is stored, read at nodes, against the lobes over cells: the error of the file is the one that it
/// states.
#[test]
fn the_error_that_is_stored_is_that_of_what_is_stored() {
    let space = SpaceTensor::new(Model::BlinnPhong, few(), &Separation::default());
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

/// Numbers in 0..1, about as independent as a hash can make them.
fn random(seed: &mut u64) -> f64 {
    *seed = seed.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let hash = (*seed ^ (*seed >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    ((hash ^ (hash >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb) >> 11) as f64 / (1u64 << 53) as f64
}

/// Mean of `value` over a cell by area, from one random point in each of 8 × 8 parts of it.
fn mean_over_cell(cell: usize, seed: &mut u64, value: impl Fn(DVec3) -> f64) -> f64 {
    const PARTS: usize = 8;
    let squared = |ring: usize| (ring as f64 / RINGS as f64).powi(2);
    let (inner, outer) = (squared(cell / AZIMUTHS), squared(cell / AZIMUTHS + 1));
    let mut sum = 0.0;
    for part in 0..PARTS * PARTS {
        let across = ((part / PARTS) as f64 + random(seed)) / PARTS as f64;
        let along = ((part % PARTS) as f64 + random(seed)) / PARTS as f64 - 0.5;
        let (radius, step) = ((inner + (outer - inner) * across).sqrt(), 2.0 * PI / AZIMUTHS as f64);
        let angle = disc::angle(cell % AZIMUTHS) + along * step;
        sum += value(DVec3::new(radius * angle.cos(), radius * angle.sin(), (1.0 - radius * radius).sqrt()));
    }
    sum / (PARTS * PARTS) as f64
}

/// The whole of what is stored, diffuse, rest and mirror terms, is the BRDF with an error as it is stored. Of
/// each cell the mean of BRDF less what is stored is estimated twice from random points; the product of both
/// is right in the mean, noise or not. Outgoing directions are of a random azimuth in each ring.
#[test]
fn what_is_stored_is_the_brdf_but_for_the_stored_error() {
    let space = SpaceTensor::new(Model::BlinnPhong, few(), &source());
    let (tensor, _) = space.decomposed([3, 8, 8]).unwrap();
    let gaussians = SOURCE_WIDTHS_DEG.map(|deg| separation::Gaussian::of_width(f64::from(deg)));
    let (kd, ks) = (0.3f32, 0.6f32);
    let (mut seed, mut errors) = (1, 0.0);
    for sample in 0..few().count() {
        let Brdf::BlinnPhong(lobe) = lobe_of(Model::BlinnPhong, &few(), sample) else { panic!() };
        let material = Brdf::BlinnPhong(BlinnPhong { kd: [kd; 3], ks: [ks; 3], ..lobe });
        let mixture = tensor.mixture(&material, 0).unwrap();
        let core = tensor.core_of(&mixture);
        let mut lost = 0.0;
        for ring in 0..RINGS {
            let out = disc::direction(ring * AZIMUTHS + (random(&mut seed) * AZIMUTHS as f64) as usize);
            let shares = tensor.shares(&mixture, out);
            for from in 0..CELLS {
                let diffuse = f64::from(kd * tensor.incoming[from * 9]);
                let rest = f64::from(ks) * f64::from(tensor.residual(&core, out, disc::direction(from)));
                let off = |incoming: DVec3| {
                    let angles = crate::brdf::angles(incoming.as_vec3a(), out.as_vec3a(), glam::Vec3A::Z);
                    let term = |(share, gaussian): (&f32, &separation::Gaussian)| {
                        f64::from(ks * share) * gaussian.about_mirror(out, incoming) / incoming.z
                    };
                    let mirror: f64 = shares.iter().zip(&gaussians).map(term).sum();
                    let brdf = f64::from(crate::brdf::evaluate(&material, glam::Vec3A::ONE, &angles).x);
                    brdf - (diffuse + rest + mirror)
                };
                let [a, b] = [(); 2].map(|()| mean_over_cell(from, &mut seed, off));
                lost += AZIMUTHS as f64 * disc::weight(ring) * disc::weight(from / AZIMUTHS) * a * b;
            }
        }
        errors += lost / (f64::from(ks) * space.norms[sample]).powi(2);
    }
    let error = errors / few().count() as f64;
    // Azimuths are not quite alike, where the columns' rank cuts a pair in two, and points are few.
    assert!((error / tensor.meta.whole - 1.0).abs() < 0.05, "{error}, and {} is stored", tensor.meta.whole);
}

/// Seen from straight above, under a white sky, a lobe reflects what the closed form says, and what is stored
/// the same but for its error: of the cells around the normal the L2 norm over incoming directions, times √π,
/// that of what a white sky sends.
#[test]
fn a_white_sky_shows_the_albedo() {
    let space = SpaceTensor::new(Model::BlinnPhong, few(), &Separation::default());
    let (tensor, _) = space.decomposed([5, 24, 24]).unwrap();
    let comparison = Comparison::new(&tensor);
    for sample in 0..few().count() {
        let lobe = lobe_of(Model::BlinnPhong, &few(), sample);
        let Brdf::BlinnPhong(BlinnPhong { shininess, .. }) = lobe else { panic!() };
        let [analytic, stored] = comparison.albedos(&lobe, 0.0).unwrap();
        let expected = f64::from(glossy_albedo(shininess));
        // Points are 0.4° apart there: midpoints, of lobes of 8° and more.
        assert!((analytic / expected - 1.0).abs() < 1e-3, "s {shininess}: {analytic} for {expected}");
        let core = tensor.core_of(&[(sample, 1.0)]);
        let lost = |out: usize| -> f64 {
            let of_cell = |from: usize| {
                let weight = disc::weight(from / AZIMUTHS);
                let exact = space.rests[[sample, out, from]] * space.norms[sample]
                    / (disc::weight(0) * weight).sqrt();
                let stored = f64::from(tensor.residual(&core, disc::direction(out), disc::direction(from)));
                weight * (stored - exact).powi(2)
            };
            (0..CELLS).map(of_cell).sum()
        };
        let error = (0..AZIMUTHS).map(lost).fold(0.0, f64::max).sqrt() * PI.sqrt();
        // The nodes are 2.4° off the normal, 0.042 radians, of which albedos, even in the angle, have the
        // square; and as much again for the innermost ring, of which bilinear weights have a twelfth too
        // much.
        let bound = error + 0.005 * expected;
        assert!((stored - expected).abs() < bound, "s {shininess}: {stored} for {expected}, bound {bound}");
    }
    assert!(comparison.albedos(&lobe_of(Model::Ggx, &samples_of(Model::Ggx), 0), 0.0).is_none());
}

/// The L2 norm with both cosines of what arrives from points by outgoing radius, summed as a comparison does.
fn norm(points: &Points, arriving: impl Fn(f64) -> Vec<f64>) -> f64 {
    let parts = 2 * RINGS;
    let squares = (0..parts).map(|at| {
        let values = arriving((at as f64 + 0.5) / parts as f64);
        let sum: f64 = values.iter().zip(&points.area).map(|(value, area)| value * value / area).sum();
        PI * (2 * at + 1) as f64 / (parts * parts) as f64 * sum
    });
    squares.sum::<f64>().sqrt()
}

/// Between directions of cells the error is that which is stored and at most twice what lobes vary within
/// cells, once for constants, once for what is linear instead. Between samples it is the mean of the
/// neighbours', for what is stored is their mixture, and what the lobe differs from the mixture of theirs.
#[test]
fn between_directions_and_samples_errors_add_up() {
    let exponents = [1.0f32, 2.0, 3.0, 4.0, 50.0, 51.0, 200.0];
    let space =
        SpaceTensor::new(Model::BlinnPhong, Samples::Line(exponents.to_vec()), &Separation::default());
    let (tensor, _) = space.decomposed([3, 8, 8]).unwrap();
    let (points, comparison) = (Points::new(), Comparison::new(&tensor));
    let lobe = |shininess: f32| Brdf::BlinnPhong(BlinnPhong { kd: [0.0; 3], ks: [1.0; 3], shininess });
    let seen_from = |radius: f64| DVec3::new(radius, 0.0, (1.0 - radius * radius).sqrt());
    let arriving = |s: f32, radius: f64| points.arriving(&lobe(s), seen_from(radius));
    let difference = |a: &[f64], b: &[f64]| -> Vec<f64> { a.iter().zip(b).map(|(a, b)| a - b).collect() };
    let whole = |s: f32| norm(&points, |radius| arriving(s, radius));
    let error = |s: f32| comparison.error(&lobe(s)).unwrap() * whole(s);
    let stored = space.errors_of(&tensor);
    for (sample, s) in exponents.into_iter().enumerate() {
        let varies = norm(&points, |radius| {
            let ring = (radius * RINGS as f64) as usize;
            let means = points.over_cells(&arriving(s, disc::radius(ring)));
            difference(&arriving(s, radius), &points.spread(&means))
        });
        let bound = stored[sample][1] * space.norms[sample] + 2.0 * varies;
        assert!(error(s) < bound, "s {s}: {}, bound {bound}", error(s));
    }
    for [s, t] in [[1.0, 2.0], [2.0, 3.0], [3.0, 4.0], [50.0, 51.0]] {
        let middle = 0.5 * (s + t);
        let bent = norm(&points, |radius| {
            let (a, b) = (arriving(s, radius), arriving(t, radius));
            let mean: Vec<f64> = a.iter().zip(&b).map(|(a, b)| 0.5 * (a + b)).collect();
            difference(&arriving(middle, radius), &mean)
        });
        let bound = 0.5 * (error(s) + error(t)) + bent;
        // Single precision.
        assert!(error(middle) < bound * (1.0 + 1e-4), "s {middle}: {}, bound {bound}", error(middle));
    }
}

#[test]
fn more_columns_err_less_and_mirror_terms_help() {
    let plain = SpaceTensor::new(Model::BlinnPhong, few(), &none());
    let split = SpaceTensor::new(Model::BlinnPhong, few(), &Separation::default());
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
            SpaceTensor::new(Model::BlinnPhong, samples, &Separation::default()).decomposed([2, 4, 4])
        })
    };
    assert_eq!(on(1).unwrap().0, on(2).unwrap().0);
}
