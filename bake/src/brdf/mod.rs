//! BRDF models, linear bases of their spaces, and sampling of their lobes.

pub mod basis;
pub mod blinn_phong;
pub mod cook_torrance;
pub mod ggx;
pub mod lobes;
pub mod tensor;

use glam::Vec3A;
use relume_formats::basis::Angles;
use relume_formats::state::Brdf;

/// What a BRDF needs to know of two unit directions at a surface with the unit shading normal `normal`.
pub fn angles(incoming: Vec3A, outgoing: Vec3A, normal: Vec3A) -> Angles {
    let half = (incoming + outgoing).normalize_or_zero();
    Angles {
        cos_half: half.dot(normal).clamp(0.0, 1.0),
        cos_difference: half.dot(outgoing).clamp(0.0, 1.0),
        cos_in: incoming.dot(normal).max(0.0),
        cos_out: outgoing.dot(normal).max(0.0),
    }
}

/// BRDF value, sr⁻¹. `albedo` is what a texture multiplies kd or the base colour with.
pub fn evaluate(material: &Brdf, albedo: Vec3A, angles: &Angles) -> Vec3A {
    match material {
        Brdf::BlinnPhong(material) => blinn_phong::evaluate(material, albedo, angles.cos_half),
        Brdf::Ggx(material) => ggx::evaluate(material, albedo, angles),
        Brdf::CookTorrance(material) => cook_torrance::evaluate(material, albedo, angles),
    }
}
