//! What a surface makes of light that arrives as spherical harmonics: the harmonics of its reflectance times
//! the incident cosine, by the outgoing direction.
//!
//! In the frame of the surface, the outgoing direction at azimuth 0, a function is even in the azimuth φ, so
//! that it has harmonics of cos mφ alone; where the outgoing direction is at φ_o they turn to those of
//! cos m(φ − φ_o). Frames then turn in the world, [`turned`].

use super::functions::{Functions, MOST};
use super::lobe_table::{NODES, azimuth_at, in_frame, locate, outgoing_at};
use crate::brdf::angles;
use crate::compress::linalg::inverse_of_positive;
use glam::{Vec3, Vec3A};
use ndarray::Array2;
use ndarray_linalg::error::LinalgError;
use rayon::prelude::*;
use relume_formats::basis::sh;
use std::f32::consts::FRAC_PI_2;

/// Harmonics of cos mφ, m ≥ 0, of four bands.
const EVEN: usize = 10;
/// Directions that tables are integrated over: angles with the normal, and azimuths.
const POINTS: [usize; 2] = [96, 96];
/// Directions that turned harmonics are found in.
const DIRECTIONS: usize = 64;

/// The harmonics of one function.
pub type Harmonics = [f32; sh::COUNT];

/// Those of the functions of a material.
pub struct LobeHarmonics {
    /// [nodes of the outgoing angle, functions, even harmonics].
    values: Vec<[f32; EVEN]>,
    count: usize,
}

impl LobeHarmonics {
    /// Of `functions`.
    pub fn new(functions: &Functions) -> Self {
        let count = functions.count();
        let node = |node: usize| {
            let outgoing = outgoing_at(node);
            of(count, |incoming| functions.evaluate(&angles(incoming, outgoing, Vec3A::Z)))
        };
        let nodes: Vec<Vec<[f32; EVEN]>> = (0..NODES).into_par_iter().map(node).collect();
        Self { values: nodes.concat(), count }
    }

    /// Of all functions towards `outgoing`, in its frame as they are.
    pub fn towards(&self, outgoing: Vec3A) -> [Harmonics; MOST] {
        let (node, share) = locate(outgoing.z);
        let mut all = [[0.0; sh::COUNT]; MOST];
        let rows = self.values[node * self.count..].chunks_exact(self.count);
        for (row, share) in rows.zip([1.0 - share, share]) {
            for (to, from) in all.iter_mut().zip(row) {
                let mut turned = turned_about_normal(from, outgoing);
                turned.iter_mut().for_each(|value| *value *= share);
                to.iter_mut().zip(turned).for_each(|(to, value)| *to += value);
            }
        }
        all
    }
}

/// The harmonics of the cosine alone.
pub fn cosine() -> Harmonics {
    sh::irradiance(Vec3::Z)
}

/// ∫ f·Y·cos dω of the functions that `values` gives.
fn of(count: usize, values: impl Fn(Vec3A) -> [f32; MOST]) -> Vec<[f32; EVEN]> {
    let mut sums = vec![[0.0f64; EVEN]; count];
    let [thetas, azimuths] = POINTS;
    let middle = |k: usize, of: usize| (k as f32 + 0.5) / of as f32;
    for theta in 0..thetas {
        let (sin, cos) = (FRAC_PI_2 * middle(theta, thetas)).sin_cos();
        for k in 0..azimuths {
            let [along, across] = azimuth_at(middle(k, azimuths));
            let incoming = Vec3A::new(-sin * along, sin * across, cos);
            let [before, after] = [k, k + 1].map(|k| {
                let [cos, sin] = azimuth_at(k as f32 / azimuths as f32);
                sin.atan2(cos)
            });
            // Both halves of the circle.
            let weight = 2.0 * (after - before) * sin * cos * FRAC_PI_2 / thetas as f32;
            let y = sh::evaluate(incoming.into());
            for (sums, value) in sums.iter_mut().zip(values(incoming)) {
                for (sum, (_, index, _)) in sums.iter_mut().zip(even()) {
                    *sum += f64::from(weight * value * y[index]);
                }
            }
        }
    }
    sums.into_iter().map(|sums| sums.map(|sum| sum as f32)).collect()
}

