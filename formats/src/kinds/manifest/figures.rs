//! What settings and measured errors may be.

use super::json::fault_of_text;
use super::{MethodEntry, SphereSetEntry};
use crate::kinds::names::fault_of_name;
use crate::method::{Card, Form};
use crate::name::{plain, shortened};
use crate::near::did_you_mean;
use serde_json::Value;
use std::collections::BTreeMap;

/// Largest measured error. It is a root of a ratio of two sums of squares of radiances in single precision,
/// which are from 10⁻⁴⁵ to 10³⁹ where not 0, over at most 10⁹ values: below 10⁸⁹.
pub const MAX_ERROR: f64 = 1e100;
/// How far a median may be above the worst, for the rounding of a mean of two.
const MEDIAN_TOLERANCE: f64 = 1e-9;

/// Those of a sphere set.
const OF_SPHERES: &[(&str, Form)] = &[
    ("revision", Form::Count),
    ("spheres", Form::Count),
    ("seed", Form::Count),
    ("iterations", Form::Count),
    ("mesh_hash", Form::Hash),
];

/// Whether `text` is a hash as it is written: 32 digits 0-9 a-f.
pub(super) fn is_hash(text: &str) -> bool {
    text.len() == 32 && text.bytes().all(|b| b.is_ascii_digit() || (b'a'..=b'f').contains(&b))
}

/// What is wrong with the figures of a method, if anything is.
pub(super) fn fault_of_method(method: &MethodEntry) -> Option<String> {
    // Those of a method of a newer program are its own.
    let known = Card::find(&method.name).map(|card| card.settings);
    let reads = || (!is_hash(&method.reads)).then(|| "`reads` is no hash of 32 digits 0-9 a-f".to_owned());
    fault_of_settings(&method.settings, known)
        .or_else(reads)
        .or_else(|| fault_of_errors(&method.errors))
        .or_else(|| fault_of_text("`measured_on`", &method.measured_on))
        .or_else(|| method.files.iter().find_map(|(kind, _)| fault_of_name("a kind", kind)))
        .map(|fault| format!("method `{}`: {fault}", method.name))
}

/// What is wrong with the settings of the sphere set of `object`, if anything is.
pub(super) fn fault_of_sphere_set((object, set): (&String, &SphereSetEntry)) -> Option<String> {
    fault_of_settings(&set.settings, Some(OF_SPHERES)).map(|fault| format!("spheres of `{object}`: {fault}"))
}

fn fault_of_settings(settings: &BTreeMap<String, Value>, known: Option<&[(&str, Form)]>) -> Option<String> {
    settings.iter().find_map(|(name, value)| {
        let fault = fault_of_key(name).or_else(|| fault_of_texts(value));
        let (Some(known), None) = (known, &fault) else { return fault };
        let Some((_, form)) = known.iter().find(|(key, _)| key == name) else {
            return Some(format!(
                "setting `{name}` is unknown{}",
                did_you_mean(name, known.iter().map(|(key, _)| *key))
            ));
        };
        form.fault(value).map(|expected| {
            format!("setting `{name}` is {}, expected {expected}", shortened(&plain(&value.to_string())))
        })
    })
}

fn fault_of_errors(errors: &BTreeMap<String, f64>) -> Option<String> {
    // JSON has no NaN; it would be written as null, which nothing can read back.
    let is_error = |error: f64| (0.0..=MAX_ERROR).contains(&error);
    errors.iter().find_map(|(name, error)| {
        let range = || {
            (!is_error(*error))
                .then(|| format!("measured error `{name}` is {error:e}, outside 0..{MAX_ERROR:e}"))
        };
        let worst = || {
            errors
                .get(&name.replace("median", "worst"))
                .filter(|worst| *error > **worst * (1.0 + MEDIAN_TOLERANCE))
        };
        fault_of_key(name).or_else(range).or_else(|| {
            worst().map(|worst| format!("measured error `{name}` is {error:e}, above the worst, {worst:e}"))
        })
    })
}

fn fault_of_key(key: &str) -> Option<String> {
    let is_plain = !key.is_empty()
        && key.len() <= 64
        && key.bytes().all(|b| b.is_ascii_lowercase() || b.is_ascii_digit() || b == b'_');
    (!is_plain).then(|| {
        format!("`{}` is no name of a setting or error, which are of a-z 0-9 _", plain(&shortened(key)))
    })
}

/// Texts within a value reach terminals too.
fn fault_of_texts(value: &Value) -> Option<String> {
    match value {
        Value::String(text) => fault_of_name("a setting", text),
        Value::Array(list) => list.iter().find_map(fault_of_texts),
        Value::Object(map) => map
            .iter()
            .find_map(|(key, value)| fault_of_name("a setting", key).or_else(|| fault_of_texts(value))),
        _ => None,
    }
}

impl Form {
    /// What is expected, if `value` is something else.
    fn fault(self, value: &Value) -> Option<&'static str> {
        let is_object = |value: &Value| match value.as_array().map(Vec::as_slice) {
            Some([Value::String(_), spheres]) => spheres.is_null() || spheres.is_u64(),
            _ => false,
        };
        let is_casting = |value: &Value| {
            value.as_array().is_some_and(|pair| pair.len() == 2 && pair.iter().all(Value::is_string))
        };
        let (fits, expected) = match self {
            Self::Count => (value.is_u64(), "a whole number of at least 0"),
            Self::Positive => (value.as_f64().is_some_and(|x| x > 0.0), "a number above 0"),
            Self::Size => (
                matches!(value.as_array().map(Vec::as_slice), Some([a, b]) if a.is_u64() && b.is_u64()),
                "[width, height]",
            ),
            Self::Hash => (value.as_str().is_some_and(is_hash), "32 digits 0-9 a-f"),
            Self::Objects => (
                value.as_array().is_some_and(|list| list.iter().all(is_object)),
                "objects with their numbers of spheres",
            ),
            Self::Text => (value.is_string(), "a text"),
            Self::Casters => (
                value.as_array().is_some_and(|list| list.iter().all(is_casting)),
                "objects with what they cast shadows by",
            ),
        };
        (!fits).then_some(expected)
    }
}
