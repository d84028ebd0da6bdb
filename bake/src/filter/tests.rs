use super::*;
use crate::job::{Job, ProgressMode};
use crate::trace::sampler::PixelSampler;
use seen::{LOOKS, STATES, looks_of};
use std::f32::consts::TAU;

const SIDE: u32 = 48;
/// Samples a half.
const SAMPLES: f32 = 8.0;

/// A fragment that shows `light` in all states by both early layers, each half with noise of `variance`.
fn fragment(pixel: u32, class: u16, light: f32, variance: f32) -> (u32, u16, Seen) {
    let (x, y) = ((pixel % SIDE) as f32, (pixel / SIDE) as f32);
    let all = 2.0 * SAMPLES;
    let mut guides = [[[0.0; LOOKS]; LAYERS]; 2];
    for (pair, (layer, state)) in
        (0..).zip((0..2).flat_map(|layer| (0..looks_of(layer)).map(move |s| (layer, s))))
    {
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
    Filter::new(Film::new(SIDE, |_| 2 * SAMPLES as u32, fragments), &Job::new(ProgressMode::None)).unwrap()
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

/// What a fragment of [`fragment`] shows by direct light in the first state.
fn shown((_, _, seen): &(u32, u16, Seen)) -> f32 {
    0.5 * (seen.guides[0][0][0] + seen.guides[1][0][0]) / SAMPLES
}

/// What every pixel shows by direct light in the first state, before and after.
fn before_and_after(fragments: &[(u32, u16, Seen)]) -> Vec<[f32; 2]> {
    let filter = filter_of(fragments.iter().copied());
    // Of one class, fragments are in the order of pixels.
    let mut values: Vec<_> = fragments.iter().map(|f| [shown(f); 2]).collect();
    for (number, rows) in rows(&filter) {
        let of = |(other, weight): &(u32, f32)| weight * shown(&fragments[*other as usize]);
        values[number as usize][1] = rows[0].iter().map(of).sum();
    }
    values
}

/// Root mean squares of what `light` is off by in direct light, before and after.
fn errors(values: &[[f32; 2]], light: impl Fn(u32) -> f32) -> [f64; 2] {
    let mut sums = [0.0; 2];
    for (pixel, values) in (0..).zip(values) {
        let squares = values.map(|value| f64::from(value - light(pixel)).powi(2));
        sums.iter_mut().zip(squares).for_each(|(sum, square)| *sum += square);
    }
    sums.map(|sum| (sum / values.len() as f64).sqrt())
}

/// A fragment in every pixel, all of one class.
fn whole(light: fn(u32) -> f32, variance: f32) -> Vec<(u32, u16, Seen)> {
    (0..SIDE * SIDE).map(|p| fragment(p, 0, light(p), variance)).collect()
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
    let fragments = whole(gradient, 0.02);
    let [before, after] = errors(&before_and_after(&fragments), gradient);
    // Both halves together have half of the variance.
    assert!((before / 0.1 - 1.0).abs() < 0.05, "{before}");
    assert!(after < 0.2 * before, "{after} of {before}");
    let noise = filter_of(fragments.into_iter()).noise().unwrap();
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
    let values = before_and_after(&whole(edge, 0.002));
    let [before, after] = errors(&values, edge);
    assert!(after < 0.35 * before, "{after} of {before}");
    // Pixels at the edge by themselves.
    for (pixel, [_, filtered]) in (0..).zip(values) {
        let truth = edge(pixel);
        assert!((filtered - truth).abs() < 4.0 * 0.0316, "{filtered} for {truth}");
    }
}

/// A film that is even in random states, with noise, and shows `light` by direct light where all is sharp.
fn with_sharp(light: impl Fn(u32) -> f32) -> Vec<(u32, u16, Seen)> {
    let mut fragments = whole(|_| 1.0, 0.02);
    for (pixel, _, seen) in &mut fragments {
        seen.guides.iter_mut().for_each(|half| half[0][STATES] = light(*pixel) * SAMPLES);
    }
    fragments
}

/// What is a highlight only where all is sharp stays, be there ever so much noise in random states, which is blurred
/// where the sharpest state shows nothing. Light that was reflected before is not asked.
#[test]
fn highlights_of_the_sharpest_state_stay() {
    let glints = |pixel: u32| if (pixel % SIDE + pixel / SIDE).is_multiple_of(2) { 0.1 } else { 2.0 };
    let rows_of = |light: &dyn Fn(u32) -> f32| rows(&filter_of(with_sharp(light).into_iter()));
    let [of_glints, of_even] = [rows_of(&glints), rows_of(&|_| 1.0)];
    let worst = |rows: &[(u32, [Row; LAYERS])]| {
        let off = |(number, rows): &(u32, [Row; LAYERS])| {
            let shown: f32 = rows[0].iter().map(|(other, weight)| weight * glints(*other)).sum();
            (shown - glints(*number)).abs()
        };
        rows.iter().map(off).fold(0.0, f32::max)
    };
    let [kept, blurred] = [&of_glints, &of_even].map(|rows| worst(rows));
    assert!(kept < 0.01 && blurred > 0.5, "{kept} {blurred}");
    assert!(of_glints.iter().zip(&of_even).all(|((_, a), (_, b))| a[1] == b[1]));
}

/// Noise that only the sharpest state has is not told.
#[test]
fn what_is_told_is_told_of_random_states() {
    let noisy = |scale: f32| {
        let mut fragments = whole(|_| 1.0, 0.02);
        for (pixel, _, seen) in &mut fragments {
            let noise = normal(*pixel, 99, 0.1);
            let halves = seen.guides.iter_mut().zip(noise);
            halves.for_each(|(half, noise)| half[0][STATES] = (1.0 + scale * noise) * SAMPLES);
        }
        filter_of(fragments.into_iter()).noise().unwrap()
    };
    let [usual, more] = [0.1, 1.0].map(noisy);
    // Shares of candidates, which are others, are 1 in all but for rounding.
    assert!((more.before / usual.before - 1.0).abs() < 1e-6, "{usual:?} {more:?}");
    assert!((more.after / usual.after - 1.0).abs() < 0.25, "{usual:?} {more:?}");
}

/// Light of any brightness is filtered alike.
#[test]
fn brightness_does_not_matter() {
    let filter_at = |scale: f32| {
        let scaled = |p: u32| {
            let (pixel, class, mut seen) = fragment(p, 0, gradient(p), 0.02);
            let guides = seen.guides.as_flattened_mut().as_flattened_mut();
            guides.iter_mut().for_each(|value| *value *= scale);
            (pixel, class, seen)
        };
        filter_of((0..SIDE * SIDE).map(scaled))
    };
    // Powers of two, so that nothing is rounded.
    let [dim, usual, bright] = [-80, 0, 80].map(|power| rows(&filter_at(2f32.powi(power))));
    assert!(dim == usual && bright == usual);
}

/// Without noise nothing changes.
#[test]
fn what_has_no_noise_stays() {
    let waves = |pixel: u32| 1.0 + 0.5 * ((pixel % SIDE) as f32 * 1.7).sin() * ((pixel / SIDE) as f32).cos();
    let fragments = whole(waves, 0.0);
    let [_, after] = errors(&before_and_after(&fragments), waves);
    assert!(after < 1e-4, "{after}");
    assert_eq!(filter_of(fragments.into_iter()).noise().unwrap().before, 0.0);
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
    let alone = filter_of(std::iter::once((pixel, class, seen)));
    assert_eq!(alone.noise(), None, "one sample says nothing of its noise");
    let halved = filter_of([(pixel, class, seen), fragment(1, 0, 1.0, 0.01)].into_iter());
    assert!(halved.noise().unwrap().before > 0.0);
    assert_eq!(halved.fragments()[0].guides[0], halved.fragments()[0].guides[1]);
}

#[test]
fn what_is_seen_comes_back_as_numbers() {
    let words: [f32; seen::WORDS] = std::array::from_fn(|k| k as f32 - 7.5);
    assert_eq!(Seen::from_words(&words).words(), words);
}
