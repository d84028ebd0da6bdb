//! Paths that look where light was seen to come from: right all the same, and less noisy for it.

use relume_bake::brdf;
use relume_bake::guided;
use relume_bake::trace::gather::{Gather, GatherPath};
use relume_bake::trace::lights::Lights;
use relume_bake::trace::reference::radiance_of;
use relume_bake::trace::world::World;
use relume_formats::state::Brdf;
use relume_scenes::Scene;

const SIZE: [u32; 2] = [24, 24];
const SAMPLES: u32 = 1024;

/// Mean and variance of the mean, pixel by pixel, of the channels' mean.
fn moments(scene: &Scene, gather: &Gather<'_>) -> Vec<[f64; 2]> {
    let brdf = |m: u32, albedo, angles: &_| brdf::evaluate(&scene.materials[m as usize].brdf, albedo, angles);
    let radiance = |path: &GatherPath| f64::from(radiance_of(path, brdf).element_sum()) / 3.0;
    let pixel = |pixel| {
        let (mut sum, mut squares) = (0.0, 0.0);
        gather.pixel(pixel, SAMPLES, |path| {
            let value = radiance(path);
            sum += value;
            squares += value * value;
        });
        let n = f64::from(SAMPLES);
        [sum / n, (squares / n - (sum / n).powi(2)) / (n - 1.0)]
    };
    (0..SIZE[0] * SIZE[1]).map(pixel).collect()
}

/// The ring's caustic, the ring polished and the plane matt: plain and guided paths have the same mean, of
/// which guided ones know far more.
#[test]
fn guided_paths_find_a_caustic_and_stay_right() {
    let mut scene = relume_scenes::load(&relume_scenes::resolve("ring").unwrap()).unwrap();
    scene.reflections = 2;
    for (index, material) in scene.materials.iter_mut().enumerate() {
        if let Brdf::BlinnPhong(m) = &mut material.brdf {
            m.shininess = if scene.vary.materials[0] == index { 180.0 } else { 5.0 };
        }
    }
    let world = World::new(&scene);
    let lights = Lights::new(&scene, &world);
    let plain = moments(&scene, &Gather::new(&scene, &world, &lights, SIZE, 2, 1));
    let guided = moments(&scene, &guided::gather(&scene, &world, &lights, SIZE, SAMPLES, 2, 2));

    let variance = |of: &[[f64; 2]]| of.iter().map(|[_, variance]| variance).sum::<f64>();
    let saved = variance(&plain) / variance(&guided);
    println!("a guide is worth {saved:.2} times the samples");
    assert!(saved > 2.0, "{saved}");

    // Of independent estimates the difference is as large as their variances say, over the image and pixel by
    // pixel; samples are stratified, so that these are upper bounds.
    let sum = |of: &[[f64; 2]]| of.iter().map(|[mean, _]| mean).sum::<f64>();
    let all = (sum(&plain) - sum(&guided)) / (variance(&plain) + variance(&guided)).sqrt();
    assert!(all.abs() < 4.0, "{all} standard errors");
    let squares = plain.iter().zip(&guided).map(|([a, va], [b, vb])| (a - b).powi(2) / (va + vb + 1e-20));
    let mean = squares.sum::<f64>() / plain.len() as f64;
    println!("{all:.2} standard errors over the image, mean square {mean:.2} by pixel");
    assert!(mean < 1.2, "{mean}");
}

/// What one pixel's paths find depends on neither threads nor what was traced before.
#[test]
fn guides_are_the_same_at_any_number_of_threads() {
    let scene = relume_scenes::load(&relume_scenes::resolve("cornell-knot").unwrap()).unwrap();
    let world = World::new(&scene);
    let lights = Lights::new(&scene, &world);
    let by = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| moments(&scene, &guided::gather(&scene, &world, &lights, SIZE, 64, 2, 1)))
    };
    assert_eq!(by(1), by(3));
}
