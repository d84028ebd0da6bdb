//! Colours as six hexadecimal digits, which are sRGB.

use super::{linear_from_srgb, srgb_from_linear};
use crate::state::Rgb;

/// Linear Rec. 709 of a colour such as `#808080` or `#888`; the `#` may be missing.
pub fn linear_from_hex(text: &str) -> Option<Rgb> {
    let text = text.trim();
    let digits = text.strip_prefix('#').unwrap_or(text);
    let digits: Vec<u8> = digits.chars().map(|c| Some(c.to_digit(16)? as u8)).collect::<Option<_>>()?;
    let bytes = match digits[..] {
        [r, g, b] => [r * 17, g * 17, b * 17],
        [r1, r0, g1, g0, b1, b0] => [r1 * 16 + r0, g1 * 16 + g0, b1 * 16 + b0],
        _ => return None,
    };
    Some(bytes.map(linear_from_srgb))
}

/// `#808080` for a linear colour in 0..=1, rounded to 8 bits.
pub fn hex_from_linear(linear: Rgb) -> String {
    let [r, g, b] = linear.map(srgb_from_linear);
    format!("#{r:02x}{g:02x}{b:02x}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn digits_are_srgb() {
        for (text, hex, grey) in [
            ("#bcbcbc", "#bcbcbc", 0.5),
            (" 808080 ", "#808080", 0.2158605),
            ("#FFF", "#ffffff", 1.0),
            ("000", "#000000", 0.0),
        ] {
            let linear = linear_from_hex(text).unwrap();
            assert!(linear.iter().all(|v| (v - grey).abs() < 3e-3), "{text}: {linear:?}");
            assert_eq!(hex_from_linear(linear), hex);
        }
        assert_eq!(linear_from_hex("#ff8000").map(hex_from_linear).as_deref(), Some("#ff8000"));
        for wrong in ["", "#", "#ff", "#ffff", "#fffff", "#gggggg", "0.5", "#ff00000", "#+f0000", "#ｆｆｆ"]
        {
            assert_eq!(linear_from_hex(wrong), None, "{wrong}");
        }
    }

    #[test]
    fn every_byte_comes_back() {
        for byte in 0..=255u8 {
            let text = format!("#{byte:02x}{:02x}{:02x}", 255 - byte, byte / 2);
            assert_eq!(hex_from_linear(linear_from_hex(&text).unwrap()), text);
        }
    }
}
