//! How much a coefficient of transfer is likely to matter: its size times what light usually has there.
//!
//! If the coefficients of light were independent with standard deviations σ, the best terms to keep would be
//! those of largest |transfer|·σ. Environment maps have more of low frequencies than of high ones; more
//! difference between above and below than between left and right, for they have a horizon; and little light
//! from below. The three numbers of that are the ones that serve the thirteen of the eighteen maps of
//! `@pmndrs/assets` best that no figure in docs/notes/SPARSE-TRANSFER.md is measured under, at several
//! rotations. Tables with a number for every level, type, face and elevation did no better on maps that they
//! were not fitted to.

use relume_formats::basis::cubemap::FACES;
use relume_formats::basis::haar::{self, Wavelet};

/// σ falls with the area of the support to this power.
const AREA_POWER: f32 = 1.0 / 3.0;
/// Top minus bottom on the four side faces: 2^(5/4).
const VERTICAL: f32 = 2.378_414_2;
/// All wavelets on the face that looks down.
const BELOW: f32 = 0.5;
/// Scaling functions come first: with the six of them, even light and light that is a whole face are exact.
/// It changes no other error.
const SCALING: f32 = 1e6;

const DOWN: usize = 3;
const SIDES: [usize; 4] = [0, 1, 4, 5];
const TOP_MINUS_BOTTOM: usize = 2;

/// The weights of all coefficients of `cubes` cubes of `face_size`² texels a face.
pub fn weights(face_size: usize, cubes: usize) -> Vec<f32> {
    let texels = face_size * face_size;
    let of_cube = |_| (0..FACES * texels).map(|index| weight(index / texels, index % texels, face_size));
    (0..cubes).flat_map(of_cube).collect()
}

fn weight(face: usize, index: usize, face_size: usize) -> f32 {
    match haar::describe(index, face_size) {
        Wavelet::Scaling => SCALING,
        Wavelet::Detail { level, m, .. } => {
            let area = 0.25_f32.powi(level as i32);
            let vertical = if m == TOP_MINUS_BOTTOM && SIDES.contains(&face) { VERTICAL } else { 1.0 };
            let below = if face == DOWN { BELOW } else { 1.0 };
            area.powf(AREA_POWER) * vertical * below
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_are_those_of_the_rule() {
        let n = 8;
        let both = weights(n, 2);
        let (weights, again) = both.split_at(6 * n * n);
        assert_eq!(weights, again);
        let at = |face: usize, level, m| weights[face * n * n + haar::index(level, m, 0, 0)];
        assert_eq!(weights.len(), 6 * n * n);
        assert!([0, 3].iter().all(|face| weights[face * n * n] == 1e6));
        assert_eq!((at(0, 0, 1), at(2, 0, 2), at(3, 0, 2)), (1.0, 1.0, 0.5));
        assert!((at(4, 0, 2) - 2.0_f32.powf(1.25)).abs() < 1e-6);
        assert!((at(1, 2, 3) - 16.0_f32.powf(-1.0 / 3.0)).abs() < 1e-6);
    }
}
