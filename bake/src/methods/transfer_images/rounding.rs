//! Values rounded to steps that no picture shows, so that files do not spell out the noise of paths.
//!
//! How bright pictures are is told by that of white matt materials, and an image counts in a picture by its
//! basis functions' largest coefficients. All images are rounded to steps that count alike there:
//! [`STEPS_OF_MIDDLE`] are the middle fragment, and [`STEPS_OF_DARK`] a dark one. What dozens of images are off
//! by adds up to a few parts in 10,000 of the former, where bases alone leave ten times as much. Later reflections,
//! which are a per cent off or more for want of what is known of materials there, have [`STEPS_OF_LATER`]: by
//! calculation those of eight materials, with 45 nodes, add up to half a per cent of the middle.

use crate::compress::quantise::scale_for;
use half::f16;
use rayon::prelude::*;
use relume_formats::kinds::transfer_images::{Image, Layout};

/// Least steps that the middle one of all fragments that are lit is worth.
const STEPS_OF_MIDDLE: f32 = 2048.0;
/// The same of images of later reflections.
const STEPS_OF_LATER: f32 = 256.0;
/// Which part of the fragments is darker than a dark one, and least steps that it is worth.
const DARK: f64 = 0.05;
const STEPS_OF_DARK: f32 = 64.0;
/// What is darker than this part of the middle does not make steps finer.
const DARKEST: f32 = 1.0 / 1024.0;
/// Least square of a coefficient, in parts of 1: what counts less is as good as nothing.
const LEAST_WEIGHT: f64 = 1e-12;

/// Rounds `images`, of these `scales` by slot, and gives them the scales of what is left; `weights` are the
/// largest squares of what a slot's values are multiplied with.
pub fn round(images: &mut [Image], scales: &mut [f32], layout: &Layout, weights: &[f64]) {
    let Some([early, later]) = steps_of_picture(images, scales, layout) else { return };
    let rounded: Vec<(usize, f32)> = images
        .par_iter_mut()
        .filter(|image| scales[image.slot] > 0.0)
        .map(|image| {
            let factor = weights[image.slot].max(LEAST_WEIGHT).sqrt();
            let scale = scales[image.slot];
            let step = if layout.slots[image.slot].first.is_later() { later } else { early };
            let step = (f64::from(step) / factor).log2().floor().exp2() / f64::from(scale);
            // From the least half, which rounds nothing, to more than twice the largest, which leaves nothing.
            let step = step.clamp(f64::from(f16::from_bits(1)), 131_072.0) as f32;
            (image.slot, round_image(&mut image.values, scale, step))
        })
        .collect();
    rounded.into_iter().for_each(|(slot, scale)| scales[slot] = scale);
}

/// The steps, in radiance, of an image that counts 1: of at most two reflections and of later ones; `None` if
/// nothing is lit.
fn steps_of_picture(images: &[Image], scales: &[f32], layout: &Layout) -> Option<[f32; 2]> {
    // All but later reflections add up; of these, there are some at each node.
    let (mut picture, mut later): (Vec<f32>, Vec<f32>) = (Vec::new(), Vec::new());
    for image in images.iter().filter(|image| layout.slots[image.slot].is_positive()) {
        let slot = &layout.slots[image.slot];
        let fragments = image.values.len() / slot.channels();
        let mut grey = vec![0.0; fragments];
        for channel in image.values.chunks_exact(fragments.max(1)) {
            let share = scales[image.slot] / slot.channels() as f32;
            grey.iter_mut().zip(channel).for_each(|(sum, value)| *sum += value.to_f32() * share);
        }
        let is_later = slot.first.is_later();
        let joined = if is_later { &mut later } else { &mut picture };
        joined.resize(joined.len().max(fragments), 0.0);
        let join = |(all, one): (&mut f32, &f32)| *all = if is_later { all.max(*one) } else { *all + one };
        joined.iter_mut().zip(&grey).for_each(join);
    }
    picture.resize(picture.len().max(later.len()), 0.0);
    picture.iter_mut().zip(&later).for_each(|(all, later)| *all += later);
    picture.retain(|radiance| *radiance > 0.0);
    picture.sort_by(f32::total_cmp);
    let at = |part: f64| picture.get((part * picture.len() as f64) as usize).copied();
    let (dark, middle) = (at(DARK)?, at(0.5)?);
    let of_dark = dark.max(middle * DARKEST) / STEPS_OF_DARK;
    Some([STEPS_OF_MIDDLE, STEPS_OF_LATER].map(|steps| (middle / steps).min(of_dark)))
}

