//! How large a model is and where it is put: what its unit may be, and the transform that stands it on the
//! ground at the origin.

use super::model::Extent;

/// Lengths in metres that models of rooms, furniture, figures and jewels have; outside, a model is in another
/// unit.
const METRES: std::ops::RangeInclusive<f64> = 0.005..=100.0;
/// Units that are tried when it is not metres: the largest that gives at most 100 m. Their name, metres, and
/// the least length in them that is likely.
const UNITS: [(&str, f64); 2] = [("centimetres", 0.01), ("millimetres", 0.001)];

/// A model's unit and place.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Placing {
    /// Metres in a unit of the model.
    pub scale: f64,
    /// What the unit is taken for, for the reader.
    pub unit: String,
    /// Width, height and depth, in the model's units.
    pub units: [f64; 3],
    /// Moves the scaled model to the origin and onto y = 0, metres.
    pub translation: [f64; 3],
    /// The same for the model turned by −90° about x, whose +Z then is up.
    pub translation_if_z_up: [f64; 3],
    /// Radius of the sphere about the middle of its box that holds the model, metres.
    pub radius: f64,
    /// Half the height of the box, metres.
    pub half_height: f64,
}

impl Placing {
    /// For a model of that extent; `scale` if somebody knows it.
    pub fn new(extent: &Extent, scale: Option<f64>) -> Self {
        let units: [f64; 3] = std::array::from_fn(|k| extent.high[k] - extent.low[k]);
        let largest = units.iter().fold(0.0_f64, |m, x| m.max(*x));
        let (scale, unit) =
            scale.map_or_else(|| guess(largest), |scale| (scale, "what --scale said".to_owned()));
        let middle: [f64; 3] = std::array::from_fn(|k| 0.5 * scale * (extent.high[k] + extent.low[k]));
        Self {
            scale,
            unit,
            units,
            translation: [-middle[0], -scale * extent.low[1], -middle[2]],
            // (x, y, z) is turned to (x, z, −y).
            translation_if_z_up: [-middle[0], -scale * extent.low[2], middle[1]],
            radius: scale * extent.radius,
            half_height: 0.5 * scale * units[1],
        }
    }
}

/// Metres in the unit of a model whose largest side is so many of them, and what that unit is called.
fn guess(largest: f64) -> (f64, String) {
    if METRES.contains(&largest) {
        return (1.0, "metres".to_owned());
    }
    let unit = UNITS.into_iter().find(|(_, metres)| largest > 1.0 && METRES.contains(&(largest * metres)));
    if let Some((name, metres)) = unit {
        return (metres, name.to_owned());
    }
    // No unit makes sense of it; how light moves does not depend on size.
    let exponent = -largest.max(f64::MIN_POSITIVE).log10().floor();
    (10.0_f64.powf(exponent.clamp(-30.0, 30.0)), "no known unit, and brought to a few metres".to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_are_guessed_from_the_largest_side() {
        for (largest, scale, unit) in [
            (1.8, 1.0, "metres"),
            (0.02, 1.0, "metres"),
            (100.0, 1.0, "metres"),
            (180.0, 0.01, "centimetres"),
            (9_000.0, 0.01, "centimetres"),
            (25_000.0, 0.001, "millimetres"),
        ] {
            assert_eq!(guess(largest), (scale, unit.to_owned()), "{largest}");
        }
        for largest in [1e-9, 3e-4, 2e5, 7e12] {
            let (scale, unit) = guess(largest);
            assert!(
                (1.0..10.001).contains(&(scale * largest)) && unit.starts_with("no known unit"),
                "{largest}: {scale}"
            );
        }
    }

    #[test]
    fn a_model_is_stood_on_the_ground_at_the_origin() {
        let extent = Extent { low: [100.0, -20.0, 40.0], high: [300.0, 180.0, 60.0], radius: 142.0 };
        let placing = Placing::new(&extent, None);
        assert_eq!((placing.scale, placing.half_height, placing.units), (0.01, 1.0, [200.0, 200.0, 20.0]));
        let close = |a: [f64; 3], b: [f64; 3]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-12);
        assert!(close(placing.translation, [-2.0, 0.2, -0.5]), "{placing:?}");
        assert!(close(placing.translation_if_z_up, [-2.0, -0.4, 0.8]), "{placing:?}");
        assert!((placing.radius - 1.42).abs() < 1e-12);
        assert_eq!(Placing::new(&extent, Some(0.001)).scale, 0.001);
    }
}
