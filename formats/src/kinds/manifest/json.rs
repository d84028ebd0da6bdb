//! The text of a manifest: JSON, read strictly. A key that is there twice, one that nobody knows and a value
//! of another type are errors, told by where in the manifest they are.

use super::{FileEntry, MAX_MEASURED_ON_CHARS, Manifest, MethodEntry, SphereSetEntry};
use crate::name::{plain, shortened};
use crate::near::did_you_mean;
use serde::de::{Deserialize, Deserializer, Error as _, MapAccess, SeqAccess, Visitor};
use serde_json::{Map, Number, Value};
use std::collections::BTreeMap;
use std::fmt;

/// The JSON value that `text` is, or what is wrong with it.
pub(super) fn parse(text: &str) -> Result<Value, String> {
    match serde_json::from_str(text) {
        Ok(Strict(value)) => Ok(value),
        Err(error) if error.is_eof() => {
            Err(format!("ends early, at line {}; the file is cut short", error.line()))
        }
        Err(error) => {
            let (line, column) = (error.line(), error.column());
            let message = error.to_string();
            let reason = message.rsplit_once(" at line ").map_or(message.as_str(), |(reason, _)| reason);
            Err(format!("line {line}, column {column}: {}", plain(reason)))
        }
    }
}

/// A value in which no object has a key twice; [`Value`] itself would keep the last.
struct Strict(Value);

impl<'de> Deserialize<'de> for Strict {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(AnyValue).map(Self)
    }
}

struct AnyValue;

impl<'de> Visitor<'de> for AnyValue {
    type Value = Value;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a value")
    }

    fn visit_bool<E>(self, value: bool) -> Result<Value, E> {
        Ok(Value::Bool(value))
    }

    fn visit_i64<E>(self, value: i64) -> Result<Value, E> {
        Ok(value.into())
    }

    fn visit_u64<E>(self, value: u64) -> Result<Value, E> {
        Ok(value.into())
    }

    fn visit_f64<E: serde::de::Error>(self, value: f64) -> Result<Value, E> {
        Number::from_f64(value).map(Value::Number).ok_or_else(|| E::custom("a number is beyond all bounds"))
    }

    fn visit_str<E>(self, value: &str) -> Result<Value, E> {
        Ok(value.into())
    }

    fn visit_unit<E>(self) -> Result<Value, E> {
        Ok(Value::Null)
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut items: A) -> Result<Value, A::Error> {
        let mut list = Vec::new();
        while let Some(Strict(item)) = items.next_element()? {
            list.push(item);
        }
        Ok(Value::Array(list))
    }

    fn visit_map<A: MapAccess<'de>>(self, mut entries: A) -> Result<Value, A::Error> {
        let mut map = Map::new();
        while let Some((key, Strict(value))) = entries.next_entry::<String, Strict>()? {
            let name = named(&key);
            if map.insert(key, value).is_some() {
                return Err(A::Error::custom(format!("key `{name}` is there twice")));
            }
        }
        Ok(Value::Object(map))
    }
}

/// A key or name as a message shows it.
fn named(name: &str) -> String {
    plain(&shortened(name)).into_owned()
}

/// What a value is, for a user.
fn what(value: &Value) -> String {
    match value {
        Value::Null => "null".to_owned(),
        Value::Bool(value) => value.to_string(),
        Value::Number(number) => number.to_string(),
        Value::String(text) => format!("\"{}\"", named(text)),
        Value::Array(_) => "a list".to_owned(),
        Value::Object(_) => "an object".to_owned(),
    }
}

/// The object at a place in a manifest, its values taken one after the other.
struct Fields {
    place: String,
    map: Map<String, Value>,
}

type Read<T> = Result<T, String>;

impl Fields {
    /// Of `value`, which must be an object with no other keys than those `known`.
    fn of(value: Value, place: &str, known: &[&str]) -> Read<Self> {
        let map = object(value, place)?;
        if let Some(stranger) = map.keys().find(|key| !known.contains(&key.as_str())) {
            return Err(format!(
                "{}: key `{}` is unknown{}",
                shown(place),
                named(stranger),
                did_you_mean(stranger, known.iter().copied())
            ));
        }
        Ok(Self { place: place.to_owned(), map })
    }

    fn place(&self, key: &str) -> String {
        join(&self.place, key)
    }

    fn take(&mut self, key: &str) -> Read<Value> {
        self.map.remove(key).ok_or_else(|| format!("{}: key `{key}` is missing", shown(&self.place)))
    }

    fn text(&mut self, key: &str) -> Read<String> {
        text(self.take(key)?, &self.place(key))
    }

    fn file(&mut self, key: &str) -> Read<FileEntry> {
        file(self.take(key)?, &self.place(key))
    }

