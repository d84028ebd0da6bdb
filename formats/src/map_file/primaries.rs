//! Colours as a map's file has them, and what they are in linear Rec. 709, in which everything is reckoned.

use crate::state::Rgb;
use glam::{DMat3, DVec3};

/// The chromaticities of a colour space, CIE 1931 xy.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Primaries {
    pub red: [f64; 2],
    pub green: [f64; 2],
    pub blue: [f64; 2],
    pub white: [f64; 2],
}

/// Chromaticities are written with three or four digits.
const SAME: f64 = 5e-4;

/// Bradford's sharpened cone responses, by columns.
const BRADFORD: DMat3 =
    DMat3::from_cols_array(&[0.8951, -0.7502, 0.0389, 0.2664, 1.7135, -0.0685, -0.1614, 0.0367, 1.0296]);

impl Primaries {
    const REC_709: Self =
        Self { red: [0.64, 0.33], green: [0.30, 0.60], blue: [0.15, 0.06], white: [0.3127, 0.3290] };

    /// Whether these are those of Rec. 709, as far as files tell.
    pub fn are_rec_709(&self) -> bool {
        let all = |p: &Self| [p.red, p.green, p.blue, p.white];
        all(self)
            .as_flattened()
            .iter()
            .zip(all(&Self::REC_709).as_flattened())
            .all(|(a, b)| (a - b).abs() <= SAME)
    }

    /// The map from linear colours of this space to linear Rec. 709; white stays white (Bradford adaptation).
    /// `None` if the chromaticities span no space.
    pub fn rec_709_from_rgb(&self) -> Option<DMat3> {
        let (from, to) = (self.xyz_from_rgb()?, Self::REC_709.xyz_from_rgb()?);
        let [cones, wanted] = [self.white, Self::REC_709.white].map(|white| BRADFORD * xyz(white));
        let adapted = BRADFORD.inverse() * DMat3::from_diagonal(wanted / cones) * BRADFORD;
        Some(to.inverse() * adapted * from).filter(DMat3::is_finite)
    }

    /// Scaled so that white has a luminance of 1.
    fn xyz_from_rgb(&self) -> Option<DMat3> {
        let unscaled = DMat3::from_cols(xyz(self.red), xyz(self.green), xyz(self.blue));
        if !(unscaled.is_finite() && unscaled.determinant().abs() > 1e-6) {
            return None;
        }
        let scale = unscaled.inverse() * xyz(self.white);
        Some(unscaled * DMat3::from_diagonal(scale)).filter(DMat3::is_finite)
    }
}

/// The colour of chromaticity `xy` and luminance 1.
fn xyz([x, y]: [f64; 2]) -> DVec3 {
    DVec3::new(x / y, 1.0, (1.0 - x - y) / y)
}

/// Maps every texel. Colours that Rec. 709 does not reach are clipped to what it does; returns their number.
pub(super) fn convert(texels: &mut [Rgb], rec_709_from_rgb: &DMat3) -> usize {
    // What is less than that below 0 is rounding: half floats have three digits.
    let clipped = |colour: DVec3| colour.min_element() < -1e-3 * colour.max_element().max(0.0);
    let mut count = 0;
    for texel in texels {
        let colour = *rec_709_from_rgb * DVec3::from(texel.map(f64::from));
        count += usize::from(clipped(colour));
        *texel = colour.max(DVec3::ZERO).as_vec3().to_array();
    }
    count
}

#[cfg(test)]
mod tests {
    use super::*;

    const ACES_WHITE: [f64; 2] = [0.32168, 0.33767];

    /// Rows as published: ITU-R BT.2087 for Rec. 2020, the ACES and Display P3 matrices as colour scientists
    /// pass them on (Bradford).
    #[test]
    fn matrices_are_those_that_others_computed() {
        let d65 = [0.3127, 0.3290];
        let spaces = [
            (
                Primaries { red: [0.708, 0.292], green: [0.170, 0.797], blue: [0.131, 0.046], white: d65 },
                [[1.6605, -0.5876, -0.0728], [-0.1246, 1.1329, -0.0083], [-0.0182, -0.1006, 1.1187]],
            ),
            (
                Primaries { red: [0.680, 0.320], green: [0.265, 0.690], blue: [0.150, 0.060], white: d65 },
                [[1.2249, -0.2249, 0.0], [-0.0421, 1.0421, 0.0], [-0.0196, -0.0786, 1.0983]],
            ),
            (
                Primaries {
                    red: [0.7347, 0.2653],
                    green: [0.0, 1.0],
                    blue: [0.0001, -0.0770],
                    white: ACES_WHITE,
                },
                [[2.5217, -1.1341, -0.3876], [-0.2765, 1.3727, -0.0962], [-0.0154, -0.1530, 1.1684]],
            ),
            (
                Primaries {
                    red: [0.713, 0.293],
                    green: [0.165, 0.830],
                    blue: [0.128, 0.044],
                    white: ACES_WHITE,
                },
                [[1.7051, -0.6218, -0.0833], [-0.1303, 1.1408, -0.0105], [-0.0240, -0.1290, 1.1530]],
            ),
        ];
        for (space, rows) in spaces {
            let ours = space.rec_709_from_rgb().unwrap().transpose();
            for (row, expected) in ours.to_cols_array_2d().iter().zip(rows) {
                assert!(
                    row.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-4),
                    "{space:?}: {row:?}, expected {expected:?}"
                );
            }
            assert!(!space.are_rec_709());
        }
    }

    #[test]
    fn white_stays_white_and_rec_709_is_itself() {
        let equal_energy = Primaries { white: [1.0 / 3.0; 2], ..Primaries::REC_709 };
        let white = equal_energy.rec_709_from_rgb().unwrap() * DVec3::ONE;
        assert!(white.abs_diff_eq(DVec3::ONE, 1e-12), "{white}");
        assert!(Primaries::REC_709.rec_709_from_rgb().unwrap().abs_diff_eq(DMat3::IDENTITY, 1e-12));
        assert!(Primaries { white: [0.31271, 0.32902], ..Primaries::REC_709 }.are_rec_709());
    }

    #[test]
    fn what_spans_no_space_gives_no_matrix() {
        for red in [[0.0, 0.0], [f64::NAN, 0.3], [0.30, 0.60]] {
            assert_eq!(Primaries { red, ..Primaries::REC_709 }.rec_709_from_rgb(), None);
        }
        assert_eq!(Primaries { white: [0.3, 0.0], ..Primaries::REC_709 }.rec_709_from_rgb(), None);
    }

    #[test]
    fn colours_outside_are_clipped_and_counted() {
        let wide = Primaries {
            red: [0.708, 0.292],
            green: [0.170, 0.797],
            blue: [0.131, 0.046],
            white: [0.3127, 0.3290],
        };
        let mut texels = [[1.0, 1.0, 1.0], [0.0, 1.0, 0.0], [0.0, 0.0, 0.0]];
        assert_eq!(convert(&mut texels, &wide.rec_709_from_rgb().unwrap()), 1);
        assert!(
            (texels[1][1] - 1.1329).abs() < 1e-4 && texels[1][0] == 0.0 && texels[1][2] == 0.0,
            "{texels:?}"
        );
        assert!(texels[0].iter().all(|x| (x - 1.0).abs() < 1e-6));
    }
}
