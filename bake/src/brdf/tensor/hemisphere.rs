//! Functions on a hemisphere as spherical harmonics about its normal, in the metric in which lobes are compared.
//!
//! A lobe times cosine, seen from one direction, is the same on both sides of the plane of incidence, so that its
//! harmonics of order m are those of cos mφ alone. They are weighed by the roots of the spectrum of natural light,
//! 1/(1 + l)² for band l: the squared norm of what two lobes differ is then what their reflected radiances are
//! expected to differ, squared, under random light of that spectrum. Sharp detail counts less than brightness,
//! as it does in a picture.

use glam::{DVec3, Vec3A};
use ndarray::{Array2, ArrayView1};
use relume_formats::kinds::brdf_tensor::MAX_ORDER;
use relume_formats::kinds::brdf_tensor::angles::{self, NODES};
use std::f64::consts::{PI, SQRT_2};
use std::ops::Range;

/// Bands, and orders.
pub const BANDS: usize = MAX_ORDER as usize + 1;
/// Points between two nodes of the angle from the normal.
const BETWEEN: usize = 5;
/// Points of half a turn. They are dense about the mirror azimuth, where lobes seen along the surface are narrow:
/// 0.07° across for a slope of 0.1 seen from [`GRAZING_DEG`].
const AZIMUTHS: usize = 160;
/// Seen from 90° nothing is received, and the limit is taken here, degrees.
pub const GRAZING_DEG: f64 = 89.5;

/// Points of a hemisphere about +Z, y ≥ 0, and what makes harmonics of values there. Each counts for the one that
/// mirrors it, too.
pub struct Hemisphere {
    /// Angle from the normal and its share of the integral, sin θ dθ, of each ring of points.
    rings: Vec<[f64; 2]>,
    /// Unit vectors, [rings, [`AZIMUTHS`]].
    directions: Vec<Vec3A>,
    /// Products with cos mφ, [[`AZIMUTHS`], [`BANDS`]].
    waves: Array2<f64>,
    /// Of each order, weighed, [bands, rings].
    bands: Vec<Array2<f64>>,
}

/// Where the harmonics of an order are among all of them: bands from the order on.
pub fn of_order(order: usize) -> Range<usize> {
    let first = |order: usize| order * (2 * BANDS + 1 - order) / 2;
    first(order)..first(order + 1)
}

/// What a surface is seen from at a node, radians.
pub fn seen_from(node: usize) -> f64 {
    angles::theta(node).min(GRAZING_DEG.to_radians())
}

/// The unit vector at an angle from the normal, radians, in the azimuth of +X.
pub fn outgoing(theta: f64) -> DVec3 {
    DVec3::new(theta.sin(), 0.0, theta.cos())
}

/// What a white sky shows of a function with these harmonics: its integral.
pub fn integral(harmonics: &[f64]) -> f64 {
    harmonics.first().map_or(0.0, |constant| constant * (4.0 * PI).sqrt())
}

impl Hemisphere {
    /// As fine as the constants say.
    pub fn new() -> Self {
        let unit = gauss_legendre(BETWEEN);
        let step = angles::theta(1);
        let ring = |node: usize, [x, weight]: [f64; 2]| {
            let theta = step * (node as f64 + x);
            [theta, weight * step * theta.sin()]
        };
        let rings: Vec<[f64; 2]> =
            (0..NODES - 1).flat_map(|node| unit.iter().map(move |point| ring(node, *point))).collect();
        // From the mirror azimuth by π·t³.
        let azimuth = |[t, weight]: [f64; 2]| [PI - PI * t.powi(3), 3.0 * PI * t * t * weight];
        let azimuths: Vec<[f64; 2]> = gauss_legendre(AZIMUTHS).into_iter().map(azimuth).collect();
        let direction = |theta: f64, phi: f64| {
            DVec3::new(theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos()).as_vec3a()
        };
        let on_ring =
            |[theta, _]: &[f64; 2]| azimuths.iter().map(|[phi, _]| direction(*theta, *phi)).collect();
        let waves = Array2::from_shape_fn((AZIMUTHS, BANDS), |(at, order)| {
            let [phi, weight] = azimuths[at];
            2.0 * weight * (order as f64 * phi).cos() * if order == 0 { 1.0 } else { SQRT_2 }
        });
        Self {
            directions: rings.iter().flat_map(|ring| -> Vec<Vec3A> { on_ring(ring) }).collect(),
            bands: (0..BANDS).map(|order| weighed(order, &rings)).collect(),
            waves,
            rings,
        }
    }

    /// The harmonics, weighed, of a function that is the same on both sides of the plane of X and Z, at unit
    /// vectors about the normal +Z: those of [`of_order`] one after another.
    pub fn harmonics(&self, value: impl Fn(Vec3A) -> f64) -> Vec<f64> {
        let values: Vec<f64> = self.directions.iter().map(|direction| value(*direction)).collect();
        let values = Array2::from_shape_vec((self.rings.len(), AZIMUTHS), values).unwrap_or_default();
        let by_order = values.dot(&self.waves);
        let of = |(order, bands): (usize, &Array2<f64>)| bands.dot(&by_order.column(order)).to_vec();
        self.bands.iter().enumerate().flat_map(of).collect()
    }

    /// The harmonics of that order of `profile`(θ)·cos mφ, which has no others: where they are is [`of_order`].
    pub fn of_profile(&self, order: usize, profile: impl Fn(f64) -> f64) -> Vec<f64> {
        // ∫ cos² mφ dφ, times the norm of the harmonic.
        let around = if order == 0 { 2.0 * PI } else { SQRT_2 * PI };
        let values: Vec<f64> = self.rings.iter().map(|[theta, _]| around * profile(*theta)).collect();
        let bands = self.bands.get(order).map(|bands| bands.dot(&ArrayView1::from(&values)).to_vec());
        bands.unwrap_or_default()
    }
}

