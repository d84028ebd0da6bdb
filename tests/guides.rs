//! Paths that look where light was seen to come from: right all the same, and less noisy for it.

use crate::support::{job, library_scene, scene};
use glam::Vec3A;
use relume_bake::brdf;
use relume_bake::guided::{self, Settings};
use relume_bake::trace::gather::{Gather, GatherPath};
use relume_bake::trace::guide::{FilmTally, Guide};
use relume_bake::trace::lights::Lights;
use relume_bake::trace::reference::radiance_of;
use relume_bake::trace::spot::Spot;
use relume_bake::trace::world::World;
use relume_formats::state::Brdf;
use relume_scenes::Scene;

const SIZE: [u32; 2] = [24, 24];
const SAMPLES: u32 = 4096;

fn guided<'a>(scene: &Scene, world: &'a World, lights: &'a Lights, samples: u32, seed: u64) -> Gather<'a> {
    let settings = Settings { size: SIZE, samples, reflections: 2, seed, target: None };
    guided::gather(scene, world, lights, &settings, &job()).unwrap()
}

/// Mean and variance of the mean, pixel by pixel, of the channels' mean.
fn moments(scene: &Scene, gather: &Gather<'_>, samples: u32) -> Vec<[f64; 2]> {
    let brdf = |spot: &Spot, angles: &_| {
        brdf::evaluate(&scene.materials[spot.material as usize].brdf, spot.albedo, angles)
    };
    let radiance = |path: &GatherPath| f64::from(radiance_of(path, brdf).element_sum()) / 3.0;
    let pixel = |pixel| {
        let (mut sum, mut squares) = (0.0, 0.0);
        gather.pixel(pixel, samples, |path| {
            let value = radiance(path);
            sum += value;
            squares += value * value;
        });
        let n = f64::from(samples);
        [sum / n, (squares / n - (sum / n).powi(2)) / (n - 1.0)]
    };
    (0..SIZE[0] * SIZE[1]).map(pixel).collect()
}

/// The ring's caustic, the ring polished and the plane matt: plain and guided paths have the same mean, of
/// which guided ones know far more.
#[test]
fn guided_paths_find_a_caustic_and_stay_right() {
    let mut scene = library_scene("ring");
    scene.reflections = 2;
    for (index, material) in scene.materials.iter_mut().enumerate() {
        if let Brdf::BlinnPhong(m) = &mut material.brdf {
            m.shininess = if scene.vary.materials[0] == index { 180.0 } else { 5.0 };
        }
    }
    let world = World::new(&scene);
    let lights = Lights::new(&scene, &world);
    let plain = moments(&scene, &Gather::new(&scene, &world, &lights, SIZE, 2, 1), SAMPLES);
    let found = moments(&scene, &guided(&scene, &world, &lights, SAMPLES, 2), SAMPLES);

    let variance = |of: &[[f64; 2]]| of.iter().map(|[_, variance]| variance).sum::<f64>();
    let saved = variance(&plain) / variance(&found);
    println!("a guide is worth {saved:.2} times the samples");
    assert!(saved > 2.0, "{saved}");

    // Of independent estimates the difference is as large as their variances say, over the image and pixel by
    // pixel; samples are stratified, so that these are upper bounds.
    let sum = |of: &[[f64; 2]]| of.iter().map(|[mean, _]| mean).sum::<f64>();
    let all = (sum(&plain) - sum(&found)) / (variance(&plain) + variance(&found)).sqrt();
    assert!(all.abs() < 4.0, "{all} standard errors");
    let squares = plain.iter().zip(&found).map(|([a, va], [b, vb])| (a - b).powi(2) / (va + vb + 1e-20));
    let mean = squares.sum::<f64>() / plain.len() as f64;
    println!("{all:.2} standard errors over the image, mean square {mean:.2} by pixel");
    assert!(mean < 1.2, "{mean}");
}

/// A guide that looks where nothing is, before a sky and a lamp that paths find in both ways: boxes in a white
/// sky look as if they were not there, and a lamp's light is what it is without a guide.
#[test]
fn no_guide_changes_what_is_seen() {
    let mut tally = FilmTally::default();
    for k in 0..4096 {
        let place = [(k % 64) as f32 / 64.0, (k / 64) as f32 / 64.0];
        for (normal, way) in [(Vec3A::Y, 1.0), (Vec3A::Z, 1.0), (Vec3A::X, -1.0), (Vec3A::NEG_X, 0.3)] {
            tally.add(place, normal, Vec3A::new(way, 0.6, 0.7).normalize(), 1.0);
        }
    }
    for (light, is_furnace) in [
        ("[environment]\ngain = [1, 1, 1]\n", true),
        (
            "[[light]]\nname = 'lamp'\nkind = 'area'\nradiance = [3, 3, 3]\n\
             transform = { translation = [0, 2, 2], rotation_deg = [-45, 0, 0], scale = 3 }\n",
            false,
        ),
    ] {
        let scene = scene(&format!(
            "[camera]\nposition = [1, 1, 4]\ntarget = [0, 0, 0]\nfov_deg = 30\n[render]\n\
             size = [24, 24]\n[vary]\nmaterials = ['m']\n[materials.m]\nbrdf = 'blinn-phong'\nkd = [1, 1, 1]\n\
             ks = [0, 0, 0]\nshininess = 1\n[[object]]\nname = 'o'\nmaterial = 'm'\nshape = 'box'\n{light}"
        ));
        let world = World::new(&scene);
        let lights = Lights::new(&scene, &world);
        let plain = Gather::new(&scene, &world, &lights, SIZE, 2, 1);
        let guided = plain.clone().guided_by(Guide::new(&tally, None));
        let [plain, guided] = [plain, guided].map(|gather| moments(&scene, &gather, SAMPLES));
        let sums = |of: &[[f64; 2]]| of.iter().fold([0.0; 2], |s, m| [s[0] + m[0], s[1] + m[1]]);
        let ([plain, spread], [found, guided_spread]) = (sums(&plain), sums(&guided));
        let truth = if is_furnace { f64::from(SIZE[0] * SIZE[1]) } else { plain };
        let error = (guided_spread + if is_furnace { 0.0 } else { spread }).sqrt();
        println!(
            "{:.5} of the truth, ± {:.5}; plain ± {:.5}",
            found / truth,
            error / truth,
            spread.sqrt() / truth
        );
        assert!((found - truth).abs() < 4.0 * error && error < 0.003 * truth, "{found} {truth} ± {error}");
        // Of a lamp most noise is that of choosing points on it.
        assert!(!is_furnace || guided_spread > 1.1 * spread, "the guide has not been followed");
    }
}

/// The same paths at any number of threads.
#[test]
fn guides_are_the_same_at_any_number_of_threads() {
    let scene = library_scene("cornell-knot");
    let world = World::new(&scene);
    let lights = Lights::new(&scene, &world);
    let by = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| moments(&scene, &guided(&scene, &world, &lights, 64, 1), 64))
    };
    assert_eq!(by(1), by(3));
}
