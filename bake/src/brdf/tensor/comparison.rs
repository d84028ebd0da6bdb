//! What a stored tensor says of materials, against their BRDF, at directions and materials that it was not
//! made of.

use super::separation::Gaussian;
use super::table::Points;
use glam::DVec3;
use relume_formats::basis::disc::RINGS;
use relume_formats::kinds::BrdfTensor;
use relume_formats::state::Brdf;
use std::f64::consts::PI;

/// Outgoing directions that errors are summed over, on either side of the nodes of each ring.
const OUTGOING: usize = 2 * RINGS;

/// A tensor beside the points that BRDFs are evaluated at.
pub struct Comparison<'a> {
    tensor: &'a BrdfTensor,
    points: Points,
    terms: Vec<Gaussian>,
}

impl<'a> Comparison<'a> {
    /// Of `tensor`.
    pub fn new(tensor: &'a BrdfTensor) -> Self {
        let terms = tensor.widths_deg.iter().map(|deg| Gaussian::of_width(f64::from(*deg))).collect();
        Self { tensor, points: Points::new(), terms }
    }

    /// Relative L2 error of the glossy lobe of `material`, whose strength is 1 and the same in all channels,
    /// over both directions with both cosines; `None` if the tensor is of another model.
    pub fn error(&self, material: &Brdf) -> Option<f64> {
        let mixture = self.tensor.mixture(material, 0)?;
        let (mut off, mut whole) = (0.0, 0.0);
        for at in 0..OUTGOING {
            let edge = |at: usize| at as f64 / OUTGOING as f64;
            let outgoing = seen_from(0.5 * (edge(at) + edge(at + 1)));
            let weight = PI * (edge(at + 1).powi(2) - edge(at).powi(2));
            let arriving = self.points.arriving(material, outgoing);
            let stored = self.stored(&mixture, outgoing);
            for ((value, stored), area) in arriving.iter().zip(stored).zip(&self.points.area) {
                off += weight * (value - stored).powi(2) / area;
                whole += weight * value * value / area;
            }
        }
        Some((off / whole).sqrt())
    }

    /// What `material`, as for [`Comparison::error`], reflects of a white sky seen under `angle`, radians
    /// from the normal: by its BRDF, and by the tensor.
    pub fn albedos(&self, material: &Brdf, angle: f64) -> Option<[f64; 2]> {
        let (mixture, outgoing) = (self.tensor.mixture(material, 0)?, seen_from(angle.sin()));
        let arriving = self.points.arriving(material, outgoing);
        Some([arriving, self.stored(&mixture, outgoing)].map(|values| values.into_iter().sum()))
    }

    /// What [`Points::arriving`] is of the BRDF, of the mixture of samples: rest and mirror terms.
    fn stored(&self, mixture: &[(usize, f32)], outgoing: DVec3) -> Vec<f64> {
        let core = self.tensor.core_of(mixture);
        let shares = self.tensor.shares(mixture, outgoing);
        let points = self.points.directions.iter().zip(&self.points.area).zip(&self.points.solid_angle);
        let at_point = |((incoming, area), solid_angle): ((&DVec3, &f64), &f64)| {
            let rest = f64::from(self.tensor.residual(&core, outgoing, *incoming)) * area;
            let term = |(share, gaussian): (&f32, &Gaussian)| {
                f64::from(*share) * gaussian.about_mirror(outgoing, *incoming) * solid_angle
            };
            rest + shares.iter().zip(&self.terms).map(term).sum::<f64>()
        };
        points.map(at_point).collect()
    }
}

/// In the azimuth of +X.
fn seen_from(radius: f64) -> DVec3 {
    DVec3::new(radius, 0.0, (1.0 - radius * radius).max(0.0).sqrt())
}
