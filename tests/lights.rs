//! Lights are chosen by what of them arrives: those that do not cost no samples.

use crate::support::{render, scene};
use relume_bake::trace::reference::Paths;
use relume_scenes::Scene;

/// A room of 2 m, closed on all sides, with the camera in it.
const CELL: &str = "
    [render]
    size = [24, 24]
    [camera]
    position = [0.0, 1.0, 0.95]
    target = [0.0, 0.9, 0.0]
    fov_deg = 70.0
    [materials.m]
    brdf = 'blinn-phong'
    kd = [0.5, 0.5, 0.5]
    [[object]]
    name = 'walls'
    shape = 'box'
    material = 'm'
    transform = { translation = [0.0, 1.0, 0.0], scale = 2.0 }
";
/// The size of a candle's flame.
const CANDLE: &str = "
    [[light]]
    name = 'candle'
    kind = 'area'
    radiance = [900.0, 700.0, 400.0]
    transform = { translation = [0.3, 0.5, -0.2], rotation_deg = [0.0, 40.0, 0.0], scale = 0.02 }
";
const SUN: &str = "
    [[light]]
    name = 'sun'
    kind = 'directional'
    transform = { rotation_deg = [-70.0, 30.0, 0.0] }
    irradiance = [1000.0, 1000.0, 1000.0]
";
const PLAIN: &str = "
    [render]
    size = [24, 24]
    [camera]
    position = [0.0, 1.5, 4.0]
    target = [0.0, 0.3, 0.0]
    fov_deg = 40.0
    [materials.m]
    brdf = 'blinn-phong'
    kd = [0.5, 0.5, 0.5]
    [[object]]
    name = 'plain'
    shape = 'quad'
    material = 'm'
    transform = { scale = 400.0 }
    [[object]]
    name = 'stone'
    shape = 'sphere'
    material = 'm'
    transform = { translation = [0.0, 0.4, 0.0], scale = 0.4 }
";
const BULB: &str = "
    [[light]]
    name = 'bulb'
    kind = 'point'
    transform = { translation = [0.9, 1.2, 0.6] }
    intensity = [2.0, 2.0, 2.0]
";
const SKY: &str = "
    [environment]
    gain = [0.02, 0.02, 0.03]
";

fn image(scene: &Scene, samples: u32, paths: Paths, seed: u64) -> Vec<[f32; 3]> {
    render(scene, [24, 24], samples, 2, paths, seed).radiance
}

/// Mean square of what 64 samples are off by, over that of the truth, `truth` having far more.
fn noise(scene: &Scene, truth: &[[f32; 3]], paths: Paths) -> f64 {
    let squares = |a: &[[f32; 3]], b: &[[f32; 3]]| -> f64 {
        a.iter().flatten().zip(b.iter().flatten()).map(|(a, b)| f64::from(a - b).powi(2)).sum()
    };
    let black = vec![[0.0; 3]; truth.len()];
    let error: f64 = (1..5).map(|seed| squares(&image(scene, 64, paths, seed), truth)).sum();
    error / 4.0 / squares(truth, &black)
}

fn sum(a: &[[f32; 3]], b: &[[f32; 3]]) -> Vec<[f32; 3]> {
    a.iter().zip(b).map(|(a, b)| std::array::from_fn(|k| a[k] + b[k])).collect()
}

/// A candle in a closed room under a sun outside is nearly as free of noise as without the sun: few samples
/// look at what was never seen.
#[test]
fn a_sun_that_reaches_nothing_costs_next_to_nothing() {
    let [alone, under_a_sun] =
        [CELL.to_owned() + CANDLE, CELL.to_owned() + CANDLE + SUN].map(|text| scene(&text));
    for paths in [Paths::Best, Paths::Gather] {
        let truth = image(&alone, 4096, paths, 9);
        let [least, found] = [&alone, &under_a_sun].map(|scene| noise(scene, &truth, paths));
        println!("{paths:?}: {found:.6} with the sun, {least:.6} without");
        // By power, one sample in some 10⁵ would look at the candle.
        assert!(found < 1.5 * least, "{found} {least}");
    }
}

/// A bulb over a wide plain under a dim sky: a sample looks at one of the two, so at best the noise is the sum
/// of what either has alone, of which each gets a part of the samples.
#[test]
fn a_bulb_stands_its_chance_beside_a_sky() {
    let [bulb, sky, both] = [BULB.to_owned(), SKY.to_owned(), BULB.to_owned() + SKY]
        .map(|lights| scene(&(PLAIN.to_owned() + &lights)));
    for paths in [Paths::Best, Paths::Gather] {
        let truths = [&bulb, &sky].map(|scene| image(scene, 4096, paths, 9));
        let truth = sum(&truths[0], &truths[1]);
        let squares = |image: &[[f32; 3]]| image.iter().flatten().map(|v| f64::from(*v).powi(2)).sum::<f64>();
        let least: f64 = [&bulb, &sky]
            .iter()
            .zip(&truths)
            .map(|(scene, truth_of)| noise(scene, truth_of, paths) * squares(truth_of) / squares(&truth))
            .sum();
        let found = noise(&both, &truth, paths);
        println!("{paths:?}: {found:.6} together, {least:.6} apart");
        // By power, one sample in thousands would look at the bulb.
        assert!(found < 4.0 * least, "{found} {least}");
    }
}
