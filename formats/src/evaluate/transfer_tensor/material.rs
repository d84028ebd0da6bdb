//! What a material makes of what a vertex receives.

use crate::basis::sh;
use crate::kinds::BrdfTensor;
use crate::kinds::brdf_tensor::strength;
use crate::state::Brdf;
use glam::Vec3;
use std::f32::consts::{PI, TAU};

/// The glossy lobes of a material, its strength included: for each channel tables by angle of the outgoing direction,
/// see [`BrdfTensor::seen_from`].
#[derive(Debug, Clone, PartialEq)]
pub struct Lobes {
    /// Row-major [angle nodes, profiles]: how much each incoming profile counts.
    pub profiles: [Vec<f32>; 3],
    /// Row-major [angle nodes, cones]: what each cone reflects.
    pub cones: [Vec<f32>; 3],
}

impl Lobes {
    /// Those of `brdf`; `None` if it is of another model than `space`.
    pub fn new(space: &BrdfTensor, brdf: &Brdf) -> Option<Self> {
        let mixtures = [space.mixture(brdf, 0)?, space.mixture(brdf, 1)?, space.mixture(brdf, 2)?];
        let strength = strength(brdf);
        let scaled = |c: usize, table: Vec<f32>| table.into_iter().map(|value| strength[c] * value).collect();
        Some(Self {
            profiles: std::array::from_fn(|c| scaled(c, space.weights_of(&mixtures[c]))),
            cones: std::array::from_fn(|c| scaled(c, space.shares_of(&mixtures[c]))),
        })
    }
}

/// Steps from the normal to the horizon, and around it, of the sums over a hemisphere.
const STEPS: [usize; 2] = [96, 64];

/// What radiance from each of [`sh::directions`], in the frame of a vertex, counts for in each column of `space`, row-major
/// [directions, columns]: exact for light of four bands.
pub fn harmonic_weights(space: &BrdfTensor) -> Vec<f32> {
    let columns = space.columns();
    let mut integrals = vec![[0.0f64; sh::COUNT]; columns];
    for step in 0..STEPS[0] * STEPS[1] {
        let (down, around) = (step / STEPS[1], step % STEPS[1]);
        // Midpoints in cos²θ, whose differential is that of the cosine-weighted solid angle.
        let cosine = (1.0 - (down as f32 + 0.5) / STEPS[0] as f32).sqrt();
        let (sine, phi) = ((1.0 - cosine * cosine).sqrt(), TAU * (around as f32 + 0.5) / STEPS[1] as f32);
        let direction = Vec3::new(sine * phi.cos(), sine * phi.sin(), cosine);
        let weight = f64::from(PI) / (STEPS[0] * STEPS[1]) as f64;
        let harmonics = sh::evaluate(direction);
        for (sums, value) in integrals.iter_mut().zip(space.column_values(direction)) {
            sums.iter_mut().zip(harmonics).for_each(|(sum, y)| *sum += weight * f64::from(y * value));
        }
    }
    let of_columns: Vec<[f64; sh::COUNT]> = integrals.iter().map(sh::at_directions).collect();
    (0..sh::COUNT).flat_map(|p| of_columns.iter().map(move |weights| weights[p] as f32)).collect()
}