/// What makes weighed harmonics of an order of values on rings, [bands, rings].
fn weighed(order: usize, rings: &[[f64; 2]]) -> Array2<f64> {
    let columns: Vec<Vec<f64>> = rings.iter().map(|[theta, _]| legendre(order, *theta)).collect();
    Array2::from_shape_fn((BANDS - order, rings.len()), |(band, ring)| {
        columns[ring][band] * rings[ring][1] / (1 + order + band) as f64
    })
}

/// What cos mφ, times √2 for m > 0, is multiplied with in the orthonormal harmonics of order m, without the
/// Condon-Shortley phase: bands from m on.
fn legendre(order: usize, theta: f64) -> Vec<f64> {
    let (sin, cos) = theta.sin_cos();
    let m = order as f64;
    let diagonal = |value: f64, k: usize| value * sin * ((2 * k + 1) as f64 / (2 * k) as f64).sqrt();
    let mut values = vec![(1..=order).fold((4.0 * PI).recip().sqrt(), diagonal)];
    let mut before = 0.0;
    for band in order + 1..BANDS {
        let l = band as f64;
        let squared = |l: f64| (l * l - m * m) / (4.0 * l * l - 1.0);
        let last = values.last().copied().unwrap_or(0.0);
        values.push((cos * last - squared(l - 1.0).sqrt() * before) / squared(l).sqrt());
        before = last;
    }
    values
}

/// The points and weights of Gauss's quadrature with Legendre's polynomials over 0 to 1, by Newton's method.
fn gauss_legendre(count: usize) -> Vec<[f64; 2]> {
    let n = count as f64;
    let point = |k: usize| {
        let mut x = (PI * (k as f64 + 0.75) / (n + 0.5)).cos();
        let mut slope = 1.0;
        for _ in 0..8 {
            let (mut value, mut before) = (x, 1.0);
            for l in 2..=count {
                let l = l as f64;
                (value, before) = (((2.0 * l - 1.0) * x * value - (l - 1.0) * before) / l, value);
            }
            slope = n * (x * value - before) / (x * x - 1.0);
            x -= value / slope;
        }
        [0.5 * (1.0 - x), 1.0 / ((1.0 - x * x) * slope * slope)]
    };
    (0..count).map(point).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use relume_formats::basis::sh;

    /// Gauss's quadrature of n points is exact to polynomials of degree 2n − 1.
    #[test]
    fn quadrature_of_polynomials_is_exact() {
        for (count, degree) in [(1, 1), (5, 9), (160, 300)] {
            let sum: f64 = gauss_legendre(count).into_iter().map(|[x, w]| w * x.powi(degree)).sum();
            assert!((sum * f64::from(degree + 1) - 1.0).abs() < 1e-12, "{count}: {sum}");
        }
    }

    /// Products of two functions of one order are polynomials in cos θ of degree 96 at most: 49 points of Gauss's
    /// in cos θ are exact.
    #[test]
    fn functions_are_orthonormal() {
        let points = gauss_legendre(BANDS);
        for order in [0, 1, 2, 7, 48] {
            let values: Vec<Vec<f64>> =
                points.iter().map(|[x, _]| legendre(order, (2.0 * x - 1.0).acos())).collect();
            for (a, b) in (0..BANDS - order).flat_map(|a| (0..=a).map(move |b| (a, b))) {
                let sum: f64 = points.iter().zip(&values).map(|([_, w], v)| 2.0 * w * v[a] * v[b]).sum();
                let product = 2.0 * PI * sum;
                assert!((product - f64::from(u8::from(a == b))).abs() < 1e-11, "{order} {a} {b}: {product}");
            }
        }
    }

    /// The first four bands are those written out for the player, at φ = 0.
    #[test]
    fn the_first_bands_are_the_known_ones() {
        for theta in [0.0, 0.3, 1.2, 2.5] {
            let known = sh::evaluate(outgoing(theta).as_vec3());
            for (order, band) in (0..4).flat_map(|m| (m..4).map(move |l| (m, l))) {
                let ours = legendre(order, theta)[band - order] * if order == 0 { 1.0 } else { SQRT_2 };
                let value = f64::from(known[band * band + band + order]);
                assert!((ours - value).abs() < 1e-6, "{band} {order}: {ours} {value}");
            }
        }
    }

    /// (a·ω)² over the upper hemisphere, whose integral is 2π/3 of |a|², and its harmonics by the other way of
    /// orders and profiles: x² = sin²θ (1 + cos 2φ)/2.
    #[test]
    fn a_polynomial_has_the_harmonics_of_its_profiles() {
        let hemisphere = Hemisphere::new();
        let found = hemisphere.harmonics(|d| f64::from(d.x * d.x));
        // Directions are in single precision.
        assert!((integral(&found) - 2.0 * PI / 3.0).abs() < 1e-6);
        let half = |theta: f64| 0.5 * theta.sin().powi(2);
        for order in 0..BANDS {
            let expected =
                if order == 0 || order == 2 { hemisphere.of_profile(order, half) } else { Vec::new() };
            for (at, value) in found[of_order(order)].iter().enumerate() {
                assert!((value - expected.get(at).unwrap_or(&0.0)).abs() < 1e-6, "{order} {at}");
            }
        }
        assert_eq!(of_order(BANDS - 1).end, found.len());
    }
}
