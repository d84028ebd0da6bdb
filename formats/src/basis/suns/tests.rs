//! Suns of maps with discs of known size and strength.

use super::*;

const SIZE: [u32; 2] = [512, 256];

/// A smooth sky with even discs of (direction, radius in degrees, radiance) on it, each texel the mean over 8 × 8 directions.
fn sky(discs: &[(Vec3, f64, Rgb)]) -> EquirectMap {
    let [width, height] = SIZE;
    let points = 8;
    let texel = |i: u32| {
        let mut sum = [0.0; 3];
        for k in 0..points * points {
            let at = |texel: u32, part: u32| f64::from(texel) + (f64::from(part) + 0.5) / f64::from(points);
            let (u, v) = (at(i % width, k % points), at(i / width, k / points));
            let (azimuth, polar) = (TAU * (u / f64::from(width) - 0.5), PI * v / f64::from(height));
            let direction =
                DVec3::new(polar.sin() * azimuth.sin(), polar.cos(), -polar.sin() * azimuth.cos());
            for (c, sum) in sum.iter_mut().enumerate() {
                *sum += 0.5 + 0.2 * direction.y + 0.1 * c as f64;
                for (towards, radius_deg, radiance) in discs {
                    if direction.dot(towards.as_dvec3()) > radius_deg.to_radians().cos() {
                        *sum += f64::from(radiance[c]);
                    }
                }
            }
        }
        sum.map(|sum| (sum / f64::from(points * points)) as f32)
    };
    EquirectMap { width, height, texels: (0..width * height).map(texel).collect() }
}

fn towards(azimuth_deg: f32, elevation_deg: f32) -> Vec3 {
    let ((sin_a, cos_a), (sin_e, cos_e)) =
        (azimuth_deg.to_radians().sin_cos(), elevation_deg.to_radians().sin_cos());
    Vec3::new(cos_e * sin_a, sin_e, -cos_e * cos_a)
}

/// ∫L·ω dω of each channel, by adding up the map at four by four points a texel.
fn vectors(map: &EquirectMap) -> [DVec3; 3] {
    let mut sums = [DVec3::ZERO; 3];
    let (columns, rows) = (4 * map.width, 4 * map.height);
    // Two points of Gauss in each half of a texel, for there interpolation is smooth.
    let point = |k: u32| f64::from(k / 2) + 0.5 + (f64::from(k % 2) - 0.5) / 3.0f64.sqrt();
    for y in 0..rows {
        let polar = PI * 2.0 * point(y) / f64::from(rows);
        let weight = polar.sin() * PI / f64::from(rows) * TAU / f64::from(columns);
        for x in 0..columns {
            let (u, v) = (2.0 * point(x) / f64::from(columns), polar / PI);
            let azimuth = TAU * (u - 0.5);
            let direction =
                DVec3::new(polar.sin() * azimuth.sin(), polar.cos(), -polar.sin() * azimuth.cos());
            let radiance = map.sample([u as f32, v as f32]);
            (0..3).for_each(|c| sums[c] += weight * f64::from(radiance[c]) * direction);
        }
    }
    sums
}

/// What is known of a disc: irradiance of a surface that faces it is radiance times π sin²; the size that is
/// found is larger by what texels blur.
#[track_caller]
fn expect_disc(sun: &Sun, (direction, radius_deg, radiance): (Vec3, f64, Rgb)) {
    // A tenth of a texel.
    assert!(sun.direction.dot(direction) > 0.07_f32.to_radians().cos(), "{sun:?} {direction}");
    for (radiance, irradiance) in radiance.into_iter().zip(sun.irradiance) {
        let expected = f64::from(radiance) * PI * radius_deg.to_radians().sin().powi(2);
        let found = f64::from(irradiance) / expected;
        // A disc of 1° is known by some 80 points of its texels, as far as these are concerned.
        assert!((found - 1.0).abs() < 0.02, "{found} of the irradiance");
    }
    let size = f64::from(sun.radius).to_degrees();
    let narrow = f64::from(direction.x.hypot(direction.z));
    let expected = radius_deg.hypot(STEP_DEG * (0.5 + 0.5 * narrow * narrow).sqrt());
    assert!((size / expected - 1.0).abs() < 0.05, "radius {size}, expected {expected}");
}

/// Height of a texel. The variance of its box and of the tent between centres is 1/12 + 1/6 of its square, and that
/// of a disc along an axis a quarter of its radius squared: so it blurs like a disc of as large a radius, less
/// along rows where these are narrow.
const STEP_DEG: f64 = 180.0 / 256.0;

