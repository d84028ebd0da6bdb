//! One wording for names that are not there.

use relume_formats::near::what_there_is;

/// "no material `bnny`; did you mean `bunny`? There are: `bunny`, `walls`".
pub(crate) fn unknown_name<'a>(what: &str, given: &str, known: impl IntoIterator<Item = &'a str>) -> String {
    let known: Vec<&str> = known.into_iter().collect();
    if known.is_empty() {
        return format!("no {what} `{given}`; there is none at all");
    }
    format!("no {what} `{given}`{}", what_there_is(given, &known))
}
