//! AgX, base look, without any look on top: T. Sobotka, *AgX* (github.com/sobotka/AgX, 2022), in the variant
//! of Blender 4 and three.js since version 160.
//!
//! Colours go to Rec. 2020 primaries (ITU-R BT.2087, four decimals), are drawn in towards grey by a matrix,
//! encoded as the logarithm of radiance from 10 stops below middle grey to 6.5 above it, bent by a polynomial
//! of degree six that B. Wrensch fitted to Sobotka's table `AgX_Default_Contrast`, drawn out again, and taken
//! from the power 1/2.2, for which the table was made, to linear values. The matrices are E. Chow's, of
//! Blender's configuration.

use super::Rgb;

type Matrix = [[f32; 3]; 3];

const REC2020_FROM_REC709: Matrix =
    [[0.6274, 0.3293, 0.0433], [0.0691, 0.9195, 0.0113], [0.0164, 0.0880, 0.8956]];
const REC709_FROM_REC2020: Matrix =
    [[1.6605, -0.5876, -0.0728], [-0.1246, 1.1329, -0.0083], [-0.0182, -0.1006, 1.1187]];
const INSET: Matrix = [
    [0.856_627_15, 0.095_121_24, 0.048_251_606],
    [0.137_318_97, 0.761_242, 0.101_439_04],
    [0.111_898_21, 0.076_799_42, 0.811_302_37],
];
const OUTSET: Matrix = [
    [1.127_100_6, -0.110_606_64, -0.016_493_939],
    [-0.141_329_76, 1.157_823_7, -0.016_493_939],
    [-0.141_329_76, -0.110_606_64, 1.251_936_4],
];
/// Where the logarithm begins and ends, EV: 0.18 · 2⁻¹⁰ and 0.18 · 2^6.5.
const LEAST_EV: f32 = -12.473_93;
const MOST_EV: f32 = 4.026_069;
/// Coefficients of the contrast curve, the highest power first.
const CONTRAST: [f32; 7] = [15.5, -40.14, 31.96, -6.868, 0.4298, 0.1191, -0.00232];
/// Below this nothing has a logarithm of use.
const TINY: f32 = 1e-10;
/// The power for which the contrast curve was made.
const POWER: f32 = 2.2;

/// Display values of `exposed`, whose channels are from 0 to 10⁹; bright saturated colours may leave 0..=1 a
/// little.
pub(super) fn shown(exposed: Rgb) -> Rgb {
    let drawn_in = times(&INSET, times(&REC2020_FROM_REC709, exposed));
    let bent =
        drawn_in.map(|v| contrast(((v.max(TINY).log2() - LEAST_EV) / (MOST_EV - LEAST_EV)).clamp(0.0, 1.0)));
    times(&REC709_FROM_REC2020, times(&OUTSET, bent).map(|v| v.max(0.0).powf(POWER)))
}

/// The encoded value of the logarithm `x`, 0..=1.
fn contrast(x: f32) -> f32 {
    CONTRAST.into_iter().fold(0.0, |sum, coefficient| sum * x + coefficient)
}

