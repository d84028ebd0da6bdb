//! How far images are from their references.
//!
//! Over the pixels that count, all three channels alike, x ours and t the truth, both linear radiance:
//!
//! * relative L2: ‖x − t‖ / ‖t‖;
//! * relMSE: the mean of (x − t)² / (t² + ε) with ε = 0.01 m², m the mean of t. Rousselle et al. (2011) have
//!   ε = 0.01, which weighs dark pixels by the units of the scene; with the mean in it the figure does not
//!   depend on the scene's exposure;
//! * maximum: the largest |x − t| / m;
//! * FLIP (Andersson et al. 2020): the mean of what a person sees of the difference when the displayed 8-bit
//!   images are flipped back and forth, over all pixels, at the library's default distance (67 pixels a
//!   degree).
//!
//! Each is a figure of one state; a chart has the median and the worst over its states.

use super::figures::{ImageErrors, OverStates};
use nv_flip::{DEFAULT_PIXELS_PER_DEGREE, FlipImageRgb8};
use rayon::prelude::*;
use relume_bake::compress::statistics::{median, worst};
use relume_formats::basis::srgb_from_linear;
use relume_formats::state::Rgb;

/// ε of relMSE in squares of the mean.
const REL_MSE_EPSILON: f64 = 0.01;

/// An image beside its reference, in one state. All three slices are row-major, a value a pixel.
#[derive(Debug, Clone, Copy)]
pub struct Pair<'a> {
    /// Linear radiance, as a player shows it.
    pub ours: &'a [Rgb],
    /// Linear radiance of the reference.
    pub truth: &'a [Rgb],
    /// False where a light or the background is seen, which FLIP alone takes in.
    pub counted: &'a [bool],
    /// Exposure at which both are displayed: 2^`exposure_ev` is the gain.
    pub exposure_ev: f32,
}

/// The figures of one state.
struct Errors {
    relative_l2: f64,
    rel_mse: f64,
    flip: f64,
    maximum: f64,
}

/// The errors of `pairs`, one for each state, of `size` pixels.
///
/// All errors of a state are infinite if a channel of ours that counts is no finite number, FLIP is if any
/// is. They also are if slices do not have `size` pixels. A black reference makes every difference infinite.
/// Where no pixel counts there is no error but FLIP.
pub fn image_errors(pairs: &[Pair<'_>], size: [u32; 2]) -> ImageErrors {
    let states: Vec<Errors> = pairs.par_iter().map(|pair| errors(pair, size)).collect();
    let over = |of: fn(&Errors) -> f64| {
        let values: Vec<f64> = states.iter().map(of).collect();
        OverStates { median: median(&values), worst: worst(&values) }
    };
    ImageErrors {
        relative_l2: over(|e| e.relative_l2),
        rel_mse: over(|e| e.rel_mse),
        flip: over(|e| e.flip),
        maximum: over(|e| e.maximum),
    }
}

fn errors(pair: &Pair<'_>, size: [u32; 2]) -> Errors {
    let pixels = size[0] as usize * size[1] as usize;
    if pair.ours.len() != pixels || pair.truth.len() != pixels || pair.counted.len() != pixels {
        return Errors {
            relative_l2: f64::INFINITY,
            rel_mse: f64::INFINITY,
            flip: f64::INFINITY,
            maximum: f64::INFINITY,
        };
    }
    let channels = || counted(pair).map(|(ours, truth)| (f64::from(ours), f64::from(truth)));
    let count = channels().count().max(1) as f64;
    let mean = channels().map(|(_, t)| t).sum::<f64>() / count;
    let square = |x: f64| x * x;
    let off: f64 = channels().map(|(x, t)| square(x - t)).sum();
    let norm: f64 = channels().map(|(_, t)| square(t)).sum();
    let epsilon = REL_MSE_EPSILON * square(mean);
    let relative: f64 = channels().map(|(x, t)| part(square(x - t), square(t) + epsilon)).sum();
    // `f64::max` would pass over what is no number.
    let largest =
        channels().map(|(x, t)| (x - t).abs()).fold(0.0, |a, b| if b.is_nan() || b > a { b } else { a });
    let flip =
        if pair.ours.as_flattened().iter().all(|x| x.is_finite()) { flip(pair, size) } else { f64::INFINITY };
    Errors {
        relative_l2: part(off, norm).sqrt(),
        rel_mse: or_infinite(relative / count),
        flip,
        maximum: part(largest, mean),
    }
}

/// The channels of the pixels that count, ours and the truth's.
fn counted<'a>(pair: &Pair<'a>) -> impl Iterator<Item = (f32, f32)> + use<'a> {
    let pixels = pair.ours.iter().zip(pair.truth).zip(pair.counted).filter(|(_, counted)| **counted);
    pixels.flat_map(|((ours, truth), _)| ours.iter().copied().zip(truth.iter().copied()))
}