/// Rounds halves to multiples of `step`, a power of two, and returns the scale that suits them then.
fn round_image(values: &mut [f16], scale: f32, step: f32) -> f32 {
    let rounded = |value: f16| (value.to_f32() / step).round_ties_even() * step;
    let largest = values.iter().map(|value| rounded(*value).abs()).fold(0.0, f32::max);
    let to = scale_for(largest * scale);
    // Powers of two, so that this is exact.
    let times = if to > 0.0 { scale / to } else { 0.0 };
    values.iter_mut().for_each(|value| *value = f16::from_f32(rounded(*value) * times));
    to
}

#[cfg(test)]
mod tests {
    use super::*;
    use relume_formats::kinds::transfer_images::{LaterImages, Slot};

    /// One editable material of two bases and light of two colours: slots 0 to 3 are matt, then the other
    /// basis'.
    fn layout() -> Layout {
        Layout::new(1, 2, false, None)
    }

    fn image(slot: usize, values: &[f32], scale: f32) -> Image {
        let values = values.iter().map(|value| f16::from_f32(value / scale)).collect::<Vec<_>>();
        Image { slot, values: values.repeat(3) }
    }

    /// Steps are what is asked for of each, whatever the scale; what is left has the scale that suits it.
    #[test]
    fn steps_count_alike_in_a_picture() {
        let values: Vec<f32> = (0..1000).map(|i| 0.4 + 0.001 * i as f32).collect();
        let weak: Vec<f32> = values.iter().map(|v| 1e-2 * (v - 0.9)).collect();
        let mut scales = [1.4f32, 0.005, 1e-6].map(scale_for).to_vec();
        let glossy = layout().slots.iter().position(|slot| slot.eye_basis == 1).unwrap();
        let slots = [0, glossy, glossy + 1];
        let mut by_slot = vec![0.0; layout().slots.len()];
        slots.iter().zip(&scales).for_each(|(slot, scale)| by_slot[*slot] = *scale);
        let mut images = vec![
            image(slots[0], &values, scales[0]),
            image(slots[1], &weak, scales[1]),
            image(slots[2], &[1e-6, -1e-6], scales[2]),
        ];
        let mut weights = vec![1.0; layout().slots.len()];
        weights[slots[1]] = 0.25;
        round(&mut images, &mut by_slot, &layout(), &weights);
        scales = slots.map(|slot| by_slot[slot]).to_vec();
        // The middle value is 0.9: of 2048 parts of it the next power of two is 2⁻¹²; a dark one is no finer.
        for (which, exact, step) in [(0, &values, 2f32.powi(-12)), (1, &weak, 2f32.powi(-11))] {
            for (half, exact) in images[which].values.iter().zip(exact.repeat(3)) {
                let value = half.to_f32() * scales[which];
                assert_eq!((value / step).fract(), 0.0);
                // Half a step, and what halves had been off by: 2⁻¹¹.
                assert!((value - exact).abs() <= 0.5 * step + exact.abs() * 5e-4, "{value} {exact}");
            }
            let largest = images[which].values.iter().map(|v| v.to_f32().abs()).fold(0.0, f32::max);
            assert_eq!(scale_for(largest * scales[which]), scales[which]);
        }
        assert_eq!(scales[2], 0.0, "nothing that shows is left of it");
        assert!(images[2].values.iter().all(|value| *value == f16::ZERO));
    }

