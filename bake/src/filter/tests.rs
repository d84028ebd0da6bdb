use super::*;
use crate::job::{Job, ProgressMode};
use crate::trace::sampler::PixelSampler;
use seen::STATES;
use std::f32::consts::TAU;

const SIDE: u32 = 48;
/// Samples a half.
const SAMPLES: f32 = 8.0;

/// A fragment that shows `light` in all states by both early layers, each half with noise of `variance`.
fn fragment(pixel: u32, class: u16, light: f32, variance: f32) -> (u32, u16, Seen) {
    let (x, y) = ((pixel % SIDE) as f32, (pixel / SIDE) as f32);
    let all = 2.0 * SAMPLES;
    let mut guides = [[[0.0; STATES]; LAYERS]; 2];
    for (pair, (layer, state)) in (0..).zip((0..2).flat_map(|layer| (0..STATES).map(move |s| (layer, s)))) {
        let noise = normal(pixel, pair, variance);
        guides.iter_mut().zip(noise).for_each(|(half, noise)| half[layer][state] = (light + noise) * SAMPLES);
    }
    let seen = Seen {
        samples: [SAMPLES; 2],
        position: [x * 0.1 * all, y * 0.1 * all, 0.0],
        normal: [0.0, 0.0, all],
        colour: [0.5 * all; 3],
        guides,
        ..Seen::default()
    };
    (pixel, class, seen)
}

fn filter_of(fragments: impl Iterator<Item = (u32, u16, Seen)>) -> Filter {
    Filter::new(Film::new(SIDE, fragments), &Job::new(ProgressMode::None)).unwrap()
}

/// Two independent numbers of mean 0 and variance `variance`, normally distributed.
fn normal(pixel: u32, pair: u32, variance: f32) -> [f32; 2] {
    let [u, v] = PixelSampler::new(11, pixel).sample(0).pair(pair);
    let radius = (-2.0 * variance * (1.0 - u).ln()).sqrt();
    [radius * (TAU * v).cos(), radius * (TAU * v).sin()]
}

fn rows(filter: &Filter) -> Vec<(u32, [Row; LAYERS])> {
    filter.tiles().into_iter().flat_map(|tile| filter.rows(tile)).collect()
}

/// Root mean squares of what `light` is off by in direct light, before and after.
fn errors(filter: &Filter, light: impl Fn(u32) -> f32) -> [f64; 2] {
    let shown = |number: u32| filter.fragments()[number as usize].guide(0)[0];
    let mut sums = [0.0; 2];
    for (number, rows) in rows(filter) {
        let truth = light(filter.fragments()[number as usize].pixel);
        let filtered: f32 = rows[0].iter().map(|(other, weight)| weight * shown(*other)).sum();
        let squares = [shown(number), filtered].map(|value| f64::from(value - truth).powi(2));
        sums.iter_mut().zip(squares).for_each(|(sum, square)| *sum += square);
    }
    sums.map(|sum| (sum / filter.fragments().len() as f64).sqrt())
}

fn gradient(pixel: u32) -> f32 {
    1.0 + 0.02 * (pixel % SIDE) as f32
}

/// Half in shadow.
fn edge(pixel: u32) -> f32 {
    if pixel % SIDE < SIDE / 2 { 0.2 } else { 1.0 }
}

/// Everything that is known comes back, and is whole and made of neighbours of the class alone.
#[test]
fn rows_are_means_of_neighbours_of_the_class() {
    let class = |pixel: u32| u16::from(pixel % SIDE >= 20);
    let filter = filter_of((0..SIDE * SIDE).map(|p| fragment(p, class(p), 1.0, 0.01)));
    let rows = rows(&filter);
    let mut met: Vec<u32> = rows.iter().map(|(number, _)| *number).collect();
    met.sort_unstable();
    assert_eq!(met, (0..SIDE * SIDE).collect::<Vec<_>>());
    for (number, rows) in &rows {
        let own = filter.fragments()[*number as usize].class;
        for row in &rows[..2] {
            let sum: f32 = row.iter().map(|(_, weight)| weight).sum();
            assert!((sum - 1.0).abs() < 1e-5, "{sum}");
            assert!(row.iter().all(|(_, weight)| *weight > 0.0));
            assert!(row.iter().all(|(other, _)| filter.fragments()[*other as usize].class == own));
        }
        assert_eq!(rows[2], [(*number, 1.0)], "there is no later light");
    }
}

