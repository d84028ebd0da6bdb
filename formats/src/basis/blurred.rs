//! Environment maps as broad cones see them: filtered by Gaussians of the angle.

use super::EquirectMap;
use super::cubemap::{self, FACES};
use crate::state::Rgb;
use glam::Vec3;
use std::f32::consts::{FRAC_1_PI, PI, TAU};

/// Standard deviations up to which texels count.
const REACH: f32 = 4.0;

/// Columns and rows of what [`blurred`] makes for `width_deg`.
pub fn size(width_deg: f32) -> [u32; 2] {
    let width = ((400.0 / width_deg).ceil() as u32).next_power_of_two().clamp(32, 256);
    [width, width / 2]
}

/// `map` filtered by a Gaussian of the angle with a standard deviation of `width_deg` degrees, which is above 0: some
/// 1.1 to 2.2 texels to a deviation. What is filtered is the map on a cube of texels half as wide as that, so that
/// suns are to be taken out of it first.
pub fn blurred(map: &EquirectMap, width_deg: f32) -> EquirectMap {
    let side = ((180.0 / width_deg).ceil() as usize).next_power_of_two().clamp(8, 64);
    let [width, height] = size(width_deg).map(|texels| texels as usize);
    let texels = by_height(&cubemap::from_equirect(map, 0.0, side), side);
    let sigma = width_deg.to_radians();
    let row = |row: usize| {
        let height_of = |theta: f32| theta.clamp(0.0, PI).cos();
        let theta = PI * (row as f32 + 0.5) / height as f32;
        let [least, most] = [theta + REACH * sigma, theta - REACH * sigma].map(height_of);
        let band = texels.partition_point(|t| t.0.y < least)..texels.partition_point(|t| t.0.y <= most);
        let near = &texels[band];
        (0..width).map(move |column| {
            let phi = TAU * ((column as f32 + 0.5) / width as f32 - 0.5);
            let (sin, cos) = theta.sin_cos();
            mean_about(Vec3::new(sin * phi.sin(), cos, -sin * phi.cos()), sigma, near)
        })
    };
    EquirectMap { width: width as u32, height: height as u32, texels: (0..height).flat_map(row).collect() }
}

/// The texels of a cube by their height: direction, solid angle, radiance.
fn by_height(cube: &[Rgb], side: usize) -> Vec<(Vec3, f32, Vec3)> {
    let solid_angles = cubemap::solid_angles(side);
    let texel = |(index, radiance): (usize, &Rgb)| {
        let (face, within) = (index / (side * side), index % (side * side));
        let [x, y] = [within % side, within / side].map(|c| c as f64 + 0.5);
        let direction = cubemap::direction(face, side, x, y).as_vec3();
        (direction, solid_angles[within] as f32, Vec3::from(*radiance))
    };
    let mut texels: Vec<_> = cube.iter().take(FACES * side * side).enumerate().map(texel).collect();
    texels.sort_by(|a, b| a.0.y.total_cmp(&b.0.y));
    texels
}

fn mean_about(direction: Vec3, sigma: f32, texels: &[(Vec3, f32, Vec3)]) -> Rgb {
    let least = (REACH * sigma).min(PI).cos();
    let (mut sum, mut total) = (Vec3::ZERO, 0.0);
    for (towards, solid_angle, radiance) in texels {
        let cosine = direction.dot(*towards);
        if cosine > least {
            // The angle by its chord: 2·asin(|a − b|/2).
            let angle = 2.0 * (0.5 * (2.0 - 2.0 * cosine).max(0.0).sqrt()).min(1.0).asin();
            let weight = solid_angle * (-0.5 * (angle / sigma) * (angle / sigma)).exp();
            (sum, total) = (sum + weight * *radiance, total + weight);
        }
    }
    if total > 0.0 { (sum / total).to_array() } else { [0.0; 3] }
}

/// The radiance of `map`, turned by `rotation_deg` about +Y, counter-clockwise seen from above, from the unit vector
/// `direction` in world space.
pub fn radiance(map: &EquirectMap, rotation_deg: f32, direction: Vec3) -> Rgb {
    let (sin, cos) = rotation_deg.to_radians().sin_cos();
    let Vec3 { x, y, z } = direction;
    let (x, z) = (cos * x - sin * z, cos * z + sin * x);
    map.sample([0.5 + x.atan2(-z) * (0.5 * FRAC_1_PI), (x * x + z * z).sqrt().atan2(y) * FRAC_1_PI])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn map(width: u32, radiance: impl Fn(Vec3) -> f32) -> EquirectMap {
        let texel = |i: u32| {
            let (u, v) = ((i % width) as f32 + 0.5, (i / width) as f32 + 0.5);
            let (phi, theta) = (TAU * (u / width as f32 - 0.5), TAU * v / width as f32);
            let direction = Vec3::new(theta.sin() * phi.sin(), theta.cos(), -theta.sin() * phi.cos());
            [radiance(direction), 1.0, 0.0]
        };
        EquirectMap { width, height: width / 2, texels: (0..width * width / 2).map(texel).collect() }
    }

    /// A spherical harmonic of band l shrinks by e^(−l(l+1)σ²/2) under the heat kernel, which a Gaussian of the angle is but for
    /// curvature: σ²/12 of itself in the exponent, 0.02 here.
    #[test]
    fn linear_light_shrinks_as_the_heat_kernel_has_it() {
        let axis = Vec3::new(0.48, 0.6, 0.64);
        let linear = map(512, |d| 1.0 + d.dot(axis));
        for width_deg in [3.0f32, 6.0, 12.0, 24.0] {
            let (found, sigma) = (blurred(&linear, width_deg), width_deg.to_radians());
            let shrunk = (-sigma * sigma).exp();
            for step in 0..40 {
                let (z, phi) = (1.0 - 2.0 * (step as f32 + 0.5) / 40.0, 2.4 * step as f32);
                let r = (1.0f32 - z * z).sqrt();
                let direction = Vec3::new(r * phi.cos(), z, r * phi.sin());
                let [red, green, blue] = radiance(&found, 0.0, direction);
                let expected = 1.0 + shrunk * direction.dot(axis);
                assert!((red - expected).abs() < 0.012, "{width_deg} {direction}: {red} for {expected}");
                assert!((green - 1.0).abs() < 1e-5 && blue == 0.0);
            }
        }
    }

    #[test]
    fn a_turned_map_shows_what_a_turned_direction_sees() {
        let warm = blurred(&map(128, |d| (1.0 + d.x).powi(4)), 6.0);
        for turn in [30.0f32, 90.0, -135.0] {
            let (sin, cos) = turn.to_radians().sin_cos();
            // +X turned counter-clockwise seen from above.
            let turned = Vec3::new(cos, 0.0, -sin);
            let [found, there] = [radiance(&warm, turn, turned)[0], radiance(&warm, 0.0, Vec3::X)[0]];
            assert!((found - there).abs() < 0.01 * there, "{turn}: {found} for {there}");
        }
    }
}
