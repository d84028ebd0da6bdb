//! Real orthonormal spherical harmonics of four bands ("4th order"), index l² + l + m, z the polar axis,
//! without the Condon-Shortley phase (Sloan 2008, "Stupid spherical harmonics (SH) tricks", appendix A2).

use glam::Vec3;
use std::f32::consts::{FRAC_PI_4, PI, TAU};

/// Bands.
pub const BANDS: usize = 4;
/// Functions.
pub const COUNT: usize = BANDS * BANDS;

/// What the coefficients of a band are multiplied with by convolution with max(0, cos θ): radiance becomes
/// irradiance (Ramamoorthi and Hanrahan 2001, eq. 19).
pub const COSINE_LOBE: [f32; BANDS] = [PI, 2.0 * PI / 3.0, FRAC_PI_4, 0.0];

/// All functions in a unit direction.
#[inline(always)]
pub fn evaluate(Vec3 { x, y, z }: Vec3) -> [f32; COUNT] {
    let (xx, yy, zz) = (x * x, y * y, z * z);
    let (sin2, cos2) = (x * y, xx - yy);
    [
        0.282_094_8,
        0.488_602_5 * y,
        0.488_602_5 * z,
        0.488_602_5 * x,
        1.092_548_4 * sin2,
        1.092_548_4 * y * z,
        0.315_391_57 * (3.0 * zz - 1.0),
        1.092_548_4 * x * z,
        0.546_274_2 * cos2,
        0.590_043_6 * (y * (3.0 * xx - yy)),
        2.890_611_4 * sin2 * z,
        0.457_045_8 * y * (5.0 * zz - 1.0),
        0.373_176_33 * z * (5.0 * zz - 3.0),
        0.457_045_8 * x * (5.0 * zz - 1.0),
        1.445_305_7 * z * cos2,
        0.590_043_6 * (x * (xx - 3.0 * yy)),
    ]
}

/// The weights that make irradiance at a surface of unit `normal` of the coefficients of radiance, as far as
/// four bands tell.
pub fn irradiance(normal: Vec3) -> [f32; COUNT] {
    let values = evaluate(normal);
    std::array::from_fn(|index| COSINE_LOBE[index.isqrt()] * values[index])
}

/// Unit vectors whose values of all functions tell a sum of them: a spiral from pole to pole, of 0.42 turns from one to
/// the next, for which the matrix of these values has a condition number of 2.5.
pub fn directions() -> [Vec3; COUNT] {
    std::array::from_fn(|k| {
        let z = 1.0 - (2 * k + 1) as f32 / COUNT as f32;
        let (r, (sin, cos)) = ((1.0 - z * z).sqrt(), (0.42 * TAU * k as f32).sin_cos());
        Vec3::new(r * cos, r * sin, z)
    })
}

/// What values in [`directions`] count for in the integral of a sum of functions with something whose integrals with
/// each of them are `integrals`.
pub fn at_directions(integrals: &[f64; COUNT]) -> [f64; COUNT] {
    // Σ_p w_p Y_s(d_p) = integral s, by elimination with the largest pivot of a column.
    let values = directions().map(evaluate);
    let mut rows: [[f64; COUNT + 1]; COUNT] = std::array::from_fn(|s| {
        std::array::from_fn(|p| values.get(p).map_or(integrals[s], |values| f64::from(values[s])))
    });
    for column in 0..COUNT {
        let size = |row: &usize| rows[*row][column].abs();
        let pivot = (column..COUNT).max_by(|a, b| size(a).total_cmp(&size(b))).unwrap_or(column);
        rows.swap(column, pivot);
        let pivot = rows[column];
        for row in rows.iter_mut().enumerate().filter(|(at, _)| *at != column).map(|(_, row)| row) {
            let factor = row[column] / pivot[column];
            row.iter_mut().zip(pivot).for_each(|(value, above)| *value -= factor * above);
        }
    }
    std::array::from_fn(|p| rows[p][COUNT] / rows[p][p])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::basis::cubemap::{FACES, direction, solid_angles};

    const SIDE: usize = 64;

    fn over_sphere(mut add: impl FnMut(Vec3, f64)) {
        let weights = solid_angles(SIDE);
        for texel in 0..FACES * SIDE * SIDE {
            let (face, within) = (texel / (SIDE * SIDE), texel % (SIDE * SIDE));
            let [x, y] = [within % SIDE, within / SIDE].map(|k| k as f64 + 0.5);
            add(direction(face, SIDE, x, y).as_vec3(), weights[within]);
        }
    }

    /// The midpoint rule over texels of 1/32 of the cube's half side: off by less than 1e-3 of products of
    /// polynomials of degree three, whose second derivatives reach some 40 (h²/24 · 40 = 1.6e-3 at their
    /// peaks alone).
    #[test]
    fn functions_are_orthonormal() {
        let mut products = [[0.0; COUNT]; COUNT];
        over_sphere(|towards, weight| {
            let values = evaluate(towards).map(f64::from);
            for (row, a) in products.iter_mut().zip(values) {
                row.iter_mut().zip(values).for_each(|(sum, b)| *sum += weight * a * b);
            }
        });
        for (i, row) in products.iter().enumerate() {
            for (j, product) in row.iter().enumerate() {
                let expected = f64::from(u8::from(i == j));
                assert!((product - expected).abs() < 1e-3, "{i}, {j}: {product}");
            }
        }
    }

    /// Of radiance that is a polynomial of degree two, four bands tell the irradiance exactly: that of (a·ω)²
    /// is π/4·(1 + |a·n|²) for a unit vector a.
    #[test]
    fn irradiance_of_a_quadratic_is_exact() {
        let (along, normal) = (Vec3::new(0.6, 0.0, 0.8), Vec3::new(0.48, 0.64, 0.6));
        let mut coefficients = [0.0f64; COUNT];
        over_sphere(|towards, weight| {
            let radiance = f64::from(along.dot(towards)).powi(2);
            let values = evaluate(towards);
            coefficients.iter_mut().zip(values).for_each(|(sum, y)| *sum += weight * radiance * f64::from(y));
        });
        let found: f64 = coefficients.iter().zip(irradiance(normal)).map(|(c, w)| c * f64::from(w)).sum();
        let expected = std::f64::consts::FRAC_PI_4 * (1.0 + f64::from(along.dot(normal)).powi(2));
        assert!((found - expected).abs() < 1e-3, "{found} {expected}");
    }
    /// Of what only one function has an integral with, in turn: the sum of values in directions, so weighed, is the
    /// coefficient of that function, to what rounding of 24 bits is times the condition.
    #[test]
    fn values_in_directions_tell_coefficients() {
        let coefficients: [f64; COUNT] = std::array::from_fn(|s| (s as f64 * 0.618).fract() - 0.4);
        let value = |towards: Vec3| -> f64 {
            evaluate(towards).iter().zip(coefficients).map(|(y, c)| f64::from(*y) * c).sum()
        };
        for (s, coefficient) in coefficients.iter().enumerate() {
            let weights = at_directions(&std::array::from_fn(|other| f64::from(u8::from(other == s))));
            let found: f64 = weights.iter().zip(directions()).map(|(w, d)| w * value(d)).sum();
            assert!((found - coefficient).abs() < 1e-5, "{s}: {found} for {coefficient}");
        }
    }
}
