//! Lights are chosen by what of them arrives: those that do not cost no samples.

use crate::support::{render, scene};
use relume_bake::trace::reference::Paths;
use relume_scenes::Scene;

const CANDLE: &str = include_str!("../bake/examples/lights/candle.toml");
const BULB: &str = include_str!("../bake/examples/lights/bulb.toml");

/// What stands before `first`.
fn before<'a>(text: &'a str, first: &str) -> &'a str {
    &text[..text.rfind(first).unwrap()]
}

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
    let [alone, under_a_sun] = [before(CANDLE, "[[light]]"), CANDLE].map(scene);
    for paths in [Paths::Best, Paths::Gather] {
        let truth = image(&alone, 4096, paths, 9);
        let [least, found] = [&alone, &under_a_sun].map(|scene| noise(scene, &truth, paths));
        println!("{paths:?}: {found:.6} with the sun, {least:.6} without");
        // By power, one sample in some 10⁴ would look at the candle.
        assert!(found < 1.5 * least, "{found} {least}");
    }
}

/// A bulb over a wide plain under a dim sky: a sample looks at one of the two, so at best the noise is the sum
/// of what either has alone, of which each gets a part of the samples.
#[test]
fn a_bulb_stands_its_chance_beside_a_sky() {
    let lit_by_bulb = before(BULB, "[environment]");
    let under_the_sky = before(BULB, "[[light]]").to_owned() + &BULB[lit_by_bulb.len()..];
    let [bulb, sky, both] = [lit_by_bulb, &under_the_sky, BULB].map(scene);
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