#[test]
fn discs_are_found_as_they_are_wherever_they_stand() {
    // In the middle, where the map's ends meet, at the horizon, below, towards an edge of a cube, and at the pole.
    let places = [(0.0, 30.0), (180.0, 42.0), (-60.0, 0.0), (20.0, -50.0), (45.0, 20.0), (0.0, 89.9)];
    for (azimuth, elevation) in places {
        let disc = (towards(azimuth, elevation), 1.0, [900.0, 700.0, 400.0]);
        let map = sky(&[disc]);
        let Split { rest, suns } = split(&map);
        assert_eq!(suns.len(), 1, "{azimuth} {elevation}");
        // Around a pole a map of rows cannot show a disc as it is.
        if elevation < 80.0 {
            expect_disc(&suns[0], disc);
        }
        assert!(rest.texels.iter().flatten().all(|value| (0.0..1.0).contains(value)));
        // Both together are the map, for surfaces that face the sun, and to a part of its size for others.
        for (c, (whole, left)) in vectors(&map).into_iter().zip(vectors(&rest)).enumerate() {
            let direction = suns[0].direction.as_dvec3();
            let (irradiance, off) = (f64::from(suns[0].irradiance[c]), whole - left);
            assert!((off.dot(direction) / irradiance - 1.0).abs() < 1e-3, "{off} {irradiance}");
            assert!((off - irradiance * direction).length() < 3e-3 * irradiance);
        }
    }
}

#[test]
fn a_sun_of_one_texel_is_as_large_as_what_is_interpolated() {
    let mut map = sky(&[]);
    let texel = 60 * 512 + 300;
    map.texels[texel] = [2e4, 1e4, 5e3];
    let grid = Grid::new(&map);
    let direction = grid.direction(texel);
    let Split { rest, suns } = split(&map);
    assert_eq!(suns.len(), 1);
    assert!(suns[0].direction.as_dvec3().dot(direction) > 1.0 - 1e-6);
    // A pyramid: the mean square of its distance is that of a disc of √(4/3) half its base along the meridian,
    // and as far as it is narrower less along the other axis.
    let (step, narrow) = (STEP_DEG, direction.x.hypot(direction.z));
    let expected = ((1.0 + narrow * narrow) / 3.0_f64).sqrt() * step;
    let size = f64::from(suns[0].radius).to_degrees();
    assert!((size / expected - 1.0).abs() < 0.01, "{size} {expected}");
    let solid_angle = step.to_radians().powi(2) * narrow;
    let expected = 2e4 * solid_angle;
    assert!((f64::from(suns[0].irradiance[0]) / expected - 1.0).abs() < 1e-3);
    assert!(rest.texels.iter().zip(&map.texels).filter(|(a, b)| a != b).count() < 60);
}

#[test]
fn two_suns_are_two_the_stronger_first() {
    let (near, far) = ((towards(30.0, 40.0), 0.9, [800.0; 3]), (towards(35.2, 40.0), 0.9, [500.0; 3]));
    let opposite = (towards(-120.0, 10.0), 1.2, [600.0; 3]);
    let map = sky(&[near, far, opposite]);
    let Split { suns, .. } = split(&map);
    assert_eq!(suns.len(), 3, "{suns:?}");
    expect_disc(&suns[0], opposite);
    expect_disc(&suns[1], near);
    expect_disc(&suns[2], far);
    let many: Vec<_> =
        (0..6).map(|k| (towards(60.0 * k as f32, 30.0), 1.0, [500.0 + 50.0 * k as f32; 3])).collect();
    assert_eq!(split(&sky(&many)).suns.len(), MAX_SUNS);
    assert_eq!(split(&map), split(&map.clone()));
}

#[test]
fn what_is_no_sun_costs_nothing() {
    let large = sky(&[(towards(30.0, 40.0), 4.0, [400.0; 3])]);
    let faint = sky(&[(towards(30.0, 40.0), 0.8, [100.0; 3])]);
    let even = EquirectMap { width: 8, height: 4, texels: vec![[1.0; 3]; 32] };
    let black = EquirectMap { width: 8, height: 4, texels: vec![[0.0; 3]; 32] };
    let one = EquirectMap { width: 1, height: 1, texels: vec![[3.0; 3]] };
    // Too coarse for a sun: a texel measures 22°.
    let mut coarse = EquirectMap { width: 16, height: 8, texels: vec![[1.0; 3]; 128] };
    coarse.texels[40] = [1e6; 3];
    let mut bar = sky(&[]);
    (200..300).for_each(|x| bar.texels[90 * 512 + x] = [900.0; 3]);
    for map in [large, faint, even, black, one, coarse, bar] {
        let Split { rest, suns } = split(&map);
        assert!(suns.is_empty() && matches!(rest, Cow::Borrowed(_)), "{suns:?}");
    }
}

#[test]
fn the_integrals_of_all_texels_are_those_of_the_sphere() {
    for (width, height) in [(1, 1), (7, 2), (64, 32), (512, 256)] {
        let rows: Vec<_> = (0..height).map(|y| row_integrals(y, width, height)).collect();
        let sum = |k: usize| rows.iter().map(|row| row[k]).sum::<f64>() * width as f64;
        assert!((sum(0) / (4.0 * PI) - 1.0).abs() < 1e-9 && sum(1).abs() < 1e-9);
        // ∫ sin² dθ = π/2, and columns take turns.
        let column = TAU / width as f64;
        let shortened = 2.0 * (1.0 - column.cos()) / (column * column);
        assert!((sum(2) / (PI * PI * shortened) - 1.0).abs() < 1e-9 || shortened < 1e-9);
    }
}
