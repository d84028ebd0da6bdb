//! What was meant: the remedies at the end of messages.

use crate::basis::linear_from_hex;
use crate::near::did_you_mean;
use std::ops::Range;
use toml::de::{DeArray, DeValue};

/// Longest text that a message repeats.
const MAX_QUOTED: usize = 40;

/// Where keys belong that are likely to stand in the wrong table.
const HOMES: [(&str, &[&str]); 8] = [
    (
        "[materials.NAME]",
        &[
            "brdf",
            "kd",
            "ks",
            "shininess",
            "fresnel",
            "base_color",
            "metallic",
            "roughness",
            "texture",
            "alpha_cutoff",
        ],
    ),
    ("[camera]", &["position", "target", "fov_deg", "exposure_ev"]),
    ("[render]", &["size", "reflections"]),
    ("[[light]]", &["kind", "radiance", "intensity", "irradiance"]),
    ("[[object]]", &["shape", "node", "spheres", "subdivisions", "segments", "radius", "material"]),
    ("[environment]", &["map", "gain", "rotation_deg", "others"]),
    ("[view]", &["tonemap"]),
    ("[vary]", &["view"]),
];

/// Tables of which there may be several.
const LISTS: [&str; 3] = ["object", "light", "key"];

/// What only a scene says of what a state changes: whose it is, the keys by which the state's table is known,
/// and those of the scene.
const OF_SCENES_ALONE: [(&str, &[&str], &[&str]); 4] = [
    (
        "a material",
        &["kd", "ks", "shininess", "fresnel", "base_color", "metallic", "roughness"],
        &["brdf", "texture", "alpha_cutoff", "emission", "name"],
    ),
    ("a light", &["gain"], &["kind", "intensity", "irradiance", "name"]),
    ("the environment", &["map", "rotation_deg", "gain"], &["file", "others"]),
    (
        "a shape",
        &["clip", "time_s", "pose"],
        &["file", "shape", "node", "material", "transform", "spheres", "twist_deg", "twist_s", "name"],
    ),
];

/// What many call the colour of a material.
const COLOURS: [&str; 5] = ["color", "colour", "albedo", "diffuse", "diffuse_color"];

/// Why `key` is refused where `expected` may stand.
pub(super) fn unknown_key(key: &str, expected: &[&str]) -> String {
    let names = || expected.iter().map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", ");
    if let Some((whose, ..)) =
        OF_SCENES_ALONE.iter().find(|(_, can, cannot)| *can == expected && cannot.contains(&key))
    {
        return format!(
            "a state cannot set `{key}` of {whose}, only scene.toml can, before the bake; there are: {}",
            names()
        );
    }
    if COLOURS.contains(&key) && expected.contains(&"base_color") {
        return format!(
            "unknown key `{key}`; the colour of a material is `base_color` of ggx, `kd` of other models"
        );
    }
    // A table that has other keys of a home is that very table.
    let is_here = |keys: &[&str]| keys.iter().any(|key| expected.contains(key));
    let home = HOMES
        .iter()
        .find(|(_, keys)| keys.contains(&key) && !is_here(keys))
        .map(|(table, _)| format!("it belongs to {table}"));
    let near = did_you_mean(key, expected.iter().copied());
    let list = || format!("there are: {}", names());
    let remedy = if near.is_empty() { format!("; {}", home.unwrap_or_else(list)) } else { near };
    format!("unknown key `{}`{remedy}", short(key))
}

pub(super) fn short(text: &str) -> String {
    if text.chars().count() <= MAX_QUOTED {
        text.to_owned()
    } else {
        text.chars().take(MAX_QUOTED).chain("…".chars()).collect()
    }
}

/// What stands there, for a message.
pub(super) fn found(value: &DeValue<'_>) -> String {
    match value {
        DeValue::String(text) => format!("the text \"{}\"", short(text)),
        DeValue::Integer(number) => format!("the number {}", short(&number.to_string())),
        DeValue::Float(number) => format!("the number {}", short(number.as_str())),
        DeValue::Boolean(on) => on.to_string(),
        DeValue::Datetime(date) => format!("the date {date}"),
        DeValue::Array(list) if list.iter().all(|member| member.get_ref().is_table()) && !list.is_empty() => {
            "a list of tables".to_owned()
        }
        DeValue::Array(list) => format!("a list of {}", list.len()),
        DeValue::Table(_) => "a table".to_owned(),
    }
}

