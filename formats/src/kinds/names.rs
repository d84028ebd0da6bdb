//! What a name may be that stands in a file: of a scene, a material, an object, a map, a clip, an animation
//! or a mesh.

use crate::name::{MAX_MADE_CHARS, plain, shortened, steers};
use std::collections::HashSet;

/// What is wrong with a name of `what`, if anything is.
pub(crate) fn fault_of_name(what: &str, name: &str) -> Option<String> {
    if name.chars().nth(MAX_MADE_CHARS).is_some() {
        return Some(format!("the name of {what} has more than {MAX_MADE_CHARS} characters"));
    }
    name.chars()
        .any(steers)
        .then(|| format!("the name `{}` of {what} has control characters", plain(&shortened(name))))
}

/// What is wrong with the first of some names that are all of `what`, in the plural, and must differ.
pub(crate) fn fault_of_names<'a>(what: &str, names: impl IntoIterator<Item = &'a str>) -> Option<String> {
    let mut known = HashSet::new();
    names.into_iter().find_map(|name| {
        let twice = || (!known.insert(name)).then(|| format!("two {what} are called `{name}`"));
        fault_of_name(&format!("one of the {what}"), name).or_else(twice)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_short_plain_and_differ() {
        assert_eq!(fault_of_names("materials", ["a", "päper", &"é".repeat(MAX_MADE_CHARS)]), None);
        assert_eq!(
            fault_of_name("object", &"é".repeat(MAX_MADE_CHARS + 1)).unwrap(),
            "the name of object has more than 272 characters"
        );
        assert_eq!(
            fault_of_names("maps", ["a", "b\u{1b}[2J"]).unwrap(),
            "the name `b\\u{1b}[2J` of one of the maps has control characters"
        );
        assert_eq!(fault_of_names("maps", ["a", "b", "a"]).unwrap(), "two maps are called `a`");
    }
}
