//! Images beside their references, to look at.

use super::metrics::{Pair, displayed};
use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::{ExtendedColorType, ImageEncoder as _};
use relume_formats::state::Rgb;
use relume_formats::{Error, Place, Result};

/// Pixels between images.
const GAP: usize = 4;
/// Colour of the gaps, one that no display of light needs.
const GAP_COLOUR: [u8; 3] = [235; 3];
/// What is shown of a pixel that is no number.
const NO_NUMBER: [u8; 3] = [255, 0, 255];
/// The difference is made as bright as the brighter pixels of the reference if no more than this share of
/// what counts is then overexposed.
const OVEREXPOSED: f64 = 0.01;
/// Factors of the difference end here: what is so small cannot be seen however often it is magnified.
const MAX_FACTOR: f32 = 1000.0;

/// A PNG with a row for each pair: ours, the truth, |ours − truth| times a factor, which is returned too. It
/// is the same for all rows: the largest of 1, 2, 5, 10, … 1000 that leaves all but one in a hundred of the
/// channels that count below white.
///
/// Linear radiance L is shown as sRGB(clamp(2^ev L)); nothing is scaled otherwise. Pixels of ours that are no
/// numbers are magenta, in the difference too.
///
/// # Errors
/// If there is no pair, or one has not `size` pixels.
pub fn beside(rows: &[Pair<'_>], size: [u32; 2]) -> Result<(Vec<u8>, f32)> {
    let refuse = |reason: String| Err(Error::invalid(&Place::file("picture"), reason));
    let [width, height] = size.map(|n| n as usize);
    if width == 0
        || rows.is_empty()
        || rows.iter().any(|pair| pair.ours.len() != width * height || pair.truth.len() != width * height)
    {
        return refuse(format!("expected images of {width}×{height} pixels; render all states at one size"));
    }
    let factor = factor(rows);
    let line = 3 * (3 * width + 2 * GAP);
    let mut bytes = Vec::with_capacity(line * (height + GAP) * rows.len());
    for (number, pair) in rows.iter().enumerate() {
        if number > 0 {
            bytes.extend(GAP_COLOUR.iter().cycle().take(line * GAP));
        }
        append(&mut bytes, pair, width, factor);
    }
    let [columns, lines] = [line / 3, bytes.len() / line.max(1)];
    Ok((encoded(&bytes, [columns as u32, lines as u32])?, factor))
}

/// A PNG of linear radiance, shown as in [`beside`] at an exposure of `exposure_ev`.
///
/// # Errors
/// If it has not `size` pixels.
pub fn alone(pixels: &[Rgb], size: [u32; 2], exposure_ev: f32) -> Result<Vec<u8>> {
    encoded(&shown(pixels, exposure_ev.exp2()), size)
}

/// The PNG of `size` pixels of three bytes each.
fn encoded(bytes: &[u8], [width, height]: [u32; 2]) -> Result<Vec<u8>> {
    let mut file = Vec::new();
    let encoder = PngEncoder::new_with_quality(&mut file, CompressionType::Best, FilterType::Adaptive);
    let reason = |e| format!("{width}×{height} pixels do not fit a PNG: {e}; show fewer or smaller images");
    let refuse = |e| Error::invalid(&Place::file("picture"), reason(e));
    // Not the encoder's own check, which is an assertion.
    if bytes.len() as u64 != 3 * u64::from(width) * u64::from(height) {
        return Err(Error::invalid(
            &Place::file("picture"),
            format!("expected {width}×{height} pixels; render at that size"),
        ));
    }
    encoder.write_image(bytes, width, height, ExtendedColorType::Rgb8).map_err(refuse)?;
    Ok(file)
}

/// Three images side by side, line by line.
fn append(bytes: &mut Vec<u8>, pair: &Pair<'_>, width: usize, factor: f32) {
    let gain = pair.exposure_ev.exp2();
    let difference: Vec<Rgb> =
        pair.ours.iter().zip(pair.truth).map(|(x, t)| std::array::from_fn(|c| (x[c] - t[c]).abs())).collect();
    let images = [shown(pair.ours, gain), shown(pair.truth, gain), shown(&difference, gain * factor)];
    for row in 0..pair.ours.len() / width {
        for (at, image) in images.iter().enumerate() {
            if at > 0 {
                bytes.extend(GAP_COLOUR.iter().cycle().take(3 * GAP));
            }
            bytes.extend(image.iter().skip(3 * row * width).take(3 * width));
        }
    }
}

fn shown(pixels: &[Rgb], gain: f32) -> Vec<u8> {
    let mut bytes = displayed(pixels, gain);
    for (pixel, bytes) in pixels.iter().zip(bytes.chunks_exact_mut(3)) {
        if pixel.iter().any(|c| !c.is_finite()) {
            bytes.copy_from_slice(&NO_NUMBER);
        }
    }
    bytes
}

/// The largest round factor that overexposes few enough of the differences.
fn factor(rows: &[Pair<'_>]) -> f32 {
    let mut differences: Vec<f32> = rows.iter().flat_map(differences).filter(|d| d.is_finite()).collect();
    differences.sort_by(f32::total_cmp);
    let below = ((1.0 - OVEREXPOSED) * differences.len() as f64) as usize;
    let bright = differences.get(below).or(differences.last()).copied().unwrap_or(0.0);
    let steps = [1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0, 200.0, 500.0, MAX_FACTOR];
    // No difference at all needs no factor.
    let fitting = steps.into_iter().rfind(|factor| bright > 0.0 && factor * bright <= 1.0);
    fitting.unwrap_or(1.0)
}

/// |ours − truth| of what counts, as it is displayed but for the clamp and the curve.
fn differences<'a>(pair: &Pair<'a>) -> impl Iterator<Item = f32> + use<'a> {
    let gain = pair.exposure_ev.exp2();
    let pixels = pair.ours.iter().zip(pair.truth).zip(pair.counted).filter(|(_, counted)| **counted);
    pixels.flat_map(move |((ours, truth), _)| ours.iter().zip(truth).map(move |(x, t)| (x - t).abs() * gain))
}

