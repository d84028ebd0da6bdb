//! Halves of images as small numbers: what a half is off the value that its neighbours predict.
//!
//! A half is a number of *steps*, the largest power of two that divides all of an image. A step is written
//! as if it were the least half, 2⁻²⁴, so that bits that no value of the image uses take no room: the *code* of
//! a half is the bits of that other half, negated below 0. Codes grow with the logarithm of large values, and
//! linearly near 0.
//!
//! A code is predicted by those of the neighbours to the left, above and between, by the median edge detector
//! of JPEG-LS (Weinberger, Seroussi and Sapiro 2000); stored is what it is off by, modulo 2¹⁶, as 0, −1, 1,
//! −2, 2 … Where there are three channels, the first and the last store what they are off by more than the
//! middle one: light of one colour differs by the same factor everywhere.

use super::LARGEST_HALF;
use crate::container::Section;
use crate::error::Result;
use half::f16;

/// The bits of the largest half.
const LARGEST_BITS: u32 = 0x7bff;
/// The largest exponent of a step over the least half, 2⁻²⁴: that of a half of a single bit, 2¹⁵.
pub const MAX_STEP: u16 = 39;
/// How far the largest half of an image may be beyond its range, in parts of it: the logarithm behind its
/// scale is rounded.
const RANGE_TOLERANCE: f32 = 0.01;

/// The neighbours of every fragment that predict its values: to the left, above, and above to the left.
///
/// A fragment's neighbours are of its class. Numbers are one more than the fragment's; 0 stands for a value
/// of 0. Without a neighbour above, that to the left stands for it, and the other way round; without either, the
/// fragment before stands for both.
pub struct Neighbours(Vec<[u32; 3]>);

impl Neighbours {
    /// Of all fragments of a film that is so wide, by `pixel` and `class`, the first `editable` of which are of
    /// editable materials.
    pub fn new(width: u32, editable: usize, (all_pixels, classes): (&[u32], &[u16])) -> Self {
        // Films of no width are refused, but only when they are read.
        let width = width.max(1);
        let count = all_pixels.len();
        let mut neighbours = Vec::with_capacity(count);
        for range in [0..editable.min(count), editable.min(count)..count] {
            let key = |at: usize| (all_pixels[at], classes[at]);
            // Both what is asked for and what there is are in order.
            let mut finders = [range.start; 3];
            for here in range.clone() {
                let (pixel, class) = key(here);
                let is_first = pixel % width == 0;
                let wanted = [
                    (!is_first).then_some(1),
                    (pixel >= width).then_some(width),
                    (!is_first && pixel > width).then_some(width + 1),
                ];
                let found: [Option<u32>; 3] = std::array::from_fn(|which| {
                    let wanted = (pixel - wanted[which]?, class);
                    let at = &mut finders[which];
                    while *at < here && key(*at) < wanted {
                        *at += 1;
                    }
                    (*at < here && key(*at) == wanted).then_some(*at as u32 + 1)
                });
                let [left, above, between] = found;
                let left_or = left.or(above).unwrap_or(here as u32);
                neighbours.push([left_or, above.unwrap_or(left_or), between.unwrap_or(left_or)]);
            }
        }
        Self(neighbours)
    }
}

/// What is stored of `values`, [`channels`, fragments]: their step, and [what they are off by](encode).
pub fn written(values: &[f16], channels: usize, neighbours: &Neighbours) -> Vec<u16> {
    let step = step_of(values);
    let mut stored = vec![step];
    stored.extend(encode(values, channels, step, neighbours));
    stored
}

/// The inverse of [`written`], of an image with this scale.
///
/// # Errors
/// `Invalid` where `section` holds what is no half, or not in the range that the scale gives.
pub(crate) fn read(
    section: &Section,
    channels: usize,
    neighbours: &Neighbours,
    scale: f32,
) -> Result<Vec<f16>> {
    let stored = section.u16s()?;
    let values = stored
        .split_first()
        .filter(|(step, _)| **step <= MAX_STEP)
        .and_then(|(step, stored)| decode(stored, channels, *step, neighbours))
        .ok_or_else(|| section.invalid("holds what is no half"))?;
    section.expect(fault_of_range(scale, &values))?;
    Ok(values)
}

