//! Samples where noise is: counts of tiles for a noise that is asked for.

use crate::support::images::{bake_by, in_state, on_bases, settings, surface_pixels};
use crate::support::pictures::squared_error;
use crate::support::{job, library_scene, relative_l2};
use relume_bake::guided;
use relume_bake::methods::transfer_images::{Settings, held_out, space_for};
use relume_bake::noise_target::{FEWEST, NoiseTarget};
use relume_bake::trace::gather::Gather;
use relume_bake::trace::lights::Lights;
use relume_bake::trace::reference::{self, Paths};
use relume_bake::trace::tile_counts::TileCounts;
use relume_bake::trace::world::World;
use relume_formats::evaluate::transfer_images::evaluate;
use relume_formats::state::{Brdf, Rgb};
use relume_scenes::{ALL_REFLECTIONS, Scene};

const SIZE: u32 = 96;
const BASES: usize = 4;

/// Gives the paths that a bake of `scene` with at most `most` samples has for this target.
fn aiming<T>(
    scene: &Scene,
    most: u32,
    target: NoiseTarget,
    seed: u64,
    then: impl FnOnce(&Gather<'_>) -> T,
) -> T {
    let world = World::new(scene);
    let lights = Lights::new(scene, &world);
    let reflections = scene.reflections;
    let paths = guided::Settings { size: [SIZE; 2], samples: most, reflections, seed, target: Some(target) };
    then(&guided::gather(scene, &world, &lights, &paths, &job()).unwrap())
}

fn counts(scene: &Scene, most: u32, target: NoiseTarget) -> TileCounts {
    aiming(scene, most, target, 1, |gather| gather.counts().unwrap().clone())
}

/// Pictures of states by the paths of `gather`.
fn pictures(scene: &Scene, gather: &Gather<'_>, settings: &Settings, states: &[Vec<Brdf>]) -> Vec<Vec<Rgb>> {
    let basis = space_for(scene, BASES).unwrap().basis(BASES);
    let images = bake_by(scene, settings, &basis, gather);
    states.iter().map(|state| evaluate(&images, &on_bases(&basis, state))).collect()
}

/// What two bakes of one kind differ by, of one of them, over states that neither looked at: root of the mean square
/// of relative L2.
fn noise_of(pictures: [Vec<Vec<Rgb>>; 2], pixels: &[usize]) -> f64 {
    let [a, b] = pictures;
    let of = |(a, b): (&Vec<Rgb>, &Vec<Rgb>)| {
        let [a, b] = [a, b].map(|image| pixels.iter().map(|p| image[*p]).collect::<Vec<_>>());
        // The difference of two has the noise of both.
        0.5 * relative_l2(&a, &b).powi(2)
    };
    let squares: Vec<f64> = a.iter().zip(&b).map(of).collect();
    (squares.iter().sum::<f64>() / squares.len() as f64).sqrt()
}

fn states(scene: &Scene) -> Vec<Vec<Brdf>> {
    (400..406).map(|state| held_out::random_state(state, scene)).collect()
}

/// A bake has the noise that it was asked for, in states that neither it nor its pilot looked at, and by fewer samples
/// than if all pixels had as many.
#[test]
fn bakes_have_the_noise_that_is_asked_for_by_fewer_samples() {
    let scene = library_scene("ring");
    let target = NoiseTarget { noise: 0.05, filter: false };
    let pixels = surface_pixels(&scene, &settings(SIZE, 16, BASES, 1));
    let states = states(&scene);
    let counts = counts(&scene, 1024, target);
    let mean = counts.mean();
    assert!(mean > f64::from(FEWEST) && mean < 1024.0, "{mean}");
    let even = settings(SIZE, mean.ceil() as u32, BASES, 1);
    let tiles = SIZE.div_ceil(16) as usize;
    let everywhere = TileCounts::new([SIZE; 2], 16, vec![mean.ceil() as u32; tiles * tiles]);
    let noise = |is_spread: bool| {
        let of_seed = |seed| {
            aiming(&scene, 1024, target, seed, |gather| {
                assert_eq!(gather.counts(), Some(&counts), "other paths, the same counts");
                let gather =
                    if is_spread { gather.clone() } else { gather.clone().counted_by(everywhere.clone()) };
                pictures(&scene, &gather, &Settings { seed, ..even }, &states)
            })
        };
        noise_of([1, 2].map(of_seed), &pixels)
    };
    let [spread, even] = [true, false].map(noise);
    println!("asked 0.05, has {spread:.4}; with {mean:.0} samples everywhere {even:.4}");
    // Four states stand for all of them, some of which shine more.
    assert!(spread > 0.025 && spread < 0.1, "{spread}");
    assert!(even > 1.03 * spread, "{even} {spread}");
}

/// With the filter, what it leaves is what is asked for; and no more samples are spent than the most.
#[test]
fn the_filter_is_reckoned_with() {
    let scene = library_scene("cornell-knot");
    let told = |noise: f64, most: u32| {
        let target = NoiseTarget { noise, filter: true };
        aiming(&scene, most, target, 1, |gather| {
            let basis = space_for(&scene, BASES).unwrap().basis(BASES);
            let settings = Settings { filter: true, ..settings(SIZE, most, BASES, 1) };
            let noise = crate::support::images::baked_by(&scene, &settings, &basis, gather).noise.unwrap();
            (gather.counts().unwrap().mean(), noise.after)
        })
    };
    let (few, rough) = told(0.02, 1024);
    let (more, fine) = told(0.012, 1024);
    println!("2 %: {few:.0} samples leave {rough:.4}; 1.2 %: {more:.0} leave {fine:.4}");
    // A dozen windows, or one in a film as small as this, foretell all of it.
    assert!(rough > 0.012 && rough < 0.03 && fine > 0.0072 && fine < 0.018, "{rough} {fine}");
    assert!(more > 1.3 * few && more < 1024.0, "{few} {more}");
    let (most, _) = told(1e-4, 64);
    assert!((most - 64.0).abs() < 2.0, "{most}");
}

/// Counts depend on the scene and what is asked, on nothing else.
#[test]
fn counts_are_the_same_at_any_number_of_threads() {
    let scene = library_scene("cornell-knot");
    let target = NoiseTarget { noise: 0.02, filter: true };
    let [one, three] = [1, 3].map(|threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| counts(&scene, 64, target))
    });
    assert_eq!(one, three);
    assert!((0..SIZE * SIZE).any(|pixel| one.of(pixel) != one.of(0)));
}