    /// Every entry of the object at `key`; nothing if it may be absent and is.
    fn entries<T>(
        &mut self,
        key: &str,
        optional: bool,
        read: fn(Value, &str) -> Read<T>,
    ) -> Read<BTreeMap<String, T>> {
        if optional && !self.map.contains_key(key) {
            return Ok(BTreeMap::new());
        }
        let place = self.place(key);
        let entries = object(self.take(key)?, &place)?.into_iter();
        entries
            .map(|(name, value)| read(value, &join(&place, &named(&name))).map(|value| (name, value)))
            .collect()
    }
}

fn join(place: &str, key: &str) -> String {
    if place.is_empty() { key.to_owned() } else { format!("{place}.{key}") }
}

fn shown(place: &str) -> &str {
    if place.is_empty() { "the manifest" } else { place }
}

fn wrong(value: &Value, place: &str, expected: &str) -> String {
    format!("{}: {} where {expected} is expected", shown(place), what(value))
}

fn object(value: Value, place: &str) -> Read<Map<String, Value>> {
    match value {
        Value::Object(map) => Ok(map),
        other => Err(wrong(&other, place, "an object")),
    }
}

fn list(value: Value, place: &str) -> Read<Vec<Value>> {
    match value {
        Value::Array(list) => Ok(list),
        other => Err(wrong(&other, place, "a list")),
    }
}

fn text(value: Value, place: &str) -> Read<String> {
    match value {
        Value::String(text) => Ok(text),
        other => Err(wrong(&other, place, "a text")),
    }
}

fn number(value: Value, place: &str) -> Read<f64> {
    match value {
        Value::Number(number) => {
            number.as_f64().ok_or_else(|| format!("{place}: {number} is beyond all bounds"))
        }
        other => Err(wrong(&other, place, "a number")),
    }
}

fn file(value: Value, place: &str) -> Read<FileEntry> {
    let mut fields = Fields::of(value, place, &["file", "bytes", "hash"])?;
    let bytes = fields.take("bytes")?;
    let bytes = bytes
        .as_u64()
        .ok_or_else(|| wrong(&bytes, &fields.place("bytes"), "a whole number of at least 0"))?;
    Ok(FileEntry { file: fields.text("file")?, bytes, hash: fields.text("hash")? })
}

fn sphere_set(value: Value, place: &str) -> Read<SphereSetEntry> {
    let mut fields = Fields::of(value, place, &["file", "settings"])?;
    Ok(SphereSetEntry {
        file: fields.file("file")?,
        settings: fields.entries("settings", false, |value, _| Ok(value))?,
    })
}

/// A file of a method behind its kind.
fn file_of_kind(value: Value, place: &str) -> Read<(String, FileEntry)> {
    let pair: Result<[Value; 2], _> = list(value, place)?.try_into();
    let Ok([kind, entry]) = pair else { return Err(format!("{place}: a kind and a file are expected")) };
    Ok((text(kind, place)?, file(entry, place)?))
}

fn method(value: Value, place: &str) -> Read<MethodEntry> {
    let mut fields =
        Fields::of(value, place, &["name", "reads", "files", "settings", "errors", "measured_on"])?;
    let place = fields.place("files");
    let files = list(fields.take("files")?, &place)?.into_iter().enumerate();
    Ok(MethodEntry {
        name: fields.text("name")?,
        reads: fields.text("reads")?,
        files: files
            .map(|(at, value)| file_of_kind(value, &format!("{place}[{at}]")))
            .collect::<Read<_>>()?,
        settings: fields.entries("settings", false, |value, _| Ok(value))?,
        errors: fields.entries("errors", false, number)?,
        measured_on: if fields.map.contains_key("measured_on") {
            fields.text("measured_on")?
        } else {
            String::new()
        },
    })
}

/// The manifest that `value`, of a version that is read, stands for.
pub(super) fn manifest(value: Value) -> Read<Manifest> {
    let known = ["version", "scene", "scene_hash", "scene_file", "animations", "sphere_sets", "methods"];
    let mut fields = Fields::of(value, "", &known)?;
    let methods = list(fields.take("methods")?, "methods")?.into_iter().enumerate();
    Ok(Manifest {
        version: super::VERSION,
        scene: fields.text("scene")?,
        scene_hash: fields.text("scene_hash")?,
        scene_file: fields.file("scene_file")?,
        animations: fields.entries("animations", false, file)?,
        sphere_sets: fields.entries("sphere_sets", true, sphere_set)?,
        methods: methods.map(|(at, value)| method(value, &format!("methods[{at}]"))).collect::<Read<_>>()?,
    })
}

/// What is wrong with a text that says what was measured.
pub(super) fn fault_of_text(what: &str, text: &str) -> Option<String> {
    if text.chars().nth(MAX_MEASURED_ON_CHARS).is_some() {
        return Some(format!("{what} has more than {MAX_MEASURED_ON_CHARS} characters"));
    }
    let has_steering = text.chars().any(crate::name::steers);
    has_steering.then(|| format!("{what} has control characters: `{}`", named(text)))
}
