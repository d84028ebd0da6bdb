//! Text, keys and numbers as a TOML file writes them.

/// `text` as a TOML string. JSON's quotes and escapes are TOML's, but that JSON lets the character DEL stand
/// as it is.
pub(super) fn quoted(text: &str) -> String {
    serde_json::Value::from(text).to_string().replace('\u{7f}', "\\u007f")
}

/// `name` as a TOML key: bare if it may be.
pub(super) fn key(name: &str) -> String {
    let is_bare = !name.is_empty() && name.chars().all(|c| c.is_ascii_alphanumeric() || c == '-' || c == '_');
    if is_bare { name.to_owned() } else { quoted(name) }
}

/// How numbers are written beside a length: with five digits of that, and never fewer than one after the
/// point.
#[derive(Debug, Clone, Copy)]
pub(super) struct Digits(usize);

impl Digits {
    /// For numbers that `length` is large beside.
    pub fn beside(length: f64) -> Self {
        Self((4.0 - length.max(f64::MIN_POSITIVE).log10().floor()).clamp(1.0, 12.0) as usize)
    }

    /// `x` as a TOML float.
    pub fn number(self, x: f64) -> String {
        let text = format!("{x:.*}", self.0);
        let short = text.trim_end_matches('0');
        let short = if short.ends_with('.') { format!("{short}0") } else { short.to_owned() };
        if short == "-0.0" { "0.0".to_owned() } else { short }
    }

    /// Three numbers as a TOML list.
    pub fn list(self, [x, y, z]: [f64; 3]) -> String {
        format!("[{}, {}, {}]", self.number(x), self.number(y), self.number(z))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use serde::Deserialize;
    use std::collections::BTreeMap;

    #[derive(Deserialize)]
    #[serde(deny_unknown_fields)]
    struct Table {
        value: String,
        table: BTreeMap<String, bool>,
    }

    proptest! {
        /// Any text comes back from a TOML file as a value and as a key.
        #[test]
        fn quoted_text_is_read_back(text in prop_oneof![".*", "\\PC*", "[\\x00-\\x7f]*"]) {
            let file = format!("value = {}\n[table]\n{} = true\n", quoted(&text), key(&text));
            let table: Table = relume_formats::state::parse_toml(&file, &relume_formats::Place::file("t.toml")).unwrap();
            prop_assert_eq!(&table.value, &text);
            prop_assert_eq!(table.table.into_keys().next(), Some(text));
        }

        /// Numbers are written to 10⁻⁴ of what they stand beside.
        #[test]
        fn numbers_are_near(length in 1e-6..1e6_f64, share in -10.0..10.0_f64) {
            let x = length * share;
            let read: f64 = Digits::beside(length).number(x).parse().unwrap();
            prop_assert!((read - x).abs() <= 0.5e-4 * length.max(1e-4), "{} for {}", read, x);
        }
    }

    #[test]
    fn numbers_are_short() {
        let shown = |length: f64, x: f64| Digits::beside(length).number(x);
        assert_eq!(
            (shown(1.0, 0.5), shown(1.0, -0.000_001), shown(30.0, 7.0)),
            ("0.5".into(), "0.0".into(), "7.0".into())
        );
        assert_eq!(Digits::beside(0.01).list([0.012_345_67, 1.0, 0.0]), "[0.012346, 1.0, 0.0]");
    }
}
