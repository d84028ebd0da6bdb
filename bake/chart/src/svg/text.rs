//! How much room text takes. No font is looked at: these are the widths of DejaVu Sans, the widest of the
//! fonts that the drawing asks for.

/// Fonts that a drawing asks for, none wider than the first.
pub const FONTS: &str = "DejaVu Sans, Verdana, Arial, Helvetica, sans-serif";
/// Width of the ASCII characters from the blank on, in thousandths of the font's size.
const WIDTHS: [u16; 95] = [
    318, 401, 460, 838, 636, 950, 780, 275, 390, 390, 500, 838, 318, 361, 318, 337, 636, 636, 636, 636, 636,
    636, 636, 636, 636, 636, 337, 337, 838, 838, 838, 531, 1000, 684, 686, 698, 770, 632, 575, 775, 752, 295,
    295, 656, 557, 863, 748, 787, 603, 787, 695, 635, 611, 732, 684, 989, 685, 611, 685, 390, 337, 390, 838,
    500, 500, 613, 635, 550, 635, 615, 352, 635, 634, 278, 278, 579, 278, 974, 634, 612, 635, 635, 411, 521,
    392, 634, 592, 818, 592, 592, 525, 636, 337, 636, 838,
];
/// Any other character; ideographs are as wide.
const OTHER: u16 = 1000;
/// How far characters rise above the line they stand on, in parts of the font's size.
pub const ASCENT: f64 = 0.8;
/// How far they reach below it.
pub const DESCENT: f64 = 0.25;

/// Width of `text` in a font of `size`.
pub fn width(text: &str, size: f64) -> f64 {
    let of = |c: char| (c as usize).checked_sub(32).and_then(|at| WIDTHS.get(at)).copied().unwrap_or(OTHER);
    text.chars().map(|c| f64::from(of(c))).sum::<f64>() * size / 1000.0
}

/// `text` in lines no wider than `room`, broken at blanks, and within words that are wider.
pub fn wrapped(text: &str, size: f64, room: f64) -> Vec<String> {
    let mut lines = vec![String::new()];
    for word in text.split(' ') {
        let line = lines.last().cloned().unwrap_or_default();
        if !line.is_empty() && width(&format!("{line} {word}"), size) > room {
            lines.push(String::new());
        } else if !line.is_empty() {
            push(&mut lines, ' ');
        }
        for c in word.chars() {
            let line = lines.last().map_or("", String::as_str);
            if !line.is_empty() && width(line, size) + width(c.encode_utf8(&mut [0; 4]), size) > room {
                lines.push(String::new());
            }
            push(&mut lines, c);
        }
    }
    lines
}

fn push(lines: &mut [String], c: char) {
    if let Some(line) = lines.last_mut() {
        line.push(c);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn widths_add_up_and_scale() {
        assert_eq!(width("", 10.0), 0.0);
        assert!((width("16", 10.0) - 12.72).abs() < 1e-9);
        assert!((width("~aé", 20.0) - 20.0 * (0.838 + 0.613 + 1.0)).abs() < 1e-9);
    }

    #[test]
    fn lines_keep_to_their_room_and_lose_nothing() {
        let text = "a reference of 4096 samples a pixel, onaverylongnamethatnobodybreaks in 12 s";
        for room in [20.0, 60.0, 130.0, 1000.0] {
            let lines = wrapped(text, 10.0, room);
            assert!(lines.iter().all(|line| width(line, 10.0) <= room), "{lines:?}");
            let letters = |text: &str| text.chars().filter(|c| *c != ' ').collect::<String>();
            assert_eq!(letters(&lines.concat()), letters(text));
        }
        assert_eq!(wrapped(text, 10.0, 1000.0), [text]);
    }
}