/// Of the harmonics of cos mφ: m, their index and that of their twins of sin mφ.
fn even() -> impl Iterator<Item = (usize, usize, usize)> {
    (0..sh::BANDS).flat_map(|l| (0..=l).map(move |m| (m, l * l + l + m, l * l + l - m)))
}

fn turned_about_normal(even_ones: &[f32; EVEN], outgoing: Vec3A) -> Harmonics {
    let length = (outgoing.x * outgoing.x + outgoing.y * outgoing.y).sqrt();
    let [cos, sin] = if length > 0.0 { [outgoing.x / length, outgoing.y / length] } else { [1.0, 0.0] };
    let (cos_2, sin_2) = (cos * cos - sin * sin, 2.0 * cos * sin);
    let of_order =
        [[1.0, 0.0], [cos, sin], [cos_2, sin_2], [cos_2 * cos - sin_2 * sin, sin_2 * cos + cos_2 * sin]];
    let mut turned = [0.0; sh::COUNT];
    for (value, (m, cosine, sine)) in even_ones.iter().zip(even()) {
        turned[sine] = value * of_order[m][1];
        turned[cosine] = value * of_order[m][0];
    }
    turned
}

/// Turns harmonics between the frames of surfaces and the world.
pub struct Turns {
    directions: Vec<Vec3A>,
    /// The pseudo-inverse of the harmonics in these, [harmonics, directions].
    inverse: Array2<f64>,
}

/// How the harmonics of a frame are those of the world, row-major [of the world, of the frame].
pub type Turn = [[f32; sh::COUNT]; sh::COUNT];

impl Turns {
    /// # Errors
    /// If LAPACK fails.
    pub fn new() -> Result<Self, LinalgError> {
        let direction = |k: usize| {
            let z = 1.0 - (2 * k + 1) as f32 / DIRECTIONS as f32;
            let (sin_phi, cos_phi) = (2.399_963_2 * k as f32).sin_cos();
            let sin = (1.0 - z * z).sqrt();
            Vec3A::new(sin * cos_phi, sin * sin_phi, z)
        };
        let directions: Vec<Vec3A> = (0..DIRECTIONS).map(direction).collect();
        let values: Vec<Harmonics> = directions.iter().map(|d| sh::evaluate((*d).into())).collect();
        let values =
            Array2::from_shape_fn((DIRECTIONS, sh::COUNT), |(row, column)| f64::from(values[row][column]));
        let inverse = inverse_of_positive(&values.t().dot(&values))?.dot(&values.t());
        Ok(Self { directions, inverse })
    }

    /// From the frame of a surface of unit `normal`. Harmonics of four bands turned are such again, so that
    /// their values in enough directions tell them exactly.
    pub fn to_world(&self, normal: Vec3A) -> Turn {
        let values: Vec<Harmonics> =
            self.directions.iter().map(|d| sh::evaluate(in_frame(normal, *d).into())).collect();
        let entry = |world: usize, own: usize| {
            let row = self.inverse.row(world);
            row.iter().zip(&values).map(|(inverse, values)| inverse * f64::from(values[own])).sum::<f64>()
                as f32
        };
        std::array::from_fn(|world| std::array::from_fn(|own| entry(world, own)))
    }
}

/// `harmonics` of a frame as `turn` has them in the world.
pub fn turned(turn: &Turn, harmonics: &Harmonics) -> Harmonics {
    std::array::from_fn(|world| turn[world].iter().zip(harmonics).map(|(a, b)| a * b).sum())
}

#[cfg(test)]
mod tests;
