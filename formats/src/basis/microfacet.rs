//! The microfacet terms that linear bases are combinations of.

use super::angles::Angles;
use std::f32::consts::FRAC_1_PI;

/// Which facets a surface has, and how they hide each other.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Facets {
    /// Trowbridge and Reitz's, masked and shadowed as Smith has it: [`distribution_visibility`] at α =
    /// roughness².
    Ggx,
    /// Beckmann's, in Cook and Torrance's V-shaped grooves: [`beckmann_grooves`] at the slope that is called
    /// roughness.
    CookTorrance,
}

impl Facets {
    /// D·V, sr⁻¹: the lobe but for Fresnel reflectance.
    pub fn lobe(self, roughness: f32, angles: &Angles) -> f32 {
        match self {
            Self::Ggx => {
                let alpha = roughness * roughness;
                distribution_visibility(alpha * alpha, angles)
            }
            Self::CookTorrance => beckmann_grooves(roughness, angles),
        }
    }

    /// The diffuse lobe beside it, sr⁻¹, where Schlick's weight is `schlick`: glTF's gets what the highlight
    /// leaves, Cook and Torrance's is Lambert's.
    pub fn diffuse(self, schlick: f32) -> f32 {
        match self {
            Self::Ggx => FRAC_1_PI * (1.0 - schlick),
            Self::CookTorrance => FRAC_1_PI,
        }
    }
}

/// Schlick's weight (1 − v·h)⁵: how far Fresnel reflectance has gone from f₀ to 1.
pub fn schlick(cos_difference: f32) -> f32 {
    let x = 1.0 - cos_difference;
    x * x * x * x * x
}

/// D·V of roughness α² = `alpha_squared`, sr⁻¹: the Trowbridge-Reitz distribution times Smith's
/// height-correlated visibility, which holds the denominator 4 (n·l)(n·v). Bounded wherever one cosine is
/// above 0; 0 where both vanish.
pub fn distribution_visibility(alpha_squared: f32, angles: &Angles) -> f32 {
    let Angles { cos_half, cos_in, cos_out, .. } = *angles;
    let half_squared = cos_half * cos_half;
    // sin² + α² cos², and not 1 + (α² − 1) cos², which cancels at the peak.
    let spread = (1.0 - half_squared) + alpha_squared * half_squared;
    let smith = |cosine: f32| ((1.0 - cosine * cosine) * alpha_squared + cosine * cosine).sqrt();
    let visibility = cos_in * smith(cos_out) + cos_out * smith(cos_in);
    if visibility > 0.0 { 0.5 * FRAC_1_PI * alpha_squared / (spread * spread * visibility) } else { 0.0 }
}

/// Below this cosine a direction is in the surface: light from there carries nothing, and 1/cos² overflows.
const GRAZING: f32 = 1e-6;
/// Where e⁻ˣ leaves the range of normal numbers.
const DARK: f32 = 87.0;

/// D·V of Cook and Torrance (1981), sr⁻¹: Beckmann's distribution of facets of root mean square slope
/// `slope`, at most 1, e^(−tan²δ/m²)/(π m² cos⁴δ), times G/(4 (n·l)(n·v)) with the masking of V-shaped
/// grooves, G = min(1, 2 (n·h)(n·v)/(v·h), 2 (n·h)(n·l)/(v·h)). At most what is received is reflected (Heitz
/// 2014). 0 where both cosines vanish.
pub fn beckmann_grooves(slope: f32, angles: &Angles) -> f32 {
    let Angles { cos_half, cos_in, cos_out, .. } = *angles;
    let (half_squared, slope_squared) = (cos_half * cos_half, slope * slope);
    let tan_squared = (1.0 - half_squared) / half_squared;
    let exponent = tan_squared / slope_squared;
    let higher = cos_in.max(cos_out);
    // Neither is true of what is no number, as tan δ where there is no half vector.
    if !(exponent < DARK && higher > GRAZING) {
        return 0.0;
    }
    let inverse = 1.0 + tan_squared;
    let distribution = FRAC_1_PI * (-exponent).exp() * inverse * inverse / slope_squared;
    // As v·h = (n·l + n·v)/(2 n·h), no cosine is left alone in the denominator of the second.
    let open = 0.25 / (cos_in * cos_out);
    distribution * open.min(half_squared / ((cos_in + cos_out) * higher))
}
