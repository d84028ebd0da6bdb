//! One wording for names that are not there.

use relume_formats::name::shortened;
use relume_formats::near::what_there_is;
use relume_formats::{Error, Place, Result};
use std::collections::HashMap;

/// "no material `bnny`; did you mean `bunny`? There are: `bunny`, `walls`".
pub(crate) fn unknown_name<'a>(what: &str, given: &str, known: impl IntoIterator<Item = &'a str>) -> String {
    let known: Vec<&str> = known.into_iter().collect();
    let shown = shortened(given);
    if known.is_empty() {
        return format!("no {what} `{shown}`; there is none at all");
    }
    format!("no {what} `{shown}`{}", what_there_is(given, &known))
}

/// Names by which things are referred to.
pub(crate) struct Names<'a> {
    what: &'static str,
    in_order: Vec<&'a str>,
    indices: HashMap<&'a str, usize>,
}

impl<'a> Names<'a> {
    /// The names of every `what`; of two that are equal the first counts.
    pub fn new(what: &'static str, names: impl IntoIterator<Item = &'a str>) -> Self {
        let in_order: Vec<&str> = names.into_iter().collect();
        let indices = in_order.iter().enumerate().rev().map(|(index, name)| (*name, index)).collect();
        Self { what, in_order, indices }
    }

    /// The index of `name`, or an error that suggests one.
    pub fn index_of(&self, name: &str, place: &Place) -> Result<usize> {
        let unknown = || Error::invalid(place, unknown_name(self.what, name, self.in_order.iter().copied()));
        self.indices.get(name).copied().ok_or_else(unknown)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lists_are_as_long_as_anybody_reads() {
        let names: Vec<String> = (0..100_000).map(|number| format!("material-{number}")).collect();
        let message = unknown_name("material", "materail-7", names.iter().map(String::as_str));
        assert!(
            message.starts_with(
                "no material `materail-7`; did you mean `material-7`? There are: `material-0`, `material-1`"
            ),
            "{message}"
        );
        assert!(message.ends_with("`material-19` and 99980 more"), "{message}");
        let long = unknown_name("material", &"y".repeat(300_000), ["x".repeat(300_000).as_str()]);
        assert!(long.len() < 300 && !long.contains("did you mean"), "{long}");
    }

    #[test]
    fn the_first_of_two_equal_names_counts() {
        let names = Names::new("light", ["a", "b", "a"]);
        let place = Place::file("scene.toml");
        assert_eq!((names.index_of("a", &place).unwrap(), names.index_of("b", &place).unwrap()), (0, 1));
        assert_eq!(
            names.index_of("c", &place).unwrap_err().to_string(),
            "scene.toml: no light `c`; did you mean `a`? There are: `a`, `b`, `a`"
        );
    }
}
