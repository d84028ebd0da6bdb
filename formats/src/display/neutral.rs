//! Khronos PBR Neutral: The Khronos Group, *PBR Neutral Tone Mapper*, specification of 2024
//! (github.com/KhronosGroup/ToneMapping).
//!
//! It takes off the 4 % that a dielectric reflects head-on, so that a base colour under white light of
//! radiance 1 arrives as it was chosen, and compresses only what is brighter than 0.8: the largest channel
//! goes to 1 by a hyperbola with a continuous slope, and colours to white, in the plane of the colour and the
//! grey axis, so that their hue stays.

use super::Rgb;

/// Reflectance of a dielectric of index 1.5, head-on.
const F0: f32 = 0.04;
/// The largest channel, less [`F0`], at which compression starts.
const START: f32 = 0.8 - F0;
/// How fast colours lose saturation above that.
const DESATURATION: f32 = 0.15;

/// Display values of `exposed`, whose channels are from 0 to 10⁹.
pub(super) fn shown(exposed: Rgb) -> Rgb {
    let least = exposed[0].min(exposed[1]).min(exposed[2]);
    // A parabola that meets 0 at 0 and the full offset at twice F0, both smoothly.
    let offset = if least < 2.0 * F0 { least - least * least / (4.0 * F0) } else { F0 };
    let colour = exposed.map(|v| v - offset);
    let peak = colour[0].max(colour[1]).max(colour[2]);
    if peak < START {
        return colour;
    }
    let room = 1.0 - START;
    let new_peak = 1.0 - room * room / (peak + room - START);
    let kept = 1.0 / (DESATURATION * (peak - new_peak) + 1.0);
    colour.map(|v| new_peak * (v / peak * kept + (1.0 - kept)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// What the specification's own GLSL gives, run in single precision: exposed radiance, display values.
    const PUBLISHED: [(Rgb, Rgb); 16] = [
        ([0.0, 0.0, 0.0], [0.000000, 0.000000, 0.000000]),
        ([0.01, 0.01, 0.01], [0.000625, 0.000625, 0.000625]),
        ([0.05, 0.05, 0.05], [0.015625, 0.015625, 0.015625]),
        ([0.18, 0.18, 0.18], [0.140000, 0.140000, 0.140000]),
        ([0.5, 0.5, 0.5], [0.460000, 0.460000, 0.460000]),
        ([0.8, 0.8, 0.8], [0.760000, 0.760000, 0.760000]),
        ([1.0, 1.0, 1.0], [0.869091, 0.869091, 0.869091]),
        ([4.0, 4.0, 4.0], [0.983256, 0.983256, 0.983256]),
        ([100.0, 100.0, 100.0], [0.999421, 0.999421, 0.999421]),
        ([0.8, 0.2, 0.1], [0.760000, 0.160000, 0.060000]),
        ([0.04, 0.5, 0.02], [0.022500, 0.482500, 0.002500]),
        ([2.0, 0.5, 0.1], [0.960000, 0.321136, 0.150772]),
        ([0.0, 0.0, 5.0], [0.370921, 0.370921, 0.987143]),
        ([10.0, 8.0, 0.5], [0.993898, 0.908787, 0.589621]),
        ([30.0, 1.0, 0.02], [0.998045, 0.817529, 0.811429]),
        ([0.002, 0.3, 1.2], [0.037277, 0.255621, 0.915047]),
    ];

    #[test]
    fn values_are_those_of_the_specification() {
        for (exposed, expected) in PUBLISHED {
            let shown = shown(exposed);
            assert!(
                (0..3).all(|c| (shown[c] - expected[c]).abs() < 2e-6),
                "{exposed:?}: {shown:?} {expected:?}"
            );
        }
    }

    #[test]
    fn the_slope_goes_on_where_compression_starts() {
        // A step of 2⁻⁸ either way changes what is shown alike, but for the curvature, whose square root
        // bounds it.
        let grey = |v: f32| f64::from(shown([v; 3])[0]);
        let step = 1.0 / 256.0;
        let (below, above) = (grey(0.8) - grey(0.8 - step), grey(0.8 + step) - grey(0.8));
        assert!((below - above).abs() / below < 0.02, "{below} {above}");
    }

    fn hue(colour: Rgb) -> [f64; 2] {
        let [r, g, b] = colour.map(f64::from);
        let (x, y) = (r - 0.5 * (g + b), 0.75_f64.sqrt() * (g - b));
        let length = x.hypot(y);
        [x / length, y / length]
    }

    proptest! {
        /// The purpose of the curve: what a dielectric of base colour c sends back under white light, c + F0
        /// or so, is shown as c.
        #[test]
        fn base_colours_arrive_as_they_were_chosen(base in prop::array::uniform3(0.04_f32..0.7599)) {
            let shown = shown(base.map(|c| c + F0));
            prop_assert!((0..3).all(|c| (shown[c] - base[c]).abs() < 1e-6), "{base:?} {shown:?}");
        }

        /// Colour and result lie in one plane with the grey axis, on the same side.
        #[test]
        fn hues_stay(colour in prop::array::uniform3(0.0_f32..30.0)) {
            prop_assume!(colour[0].max(colour[1]).max(colour[2]) - colour[0].min(colour[1]).min(colour[2]) > 0.05);
            let (before, after) = (hue(colour), hue(shown(colour)));
            prop_assert!((before[0] - after[0]).abs() + (before[1] - after[1]).abs() < 1e-3, "{colour:?}: {before:?} {after:?}");
        }

        /// The order of channels stays, and none goes beyond white.
        #[test]
        fn channels_keep_their_order(colour in prop::array::uniform3(0.0_f32..1e9)) {
            let shown = shown(colour);
            for (a, b) in [(0, 1), (1, 2), (2, 0)] {
                prop_assert!(colour[a] < colour[b] || shown[a] >= shown[b] - 1e-6, "{colour:?} {shown:?}");
            }
        }
    }
}