pub(super) fn of_number(value: &DeValue<'_>) -> Option<String> {
    match value {
        DeValue::String(text) if text.trim().parse::<f64>().is_ok() => {
            Some(format!("write {} without quotes", text.trim()))
        }
        DeValue::String(text) => decimal_comma(text).map(|number| format!("write {number} without quotes")),
        DeValue::Array(list) if list.len() == 1 => Some("remove the brackets".to_owned()),
        _ => None,
    }
}

pub(super) fn of_count(value: &DeValue<'_>) -> Option<String> {
    match value {
        DeValue::Float(number) => {
            let whole = number.as_str().parse::<f64>().ok().filter(|x| x.fract() == 0.0 && x.abs() < 1e9);
            whole.map(|x| format!("write {x:.0}"))
        }
        other => of_number(other),
    }
}

pub(super) fn of_text(value: &DeValue<'_>) -> Option<String> {
    match value {
        DeValue::Integer(number) => Some(format!("write \"{number}\" with quotes")),
        DeValue::Float(number) => Some(format!("write \"{}\" with quotes", number.as_str())),
        DeValue::Array(list) if list.len() == 1 => Some("remove the brackets".to_owned()),
        _ => None,
    }
}

pub(super) fn of_switch(value: &DeValue<'_>) -> Option<String> {
    let meant = match value {
        DeValue::String(text) => match text.trim().to_lowercase().as_str() {
            "true" | "yes" | "on" | "1" => Some(true),
            "false" | "no" | "off" | "0" => Some(false),
            _ => None,
        },
        DeValue::Integer(number) => [("0", false), ("1", true)]
            .into_iter()
            .find(|(digit, _)| *digit == number.as_str())
            .map(|(_, on)| on),
        _ => None,
    };
    let quoted = value.as_str().is_some_and(|text| ["true", "false"].contains(&text));
    meant.map(|on| format!("write {on}{}", if quoted { " without quotes" } else { "" }))
}

pub(super) fn of_list(value: &DeValue<'_>) -> Option<String> {
    value.as_str().map(|text| format!("write [\"{}\"]", short(text)))
}

/// What to write where `length` numbers are expected.
pub(super) fn of_numbers(value: &DeValue<'_>, length: usize) -> Option<String> {
    let repeated = |number: &str| format!("write [{}]", vec![number; length].join(", "));
    match value {
        DeValue::Integer(number) => Some(repeated(&number.to_string())),
        DeValue::Float(number) => Some(repeated(number.as_str())),
        DeValue::String(text) if length == 3 => hex_colour(text).map(|[r, g, b]| {
            format!("write [{r:.4}, {g:.4}, {b:.4}], the linear light that this colour stands for")
        }),
        _ => None,
    }
}

/// What to do about a list that is not of `length`.
pub(super) fn of_length(list: &DeArray<'_>, length: usize) -> String {
    let digits: Option<Vec<&str>> =
        list.iter().map(|member| member.get_ref().as_integer().map(|integer| integer.as_str())).collect();
    match digits {
        Some(digits) if list.len() == 2 * length => {
            let numbers: Vec<String> = digits.chunks_exact(2).map(|pair| pair.join(".")).collect();
            format!("if the commas within numbers are decimal, write [{}]", numbers.join(", "))
        }
        _ if list.len() > length => format!("remove {}", list.len() - length),
        _ => format!("add {}", length - list.len()),
    }
}

/// Linear Rec. 709 of a colour such as `#808080` or `#888`, which is sRGB.
fn hex_colour(text: &str) -> Option<[f32; 3]> {
    linear_from_hex(Some(text).filter(|text| text.trim_start().starts_with('#'))?)
}

/// `40,5` as 40.5.
fn decimal_comma(text: &str) -> Option<String> {
    let (whole, fraction) = text.trim().split_once(',')?;
    let digits = |text: &str| !text.is_empty() && text.bytes().all(|b| b.is_ascii_digit());
    let legal = digits(whole.trim_start_matches(['-', '+'])) && digits(fraction);
    legal.then(|| format!("{whole}.{fraction}"))
}

/// Where in `text`, which is no TOML, what is wrong; `message` is the parser's.
pub(super) fn of_syntax(text: &str, span: &Range<usize>, message: &str) -> (usize, String) {
    let flat = message.split_whitespace().collect::<Vec<_>>().join(" ");
    let start = text.get(..span.start).map_or(0, |before| before.rfind('\n').map_or(0, |at| at + 1));
    let line = text.get(start..).unwrap_or_default().lines().next().unwrap_or_default();
    if flat == "duplicate key" {
        return (span.start, twice(line, short(text.get(span.clone()).unwrap_or_default()).as_str()));
    }
    match of_line(line) {
        Some((at, what)) => (start + at, what),
        None => (span.start, format!("not TOML: {flat}; mend the line")),
    }
}

