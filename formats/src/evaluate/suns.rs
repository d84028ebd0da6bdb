//! Suns, which light surfaces directly: what each point of a picture receives of a sun is what an unshadowed
//! surface would, times the share of the sun's disc that is seen from there. How that share is found is not told
//! here: by rays, or by a shadow map.

use crate::basis::suns::Sun;
use crate::kinds::scene::EnvironmentLook;
use crate::state::Rgb;
use glam::Vec3;
use std::f32::consts::FRAC_1_PI;

/// The unit vector towards `sun` in world space, where its map is turned by `rotation_deg` about +Y,
/// counter-clockwise seen from above.
pub fn towards(sun: &Sun, rotation_deg: f32) -> Vec3 {
    let (sin, cos) = rotation_deg.to_radians().sin_cos();
    let Vec3 { x, y, z } = sun.direction;
    Vec3::new(cos * x + sin * z, y, cos * z - sin * x)
}

/// Linear radiance that a white diffuse surface with the unit shading `normal` shows of `sun`, W/(sr·m²), where
/// `visibility`, 0 to 1, is the share of its disc that is in sight and above the surface itself. Gain and rotation
/// of the map are those of `look`.
pub fn radiance(sun: &Sun, look: &EnvironmentLook, normal: Vec3, visibility: f32) -> Rgb {
    let cosine = normal.dot(towards(sun, look.rotation_deg)).max(0.0);
    std::array::from_fn(|c| sun.irradiance[c] * look.gain[c] * cosine * FRAC_1_PI * visibility)
}
