//! The terms of GGX and of Cook and Torrance against their published formulas in double precision, and the
//! energy they keep.

use relume_formats::basis::Angles;
use relume_formats::basis::microfacet::{self, Facets};
use std::f64::consts::{FRAC_PI_2, PI};

type Vec3 = [f64; 3];

fn dot(a: Vec3, b: Vec3) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}

fn direction(theta: f64, phi: f64) -> Vec3 {
    [theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos()]
}

/// The angles of two directions about the normal +Z.
fn angles(a: Vec3, b: Vec3) -> Angles {
    let sum = [0, 1, 2].map(|k| a[k] + b[k]);
    let length = dot(sum, sum).sqrt();
    let [cos_half, cos_difference, cos_in, cos_out] =
        [sum[2] / length, dot(sum, a) / length, a[2], b[2]].map(|c| c as f32);
    Angles { cos_half, cos_difference, cos_in, cos_out }
}

/// D in the form of glTF 2.0, appendix B.3.2.
fn distribution(alpha_squared: f64, cos_half: f64) -> f64 {
    let f = cos_half * cos_half * (alpha_squared - 1.0) + 1.0;
    alpha_squared / (PI * f * f)
}

/// V = G/(4 |N·L| |N·V|) of the same appendix, with the height-correlated masking and shadowing of Heitz
/// (2014), eq. 72 and 99, in his own form.
fn visibility(alpha_squared: f64, cos_in: f64, cos_out: f64) -> f64 {
    let lambda = |c: f64| 0.5 * ((1.0 + alpha_squared * (1.0 - c * c) / (c * c)).sqrt() - 1.0);
    1.0 / ((1.0 + lambda(cos_in) + lambda(cos_out)) * 4.0 * cos_in * cos_out)
}

/// Beckmann's distribution, normalised so that all facets together cover the surface once (Walter et al. 2007,
/// eq. 25).
fn beckmann(slope: f64, cos_half: f64) -> f64 {
    let cos_squared = cos_half * cos_half;
    let exponent = -(1.0 - cos_squared) / (cos_squared * slope * slope);
    exponent.exp() / (PI * slope * slope * cos_squared * cos_squared)
}

/// G/(4 |N·L| |N·V|) of grooves (Cook and Torrance 1981), with v·h as it is.
fn grooves(angles: &Angles) -> f64 {
    let [h, d, i, o] = [angles.cos_half, angles.cos_difference, angles.cos_in, angles.cos_out].map(f64::from);
    (2.0 * h * o / d).min(2.0 * h * i / d).min(1.0) / (4.0 * i * o)
}

/// Angles of incidence, degrees.
const THETAS_DEG: [f64; 12] = [0.0, 1.0, 10.0, 25.0, 45.0, 60.0, 75.0, 85.0, 89.0, 89.9, 89.99, 89.9999];

const ROUGHNESSES: [f64; 6] = [0.12, 0.32, 0.4, 0.5, 0.75, 1.0];

#[test]
fn distribution_and_visibility_are_those_of_the_formulas() {
    let thetas = THETAS_DEG.map(f64::to_radians);
    for roughness in ROUGHNESSES {
        let alpha_squared = roughness.powi(4) as f32;
        for (&theta_in, &theta_out) in thetas.iter().flat_map(|a| thetas.iter().map(move |b| (a, b))) {
            for step in 0..=36 {
                let angles =
                    angles(direction(theta_in, 0.0), direction(theta_out, PI * f64::from(step) / 36.0));
                let [a2, h, i, o] =
                    [alpha_squared, angles.cos_half, angles.cos_in, angles.cos_out].map(f64::from);
                let expected = distribution(a2, h) * visibility(a2, i, o);
                let value = f64::from(microfacet::distribution_visibility(alpha_squared, &angles));
                // With u = 2⁻²⁴: rounding (n·h)² to u moves 1 − (1 − α²)(n·h)² by u, which counts twice for D
                // has its square below; everything else adds and multiplies positive numbers, some twenty
                // times.
                let spread = 1.0 - (1.0 - a2) * h * h;
                let bound = (2.0 / spread + 20.0) * 2f64.powi(-24);
                let error = (value - expected).abs() / expected;
                assert!(
                    error < bound,
                    "roughness {roughness}, {angles:?}: {value} is not {expected}: {error:e} exceeds {bound:e}"
                );
            }
        }
    }
}

