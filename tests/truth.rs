//! The tracer against closed forms.

use crate::support::{mean_radiance, render, scene};
use glam::Vec3A;
use relume_bake::brdf::blinn_phong::glossy_albedo;
use relume_bake::trace::reference::Paths;
use std::f64::consts::PI;

fn v(x: f32, y: f32, z: f32) -> Vec3A {
    Vec3A::new(x, y, z)
}

/// One object of one material under a white sky.
fn under_white_sky(shape: &str, kd: f32, ks: f32, shininess: f32) -> String {
    format!(
        "[camera]\nposition = [0, 0.3, 4]\ntarget = [0, 0, 0]\nfov_deg = 30\n[render]\nsize = [24, 24]\n[environment]\ngain = [1, 1, 1]\n\
         [materials.m]\nbrdf = 'blinn-phong'\nkd = [{kd}, {kd}, {kd}]\nks = [{ks}, {ks}, {ks}]\nshininess = {shininess}\n\
         [[object]]\nname = 'o'\nmaterial = 'm'\nshape = '{shape}'\n"
    )
}

/// Everything white in a white sky looks as if it was not there.
#[test]
fn white_furnace() {
    // A box has its shading normals where its faces are; smooth ones lose or gain at the silhouette, which is a known fault of all shading normals.
    let text = under_white_sky("box", 1.0, 0.0, 1.0);
    for paths in [Paths::Best, Paths::Gather] {
        let reflections = if paths == Paths::Best { 50 } else { 2 };
        let image = render(&scene(&text), [24, 24], 64, reflections, paths, 1);
        for (radiance, variance) in image.radiance.iter().flatten().zip(image.variance.iter().flatten()) {
            assert!((radiance - 1.0).abs() < 6.0 * variance.sqrt() + 1e-4, "{paths:?}: {radiance} ± {}", variance.sqrt());
        }
        let n = image.radiance.as_flattened().len() as f32;
        let mean = image.radiance.iter().flatten().sum::<f32>() / n;
        // Channels are alike, so a third of the values are independent.
        let error = image.variance.iter().flatten().sum::<f32>().sqrt() / n * 3.0f32.sqrt();
        assert!((mean - 1.0).abs() < 4.0 * error + 1e-4 && error < 0.003, "{paths:?}: mean {mean} ± {error}");
    }
    // Concave: two boxes that face each other across a slit, light going back and forth many times.
    let two = text.clone()
        + "transform = { translation = [-0.55, 0, 0] }\n[[object]]\nname = 'p'\nmaterial = 'm'\nshape = 'box'\ntransform = { translation = [0.55, 0, 0] }\n";
    let (mean, error) =
        mean_radiance(&scene(&two), 10_000, 20_000, |[x, y]| (v(0.0, 0.0, 2.0), v(0.2 * (x - 0.5), 0.3 * (y - 0.5), -1.0).normalize()));
    assert!((mean - 1.0).abs() < 4.0 * error + 1e-3, "{mean} ± {error}");
}

/// The glossy lobe under a white sky reflects its albedo, which has a closed form straight from above.
#[test]
fn glossy_albedo_from_above() {
    for shininess in [1.0, 5.0, 50.0, 200.0] {
        let scene = scene(&under_white_sky("quad", 0.0, 0.5, shininess));
        let (mean, error) = mean_radiance(&scene, 1, 1 << 16, |[x, y]| (v(0.1 * x, 1.0, 0.1 * y), Vec3A::NEG_Y));
        let expected = 0.5 * f64::from(glossy_albedo(shininess));
        assert!((mean - expected).abs() < 4.0 * error + 1e-4 * expected, "s = {shininess}: {mean} ± {error}, expected {expected}");
    }
}

const LIT_FLOOR: &str = "
    [camera]
    position = [0.3, 0.5, 0.2]
    target = [0.3, 0.0, 0.2001]
    fov_deg = 0.1
    [render]
    size = [1, 1]
    [materials.m]
    brdf = 'blinn-phong'
    kd = [0.8, 0.8, 0.8]
    [[object]]
    name = 'floor'
    material = 'm'
    shape = 'quad'
    transform = { scale = 10.0 }
    [[light]]
    name = 'lamp'
    kind = 'area'
    radiance = [2.0, 2.0, 2.0]
    transform = { translation = [0.0, 1.0, 0.0], rotation_deg = [-90.0, 0.0, 0.0] }
";

