//! Noise that is filtered out of transfer-images.

use crate::support::images::{bake, gathering, in_state, on_bases, settings, surface_pixels};
use crate::support::pictures::{block_sums, squared_error};
use crate::support::{job, relative_l2, render, with_two_reflections};
use relume_bake::filter::seen::half_of;
use relume_bake::filter::{Film, Filter, Seen, Watcher, pictures};
use relume_bake::methods::transfer_images::{Settings, held_out};
use relume_bake::trace::gather::{Gather, GatherPath};
use relume_bake::trace::reference::{self, Paths};
use relume_formats::evaluate::transfer_images::evaluate;
use relume_formats::state::{Brdf, Rgb};
use relume_scenes::Scene;

fn filtered(size: u32, samples: u32, bases: usize) -> Settings {
    Settings { filter: true, ..settings(size, samples, bases, 1) }
}

fn states(scene: &Scene) -> Vec<Vec<Brdf>> {
    (100..108).map(|state| held_out::random_state(state, scene)).collect()
}

/// Pictures of states by the same paths and the same filter.
fn pictures_of(scene: &Scene, states: &[Vec<Brdf>], settings: &Settings) -> Vec<Vec<Rgb>> {
    let scenes: Vec<Scene> = states.iter().map(|state| in_state(scene, state)).collect();
    let Settings { size, samples, seed, .. } = *settings;
    let settings =
        reference::Settings { size, samples, seed, reflections: 2, paths: Paths::Gather, target: None };
    pictures::render(scene, &scenes, &settings, &job())
        .unwrap()
        .into_iter()
        .map(|image| image.radiance)
        .collect()
}

/// What the filter makes of images and of a picture of a state is the same: what is left is what bases
/// lose, as without it.
#[test]
fn sums_of_filtered_images_are_filtered_sums() {
    let scene = with_two_reflections("cornell-knot");
    let settings = filtered(48, 16, 12);
    let (basis, images) = bake(&scene, &settings, true);
    let states = states(&scene);
    for (state, picture) in states.iter().zip(pictures_of(&scene, &states, &settings)) {
        let shown = evaluate(&images, &on_bases(&basis, state));
        let error = relative_l2(&shown, &picture);
        assert!(error < 0.002, "{error}");
    }
}

/// Less than half of the noise is left on a coarse film, in states that it was not made for, and it says how
/// much.
#[test]
fn noise_is_filtered_and_what_is_left_is_known() {
    expect_filtered(96, 64, 384);
}

/// The table of docs/notes/TRANSFER-IMAGES.md.
#[test]
#[ignore = "takes minutes"]
fn noise_is_filtered_on_a_fine_film() {
    [64, 256].into_iter().for_each(|samples| expect_filtered(256, samples, 512));
}

/// Compares with two path traced halves of `truth` samples, whose own noise is not in the errors.
fn expect_filtered(size: u32, samples: u32, truth: u32) {
    let scene = with_two_reflections("cornell-knot");
    let settings = filtered(size, samples, 4);
    let states = &states(&scene)[..3];
    let pixels = surface_pixels(&scene, &settings);
    let noise = gathering(&scene, &settings, |gather| filter_of(&scene, gather, &settings)).noise().unwrap();
    let mut squares = [0.0; 2];
    for (state, picture) in states.iter().zip(pictures_of(&scene, states, &settings)) {
        let scene = in_state(&scene, state);
        let render = |samples, paths, seed| render(&scene, settings.size, samples, 2, paths, seed).radiance;
        let truth = [7, 8].map(|seed| render(truth, Paths::Best, seed));
        let raw = render(settings.samples, Paths::Gather, settings.seed);
        let [raw, picture] = [raw, picture].map(|image| {
            let truth = truth.each_ref();
            [1, 16].map(|side| {
                squared_error(
                    &block_sums(&image, &pixels, size, side),
                    &truth.map(|t| block_sums(t, &pixels, size, side)),
                )
            })
        });
        let [before, after] = [raw, picture].map(|errors| errors.map(|error| 100.0 * error.sqrt()));
        println!(
            "{samples} samples: {:.2} % before, {:.2} % after; of means {:.2} % and {:.2} %",
            before[0], after[0], before[1], after[1]
        );
        squares
            .iter_mut()
            .zip([raw[0], picture[0]])
            .for_each(|(sum, error)| *sum += error / states.len() as f64);
    }
    let [before, after] = squares.map(f64::sqrt);
    println!("{before:.4} before, {after:.4} after, estimated {noise:?}");
    assert!(after < 0.5 * before, "{after} of {before}");
    for (told, seen) in [(noise.before, before), (noise.after, after)] {
        assert!((1.0 / 1.5..1.5).contains(&(told / seen)), "{told} for {seen}");
    }
}

fn filter_of(scene: &Scene, gather: &Gather<'_>, settings: &Settings) -> Filter {
    Filter::new(film_of(scene, gather, settings), &job()).unwrap()
}

/// What a bake knows of its fragments.
pub fn film_of(scene: &Scene, gather: &Gather<'_>, settings: &Settings) -> Film {
    let watcher = Watcher::new(scene);
    let fixed = scene.vary.materials.len();
    let class = |material: u32| scene.vary.place_of(material).unwrap_or(fixed);
    let mut fragments = Vec::new();
    for pixel in 0..settings.size[0] * settings.size[1] {
        let mut classes = vec![Seen::default(); fixed + 1];
        let (mut number, samples) = (0, gather.samples(pixel, settings.samples));
        gather.pixel(pixel, samples, |path| {
            if let GatherPath::Surface(eye) = path {
                watcher.add(path, half_of(number, samples), &mut classes[class(eye.spot.material)]);
            }
            number += 1;
        });
        fragments.extend((0..).zip(classes).map(|(class, seen)| (pixel, class, seen)));
    }
    let samples = |pixel: u32| gather.samples(pixel, settings.samples);
    Film::new(settings.size[0], samples, fragments.into_iter())
}
