//! What a stored tensor says of materials, against their BRDF, at directions and materials that it was not made of.

use super::hemisphere::{self, Hemisphere, of_order};
use super::{ENDS_COUNT, cones, lobe_harmonics, profiles};
use glam::DVec3;
use relume_formats::kinds::BrdfTensor;
use relume_formats::kinds::brdf_tensor::angles::NODES;
use relume_formats::state::Brdf;
use std::f64::consts::FRAC_PI_2;

/// Angles that errors are summed over: the nodes, the ends left out, and the middles between them.
const ANGLES: usize = 2 * (NODES - 1);

/// A tensor beside the harmonics that BRDFs are compared in.
pub struct Comparison<'a> {
    tensor: &'a BrdfTensor,
    hemisphere: Hemisphere,
    /// The harmonics of each incoming profile times cosine.
    profiles: Vec<Vec<f64>>,
}

impl<'a> Comparison<'a> {
    /// Of `tensor`.
    pub fn new(tensor: &'a BrdfTensor) -> Self {
        let hemisphere = Hemisphere::new();
        let of_profile = |(k, order): (usize, &u32)| {
            let value = |node: usize| f64::from(tensor.incoming[node * tensor.orders.len() + k]);
            profiles::harmonics(*order as usize, value, &hemisphere)
        };
        let profiles = tensor.orders.iter().enumerate().map(of_profile).collect();
        Self { tensor, profiles, hemisphere }
    }

    /// Relative error of the glossy lobe of `material`, whose strength is 1 and the same in all channels, in the
    /// metric of natural light and over all angles that it is seen from; `None` if the tensor is of another model.
    pub fn error(&self, material: &Brdf) -> Option<f64> {
        let step = FRAC_PI_2 / ANGLES as f64;
        let angles: Vec<f64> = (1..ANGLES).map(|at| at as f64 * step).collect();
        self.squares(material, &angles).map(|[off, whole]| (off / whole).sqrt())
    }

    /// The squared norms of what the stored lobe of a material is off, and of the lobe, seen from `angles`,
    /// radians from the normal, each of which counts as in the making of tensors.
    pub fn squares(&self, material: &Brdf, angles: &[f64]) -> Option<[f64; 2]> {
        let mixture = self.tensor.mixture(material, 0)?;
        let (mut off, mut whole) = (0.0, 0.0);
        for theta in angles {
            let weight = theta.sin() * theta.cos() + ENDS_COUNT;
            let lobe = lobe_harmonics(material, hemisphere::outgoing(*theta), &self.hemisphere);
            for (value, stored) in lobe.iter().zip(self.stored(&mixture, *theta)) {
                off += weight * (value - stored).powi(2);
                whole += weight * value * value;
            }
        }
        Some([off, whole])
    }

    /// What `material`, as for [`Comparison::error`], reflects of a white sky seen under `theta`, radians from the
    /// normal: by its BRDF, and by the tensor.
    pub fn albedos(&self, material: &Brdf, theta: f64) -> Option<[f64; 2]> {
        let stored = self.stored(&self.tensor.mixture(material, 0)?, theta);
        let lobe = lobe_harmonics(material, hemisphere::outgoing(theta), &self.hemisphere);
        Some([lobe, stored].map(|harmonics| hemisphere::integral(&harmonics)))
    }

    /// The harmonics of what is stored of a mixture of samples.
    pub fn stored(&self, mixture: &[(usize, f32)], theta: f64) -> Vec<f64> {
        let outgoing: DVec3 = hemisphere::outgoing(theta);
        let shares = BrdfTensor::seen_from(&self.tensor.shares_of(mixture), outgoing.as_vec3());
        let weights = BrdfTensor::seen_from(&self.tensor.weights_of(mixture), outgoing.as_vec3());
        let mut sum = vec![0.0; of_order(hemisphere::BANDS - 1).end];
        for (share, cone) in
            shares.iter().zip(cones::harmonics(&self.tensor.cones, outgoing, &self.hemisphere))
        {
            sum.iter_mut().zip(cone).for_each(|(sum, value)| *sum += f64::from(*share) * value);
        }
        for ((weight, profile), order) in weights.iter().zip(&self.profiles).zip(&self.tensor.orders) {
            let own = sum.get_mut(of_order(*order as usize)).unwrap_or_default();
            own.iter_mut().zip(profile).for_each(|(sum, value)| *sum += f64::from(*weight) * value);
        }
        sum
    }
}
