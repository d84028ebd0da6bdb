//! Procedural environment maps, for scenes that need no downloads.

use glam::DVec3;
use relume_formats::basis::EquirectMap;
use std::f64::consts::{PI, TAU};

/// Names of the maps.
pub(crate) const NAMES: [&str; 2] = ["clear-sky", "lamps"];

const WIDTH: u32 = 512;
const HEIGHT: u32 = 256;

/// The map called `name`.
pub(crate) fn by_name(name: &str) -> Option<EquirectMap> {
    match name {
        "clear-sky" => Some(painted(clear_sky)),
        "lamps" => Some(painted(lamps)),
        _ => None,
    }
}

/// A map of the given radiance, each texel the mean over 4 × 4 directions.
fn painted(radiance: impl Fn(DVec3) -> DVec3) -> EquirectMap {
    let texel = |x: u32, y: u32| {
        let mut sum = DVec3::ZERO;
        for part in 0..16 {
            let (u, v) = (
                f64::from(x) + (f64::from(part % 4) + 0.5) / 4.0,
                f64::from(y) + (f64::from(part / 4) + 0.5) / 4.0,
            );
            let (azimuth, polar) = (TAU * (u / f64::from(WIDTH) - 0.5), PI * v / f64::from(HEIGHT));
            sum +=
                radiance(DVec3::new(polar.sin() * azimuth.sin(), polar.cos(), -polar.sin() * azimuth.cos()));
        }
        (sum / 16.0).as_vec3().to_array()
    };
    let texels = (0..WIDTH * HEIGHT).map(|i| texel(i % WIDTH, i / WIDTH)).collect();
    EquirectMap { width: WIDTH, height: HEIGHT, texels }
}

fn from_degrees(azimuth: f64, elevation: f64) -> DVec3 {
    let (azimuth, elevation) = (azimuth.to_radians(), elevation.to_radians());
    DVec3::new(elevation.cos() * azimuth.sin(), elevation.sin(), -elevation.cos() * azimuth.cos())
}

/// A blue sky over brown ground with a warm sun, 3° across so that half a degree of a real one is not asked
/// of a texel, which sends about as much light as the sky.
fn clear_sky(direction: DVec3) -> DVec3 {
    let (zenith, horizon, ground) =
        (DVec3::new(0.18, 0.34, 0.75), DVec3::new(0.75, 0.85, 1.0), DVec3::new(0.22, 0.19, 0.16));
    if direction.y < 0.0 {
        return ground;
    }
    let sky = horizon.lerp(zenith, direction.y.sqrt());
    let in_sun = direction.dot(from_degrees(-55.0, 42.0)) > 1.5_f64.to_radians().cos();
    sky + if in_sun { DVec3::new(1150.0, 980.0, 760.0) } else { DVec3::ZERO }
}

/// A dim studio: a large soft box on the left, a strip on the right, a small warm lamp behind.
fn lamps(direction: DVec3) -> DVec3 {
    let within = |azimuth, elevation, width: f64, height: f64| {
        let towards = from_degrees(azimuth, elevation);
        let right = DVec3::Y.cross(towards).normalize();
        let up = towards.cross(right);
        let (forward, x, y) = (direction.dot(towards), direction.dot(right), direction.dot(up));
        forward > 0.0 && x.abs() < width * forward && y.abs() < height * forward
    };
    let walls = DVec3::splat(0.04 + 0.03 * direction.y);
    if within(-70.0, 40.0, 0.35, 0.5) {
        DVec3::new(6.0, 6.2, 6.6)
    } else if within(80.0, 30.0, 0.06, 0.6) {
        DVec3::new(12.0, 12.0, 14.0)
    } else if direction.dot(from_degrees(170.0, 55.0)) > 3.0_f64.to_radians().cos() {
        DVec3::new(260.0, 180.0, 90.0)
    } else {
        walls
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Irradiance from above, by the texels' solid angles.
    fn irradiance(map: &EquirectMap, least: f32) -> f64 {
        let row = |y: u32| PI * f64::from(y) / f64::from(HEIGHT);
        let texel = |i: u32| {
            let (top, bottom) = (row(i / WIDTH), row(i / WIDTH + 1));
            let radiance = map.texels[i as usize][1];
            let projected = 0.5 * (bottom.sin().powi(2) - top.sin().powi(2)) * TAU / f64::from(WIDTH);
            if i / WIDTH < HEIGHT / 2 && radiance >= least { f64::from(radiance) * projected } else { 0.0 }
        };
        (0..WIDTH * HEIGHT).map(texel).sum()
    }

    #[test]
    fn sun_and_sky_send_what_their_formulas_say() {
        let map = by_name("clear-sky").unwrap();
        // Green of the sky: ∫(0.85 − 0.51√μ) μ 2π dμ = 2π(0.85/2 − 0.51/2.5); of the sun: radiance · solid
        // angle · cosine.
        let sky = TAU * (0.85 / 2.0 - 0.51 / 2.5);
        let sun = 980.0 * TAU * (1.0 - 1.5_f64.to_radians().cos()) * 42.0_f64.to_radians().sin();
        let total = irradiance(&map, 0.0);
        assert!((total / (sky + sun) - 1.0).abs() < 0.02, "{total} instead of {}", sky + sun);
        assert!(irradiance(&map, 100.0) > 0.8 * sun, "the sun is bright");
    }

    #[test]
    fn every_name_has_a_finite_map() {
        for name in NAMES {
            let map = by_name(name).unwrap();
            assert_eq!(map.texels.len(), (WIDTH * HEIGHT) as usize);
            assert!(map.texels.iter().flatten().all(|x| x.is_finite() && *x > 0.0));
        }
        assert!(by_name("dusk").is_none());
    }
}
