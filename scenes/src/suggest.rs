//! One wording for names that are not there.

use relume_formats::name::{MAX_CHARS, shortened};
use relume_formats::{Error, Place, Result};
use std::collections::HashMap;

/// As many names as anybody would read are listed.
const MOST_LISTED: usize = 20;

/// "no material `bnny`; did you mean `bunny`? There are: `bunny`, `walls`".
pub(crate) fn unknown_name<'a>(what: &str, given: &str, known: impl IntoIterator<Item = &'a str>) -> String {
    let known: Vec<&str> = known.into_iter().collect();
    let shown = shortened(given);
    if known.is_empty() {
        return format!("no {what} `{shown}`; there is none at all");
    }
    let hint = nearest(given, &known).map_or_else(String::new, |name| format!("did you mean `{name}`? "));
    let list: Vec<String> = known.iter().take(MOST_LISTED).map(|name| format!("`{}`", shortened(name))).collect();
    let more = known.len().saturating_sub(MOST_LISTED);
    let more = if more > 0 { format!(" and {more} more") } else { String::new() };
    format!("no {what} `{shown}`; {hint}There are: {}{more}", list.join(", "))
}

/// The name that is meant, if one is near. Comparing takes the product of two lengths, so that what is too long for a name is near to none.
fn nearest<'a>(given: &str, known: &[&'a str]) -> Option<&'a str> {
    if given.len() > MAX_CHARS {
        return None;
    }
    let most = 1 + given.len() / 3;
    let near = known.iter().filter(|name| name.len().abs_diff(given.len()) <= 4 * most && name.len() <= 4 * MAX_CHARS);
    let nearest = near.map(|name| (strsim::damerau_levenshtein(given, name), *name)).min();
    nearest.filter(|(distance, _)| *distance <= most).map(|(_, name)| name)
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
            message.starts_with("no material `materail-7`; did you mean `material-7`? There are: `material-0`, `material-1`"),
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