#[test]
fn grooves_are_those_of_the_formulas() {
    let thetas = THETAS_DEG.map(f64::to_radians);
    for slope in [0.015f32, 0.1, 0.3, 0.6, 1.0] {
        for (&theta_in, &theta_out) in thetas.iter().flat_map(|a| thetas.iter().map(move |b| (a, b))) {
            for step in 0..=36 {
                let angles =
                    angles(direction(theta_in, 0.0), direction(theta_out, PI * f64::from(step) / 36.0));
                let [m, h] = [slope, angles.cos_half].map(f64::from);
                let expected = beckmann(m, h) * grooves(&angles);
                let value = f64::from(microfacet::beckmann_grooves(slope, &angles));
                let turned = Angles { cos_in: angles.cos_out, cos_out: angles.cos_in, ..angles };
                assert_eq!(value, f64::from(microfacet::beckmann_grooves(slope, &turned)), "reciprocal");
                // With u = 2⁻²⁴: (n·h)² is rounded by u/2, which tan² has as u/2 over (n·h)² twice, once for
                // its numerator, and the exponent over m² besides; the rest multiplies some thirty times, and
                // the exponential turns the exponent's relative error into an absolute one. Where it is
                // beyond 87 all is dark.
                let exponent = (1.0 - h * h) / (h * h * m * m);
                let bound = (2.0 / (h * h * m * m) + 4.0 * exponent + 40.0) * 2f64.powi(-24);
                let error = (value - expected).abs();
                assert!(
                    error < bound * expected + 1e-24,
                    "slope {slope}, {angles:?}: {value} is not {expected}: {error:e} exceeds {bound:e} of it"
                );
            }
        }
    }
}

/// Where a direction lies in the surface the lobe goes on to its limit, and is 0 where both do, where there is
/// no half vector, and where one of that sort is no number.
#[test]
fn the_horizon_of_grooves_is_the_limit_of_what_is_above_it() {
    let at = |cos_half, cos_in, cos_out| {
        let angles = Angles { cos_half, cos_difference: 0.7, cos_in, cos_out };
        microfacet::beckmann_grooves(0.5, &angles)
    };
    // n·h = (i + o)/(2 v·h): G/(4 i o) is (n·h)²/((i + o) o) at the horizon.
    let limit = beckmann(0.5, f64::from(0.6f32)) * 0.36 / 0.25;
    for value in [at(0.6, 0.0, 0.5), at(0.6, 0.5, 0.0)] {
        assert!((f64::from(value) - limit).abs() < 1e-6 * limit, "{value} is not {limit}");
    }
    assert!([at(0.6, 0.0, 0.0), at(0.0, 0.5, 0.5), at(0.0, 0.0, 0.0)].iter().all(|value| *value == 0.0));
    for tiny in [1e-7f32, 1e-20, 1e-38, f32::MIN_POSITIVE] {
        for value in [at(tiny, 0.5, 0.5), at(1.0, tiny, tiny), at(1.0, tiny, 1.0), at(tiny, tiny, tiny)] {
            assert!(value.is_finite() && value >= 0.0, "{value} at {tiny}");
        }
    }
}

/// At the horizon the formulas are 0/0; the function goes on to their limit, and is 0 where there is none.
#[test]
fn the_horizon_is_the_limit_of_what_is_above_it() {
    let at = |cos_in, cos_out| {
        microfacet::distribution_visibility(
            0.25,
            &Angles { cos_half: 0.6, cos_difference: 0.7, cos_in, cos_out },
        )
    };
    let limit = distribution(0.25, f64::from(0.6f32)) * visibility(0.25, 1e-9, 0.5);
    for value in [at(0.0, 0.5), at(0.5, 0.0)] {
        assert!((f64::from(value) - limit).abs() < 1e-6 * limit, "{value} is not {limit}");
    }
    assert_eq!(at(0.0, 0.0), 0.0);
}

/// The weight is 1 at grazing, 0 at normal incidence, and falls with the fifth power.
#[test]
fn schlick_is_a_fifth_power() {
    for step in 0..=100 {
        let cosine = step as f32 / 100.0;
        let expected = (1.0 - f64::from(cosine)).powi(5);
        assert!((f64::from(microfacet::schlick(cosine)) - expected).abs() < 1e-6, "at {cosine}");
    }
}