/// `difference` in parts of `whole`; nothing is no part of anything.
fn part(difference: f64, whole: f64) -> f64 {
    if difference == 0.0 { 0.0 } else { or_infinite(difference / whole) }
}

fn or_infinite(error: f64) -> f64 {
    if error.is_finite() { error } else { f64::INFINITY }
}

/// Mean FLIP of two images as they are displayed.
fn flip(pair: &Pair<'_>, size: [u32; 2]) -> f64 {
    let gain = pair.exposure_ev.exp2();
    let [ours, truth] = [pair.ours, pair.truth].map(|pixels| displayed(pixels, gain));
    mean_flip(&ours, &truth, size)
}

/// What a display shows of linear radiance: sRGB(clamp(`gain` · L)), row-major, three bytes a pixel.
pub fn displayed(pixels: &[Rgb], gain: f32) -> Vec<u8> {
    pixels.as_flattened().iter().map(|c| srgb_from_linear(c * gain)).collect()
}

/// Mean FLIP of two displayed images of `size` pixels, three bytes each, row-major; infinite if they are not
/// of this size.
pub fn mean_flip(ours: &[u8], truth: &[u8], size: [u32; 2]) -> f64 {
    let bytes = 3 * size[0] as usize * size[1] as usize;
    if bytes == 0 || ours.len() != bytes || truth.len() != bytes {
        return f64::INFINITY;
    }
    let image = |bytes: &[u8]| FlipImageRgb8::with_data(size[0], size[1], bytes);
    let map = nv_flip::flip(image(truth), image(ours), DEFAULT_PIXELS_PER_DEGREE);
    map.to_vec().into_iter().map(f64::from).sum::<f64>() / f64::from(size[0] * size[1])
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: [u32; 2] = [24, 16];
    const PIXELS: usize = 24 * 16;
    /// FLIP and sums in double precision of values that are exact in single precision.
    const CLOSE: f64 = 1e-12;

    fn close(a: f64, b: f64) -> bool {
        (a - b).abs() <= CLOSE * b.abs().max(1.0)
    }

    fn of(ours: &[Rgb], truth: &[Rgb], counted: &[bool]) -> ImageErrors {
        image_errors(&[Pair { ours, truth, counted, exposure_ev: 0.0 }], SIZE)
    }

    fn all(errors: &ImageErrors) -> [f64; 4] {
        [errors.relative_l2, errors.rel_mse, errors.flip, errors.maximum].map(|o| o.worst)
    }

    /// Values of no pattern, 1/64 to 1.
    fn textured() -> Vec<Rgb> {
        (0..PIXELS).map(|i| std::array::from_fn(|c| ((i * 37 + c * 101) % 64 + 1) as f32 / 64.0)).collect()
    }

    #[test]
    fn the_same_image_has_no_error() {
        let image = textured();
        assert_eq!(all(&of(&image, &image, &[true; PIXELS])), [0.0; 4]);
        let black = [[0.0; 3]; PIXELS];
        assert_eq!(all(&of(&black, &black, &[true; PIXELS])), [0.0; 4]);
    }

    #[test]
    fn a_constant_offset_of_a_constant_image() {
        // x − t = 1/8 everywhere, t = 1/2: relative L2 and maximum 1/4, relMSE (1/8)² / (1.01 · (1/2)²).
        let errors = of(&[[0.625; 3]; PIXELS], &[[0.5; 3]; PIXELS], &[true; PIXELS]);
        assert!(close(errors.relative_l2.worst, 0.25) && close(errors.maximum.worst, 0.25));
        assert!(close(errors.rel_mse.worst, 0.0625 / 1.01), "{errors:?}");
        assert!(errors.flip.worst > 0.0 && errors.flip.worst < 1.0);
    }

    #[test]
    fn one_hot_pixel() {
        // A channel of 1 more in N pixels of t = 1/2: ‖x − t‖ = 1, ‖t‖ = √(3N)/2, m = 1/2.
        let mut ours = [[0.5; 3]; PIXELS];
        ours[77][1] = 1.5;
        let errors = of(&ours, &[[0.5; 3]; PIXELS], &[true; PIXELS]);
        let n = PIXELS as f64;
        assert!(close(errors.relative_l2.worst, 2.0 / (3.0 * n).sqrt()));
        assert!(close(errors.rel_mse.worst, 1.0 / (1.01 * 0.25) / (3.0 * n)));
        assert!(close(errors.maximum.worst, 2.0));
    }

    #[test]
    fn sums_of_no_pattern_equal_the_definitions_term_by_term() {
        let truth = textured();
        let ours: Vec<Rgb> = truth.iter().rev().copied().collect();
        let counted: Vec<bool> = (0..PIXELS).map(|i| i % 3 != 0).collect();
        let (mut off, mut norm, mut sum, mut largest, mut n) = (0.0, 0.0, 0.0, 0.0f64, 0.0);
        for i in (0..PIXELS).filter(|i| i % 3 != 0) {
            for c in 0..3 {
                let (x, t) = (f64::from(ours[i][c]), f64::from(truth[i][c]));
                off += (x - t).powi(2);
                norm += t.powi(2);
                sum += t;
                largest = largest.max((x - t).abs());
                n += 1.0;
            }
        }
        let mean = sum / n;
        let mut relative = 0.0;
        for i in (0..PIXELS).filter(|i| i % 3 != 0) {
            for c in 0..3 {
                let (x, t) = (f64::from(ours[i][c]), f64::from(truth[i][c]));
                relative += (x - t).powi(2) / (t.powi(2) + 0.01 * mean.powi(2));
            }
        }
        let errors = of(&ours, &truth, &counted);
        assert!(close(errors.relative_l2.worst, (off / norm).sqrt()));
        assert!(close(errors.rel_mse.worst, relative / n));
        assert!(close(errors.maximum.worst, largest / mean));
    }

    #[test]
    fn exposure_changes_flip_alone_and_radiance_scales_out() {
        let truth = textured();
        let ours: Vec<Rgb> = truth.iter().map(|p| p.map(|c| 0.75 * c)).collect();
        let scaled = |image: &[Rgb]| image.iter().map(|p| p.map(|c| 16.0 * c)).collect::<Vec<_>>();
        let here = of(&ours, &truth, &[true; PIXELS]);
        let (bright, bright_truth) = (scaled(&ours), scaled(&truth));
        let pair =
            |exposure_ev| Pair { ours: &bright, truth: &bright_truth, counted: &[true; PIXELS], exposure_ev };
        assert_eq!(image_errors(&[pair(-4.0)], SIZE), here, "a power of two, so even rounding is the same");
        let overexposed = image_errors(&[pair(3.0)], SIZE);
        assert_eq!(
            (overexposed.flip.worst, overexposed.relative_l2),
            (0.0, here.relative_l2),
            "all is white"
        );
    }

    #[test]
    fn what_does_not_count_is_left_out_of_all_but_flip() {
        let mut ours = [[0.5; 3]; PIXELS];
        ours[5] = [100.0; 3];
        let mut counted = [true; PIXELS];
        counted[5] = false;
        let errors = of(&ours, &[[0.5; 3]; PIXELS], &counted);
        assert_eq!([errors.relative_l2.worst, errors.rel_mse.worst, errors.maximum.worst], [0.0; 3]);
        assert!(errors.flip.worst > 0.0);
        assert_eq!(of(&ours, &[[0.5; 3]; PIXELS], &[false; PIXELS]).relative_l2.worst, 0.0, "nothing counts");
    }

    #[test]
    fn what_is_no_number_is_an_infinite_error() {
        let truth = textured();
        for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
            let mut ours = truth.clone();
            ours[7][2] = bad;
            assert_eq!(all(&of(&ours, &truth, &[true; PIXELS])), [f64::INFINITY; 4], "{bad}");
            let counted: [bool; PIXELS] = std::array::from_fn(|i| i != 7);
            assert_eq!(
                all(&of(&ours, &truth, &counted)),
                [0.0, 0.0, f64::INFINITY, 0.0],
                "{bad}, only displayed"
            );
        }
        let black = [[0.0; 3]; PIXELS];
        assert_eq!(of(&truth, &black, &[true; PIXELS]).relative_l2.worst, f64::INFINITY, "a black reference");
        assert_eq!(all(&of(&truth[1..], &truth, &[true; PIXELS])), [f64::INFINITY; 4], "another size");
    }

    #[test]
    fn flip_of_black_and_white_is_nearly_one() {
        // FLIP's largest: the paper's figure for black against white is 0.97 to 1.
        let errors = of(&[[1.0; 3]; PIXELS], &[[0.0; 3]; PIXELS], &[true; PIXELS]);
        assert!((0.95..=1.0).contains(&errors.flip.worst), "{}", errors.flip.worst);
    }

    #[test]
    fn median_and_worst_are_over_states() {
        let truth = [[0.5; 3]; PIXELS];
        let images = [0.625, 0.5, 1.0].map(|v| [[v; 3]; PIXELS]);
        let pairs: Vec<Pair<'_>> = images
            .iter()
            .map(|ours| Pair { ours, truth: &truth, counted: &[true; PIXELS], exposure_ev: 0.0 })
            .collect();
        let relative = image_errors(&pairs, SIZE).relative_l2;
        assert!(close(relative.median, 0.25) && close(relative.worst, 1.0));
    }
}
