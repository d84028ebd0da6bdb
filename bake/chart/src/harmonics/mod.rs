//! Spherical harmonics of the bands 0 to 4, for the rivals that Relume's methods are measured beside:
//! precomputed radiance transfer (Sloan, Kautz, Snyder 2002) and shadows by exponentiation
//! ([`exponentiation`], Ren et al. 2006). No bundle has any of it.
//!
//! Functions are real and orthonormal on the sphere, z is the axis of the zonal ones, y_lm has index l² + l +
//! m.

pub mod exponentiation;

use glam::{DVec3, Vec3};
use relume_formats::basis::cubemap::{FACES, direction, solid_angles};
use relume_formats::basis::sh;
use std::f64::consts::{PI, TAU};

/// Bands.
pub const BANDS: usize = 5;
/// Functions.
pub const COUNT: usize = BANDS * BANDS;
/// A function of direction by its coefficients.
pub type Coefficients = [f32; COUNT];
/// A function around the z axis, by its coefficients in each band.
pub type Zonal = [f64; BANDS];

/// The band of each function.
const BAND: [usize; COUNT] = [0, 1, 1, 1, 2, 2, 2, 2, 2, 3, 3, 3, 3, 3, 3, 3, 4, 4, 4, 4, 4, 4, 4, 4, 4];

/// All functions in the direction of a unit vector.
pub fn basis(direction: Vec3) -> Coefficients {
    basis_of(direction.to_array().map(|coordinate| [coordinate])).map(|[value]| value)
}

/// All functions in the directions of unit vectors, given by coordinates, a lane each.
#[inline(always)]
pub fn basis_of<const LANES: usize>([xs, ys, zs]: [[f32; LANES]; 3]) -> [[f32; LANES]; COUNT] {
    let mut values = [[0.0; LANES]; COUNT];
    for lane in 0..LANES {
        let (x, y, z) = (xs[lane], ys[lane], zs[lane]);
        let (xx, yy, zz) = (x * x, y * y, z * z);
        let (sin2, cos2, turned, sin3, cos3) =
            (x * y, xx - yy, 7.0 * zz - 1.0, y * (3.0 * xx - yy), x * (xx - 3.0 * yy));
        let mut put = |index: usize, value: f32| values[index][lane] = value;
        sh::evaluate(Vec3::new(x, y, z)).into_iter().enumerate().for_each(|(index, value)| put(index, value));
        put(16, 2.503_342_9 * sin2 * cos2);
        put(17, 1.770_130_8 * z * sin3);
        put(18, 0.946_174_7 * sin2 * turned);
        put(19, 0.669_046_5 * y * z * (turned - 2.0));
        put(20, 0.105_785_55 * (35.0 * zz * zz - 30.0 * zz + 3.0));
        put(21, 0.669_046_5 * x * z * (turned - 2.0));
        put(22, 0.473_087_35 * cos2 * turned);
        put(23, 1.770_130_8 * z * cos3);
        put(24, 0.625_835_7 * (xx * xx - 6.0 * xx * yy + yy * yy));
    }
    values
}

/// All functions at the centres of the texels of a cube of `side` texels a side, [6·side²], and each texel's
/// solid angle in steradians.
pub fn of_texels(side: usize) -> Vec<(Coefficients, f32)> {
    let angles = solid_angles(side);
    let of = |texel: usize| {
        let (face, x, y) = (texel / (side * side), texel % side, texel / side % side);
        let centre = direction(face, side, x as f64 + 0.5, y as f64 + 0.5);
        (basis(centre.as_vec3()), angles[y * side + x] as f32)
    };
    (0..FACES * side * side).map(of).collect()
}

/// ∫ of each function times what is given by its integral over each texel.
pub fn project(integrals: &[f32], texels: &[(Coefficients, f32)]) -> Coefficients {
    let mut sums = [0.0f64; COUNT];
    for (value, (basis, _)) in integrals.iter().zip(texels).filter(|(value, _)| **value != 0.0) {
        sums.iter_mut().zip(basis).for_each(|(sum, y)| *sum += f64::from(*value) * f64::from(*y));
    }
    sums.map(|sum| sum as f32)
}

/// What the coefficients of a zonal function are multiplied with, band by band, to turn its axis: times the
/// values of all functions in that direction they are those of the turned one.
pub fn turned_by(zonal: &Zonal) -> Zonal {
    std::array::from_fn(|band| zonal[band] * (4.0 * PI / (2 * band + 1) as f64).sqrt())
}