/// A gradient is a function that is linear in place. Away from its borders nothing of it is lost.
#[test]
fn noise_goes_and_gradients_stay() {
    let filter = filter_of((0..SIDE * SIDE).map(|p| fragment(p, 0, gradient(p), 0.02)));
    let [before, after] = errors(&filter, gradient);
    // Both halves together have half of the variance.
    assert!((before / 0.1 - 1.0).abs() < 0.05, "{before}");
    assert!(after < 0.2 * before, "{after} of {before}");
    let noise = filter.noise().unwrap();
    let norm = (0..SIDE * SIDE).map(|p| f64::from(gradient(p)).powi(2)).sum::<f64>() / f64::from(SIDE * SIDE);
    // Two layers show the same: twice the light, and two independent estimates of the same noise.
    let expected = |error: f64| error * 2f64.sqrt() / (2.0 * norm.sqrt());
    assert!((noise.before / expected(before) - 1.0).abs() < 0.1, "{noise:?}, {}", expected(before));
    let ratio = noise.after / expected(after);
    assert!((1.0 / 1.5..1.5).contains(&ratio), "{noise:?}, {}", expected(after));
}

/// The edge of a shadow is in the guides, and stands out of the noise.
#[test]
fn edges_stay() {
    let filter = filter_of((0..SIDE * SIDE).map(|p| fragment(p, 0, edge(p), 0.002)));
    let [before, after] = errors(&filter, edge);
    assert!(after < 0.35 * before, "{after} of {before}");
    // Pixels at the edge by themselves.
    let shown = |number: u32| filter.fragments()[number as usize].guide(0)[0];
    for (number, rows) in rows(&filter) {
        let truth = edge(filter.fragments()[number as usize].pixel);
        let filtered: f32 = rows[0].iter().map(|(other, weight)| weight * shown(*other)).sum();
        assert!((filtered - truth).abs() < 4.0 * 0.0316, "{filtered} for {truth}");
    }
}

/// Without noise nothing changes.
#[test]
fn what_has_no_noise_stays() {
    let waves = |pixel: u32| 1.0 + 0.5 * ((pixel % SIDE) as f32 * 1.7).sin() * ((pixel / SIDE) as f32).cos();
    let filter = filter_of((0..SIDE * SIDE).map(|p| fragment(p, 0, waves(p), 0.0)));
    let [_, after] = errors(&filter, waves);
    assert!(after < 1e-4, "{after}");
    assert_eq!(filter.noise().unwrap().before, 0.0);
}

/// Black, a single fragment, none at all, and a half that no sample fell on.
#[test]
fn little_is_no_trouble() {
    let none = filter_of(std::iter::empty());
    assert_eq!((none.fragments().len(), none.noise(), rows(&none).len()), (0, None, 0));
    let black = filter_of((0..SIDE * SIDE).map(|p| fragment(p, 0, 0.0, 0.0)));
    assert_eq!(black.noise(), None);
    assert!(rows(&black).iter().all(|(number, rows)| rows.iter().all(|row| *row == [(*number, 1.0)])));
    let single = filter_of(std::iter::once(fragment(100, 3, 1.0, 0.5)));
    assert_eq!(rows(&single), [(0, std::array::from_fn(|_| vec![(0, 1.0)]))]);
    let (pixel, class, mut seen) = fragment(0, 0, 1.0, 0.0);
    (seen.samples[1], seen.guides[1]) = (0.0, Default::default());
    let halved = filter_of([(pixel, class, seen), fragment(1, 0, 1.0, 0.01)].into_iter());
    assert_eq!(halved.fragments()[0].guide(0), [1.0; STATES]);
}

#[test]
fn what_is_seen_comes_back_as_numbers() {
    let words: [f32; seen::WORDS] = std::array::from_fn(|k| k as f32 - 7.5);
    assert_eq!(Seen::from_words(&words).words(), words);
}
