//! The microfacet terms of GGX that linear bases are combinations of.

use super::angles::Angles;
use std::f32::consts::FRAC_1_PI;

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