/// The zonal function that is 0 in the cap around z whose half angle has the cosine `cos`, and 1 elsewhere.
pub fn open_but_for_cap(cos: f64) -> Zonal {
    // ∫ P_l from cos to 1.
    let mut legendre = [1.0; BANDS + 2];
    legendre[1] = cos;
    for l in 2..legendre.len() {
        let n = l as f64;
        legendre[l] = ((2.0 * n - 1.0) * cos * legendre[l - 1] - (n - 1.0) * legendre[l - 2]) / n;
    }
    std::array::from_fn(|band| {
        let integral = match band {
            0 => 1.0 - cos,
            _ => (legendre[band - 1] - legendre[band + 1]) / (2 * band + 1) as f64,
        };
        let whole = if band == 0 { (4.0 * PI).sqrt() } else { 0.0 };
        whole - TAU * ((2 * band + 1) as f64 / (4.0 * PI)).sqrt() * integral
    })
}

/// Directions and weights in steradians that integrate over the sphere whatever is made of three of the
/// functions: polynomials of degree 3·4, by eight heights of Gauss and Legendre and sixteen azimuths.
fn quadrature() -> Vec<(DVec3, f64)> {
    let (heights, azimuths) = (gauss_legendre(), 16);
    let mut points = Vec::new();
    for (z, weight) in heights {
        for k in 0..azimuths {
            let (sin, cos) = (TAU * (k as f64 + 0.5) / azimuths as f64).sin_cos();
            let r = (1.0 - z * z).sqrt();
            points.push((DVec3::new(r * cos, r * sin, z), weight * TAU / azimuths as f64));
        }
    }
    points
}

/// Points and weights in −1..1 that are exact for polynomials of degree 15: Newton's method on P_8.
fn gauss_legendre() -> Vec<(f64, f64)> {
    const N: usize = 8;
    let point = |k: usize| {
        let mut z = (PI * (k as f64 + 0.75) / (N as f64 + 0.5)).cos();
        let mut slope = 1.0;
        for _ in 0..16 {
            let (mut before, mut value) = (1.0, z);
            for l in 2..=N {
                let n = l as f64;
                (before, value) = (value, ((2.0 * n - 1.0) * z * value - (n - 1.0) * before) / n);
            }
            slope = N as f64 * (z * value - before) / (z * z - 1.0);
            z -= value / slope;
        }
        (z, 2.0 / ((1.0 - z * z) * slope * slope))
    };
    (0..N).map(point).collect()
}

/// Products of functions, cut off to the bands that there are.
pub struct Product {
    /// ∫ y_i·y_j·y_k for i ≤ j and every k where that is not 0; twice it for i < j, so that it holds for a
    /// square.
    terms: Vec<([u8; 3], f32)>,
}

impl Default for Product {
    fn default() -> Self {
        let points = quadrature();
        let values: Vec<(Coefficients, f64)> =
            points.iter().map(|(direction, weight)| (basis(direction.as_vec3()), *weight)).collect();
        let mut terms = Vec::new();
        for k in 0..COUNT {
            for i in 0..COUNT {
                for j in i..COUNT {
                    let of_point =
                        |(y, weight): &(Coefficients, f64)| f64::from(y[i] * y[j]) * f64::from(y[k]) * weight;
                    let integral: f64 = values.iter().map(of_point).sum();
                    // Values are rounded to 1e-7; the smallest integral that is not 0 is 0.02.
                    if integral.abs() > 1e-3 {
                        let twice = if i < j { 2.0 } else { 1.0 };
                        terms.push(([i as u8, j as u8, k as u8], (twice * integral) as f32));
                    }
                }
            }
        }
        Self { terms }
    }
}

impl Product {
    /// The squares of functions, a lane each.
    #[inline(always)]
    pub fn square<const LANES: usize>(&self, f: &[[f32; LANES]; COUNT]) -> [[f32; LANES]; COUNT] {
        let mut square = [[0.0; LANES]; COUNT];
        for ([i, j, k], integral) in &self.terms {
            let (a, b, sum) = (&f[usize::from(*i)], &f[usize::from(*j)], &mut square[usize::from(*k)]);
            for lane in 0..LANES {
                sum[lane] += integral * a[lane] * b[lane];
            }
        }
        square
    }

