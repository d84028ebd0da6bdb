//! What a display shows of linear radiance: exposure, then a curve that brings what is brighter than the
//! display can be into its range.
//!
//! This is the one CPU form: PNG frames are made by it, and `tonemap.wgsl` of the player must equal it.

mod agx;
mod auto;
mod neutral;

pub use auto::{MIDDLE_GREY, auto_exposure_ev};

use crate::state::{MAX_EXPOSURE_EV, Rgb};
use serde::{Deserialize, Serialize};

/// A curve from linear radiance to linear display values.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Tonemap {
    /// Each channel is cut off at 0 and 1, which leaves all below 1 as it is and turns bright colours into
    /// others.
    Clamp,
    /// Khronos PBR Neutral (2024): base colours as they are, highlights compressed and led to white in their
    /// hue.
    #[default]
    Neutral,
    /// AgX (Sobotka 2022), base look, in Rec. 2020 primaries: film-like, with little contrast and much room
    /// for highlights.
    Agx,
}

/// The largest exposed radiance that curves are given: at it all of them have long reached their end.
const MOST: f32 = 1e9;

impl Tonemap {
    /// All of them, in the order of their numbers in files and in the shader.
    pub const ALL: [Self; 3] = [Self::Clamp, Self::Neutral, Self::Agx];

    /// The name in states and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Clamp => "clamp",
            Self::Neutral => "neutral",
            Self::Agx => "agx",
        }
    }

    /// The curve of this name.
    pub fn of_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|tonemap| tonemap.name() == name)
    }

    /// Linear display values, 0..=1, of exposed linear radiance, both Rec. 709. What is negative or no number
    /// counts as 0, what is above 10⁹ as 10⁹.
    pub fn shown(self, exposed: Rgb) -> Rgb {
        #[allow(
            clippy::manual_clamp,
            reason = "`clamp` would keep what is no number, which `max` passes over"
        )]
        let exposed = exposed.map(|v| v.max(0.0).min(MOST));
        let shown = match self {
            Self::Clamp => exposed,
            Self::Neutral => neutral::shown(exposed),
            Self::Agx => agx::shown(exposed),
        };
        shown.map(|v| v.clamp(0.0, 1.0))
    }
}

/// How a display shows radiance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Display {
    /// Exposure: the curve is given 2^ev times the radiance.
    pub exposure_ev: f32,
    /// The curve.
    pub tonemap: Tonemap,
}

impl Display {
    /// Linear display values, 0..=1, of linear radiance.
    pub fn shown(&self, radiance: Rgb) -> Rgb {
        let gain = self.exposure_ev.exp2();
        self.tonemap.shown(radiance.map(|v| v * gain))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn exposure_comes_before_the_curve() {
        let clamp = |exposure_ev| Display { exposure_ev, tonemap: Tonemap::Clamp };
        assert_eq!(clamp(2.0).shown([0.125, 2.0, -1.0]), [0.5, 1.0, 0.0]);
        assert_eq!(clamp(-3.0).shown([f32::NEG_INFINITY, f32::INFINITY, 4.0]), [0.0, 1.0, 0.5]);
        for tonemap in Tonemap::ALL {
            let bright = Display { exposure_ev: 1.5, tonemap };
            assert_eq!(
                bright.shown([0.1, 0.2, 0.3]),
                tonemap.shown([0.1, 0.2, 0.3].map(|v: f32| v * 1.5_f32.exp2()))
            );
        }
    }

    #[test]
    fn names_are_those_of_states() {
        for tonemap in Tonemap::ALL {
            assert_eq!(Tonemap::of_name(tonemap.name()), Some(tonemap));
            assert_eq!(serde_json::to_value(tonemap).unwrap(), tonemap.name());
        }
        assert_eq!(Tonemap::of_name("aces"), None);
    }

    #[test]
    fn what_is_no_light_is_black_and_what_is_endless_is_the_end_of_the_curve() {
        for tonemap in Tonemap::ALL {
            let black = tonemap.shown([0.0; 3]);
            assert_eq!(black, [0.0; 3], "{tonemap:?}");
            for none in [-0.0, -1.0, f32::NEG_INFINITY, f32::NAN] {
                assert_eq!(tonemap.shown([none; 3]), black, "{tonemap:?} {none}");
                assert_eq!(
                    tonemap.shown([none, 0.5, 0.25]),
                    tonemap.shown([0.0, 0.5, 0.25]),
                    "{tonemap:?} {none}"
                );
            }
            let white = tonemap.shown([f32::INFINITY; 3]);
            assert_eq!(tonemap.shown([f32::MAX; 3]), white);
            // AgX's polynomial ends a little below 1; all are the 255 of a byte.
            assert!(
                white.iter().all(|v| *v > 0.9965 && crate::basis::srgb_from_linear(*v) == 255),
                "{tonemap:?}: {white:?}"
            );
        }
    }

    #[test]
    fn grey_rises_with_radiance() {
        for tonemap in Tonemap::ALL {
            let mut last = [-1.0_f32; 3];
            for step in 0..20_000 {
                // 10⁻⁴ to 10⁴; AgX's logarithm begins and ends within.
                let v = 10_f32.powf(step as f32 / 2500.0 - 4.0);
                let shown = tonemap.shown([v; 3]);
                // Where AgX's logarithm ends, one channel of a grey does so a little before the others, for
                // its matrices have four decimals.
                assert!((0..3).all(|c| shown[c] >= last[c] - 3e-6), "{tonemap:?} at {v}: {last:?} {shown:?}");
                last = shown;
            }
        }
    }

    proptest! {
        #[test]
        fn anything_is_shown_within_the_display(bits in any::<[u32; 3]>()) {
            for tonemap in Tonemap::ALL {
                let shown = tonemap.shown(bits.map(f32::from_bits));
                prop_assert!(shown.iter().all(|v| (0.0..=1.0).contains(v)), "{tonemap:?}: {shown:?}");
            }
        }
    }
}
