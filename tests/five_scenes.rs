//! transfer-images as they are seen, with all reflections, against the path tracer.

use crate::support::images::{bake_by, gathering, in_state, on_bases, settings, surface_pixels};
use crate::support::pictures::{block_sums, squared_error};
use crate::support::{library_scene, render};
use relume_bake::compress::statistics::median;
use relume_bake::methods::transfer_images::{Settings, held_out, space_for};
use relume_bake::trace::gather::Gather;
use relume_bake::trace::lights::Lights;
use relume_bake::trace::reference::Paths;
use relume_bake::trace::world::World;
use relume_chart::metrics::{displayed, mean_flip};
use relume_formats::evaluate::transfer_images::evaluate;
use relume_formats::state::{BlinnPhong, Brdf, Rgb};
use relume_scenes::{ALL_REFLECTIONS, Scene};

const SCENES: [&str; 5] = ["cornell-knot", "statue-hall", "ring", "showroom", "bunny-room"];
const BASES: usize = 9;
/// Samples, whether paths follow a guide, and whether noise is filtered out.
const VARIANTS: [(u32, bool, bool); 5] =
    [(64, false, false), (64, true, false), (64, false, true), (64, true, true), (256, true, true)];
/// What a user makes.
const AS_BAKED: [(u32, bool, bool); 2] = [(64, true, true), (256, true, true)];
/// Samples of each half of the truth.
const TRUTH: u32 = 256;
/// Side of the squares whose means tell what is wrong beside noise, pixels.
const SQUARE: usize = 16;

/// Random states that reflect no more than they get, which Blinn-Phong's lobe may do.
fn states(scene: &Scene, count: u32) -> Vec<Vec<Brdf>> {
    let dim = |brdf| match brdf {
        Brdf::BlinnPhong(m) => {
            let half = |colour: Rgb| colour.map(|c| 0.5 * c);
            Brdf::BlinnPhong(BlinnPhong { kd: half(m.kd), ks: half(m.ks), ..m })
        }
        other => other,
    };
    (300..300 + count)
        .map(|state| held_out::random_state(state, scene).into_iter().map(dim).collect())
        .collect()
}

/// Relative L2 of pixels and of means over squares, per cent, state by state.
fn errors(pictures: &[Vec<Rgb>], truths: &[[Vec<Rgb>; 2]], pixels: &[usize], size: u32) -> [Vec<f64>; 2] {
    [1, SQUARE].map(|side| {
        let sums = |image: &Vec<Rgb>| block_sums(image, pixels, size, side);
        let of = |(picture, truth): (&Vec<Rgb>, &[Vec<Rgb>; 2])| {
            100.0 * squared_error(&sums(picture), &truth.each_ref().map(sums)).sqrt()
        };
        pictures.iter().zip(truths).map(of).collect()
    })
}

/// Mean FLIP of pictures beside the mean of both truths, at the exposure that brings the geometric mean of that to
/// middle grey; state by state.
fn flips(pictures: &[Vec<Rgb>], truths: &[[Vec<Rgb>; 2]], size: u32) -> Vec<f64> {
    let of = |(picture, [a, b]): (&Vec<Rgb>, &[Vec<Rgb>; 2])| {
        let mean = |(a, b): (&Rgb, &Rgb)| std::array::from_fn(|k| 0.5 * (a[k] + b[k]));
        let truth: Vec<Rgb> = a.iter().zip(b).map(mean).collect();
        let lit = truth.as_flattened().iter().filter(|light| **light > 0.0);
        let logarithms: f32 = lit.clone().map(|light| light.ln()).sum();
        let gain = 0.18 / (logarithms / lit.count() as f32).exp();
        let [ours, truth] = [picture, &truth].map(|image| displayed(image, gain));
        mean_flip(&ours, &truth, [size; 2])
    };
    pictures.iter().zip(truths).map(of).collect()
}

/// The table of docs/notes/TRANSFER-IMAGES.md.
#[test]
#[ignore = "takes a quarter of an hour"]
fn five_scenes_as_they_are_seen() {
    SCENES.into_iter().for_each(|name| measure(name, 256, 4, &VARIANTS));
}

/// The same of a film of the usual size, in more states.
#[test]
#[ignore = "takes the better part of an hour"]
fn a_large_film_as_it_is_seen() {
    measure("cornell-knot", 512, 8, &AS_BAKED);
}

/// Prints a row for each variant.
fn measure(name: &str, size: u32, states_looked_at: u32, variants: &[(u32, bool, bool)]) {
    let scene = library_scene(name);
    let basis = space_for(&scene, BASES).unwrap().basis(BASES);
    let states = states(&scene, states_looked_at);
    let pixels = surface_pixels(&scene, &settings(size, 16, BASES, 1));
    let truth_of = |state: &Vec<Brdf>| {
        let scene = in_state(&scene, state);
        [7, 8].map(|seed| render(&scene, [size; 2], TRUTH, ALL_REFLECTIONS, Paths::Best, seed).radiance)
    };
    let truths: Vec<[Vec<Rgb>; 2]> = states.iter().map(truth_of).collect();
    for &(samples, guide, filter) in variants {
        let settings = Settings { filter, ..settings(size, samples, BASES, 1) };
        let start = std::time::Instant::now();
        let images = if guide {
            gathering(&scene, &settings, |gather| bake_by(&scene, &settings, &basis, gather))
        } else {
            let world = World::new(&scene);
            let lights = Lights::new(&scene, &world);
            let gather = Gather::new(&scene, &world, &lights, [size; 2], ALL_REFLECTIONS, 1);
            bake_by(&scene, &settings, &basis, &gather)
        };
        let seconds = start.elapsed().as_secs_f64();
        let shown: Vec<Vec<Rgb>> =
            states.iter().map(|state| evaluate(&images, &on_bases(&basis, state))).collect();
        let of = errors(&shown, &truths, &pixels, size);
        let flip = median(&flips(&shown, &truths, size));
        let [[all, worst], [means, _]] =
            of.each_ref().map(|of| [median(of), of.iter().copied().fold(0.0, f64::max)]);
        println!(
            "| {name} | {samples} | {} | {} | {all:.2} / {worst:.2} | {means:.2} | {flip:.3} | {seconds:.1} |",
            if guide { "guided" } else { "lobes" },
            if filter { "on" } else { "off" },
        );
        assert!(worst < 100.0, "{name}");
    }
}
