//! How far off pictures are whose truth has noise itself.

use relume_formats::state::Rgb;

/// Sums over squares of `side` pixels of those in `pixels`.
pub fn block_sums(image: &[Rgb], pixels: &[usize], size: u32, side: usize) -> Vec<Rgb> {
    let across = size as usize / side;
    let mut sums = vec![[0.0; 3]; across * across];
    for pixel in pixels {
        let [x, y] = [pixel % size as usize, pixel / size as usize].map(|p| p / side);
        sums[y * across + x].iter_mut().zip(image[*pixel]).for_each(|(sum, value)| *sum += value);
    }
    sums
}

/// In parts of the square of the truth, of which there are two independent estimates: their noise is not in
/// it.
pub fn squared_error(image: &[Rgb], truth: &[Vec<Rgb>; 2]) -> f64 {
    let [a, b] = truth.each_ref().map(|truth| truth.as_flattened());
    let (mut error, mut norm) = (0.0, 0.0);
    for ((value, a), b) in image.as_flattened().iter().zip(a).zip(b) {
        let [value, a, b] = [value, a, b].map(|v| f64::from(*v));
        error += (value - a) * (value - b);
        norm += a * b;
    }
    error.max(0.0) / norm
}
