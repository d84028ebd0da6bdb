//! The analytic metallic-roughness BRDF, see [`Ggx`]: the truth that bases approximate.

use glam::Vec3A;
use relume_formats::basis::{Angles, microfacet};
use relume_formats::state::{DIELECTRIC_F0, Ggx};
use std::f32::consts::FRAC_1_PI;

/// BRDF value, sr⁻¹; `albedo` multiplies the base colour.
pub fn evaluate(material: &Ggx, albedo: Vec3A, angles: &Angles) -> Vec3A {
    let base = Vec3A::from(material.base_color) * albedo;
    let metallic = material.metallic;
    let f0 = Vec3A::splat(DIELECTRIC_F0 * (1.0 - metallic)) + base * metallic;
    let fresnel = f0 + (Vec3A::ONE - f0) * microfacet::schlick(angles.cos_difference);
    let diffuse = (Vec3A::ONE - fresnel) * base * ((1.0 - metallic) * FRAC_1_PI);
    let alpha = material.roughness * material.roughness;
    diffuse + fresnel * microfacet::distribution_visibility(alpha * alpha, angles)
}