/// An image uses the range that its scale gives it, neither more nor less than half.
fn fault_of_range(scale: f32, values: &[f16]) -> Option<String> {
    // Without their signs the bits of halves are in the order of their sizes.
    let largest = values.iter().map(|v| v.to_bits() & 0x7fff).max().unwrap_or(0);
    let largest = f16::from_bits(largest).to_f32();
    let most = LARGEST_HALF * (1.0 + RANGE_TOLERANCE);
    let least = LARGEST_HALF / 2.0 * (1.0 - RANGE_TOLERANCE);
    if scale == 0.0 {
        return (largest > 0.0).then(|| format!("has values up to {largest} and scale 0"));
    }
    (!(least..=most).contains(&largest))
        .then(|| format!("its largest value is {largest}, outside {least}..{most}"))
}

/// The exponent over 2⁻²⁴ of the largest power of two that divides all of `values`; 0 if all are 0.
pub fn step_of(values: &[f16]) -> u16 {
    let lowest_bit = |value: &f16| {
        let (exponent, fraction) = parts(value.to_bits());
        fraction.trailing_zeros() as u16 + exponent
    };
    values.iter().filter(|value| value.to_bits() & 0x7fff != 0).map(lowest_bit).min().unwrap_or(0)
}

/// The size of a half as `fraction` · 2^`exponent` · 2⁻²⁴.
fn parts(bits: u16) -> (u16, u32) {
    let (exponent, fraction) = ((bits >> 10) & 31, u32::from(bits & 1023));
    if exponent == 0 { (0, fraction) } else { (exponent - 1, fraction | 1024) }
}

/// What `values`, [`channels`, fragments], are off by what predicts them, in steps of exponent `step`, which
/// divide them.
pub fn encode(values: &[f16], channels: usize, step: u16, neighbours: &Neighbours) -> Vec<u16> {
    let fragments = values.len() / channels;
    let code = |value: &f16| {
        let bits = value.to_bits();
        let size = rescaled(u32::from(bits & 0x7fff), -i32::from(step)) as i16;
        if bits & 0x8000 == 0 { size } else { -size }
    };
    let mut off = vec![0; values.len()];
    for (off, values) in off.chunks_exact_mut(fragments.max(1)).zip(values.chunks_exact(fragments.max(1))) {
        let codes: Vec<i16> = std::iter::once(0).chain(values.iter().map(code)).collect();
        for ((off, code), around) in off.iter_mut().zip(&codes[1..]).zip(&neighbours.0) {
            *off = code.wrapping_sub(predicted(&codes, around));
        }
    }
    if let Some([first, middle, last]) = three(&mut off, fragments, channels) {
        for ((first, middle), last) in first.iter_mut().zip(middle).zip(last) {
            (*first, *last) = (first.wrapping_sub(*middle), last.wrapping_sub(*middle));
        }
    }
    off.into_iter().map(folded).collect()
}

/// The inverse of [`encode`]; `None` where `stored` is none of halves that are finite.
pub fn decode(stored: &[u16], channels: usize, step: u16, neighbours: &Neighbours) -> Option<Vec<f16>> {
    let fragments = stored.len() / channels;
    let mut off: Vec<i16> = stored.iter().map(|stored| unfolded(*stored)).collect();
    if let Some([first, middle, last]) = three(&mut off, fragments, channels) {
        for ((first, middle), last) in first.iter_mut().zip(middle).zip(last) {
            (*first, *last) = (first.wrapping_add(*middle), last.wrapping_add(*middle));
        }
    }
    // Codes from 1024 on have an exponent, which the step's is added to.
    let bits =
        |size: u32| if size < 1024 { rescaled(size, step.into()) } else { size + (u32::from(step) << 10) };
    let mut bits_of: Vec<u16> = Vec::new();
    let mut values = Vec::with_capacity(stored.len());
    let mut codes: Vec<i16> = vec![0; fragments + 1];
    for off in off.chunks_exact(fragments.max(1)) {
        let mut before = 0;
        for (at, (off, around)) in (1..).zip(off.iter().zip(&neighbours.0)) {
            let [left, above, between] = *around;
            // Nearly always the last one, which need not come from memory.
            let left = if left as usize + 1 == at { before } else { code_at(&codes, left) };
            before = off.wrapping_add(median(left, code_at(&codes, above), code_at(&codes, between)));
            codes[at] = before;
        }
        // The larger the code, the larger the half.
        let largest = codes.iter().map(|code| code.unsigned_abs()).max().unwrap_or(0);
        if bits(largest.into()) > LARGEST_BITS {
            return None;
        }
        bits_of.extend((bits_of.len()..=largest.into()).map(|size| bits(size as u32) as u16));
        let half = |code: &i16| {
            let bits = bits_of.get(usize::from(code.unsigned_abs())).copied().unwrap_or_default();
            f16::from_bits(bits | (*code as u16 & 0x8000))
        };
        values.extend(codes[1..].iter().map(half));
    }
    Some(values)
}

