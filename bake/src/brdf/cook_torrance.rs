//! The analytic BRDF of Cook and Torrance, see [`CookTorrance`]: the truth that bases approximate.

use glam::Vec3A;
use relume_formats::basis::{Angles, microfacet};
use relume_formats::state::CookTorrance;
use std::f32::consts::FRAC_1_PI;

/// BRDF value, sr⁻¹; `albedo` multiplies kd.
pub fn evaluate(material: &CookTorrance, albedo: Vec3A, angles: &Angles) -> Vec3A {
    let CookTorrance { kd, ks, fresnel, roughness } = *material;
    let reflectance = fresnel + (1.0 - fresnel) * microfacet::schlick(angles.cos_difference);
    let glossy = reflectance * microfacet::beckmann_grooves(roughness, angles);
    Vec3A::from(kd) * albedo * FRAC_1_PI + Vec3A::from(ks) * glossy
}