    /// The matrix that multiplies with `f`, row-major.
    pub fn matrix(&self, f: &Coefficients) -> [[f32; COUNT]; COUNT] {
        let mut matrix = [[0.0; COUNT]; COUNT];
        for ([i, j, k], integral) in &self.terms {
            let [i, j, k] = [i, j, k].map(|index| usize::from(*index));
            let once = if i < j { 0.5 } else { 1.0 } * integral;
            matrix[k][j] += once * f[i];
            if i < j {
                matrix[k][i] += once * f[j];
            }
        }
        matrix
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Unit vectors all over the sphere.
    pub(super) fn directions(count: usize) -> impl Iterator<Item = Vec3> {
        (0..count).map(move |k| {
            let (z, phi) = (1.0 - 2.0 * (k as f32 + 0.5) / count as f32, 2.399_963_2 * k as f32);
            let r = (1.0 - z * z).sqrt();
            Vec3::new(r * phi.cos(), r * phi.sin(), z)
        })
    }

    #[test]
    fn functions_are_orthonormal() {
        let points = quadrature();
        for i in 0..COUNT {
            for j in 0..COUNT {
                let integral: f64 = points
                    .iter()
                    .map(|(d, weight)| {
                        let y = basis(d.as_vec3());
                        f64::from(y[i]) * f64::from(y[j]) * weight
                    })
                    .sum();
                let expected = f64::from(u8::from(i == j));
                // The quadrature is exact; values of at most 1.8 are off by a few roundings.
                assert!((integral - expected).abs() < 3e-6, "{i} {j}: {integral}");
            }
        }
    }

    #[test]
    fn functions_of_a_band_add_up_to_the_legendre_polynomial_of_the_angle() {
        for (a, b) in directions(40).zip(directions(41).skip(1)) {
            let (ya, yb, t) = (basis(a), basis(b), f64::from(a.dot(b)));
            let legendre = [
                1.0,
                t,
                (3.0 * t * t - 1.0) / 2.0,
                (5.0 * t * t - 3.0) * t / 2.0,
                ((35.0 * t * t - 30.0) * t * t + 3.0) / 8.0,
            ];
            for (band, expected) in legendre.into_iter().enumerate() {
                let sum: f64 = (0..COUNT)
                    .filter(|index| BAND[*index] == band)
                    .map(|index| f64::from(ya[index]) * f64::from(yb[index]))
                    .sum();
                let scale = 4.0 * PI / (2 * band + 1) as f64;
                assert!((sum * scale - expected).abs() < 1e-5, "band {band}: {} {expected}", sum * scale);
            }
        }
    }

    /// Nothing is rotated: a turned zonal function is the values of all functions times one number a band.
    #[test]
    fn a_turned_cap_is_the_projection_of_what_is_there() {
        let texels = of_texels(128);
        let points = (0..texels.len()).map(|texel| {
            let (face, x, y) = (texel / (128 * 128), texel % 128, texel / 128 % 128);
            direction(face, 128, x as f64 + 0.5, y as f64 + 0.5).as_vec3()
        });
        let points: Vec<Vec3> = points.collect();
        for (axis, cos) in directions(6).zip([0.995f32, 0.95, 0.8, 0.5, 0.2, 0.0]) {
            let seen: Vec<f32> = points
                .iter()
                .zip(&texels)
                .map(|(point, (_, angle))| if point.dot(axis) > cos { 0.0 } else { *angle })
                .collect();
            let (projected, scale) = (project(&seen, &texels), turned_by(&open_but_for_cap(f64::from(cos))));
            let y = basis(axis);
            for index in 0..COUNT {
                let turned = scale[BAND[index]] * f64::from(y[index]);
                // Texels of 1.3e-4 sr are in or out whole: along a cap's edge of at most 2π, where a texel is
                // 0.012 wide, errors of half of one each add as random ones do: ±6e-5·√(2π/0.012) = 1.4e-3 in
                // all.
                assert!((turned - f64::from(projected[index])).abs() < 4e-3, "{cos} {index}: {turned}");
            }
        }
    }

    #[test]
    fn a_square_is_the_projection_of_the_square() {
        let product = Product::default();
        let f: Coefficients = std::array::from_fn(|k| ((7 * k + 3) % 11) as f32 / 11.0 - 0.4);
        let square = product.square(&f.map(|value| [value])).map(|[value]| value);
        let by_matrix = product.matrix(&f).map(|row| row.iter().zip(&f).map(|(m, f)| m * f).sum::<f32>());
        // An independent integral: the midpoint rule on 6·64² texels, of functions smooth enough that it is
        // off by (1/64)² of them.
        let texels = of_texels(64);
        let values: Vec<f32> = texels
            .iter()
            .map(|(y, angle)| y.iter().zip(&f).map(|(y, f)| y * f).sum::<f32>().powi(2) * angle)
            .collect();
        let projected = project(&values, &texels);
        for k in 0..COUNT {
            assert!((square[k] - by_matrix[k]).abs() < 1e-5, "{k}: {} {}", square[k], by_matrix[k]);
            assert!((square[k] - projected[k]).abs() < 2e-3, "{k}: {} {}", square[k], projected[k]);
        }
    }
}
