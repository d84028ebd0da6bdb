//! One wording for names that are not there.

/// "no material `bnny`; did you mean `bunny`? There are: `bunny`, `walls`".
pub(crate) fn unknown_name<'a>(what: &str, given: &str, known: impl IntoIterator<Item = &'a str>) -> String {
    let known: Vec<&str> = known.into_iter().collect();
    if known.is_empty() {
        return format!("no {what} `{given}`; there is none at all");
    }
    let nearest = known.iter().map(|name| (strsim::damerau_levenshtein(given, name), *name)).min();
    let hint = match nearest {
        Some((distance, name)) if distance <= 1 + given.len() / 3 => format!("did you mean `{name}`? "),
        _ => String::new(),
    };
    let list: Vec<String> = known.iter().map(|name| format!("`{name}`")).collect();
    format!("no {what} `{given}`; {hint}There are: {}", list.join(", "))
}