/// Why `key`, which stands in `line` for the second time, is refused.
fn twice(line: &str, key: &str) -> String {
    let (header, several) = (line.trim_start().starts_with('['), LISTS.contains(&key));
    match (header, several) {
        (true, true) => format!(
            "[{key}] stands for one table where there are several; write [[{key}]] above each, with two brackets"
        ),
        (true, false) => format!("[{key}] is there twice; put the keys of both into one"),
        (false, _) => format!("`{key}` is there twice; remove one"),
    }
}

/// Where in a line that is no TOML what is wrong, and the remedy.
fn of_line(line: &str) -> Option<(usize, String)> {
    if let Some((at, sign)) = line.char_indices().find(|(_, c)| "“”„‟«»‘’‚".contains(*c)) {
        return Some((at, format!("`{sign}` is a typographic quotation mark; write \" instead")));
    }
    if let Some((at, sign)) = line.char_indices().find(|(_, c)| "−–—".contains(*c)) {
        return Some((at, format!("`{sign}` is a typographic dash; write - instead")));
    }
    if let Some(hint) = of_header(line) {
        return Some(hint);
    }
    if let Some((key, value)) =
        line.split_once(':').filter(|(key, _)| !key.is_empty() && key.trim().chars().all(is_bare))
    {
        return Some((key.len(), format!("`:` after `{0}`; write {0} = {1}", key.trim(), value.trim())));
    }
    let (before, after) = line.split_once('=')?;
    let (key, value) = (before.trim(), after.trim());
    let at = line.len() - after.trim_start().len();
    if let Some([r, g, b]) = hex_colour(value) {
        return Some((
            at,
            format!(
                "{key}: `#` begins a comment; write [{r:.4}, {g:.4}, {b:.4}], the linear light that this colour stands for"
            ),
        ));
    }
    let value = value.split('#').next().unwrap_or_default().trim();
    let found = if value.is_empty() { "nothing".to_owned() } else { format!("`{}`", short(value)) };
    Some((at, format!("{key}: {found} is no value; {}", of_value(value)?)))
}

/// A table called by a name with blanks, as other programs give them.
fn of_header(line: &str) -> Option<(usize, String)> {
    let name = line.trim().strip_prefix('[')?.strip_suffix(']')?.strip_prefix("materials.")?;
    let quoted = name.starts_with(['"', '\'']);
    (!quoted && !name.chars().all(is_bare)).then(|| {
        let at = line.len() - line.trim_start().len();
        (
            at,
            format!(
                "the name `{0}` has more than letters, digits, - and _; write [materials.\"{0}\"]",
                short(name)
            ),
        )
    })
}

fn is_bare(c: char) -> bool {
    c.is_ascii_alphanumeric() || "_-.".contains(c)
}

fn of_value(value: &str) -> Option<String> {
    if let Some(number) = decimal_comma(value) {
        return Some(format!("write {number}, with a decimal point"));
    }
    if let Some(before) = value.strip_suffix([';', ',']) {
        return Some(format!("write {}, without the sign at its end", before.trim_end()));
    }
    let number = value.trim_start_matches(['+', '-']);
    let digits = |text: &str| !text.is_empty() && text.bytes().all(|b| b.is_ascii_digit());
    match value.to_lowercase().as_str() {
        "" => return Some("write one after the `=`".to_owned()),
        "true" | "yes" | "on" => return Some("write true".to_owned()),
        "false" | "no" | "off" => return Some("write false".to_owned()),
        _ => {}
    }
    if number.strip_prefix('.').is_some_and(digits) || number.strip_suffix('.').is_some_and(digits) {
        let sign = value.get(..value.len() - number.len()).unwrap_or_default();
        let whole = if number.starts_with('.') { format!("0{number}") } else { format!("{number}0") };
        return Some(format!("write {sign}{whole}"));
    }
    let word = value.starts_with(|c: char| c.is_alphabetic())
        && value.chars().all(|c| is_bare(c) || "/ ".contains(c) || c.is_alphabetic());
    word.then(|| format!("write \"{value}\" with quotes"))
}