#[cfg(test)]
mod tests {
    use super::*;
    use relume_formats::basis::srgb_from_linear;

    const SIZE: [u32; 2] = [5, 3];

    fn decoded(png: &[u8]) -> image::RgbImage {
        image::load_from_memory(png).unwrap().into_rgb8()
    }

    fn pair<'a>(ours: &'a [Rgb], truth: &'a [Rgb]) -> Pair<'a> {
        Pair { ours, truth, counted: &[true; 15], exposure_ev: 1.0 }
    }

    #[test]
    fn ours_truth_and_difference_stand_side_by_side() {
        let truth: [Rgb; 15] = std::array::from_fn(|i| [0.01 * i as f32, 0.3, 0.2]);
        let ours = truth.map(|p| [p[0], p[1] + 0.011, p[2] - 0.002]);
        let (png, factor) = beside(&[pair(&ours, &truth), pair(&truth, &truth)], SIZE).unwrap();
        // The largest difference is displayed at 2 · 0.011: 20 times is 0.44, 50 times would be over 1.
        assert_eq!(factor, 20.0);
        let image = decoded(&png);
        assert_eq!(image.dimensions(), (3 * 5 + 2 * 4, 2 * 3 + 4));
        let expected = |p: Rgb, gain: f32| image::Rgb(p.map(|c| srgb_from_linear(c * gain)));
        for i in 0..15 {
            let (x, y) = (i as u32 % 5, i as u32 / 5);
            assert_eq!(*image.get_pixel(x, y), expected(ours[i], 2.0));
            assert_eq!(*image.get_pixel(x + 9, y), expected(truth[i], 2.0));
            let difference = std::array::from_fn(|c| (ours[i][c] - truth[i][c]).abs());
            assert_eq!(*image.get_pixel(x + 18, y), expected(difference, 40.0));
            assert_eq!(
                *image.get_pixel(x + 18, y + 7),
                image::Rgb([0; 3]),
                "the second row has no difference"
            );
        }
        assert_eq!([(6, 0), (14, 2), (0, 3), (22, 6)].map(|(x, y)| image.get_pixel(x, y).0), [GAP_COLOUR; 4]);
    }

    #[test]
    fn an_image_alone_is_exposed_and_of_its_size() {
        let pixels: [Rgb; 15] = std::array::from_fn(|i| [0.01 * i as f32, 0.3, 0.2]);
        let image = decoded(&alone(&pixels, SIZE, -1.0).unwrap());
        assert_eq!(
            (image.dimensions(), image.get_pixel(4, 2).0),
            ((5, 3), pixels[14].map(|c| srgb_from_linear(0.5 * c)))
        );
        assert!(alone(&pixels, [4, 3], 0.0).unwrap_err().to_string().contains("expected 4×3 pixels"));
    }

    #[test]
    fn what_is_no_number_is_magenta_and_no_difference_has_factor_one() {
        let truth = [[0.25; 3]; 15];
        let mut ours = truth;
        ours[2][1] = f32::NAN;
        let (png, factor) = beside(&[pair(&ours, &truth)], SIZE).unwrap();
        let image = decoded(&png);
        assert_eq!([2, 20].map(|x| image.get_pixel(x, 0).0), [NO_NUMBER; 2]);
        assert_eq!((factor, image.get_pixel(11, 0).0), (1.0, [188; 3]));
    }

    #[test]
    fn other_sizes_are_refused() {
        let image = [[0.25; 3]; 15];
        for (rows, size) in
            [(vec![], SIZE), (vec![pair(&image, &image[1..])], SIZE), (vec![pair(&image, &image)], [4, 4])]
        {
            assert!(beside(&rows, size).unwrap_err().to_string().contains("render all states at one size"));
        }
    }
}
