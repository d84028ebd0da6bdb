//! What lights emit.

use super::{LightState, Rgb};
use crate::error::{Error, Place, Result};

/// The largest radiometric value, a hundred thousand times the sun's radiance. Sums over paths stay finite in
/// single precision up to it.
pub const MAX_RADIOMETRIC: f32 = 1e12;

/// Fails unless `value`, called `name` in the message, is light: not negative, not NaN, and at most
/// [`MAX_RADIOMETRIC`].
pub fn expect_radiometric(value: Rgb, name: &str, place: &Place) -> Result<()> {
    if value.iter().all(|x| (0.0..=MAX_RADIOMETRIC).contains(x)) {
        return Ok(());
    }
    Err(Error::invalid(place, format!("{name} {value:?} must be numbers of 0 to {MAX_RADIOMETRIC:e}")))
}

impl LightState {
    /// What the light called `name` emits after this change, where the scene says `emission`: radiance,
    /// intensity or irradiance.
    ///
    /// # Errors
    /// `Invalid` for a gain that is no light, or leads to what is none.
    pub fn emission(&self, emission: Rgb, name: &str, place: &Place) -> Result<Rgb> {
        let gain = self.gain.unwrap_or([1.0; 3]);
        expect_radiometric(gain, &format!("light `{name}`: gain"), place)?;
        let emission = std::array::from_fn(|k| emission[k] * gain[k]);
        expect_radiometric(emission, &format!("light `{name}`: emission times gain"), place)?;
        Ok(emission)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lit(emission: Rgb, gain: Option<Rgb>) -> std::result::Result<Rgb, String> {
        LightState { gain }.emission(emission, "lamp", &Place::file("s.toml")).map_err(|e| e.to_string())
    }

    #[test]
    fn a_gain_scales_each_channel() {
        assert_eq!(lit([1.0, 2.0, 3.0], Some([2.0, 0.0, 0.5])), Ok([2.0, 0.0, 1.5]));
        assert_eq!(lit([1.0, 2.0, 3.0], None), Ok([1.0, 2.0, 3.0]));
        assert_eq!(lit([1.0; 3], Some([MAX_RADIOMETRIC; 3])), Ok([MAX_RADIOMETRIC; 3]));
    }

    #[test]
    fn what_is_no_light_is_refused() {
        for (emission, gain, expected) in [
            ([1.0; 3], [-1.0, 1.0, 1.0], "gain [-1.0, 1.0, 1.0] must be numbers of 0 to 1e12"),
            ([1.0; 3], [f32::NAN, 1.0, 1.0], "gain [NaN, 1.0, 1.0] must be numbers of 0 to 1e12"),
            (
                [1e7; 3],
                [1e6, 1.0, 1.0],
                "emission times gain [10000000000000.0, 10000000.0, 10000000.0] must be numbers of 0 to 1e12",
            ),
        ] {
            assert_eq!(lit(emission, Some(gain)), Err(format!("s.toml: light `lamp`: {expected}")));
        }
    }
}
