//! How numbers and lists are told to people.

use relume_formats::counts::one_or;

/// "1,839 vertices", "1 vertex".
pub fn many(count: usize, one: &str, many: &str) -> String {
    format!("{} {}", grouped(count as u64), one_or(count, one, many))
}

/// "512 × 256 pixels".
pub fn pixels(size: [u32; 2]) -> String {
    format!("{} × {} pixels", size[0], size[1])
}

/// "a, b, c", or "none".
pub fn list(items: impl Iterator<Item = String>) -> String {
    let items: Vec<String> = items.collect();
    if items.is_empty() { "none".to_owned() } else { items.join(", ") }
}

/// 1234567 as 1,234,567.
pub fn grouped(number: u64) -> String {
    let digits = number.to_string();
    let mut out = String::new();
    for (index, digit) in digits.chars().enumerate() {
        if index > 0 && (digits.len() - index).is_multiple_of(3) {
            out.push(',');
        }
        out.push(digit);
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn digits_are_grouped_by_three() {
        let cases = [(0, "0"), (999, "999"), (1000, "1,000"), (65_536, "65,536"), (1_234_567, "1,234,567")];
        cases.iter().for_each(|(number, text)| assert_eq!(grouped(*number), *text));
    }
}
