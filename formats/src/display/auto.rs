//! Exposure from the picture itself: E. Reinhard, M. Stark, P. Shirley, J. Ferwerda, *Photographic tone
//! reproduction for digital images*, ACM TOG 21(3), 2002, equation 1: the geometric mean of luminance becomes
//! middle grey.

use super::{MAX_EXPOSURE_EV, Rgb};

/// The linear value to which the mean of a picture is brought.
pub const MIDDLE_GREY: f32 = 0.18;

/// Luminance of linear Rec. 709 (ITU-R BT.709): what each channel adds.
const LUMINANCE: [f64; 3] = [0.2126, 0.7152, 0.0722];

/// The exposure, EV, at which the geometric mean of the luminance of `radiance` is [`MIDDLE_GREY`], within
/// the range that exposures have. Pixels that are black, as where nothing is seen, or no number do not count;
/// `None` if no pixel does.
pub fn auto_exposure_ev(radiance: &[Rgb]) -> Option<f32> {
    let luminance =
        |rgb: &Rgb| rgb.iter().zip(LUMINANCE).map(|(v, weight)| f64::from(*v) * weight).sum::<f64>();
    let (sum, count) = radiance
        .iter()
        .map(luminance)
        .filter(|y| *y > 0.0 && y.is_finite())
        .fold((0.0, 0_u64), |(sum, count), y| (sum + y.log2(), count + 1));
    let ev = f64::from(MIDDLE_GREY).log2() - sum / count as f64;
    (count > 0).then(|| (ev as f32).clamp(-MAX_EXPOSURE_EV, MAX_EXPOSURE_EV))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_even_picture_becomes_middle_grey() {
        for radiance in [1e-4_f32, 0.18, 1.0, 37.0] {
            let ev = auto_exposure_ev(&[[radiance; 3]; 7]).unwrap();
            assert!((radiance * ev.exp2() - MIDDLE_GREY).abs() < 1e-6, "{radiance}: {ev}");
        }
    }

    #[test]
    fn means_are_geometric_and_of_what_is_seen() {
        // Two stops up and two down cancel.
        let picture = [[0.72_f32; 3], [0.045; 3], [0.0; 3], [f32::NAN; 3], [f32::INFINITY, 0.0, 0.0]];
        assert!(auto_exposure_ev(&picture).unwrap().abs() < 1e-6);
        // A green surface of luminance 0.18, by the weight of its channel.
        assert!(auto_exposure_ev(&[[0.0, 0.18 / 0.7152, 0.0]]).unwrap().abs() < 1e-6);
        assert_eq!(
            [auto_exposure_ev(&[]), auto_exposure_ev(&[[0.0; 3]]), auto_exposure_ev(&[[-1.0; 3]])],
            [None; 3]
        );
    }

    #[test]
    fn exposures_stay_within_their_range() {
        assert_eq!(auto_exposure_ev(&[[1e-30; 3]]), Some(32.0));
        assert_eq!(auto_exposure_ev(&[[1e30; 3]]), Some(-32.0));
    }
}