/// The bits of a half of size `bits`, times 2^`exponent`; the product must be a half, or is beyond all.
fn rescaled(bits: u32, exponent: i32) -> u32 {
    let (own, fraction) = parts(bits as u16);
    if fraction == 0 {
        return 0;
    }
    let lowest = i32::from(own) + exponent + fraction.trailing_zeros() as i32;
    let fraction = fraction >> fraction.trailing_zeros();
    let top = lowest + 31 - fraction.leading_zeros() as i32;
    if top < 10 {
        fraction << lowest
    } else {
        (((top - 9) as u32) << 10) | ((fraction << (lowest + 10 - top)) & 1023)
    }
}

/// What the codes around predict, by the median edge detector.
#[inline]
fn predicted(codes: &[i16], around: &[u32; 3]) -> i16 {
    let [left, above, between] = around.map(|at| code_at(codes, at));
    median(left, above, between)
}

#[inline]
fn code_at(codes: &[i16], at: u32) -> i16 {
    codes.get(at as usize).copied().unwrap_or_default()
}

#[inline]
fn median(left: i16, above: i16, between: i16) -> i16 {
    let (low, high) = (left.min(above), left.max(above));
    // The plane through the three, if it is between the two.
    let plane = i32::from(left) + i32::from(above) - i32::from(between);
    plane.clamp(low.into(), high.into()) as i16
}

/// The three channels, if there are as many.
fn three(values: &mut [i16], fragments: usize, channels: usize) -> Option<[&mut [i16]; 3]> {
    if channels != 3 {
        return None;
    }
    let (first, rest) = values.split_at_mut(fragments);
    let (middle, last) = rest.split_at_mut(fragments);
    Some([first, middle, last])
}

/// 0, −1, 1, −2, 2 … as 0, 1, 2, 3, 4 …
fn folded(value: i16) -> u16 {
    ((value << 1) ^ (value >> 15)) as u16
}

fn unfolded(stored: u16) -> i16 {
    (stored >> 1) as i16 ^ -((stored & 1) as i16)
}

#[cfg(test)]
mod tests {
    use super::super::{Head, Meta};
    use super::*;

    /// Of a film 5 wide, with these (pixel, class), those of two editable materials first.
    fn head(fragments: &[(u32, u16)]) -> Head {
        let editable = fragments.partition_point(|(_, class)| *class < 2);
        Head {
            meta: Meta {
                size: [5, 8],
                materials: vec!["a".to_owned(), "b".to_owned()],
                bases: 2,
                chromaticity: None,
                samples: 1,
                seed: 0,
                editable_fragments: editable as u32,
            },
            later: None,
            pixel: fragments.iter().map(|(pixel, _)| *pixel).collect(),
            class: fragments.iter().map(|(_, class)| *class).collect(),
            coverage: vec![f16::ONE; fragments.len()],
            scales: Vec::new(),
        }
    }

    /// Some fragments of all classes, on a film that is nowhere quite full.
    fn some() -> Vec<(u32, u16)> {
        let some = |from: u32, class: u16, every: u32| {
            (from..40).filter(move |pixel| pixel % every != 1).map(move |pixel| (pixel, class))
        };
        let mut editable: Vec<_> = some(0, 0, 7).chain(some(3, 1, 3)).collect();
        editable.sort_unstable();
        editable.into_iter().chain(some(1, 2, 4)).collect()
    }