fn times(matrix: &Matrix, [r, g, b]: Rgb) -> Rgb {
    matrix.map(|row| row[0] * r + row[1] * g + row[2] * b)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{DMat3, DVec3};

    /// What the AgX of three.js 0.182 gives, its GLSL run in single precision: exposed radiance, display
    /// values.
    const PUBLISHED: [(Rgb, Rgb); 16] = [
        ([0.0, 0.0, 0.0], [0.000000, 0.000000, 0.000000]),
        ([0.01, 0.01, 0.01], [0.005996, 0.005994, 0.005995]),
        ([0.05, 0.05, 0.05], [0.061382, 0.061366, 0.061367]),
        ([0.18, 0.18, 0.18], [0.214549, 0.214502, 0.214499]),
        ([0.5, 0.5, 0.5], [0.425196, 0.425120, 0.425102]),
        ([0.8, 0.8, 0.8], [0.537049, 0.536958, 0.536931]),
        ([1.0, 1.0, 1.0], [0.590225, 0.590138, 0.590103]),
        ([4.0, 4.0, 4.0], [0.861012, 0.860912, 0.860833]),
        ([100.0, 100.0, 100.0], [0.996978, 0.996878, 0.996778]),
        ([0.8, 0.2, 0.1], [0.580614, 0.255223, 0.168449]),
        ([0.04, 0.5, 0.02], [0.148353, 0.411955, 0.077463]),
        ([2.0, 0.5, 0.1], [0.816278, 0.453793, 0.263060]),
        ([0.0, 0.0, 5.0], [0.276112, 0.445430, 1.000000]),
        ([10.0, 8.0, 0.5], [0.966640, 0.931406, 0.745519]),
        ([30.0, 1.0, 0.02], [1.000000, 0.859026, 0.761746]),
        ([0.002, 0.3, 1.2], [0.119495, 0.373188, 0.701982]),
    ];

    #[test]
    fn values_are_those_that_three_js_shows() {
        for (exposed, expected) in PUBLISHED {
            let shown = shown(exposed).map(|v| v.clamp(0.0, 1.0));
            assert!(
                (0..3).all(|c| (shown[c] - expected[c]).abs() < 2e-5),
                "{exposed:?}: {shown:?} {expected:?}"
            );
        }
    }

    /// Sobotka's table `AgX_Default_Contrast.spi1d`, every 455th of its 4096 values. The polynomial is off by
    /// 0.0058 at most, at number 3897.
    #[test]
    fn contrast_is_that_of_the_published_table() {
        let table = [
            0.0, 0.0094135, 0.0302774, 0.0810636, 0.2000341, 0.3992467, 0.6209258, 0.8224253, 0.9467863, 1.0,
        ];
        for (number, expected) in (0..).step_by(455).zip(table) {
            let bent = contrast(number as f32 / 4095.0);
            assert!((bent - expected).abs() < 0.0059, "{number}: {bent} {expected}");
        }
        let rises = |step: u16| contrast(f32::from(step) / 4096.0) < contrast(f32::from(step + 1) / 4096.0);
        assert!((0..4096).all(rises));
    }

    /// RGB to XYZ from the chromaticities of primaries and of D65.
    fn xyz_from(primaries: [[f64; 2]; 3]) -> DMat3 {
        let xyz = |[x, y]: [f64; 2]| DVec3::new(x / y, 1.0, (1.0 - x - y) / y);
        let primaries = DMat3::from_cols(xyz(primaries[0]), xyz(primaries[1]), xyz(primaries[2]));
        primaries * DMat3::from_diagonal(primaries.inverse() * xyz([0.3127, 0.3290]))
    }

    fn expect_near(matrix: &Matrix, expected: DMat3, tolerance: f64) {
        for (row, column) in (0..3).flat_map(|row| (0..3).map(move |column| (row, column))) {
            let (ours, theirs) = (f64::from(matrix[row][column]), expected.col(column)[row]);
            assert!((ours - theirs).abs() <= tolerance, "row {row}, column {column}: {ours} {theirs}");
        }
    }

    #[test]
    fn primaries_are_those_of_the_recommendations() {
        let rec709 = xyz_from([[0.64, 0.33], [0.30, 0.60], [0.15, 0.06]]);
        let rec2020 = xyz_from([[0.708, 0.292], [0.170, 0.797], [0.131, 0.046]]);
        expect_near(&REC2020_FROM_REC709, rec2020.inverse() * rec709, 1e-4);
        expect_near(&REC709_FROM_REC2020, rec709.inverse() * rec2020, 1e-4);
    }

    #[test]
    fn grey_stays_grey_and_the_logarithm_spans_what_it_says() {
        for matrix in [INSET, OUTSET] {
            assert!(times(&matrix, [1.0; 3]).iter().all(|v| (v - 1.0).abs() < 1e-6), "{matrix:?}");
        }
        // Four decimals leave greys off by some 10⁻⁴.
        for step in 0..100 {
            let [r, g, b] = shown([10_f32.powf(step as f32 / 20.0 - 3.0); 3]);
            assert!((r - g).abs().max((g - b).abs()) < 3e-4, "{r} {g} {b}");
        }
        assert!(
            (LEAST_EV - (0.18_f32.log2() - 10.0)).abs() < 1e-4
                && (MOST_EV - (0.18_f32.log2() + 6.5)).abs() < 1e-4
        );
    }

    #[test]
    fn bright_colours_go_to_white() {
        for colour in [[1.0, 0.1, 0.1], [0.1, 1.0, 0.1], [0.1, 0.1, 1.0]] {
            let spread = |gain: f32| {
                let shown = shown(colour.map(|v| v * gain)).map(|v| v.clamp(0.0, 1.0));
                shown.iter().copied().fold(0.0, f32::max) - shown.iter().copied().fold(1.0, f32::min)
            };
            assert!(
                spread(1.0) > 0.2 && spread(20.0) < 0.7 * spread(1.0) && spread(1000.0) < 0.01,
                "{colour:?}"
            );
        }
    }
}