/// Irradiance from a polygon of radiance 1 by Lambert's formula: ½ Σ angle of each edge × normal component of its plane.
fn polygon_irradiance(point: [f64; 3], corners: &[[f64; 3]]) -> f64 {
    let unit = |c: &[f64; 3]| {
        let d = [c[0] - point[0], c[1] - point[1], c[2] - point[2]];
        let length = d.iter().map(|x| x * x).sum::<f64>().sqrt();
        d.map(|x| x / length)
    };
    let edge = |(i, a): (usize, &[f64; 3])| {
        let (a, b) = (unit(a), unit(&corners[(i + 1) % corners.len()]));
        let cross = [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
        let sine = cross.iter().map(|x| x * x).sum::<f64>().sqrt();
        let cosine = a.iter().zip(b).map(|(x, y)| x * y).sum::<f64>();
        sine.atan2(cosine) * cross[1] / sine
    };
    0.5 * corners.iter().enumerate().map(edge).sum::<f64>().abs()
}

/// A floor point under a square lamp, against Lambert's polygon formula, for both kinds of paths.
#[test]
fn area_light_irradiance() {
    let lamp = [[-0.5, 1.0, -0.5], [0.5, 1.0, -0.5], [0.5, 1.0, 0.5], [-0.5, 1.0, 0.5]];
    let expected = 0.8 / PI * 2.0 * polygon_irradiance([0.3, 0.0, 0.2], &lamp);
    for paths in [Paths::Best, Paths::Gather] {
        let image = render(&scene(LIT_FLOOR), [1, 1], 1 << 16, 1, paths, 3);
        let radiance = f64::from(image.radiance[0][0]);
        // The variance is an upper bound; stratification makes the true error smaller still. 1e-4 is the spread of the footprint.
        let sigma = f64::from(image.variance[0][0]).sqrt();
        assert!(
            (radiance - expected).abs() < 4.0 * sigma + 1e-4 * expected && sigma < 0.01 * expected,
            "{radiance}, expected {expected} ± {sigma}"
        );
    }
}

/// Point and directional lights: inverse square and cosine by hand.
#[test]
fn point_and_directional_irradiance() {
    let without_lamp = LIT_FLOOR.split("[[light]]").next().unwrap();
    let point = "[[light]]\nname = 'p'\nkind = 'point'\nintensity = [3.0, 3.0, 3.0]\ntransform = { translation = [0.3, 2.0, 1.7] }\n";
    let sun =
        "[[light]]\nname = 's'\nkind = 'directional'\nirradiance = [5.0, 5.0, 5.0]\ntransform = { rotation_deg = [-30.0, 0.0, 0.0] }\n";
    // Light at height 2, 1.5 aside; the sun 30° above the horizon.
    let by_point = 3.0 * 2.0 / (2.0f64.powi(2) + 1.5f64.powi(2)).powf(1.5);
    let by_sun = 5.0 * 0.5;
    for (light, irradiance) in [(point.to_owned(), by_point), (sun.to_owned(), by_sun), (format!("{point}{sun}"), by_point + by_sun)] {
        let image = render(&scene(&format!("{without_lamp}{light}")), [1, 1], 1 << 14, 1, Paths::Gather, 3);
        let (radiance, expected) = (f64::from(image.radiance[0][0]), 0.8 / PI * irradiance);
        let sigma = f64::from(image.variance[0][0]).sqrt();
        assert!((radiance - expected).abs() < 4.0 * sigma + 2e-4 * expected, "{radiance}, expected {expected} ± {sigma}");
    }
}

/// Two parallel unit squares at distance 1 exchange the share 0.19982 (Howell's catalogue C-11).
#[test]
fn form_factor_of_parallel_squares() {
    let text = LIT_FLOOR
        .replace("scale = 10.0", "scale = 1.0")
        .replace("radiance = [2.0, 2.0, 2.0]", "radiance = [1, 1, 1]")
        .replace("0.8, 0.8, 0.8", "1, 1, 1");
    let (mean, error) = mean_radiance(&scene(&text), 1, 1 << 17, |[x, y]| (v(x - 0.5, 0.5, y - 0.5), Vec3A::NEG_Y));
    // The mean over the square of E/π with unit radiance is the form factor itself.
    assert!((mean - 0.199_82).abs() < 4.0 * error + 2e-5, "{mean} ± {error}");
    assert!(error < 1e-3);
}

/// No light comes from nowhere: materials that reflect at most what they receive stay below the sky's radiance, whatever the geometry.
#[test]
fn energy_is_never_gained() {
    for (kd, shininess) in [(0.3, 1.0), (0.2, 20.0), (0.0, 200.0)] {
        let ks = (1.0 - kd) / glossy_albedo(shininess);
        let text = under_white_sky("box", kd, ks, shininess)
            + "transform = { translation = [-0.6, 0, 0] }\n[[object]]\nname = 'p'\nmaterial = 'm'\nshape = 'box'\ntransform = { translation = [0.6, 0.2, 0.1] }\n";
        let image = render(&scene(&text), [24, 24], 256, 40, Paths::Best, 5);
        for (radiance, variance) in image.radiance.iter().flatten().zip(image.variance.iter().flatten()) {
            assert!(*radiance <= 1.0 + 5.0 * variance.sqrt() + 1e-3, "kd {kd}, s {shininess}: {radiance} ± {}", variance.sqrt());
        }
    }
}

/// Both estimators must agree where both apply: two reflections in a room with glossy walls.
#[test]
fn best_and_gather_paths_agree() {
    let scene = crate::support::library_scene("cornell-knot");
    let best = render(&scene, [32, 32], 1024, 2, Paths::Best, 1);
    let gather = render(&scene, [32, 32], 1024, 2, Paths::Gather, 2);
    let (mut statistic, mut count) = (0.0, 0);
    for (((a, va), b), vb) in best.radiance.iter().zip(&best.variance).zip(&gather.radiance).zip(&gather.variance) {
        for channel in 0..3 {
            let variance = f64::from(va[channel] + vb[channel]);
            if variance > 1e-12 {
                statistic += f64::from(a[channel] - b[channel]).powi(2) / variance;
                count += 1;
            }
        }
    }
    // Variances are upper bounds, so the mean of z² is at most 1 plus its own noise (channels share paths: a third as many are independent).
    let mean = statistic / f64::from(count);
    assert!(mean < 1.0 + 5.0 * (2.0 / (f64::from(count) / 3.0)).sqrt(), "mean z² = {mean} over {count} channels");
}