    #[test]
    fn neighbours_are_the_fragments_of_their_class_beside_and_above() {
        let fragments = some();
        let Neighbours(found) = head(&fragments).neighbours();
        for (at, (pixel, class)) in fragments.iter().enumerate() {
            let number = |dx: u32, dy: u32| {
                let is_inside = pixel % 5 >= dx && pixel / 5 >= dy;
                let wanted = is_inside.then(|| (pixel - dx - 5 * dy, *class))?;
                fragments.iter().position(|other| *other == wanted).map(|at| at as u32 + 1)
            };
            let before = at as u32;
            let left = number(1, 0).or(number(0, 1)).unwrap_or(before);
            let expected = [left, number(0, 1).unwrap_or(left), number(1, 1).unwrap_or(left)];
            assert_eq!(found[at], expected, "{pixel} {class}");
        }
    }

    /// Every finite half, with steps of all sizes, of one channel and of three.
    #[test]
    fn all_halves_come_back() {
        let fragments: Vec<(u32, u16)> = (0..40).map(|pixel| (pixel, 2)).collect();
        let neighbours = head(&fragments).neighbours();
        let halves: Vec<u16> = (0..=u16::MAX).filter(|bits| f16::from_bits(*bits).is_finite()).collect();
        for step in 0..=MAX_STEP {
            let divides = |bits: &&u16| {
                let (exponent, fraction) = parts(**bits);
                fraction == 0 || fraction.trailing_zeros() as u16 + exponent >= step
            };
            let values: Vec<f16> = halves.iter().filter(divides).map(|bits| f16::from_bits(*bits)).collect();
            for values in values.chunks(120) {
                let values: Vec<f16> = values.iter().copied().cycle().take(120).collect();
                assert!(step_of(&values) >= step);
                for (channels, values) in [(1, &values[..40]), (3, &values[..])] {
                    let stored = encode(values, channels, step, &neighbours);
                    let back = decode(&stored, channels, step, &neighbours).unwrap();
                    for (a, b) in back.iter().zip(values) {
                        // A negative 0 is a 0.
                        assert!(
                            a == b && (b.to_f32() == 0.0 || a.to_bits() == b.to_bits()),
                            "{step} {a} {b}"
                        );
                    }
                }
            }
        }
    }

    /// Edges are predicted but for where they start, ramps to a step of theirs, whatever the scale; one colour
    /// takes no more room than grey.
    #[test]
    fn what_is_smooth_takes_little_room() {
        let fragments: Vec<(u32, u16)> = (0..40).map(|pixel| (pixel, 2)).collect();
        let neighbours = head(&fragments).neighbours();
        let ramp = |pixel: u32| f16::from_f32(64.0 * (3.0 + (pixel % 5) as f32 + 2.0 * (pixel / 5) as f32));
        let edge = |pixel: u32| f16::from_f32(if pixel % 5 < 2 { 8.0 } else { 4096.0 });
        let images: [(&dyn Fn(u32) -> f16, u16); 2] = [(&ramp, 1), (&edge, 0)];
        for (image, most) in images {
            let grey: Vec<f16> = (0..40).map(image).collect();
            let off = encode(&grey, 1, step_of(&grey), &neighbours);
            let inside = |pixel: &usize| !pixel.is_multiple_of(5) && pixel / 5 > 0;
            assert!((0..40).filter(inside).all(|pixel| off[pixel] <= folded(most as i16)), "{off:?}");
            let twice: Vec<f16> = grey.iter().map(|v| f16::from_f32(v.to_f32() * 8.0)).collect();
            let colour = [&grey[..], &grey, &grey].concat();
            let off = encode(&colour, 3, step_of(&colour), &neighbours);
            assert!(off[..40].iter().chain(&off[80..]).all(|off| *off == 0), "{off:?}");
            let [fine, coarse] = [&grey, &twice].map(|grey| encode(grey, 1, step_of(grey), &neighbours));
            assert_eq!(fine, coarse);
        }
    }

    #[test]
    fn what_is_no_finite_half_is_refused() {
        let neighbours = head(&[(0, 2)]).neighbours();
        for (code, step, is_half) in [
            (0x7bffi16, 0, true),
            (0x7c00, 0, false),
            (i16::MIN, 0, false),
            (-0x7bff, 0, true),
            (0x7bff, 1, false),
            (1, 39, true),
            (3, 39, false),
        ] {
            assert_eq!(decode(&[folded(code)], 1, step, &neighbours).is_some(), is_half, "{code} {step}");
        }
    }
}