    /// Where a tenth of the picture is a thousandth as bright, it is still worth dozens of steps.
    #[test]
    fn dark_places_keep_their_steps() {
        let values: Vec<f32> = (0..1000).map(|i| if i % 10 == 0 { 1e-3 } else { 1.0 }).collect();
        let mut scales = vec![scale_for(1.0); layout().slots.len()];
        let mut images = vec![image(0, &values, scales[0])];
        let weights = vec![1.0; scales.len()];
        round(&mut images, &mut scales, &layout(), &weights);
        let dark = images[0].values[0].to_f32() * scales[0];
        assert!((dark / 1e-3 - 1.0).abs() < 1.0 / 128.0, "{dark}");
    }

    /// Images of later reflections have coarser steps, but where dark places want them fine.
    #[test]
    fn later_reflections_have_coarser_steps() {
        let later = LaterImages { nodes: 1, eye_bases: 1, ..LaterImages::default() };
        let layout = Layout::new(1, 2, false, Some(later));
        let is_later = |slot: &Slot| slot.first.is_later();
        let slots = [0, layout.slots.iter().position(is_later).unwrap()];
        for (darkest, steps) in [(0.4, [2f32.powi(-11), 2f32.powi(-8)]), (1e-3, [2f32.powi(-16); 2])] {
            let values: Vec<f32> = (0..1000).map(|i| if i % 10 == 0 { darkest } else { 0.5 }).collect();
            let mut scales = vec![scale_for(0.5); layout.slots.len()];
            let mut images = slots.map(|slot| image(slot, &values, scales[slot]));
            round(&mut images, &mut scales, &layout, &vec![1.0; layout.slots.len()]);
            for (image, step) in images.iter().zip(steps) {
                let dark = image.values[0].to_f32() * scales[image.slot];
                assert_eq!((dark / step).fract(), 0.0, "{dark} {step}");
                assert!((dark - darkest).abs() <= 0.5 * step + darkest * 5e-4, "{dark} {step}");
            }
        }
    }

    #[test]
    fn black_stays_black() {
        let mut scales = vec![0.0; layout().slots.len()];
        let mut images = vec![image(0, &[0.0; 3], 1.0)];
        let weights = vec![1.0; scales.len()];
        round(&mut images, &mut scales, &layout(), &weights);
        assert!(images[0].values.iter().all(|v| *v == f16::ZERO) && scales.iter().all(|s| *s == 0.0));
    }

    /// What is brighter or dimmer than the picture by more than single precision holds is rounded to nothing or
    /// not at all, and never to what is no number.
    #[test]
    fn extremes_stay_finite() {
        for (scale, largest) in [(2f32.powi(-145), 2f32.powi(-131)), (2f32.powi(100), 2f32.powi(114))] {
            let glossy = layout().slots.iter().position(|slot| slot.eye_basis == 1).unwrap();
            let mut scales = vec![scale_for(1.0); layout().slots.len()];
            let mut images = vec![image(0, &[1.0; 3], scales[0]), image(glossy, &[1.0, 0.5, 0.25], 1.0)];
            scales[glossy] = scale;
            images[1].values.iter_mut().for_each(|v| *v = f16::from_f32(v.to_f32() * (largest / scale)));
            let before = images[1].values.clone();
            let weights = vec![1.0; scales.len()];
            round(&mut images, &mut scales, &layout(), &weights);
            if scale < 1.0 {
                assert!(images[1].values.iter().all(|v| *v == f16::ZERO) && scales[glossy] == 0.0);
            } else {
                let value = |v: &f16, scale: f32| v.to_f32() * scale;
                let same = images[1].values.iter().zip(&before);
                assert!(same.clone().all(|(a, b)| value(a, scales[glossy]) == value(b, scale)));
            }
        }
    }
}