/// `bake reference --paths gather` traces the very paths of such a bake: what is left is what bases are off by.
#[test]
fn references_have_the_same_paths() {
    let scene = Scene { reflections: 2, ..library_scene("ring") };
    let target = NoiseTarget { noise: 0.3, filter: false };
    let state = &states(&scene)[0];
    let images = aiming(&scene, 64, target, 1, |gather| {
        let counts = gather.counts().unwrap();
        assert!((0..SIZE * SIZE).any(|pixel| counts.of(pixel) != counts.of(0)));
        let basis = space_for(&scene, 9).unwrap().basis(9);
        evaluate(&bake_by(&scene, &settings(SIZE, 64, 9, 1), &basis, gather), &on_bases(&basis, state))
    });
    let settings = reference::Settings {
        size: [SIZE; 2],
        samples: 64,
        seed: 1,
        reflections: 2,
        paths: Paths::Gather,
        target: Some(target),
    };
    let truth = reference::render(&scene, &[in_state(&scene, state)], &[], &settings, &job()).unwrap();
    let error = relative_l2(&images, &truth[0].radiance);
    println!("{error:.1e}");
    assert!(error < 0.01, "{error}");
}

/// More samples at some places make no place brighter: against the path tracer, means over states and pixels.
#[test]
fn pictures_stay_unbiased() {
    let scene = library_scene("ring");
    assert_eq!(scene.reflections, ALL_REFLECTIONS);
    let scene = Scene { reflections: 2, ..scene };
    let target = NoiseTarget { noise: 0.02, filter: false };
    let state = &states(&scene)[1];
    let shown = aiming(&scene, 128, target, 1, |gather| {
        let basis = space_for(&scene, 9).unwrap().basis(9);
        evaluate(&bake_by(&scene, &settings(SIZE, 128, 9, 1), &basis, gather), &on_bases(&basis, state))
    });
    let truth = [5, 6].map(|seed| {
        crate::support::render(&in_state(&scene, state), [SIZE; 2], 128, 2, Paths::Best, seed).radiance
    });
    let sums = |image: &Vec<Rgb>| {
        let all: Vec<usize> = (0..image.len()).collect();
        crate::support::pictures::block_sums(image, &all, SIZE, 16)
    };
    let error = squared_error(&sums(&shown), &truth.each_ref().map(sums)).sqrt();
    println!("means of 16 × 16 pixels: {error:.4}");
    // Noise of a few per cent a pixel over 256 of them.
    assert!(error < 0.015, "{error}");
}
