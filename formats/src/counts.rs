//! Counts in messages.

/// "1 face", "2 faces", "0 faces".
pub fn counted(count: usize, one: &str, many: &str) -> String {
    format!("{count} {}", one_or(count, one, many))
}

/// The word that goes with `count`: "1 face has", "2 faces have".
pub fn one_or<'a>(count: usize, one: &'a str, many: &'a str) -> &'a str {
    if count == 1 { one } else { many }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_one_is_singular() {
        for (count, expected) in
            [(0, "0 vertices have"), (1, "1 vertex has"), (2, "2 vertices have"), (21, "21 vertices have")]
        {
            assert_eq!(
                format!("{} {}", counted(count, "vertex", "vertices"), one_or(count, "has", "have")),
                expected
            );
        }
    }
}
