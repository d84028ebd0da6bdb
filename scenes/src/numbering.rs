//! Names that occur more than once, as other programs write them: the later ones are numbered.

use std::collections::{HashMap, HashSet};

/// Names given so far.
#[derive(Default)]
pub(crate) struct Names {
    taken: HashSet<String>,
    /// The next number to try for a name that occurs again, so that many equal names take no time.
    next: HashMap<String, usize>,
}

impl Names {
    /// `wanted`, or if that is taken the first free of `wanted-2`, `wanted-3` and so on, which is taken from
    /// now on.
    pub fn take(&mut self, wanted: &str) -> String {
        if self.taken.insert(wanted.to_owned()) {
            return wanted.to_owned();
        }
        let next = self.next.entry(wanted.to_owned()).or_insert(2);
        loop {
            let numbered = format!("{wanted}-{next}");
            *next += 1;
            if self.taken.insert(numbered.clone()) {
                return numbered;
            }
        }
    }
}

/// `wanted` made different from each other, and those that were changed.
pub(crate) fn numbered(wanted: impl IntoIterator<Item = String>) -> (Vec<String>, Vec<String>) {
    let (mut names, mut changed) = (Names::default(), Vec::new());
    let all = wanted.into_iter().map(|wanted| {
        let name = names.take(&wanted);
        if name != wanted {
            changed.push(name.clone());
        }
        name
    });
    (all.collect(), changed)
}

/// `names` in a sentence: all of them, or the first few and how many more there are.
pub(crate) fn listed(names: &[String]) -> String {
    const MOST: usize = 3;
    let shown: Vec<String> = names.iter().take(MOST).map(|name| format!("`{name}`")).collect();
    match names.len().saturating_sub(MOST) {
        0 => shown.join(", "),
        more => format!("{} and {more} more", shown.join(", ")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(names: &[&str]) -> (Vec<String>, Vec<String>) {
        numbered(names.iter().map(|name| (*name).to_owned()))
    }

    #[test]
    fn later_names_are_numbered_past_those_that_are_taken() {
        let (all, changed) = of(&["a", "b", "a", "a-2", "a", "a-2"]);
        assert_eq!(all, ["a", "b", "a-2", "a-2-2", "a-3", "a-2-3"]);
        assert_eq!(changed, ["a-2", "a-2-2", "a-3", "a-2-3"]);
        assert_eq!(
            (listed(&changed), listed(&all[..2])),
            ("`a-2`, `a-2-2`, `a-3` and 1 more".to_owned(), "`a`, `b`".to_owned())
        );
    }

    #[test]
    fn many_equal_names_are_told_apart_at_once() {
        let (all, _) = numbered(std::iter::repeat_n("Material".to_owned(), 200_000));
        assert_eq!(all[199_999], "Material-200000");
    }
}