/// What of the light from one direction a mirror-like surface of f₀ = 1 sends anywhere: ∫ D·V·cos over the
/// hemisphere, by the midpoint rule.
fn albedo(facets: Facets, roughness: f64, theta_in: f64) -> f64 {
    const STEPS: u32 = 600;
    let from = direction(theta_in, 0.0);
    let at = |i: u32, of: f64| (f64::from(i) + 0.5) / f64::from(STEPS) * of;
    let ring = |theta: f64| -> f64 {
        let values = (0..STEPS)
            .map(|p| f64::from(facets.lobe(roughness as f32, &angles(from, direction(theta, at(p, PI))))));
        values.sum::<f64>() * theta.sin() * theta.cos()
    };
    // Twice, for the other half of the azimuths mirrors this one.
    2.0 * (0..STEPS).map(|t| ring(at(t, FRAC_PI_2))).sum::<f64>() * FRAC_PI_2 * PI / f64::from(STEPS * STEPS)
}

/// A single bounce off microfacets loses what would bounce again, and never gains. The steps resolve the
/// sharpest lobe, about α/2 = 0.05 wide, twenty times over, so the midpoint rule errs by far less than 1e-3.
#[test]
fn no_furnace_is_brighter_than_its_walls() {
    let ggx = [0.32, 0.5, 0.75, 1.0].map(|roughness| (Facets::Ggx, roughness));
    let grooves = [0.1, 0.25, 0.5, 1.0].map(|slope| (Facets::CookTorrance, slope));
    for (facets, roughness) in ggx.into_iter().chain(grooves) {
        for theta_deg in [0.0f64, 30.0, 60.0, 80.0, 88.0] {
            let albedo = albedo(facets, roughness, theta_deg.to_radians());
            assert!(albedo <= 1.0 + 1e-3, "{facets:?} {roughness} at {theta_deg}°: {albedo}");
        }
    }
    let normal = albedo(Facets::Ggx, 0.32, 0.0);
    assert!((0.98..=1.0).contains(&normal), "{normal}");
}

/// At roughness 1, D = 1/π and V = 1/(2 (i + o)), whose integral over all o is 1 − i·ln(1 + 1/i): 1 − ln 2 at
/// normal incidence. The integrand is smooth, so the midpoint rule is good to the square of its step, 7e-6.
#[test]
fn the_roughest_furnace_has_a_closed_form() {
    for theta_deg in [0.0f64, 30.0, 60.0, 80.0] {
        let cosine = theta_deg.to_radians().cos();
        let (value, expected) =
            (albedo(Facets::Ggx, 1.0, theta_deg.to_radians()), 1.0 - cosine * (1.0 + 1.0 / cosine).ln());
        assert!((value - expected).abs() < 2e-5, "at {theta_deg}°: {value} is not {expected}");
    }
}

/// Seen from above, a groove hides nothing until it is steeper than 30°, and from there on it leaves 2 cos 2δ,
/// to 45°, where light leaves along the surface. With y = tan²δ the albedo is one integral: 1 − e^(−1/3m²) + ∫
/// 2(1 − y)/(1 + y)·e^(−y/m²)/m² dy from 1/3 to 1, here by Simpson's rule, good to the fourth power of its step.
/// The midpoint rule beside it sees the kink at 30° to the square of its step, 7e-6, over m².
#[test]
fn grooves_seen_from_above_have_a_closed_form() {
    for slope in [0.2f64, 0.35, 0.5, 0.75, 1.0] {
        let m2 = slope * slope;
        let hidden = |y: f64| 2.0 * (1.0 - y) / (1.0 + y) * (-y / m2).exp() / m2;
        let (intervals, from) = (1000, 1.0 / 3.0);
        let step = (1.0 - from) / f64::from(intervals);
        let weight = |i: i32| if i == 0 || i == intervals { 1.0 } else { 2.0 + 2.0 * f64::from(i % 2) };
        let integral: f64 =
            (0..=intervals).map(|i| weight(i) * hidden(from + f64::from(i) * step)).sum::<f64>() * step / 3.0;
        let expected = 1.0 - (-from / m2).exp() + integral;
        let value = albedo(Facets::CookTorrance, slope, 0.0);
        assert!((value - expected).abs() < 1e-5 / m2, "slope {slope}: {value} is not {expected}");
    }
}
