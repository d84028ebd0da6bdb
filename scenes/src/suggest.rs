//! One wording for names that are not there.

use relume_formats::near::did_you_mean;

/// "no material `bnny`; did you mean `bunny`? There are: `bunny`, `walls`".
pub(crate) fn unknown_name<'a>(what: &str, given: &str, known: impl IntoIterator<Item = &'a str>) -> String {
    let known: Vec<&str> = known.into_iter().collect();
    if known.is_empty() {
        return format!("no {what} `{given}`; there is none at all");
    }
    let hint = did_you_mean(given, known.iter().copied());
    let list: Vec<String> = known.iter().map(|name| format!("`{name}`")).collect();
    format!("no {what} `{given}`;{hint} There are: {}", list.join(", "))
}
