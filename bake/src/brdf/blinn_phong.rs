//! The analytic Blinn-Phong BRDF (thesis eq. 4-15): the truth that bases approximate.

use glam::Vec3A;
use relume_formats::state::BlinnPhong;
use std::f32::consts::{FRAC_1_PI, TAU};

/// BRDF value at half angle δ, sr⁻¹; `albedo` multiplies kd.
pub fn evaluate(material: &BlinnPhong, albedo: Vec3A, cos_delta: f32) -> Vec3A {
    let glossy = (material.shininess + 2.0) / TAU * cos_delta.powf(material.shininess);
    Vec3A::from(material.kd) * albedo * FRAC_1_PI + Vec3A::from(material.ks) * glossy
}

/// Share of light from straight above that the unit glossy lobe reflects: ∫ (s+2)/2π · cosˢδ · cos θ dω.
///
/// The thesis normalises the lobe over half vectors, and these spread a quarter as wide as the directions
/// they stand for; so the integral grows from 1.4 at s = 1 towards 4, and glossy materials may reflect more
/// than they receive although kd + ks ≤ 1.
pub fn glossy_albedo(shininess: f32) -> f32 {
    // With θ = 2δ and u = cos δ: 4(s+2) ∫ uˢ⁺¹ (2u² − 1) du from √½ to 1.
    let power_integral = |n: f64| (1.0 - 0.5f64.powf(n / 2.0)) / n;
    let s = f64::from(shininess);
    (4.0 * (s + 2.0) * (2.0 * power_integral(s + 4.0) - power_integral(s + 2.0))) as f32
}
