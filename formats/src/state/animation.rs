//! Keyframed states. Every leaf of a state is its own track: linear between its keys, held before the first
//! and after the last.

use super::{
    CameraState, EnvironmentState, LightState, MaterialState, ShapeState, State, ViewState, parse_toml,
    read_text, with_line,
};
use crate::error::{Error, Place, Result};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::Path;

/// Upper bound on the keys of one animation.
pub const MAX_KEYS: usize = 100_000;
/// Most names on the way to a leaf of a state: `materials`, the material's, `kd`.
const MAX_LEAF_DEPTH: usize = 3;

/// A named timeline of states.
#[derive(Debug, Clone, PartialEq)]
pub struct Animation {
    /// Name, as used by `player --animation`.
    pub name: String,
    /// Length in seconds, above 0.
    pub duration_s: f32,
    /// Whether a player repeats it.
    pub looping: bool,
    /// One track per leaf, sorted by leaf.
    pub tracks: Vec<Track>,
}

/// The keys of one leaf.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Track {
    /// Path of the leaf: `["materials", "bunny", "kd"]`.
    pub leaf: Vec<String>,
    /// Key times in seconds, strictly increasing, at least one.
    pub times_s: Vec<f32>,
    /// Values at the keys.
    pub values: TrackValues,
}

/// The values of a track.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub enum TrackValues {
    /// Interpolated numbers, one per key.
    Scalar(Vec<f32>),
    /// Interpolated vectors, all of the same length.
    Vector(Vec<Vec<f32>>),
    /// Names, held until the next key.
    Name(Vec<String>),
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    duration_s: f32,
    #[serde(default, rename = "loop")]
    looping: bool,
    #[serde(default)]
    key: Vec<KeyFile>,
}

/// `[[key]]`: a time, and the leaves of a state.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct KeyFile {
    t_s: f32,
    environment: Option<EnvironmentState>,
    camera: Option<CameraState>,
    view: Option<ViewState>,
    #[serde(default)]
    lights: BTreeMap<String, LightState>,
    #[serde(default)]
    materials: BTreeMap<String, MaterialState>,
    #[serde(default)]
    shapes: BTreeMap<String, ShapeState>,
}

enum Leaf {
    Scalar(f32),
    Vector(Vec<f32>),
    Name(String),
}

impl Animation {
    /// Reads an animation file; its name is the file's without the extension.
    pub fn read_file(path: &Path) -> Result<Self> {
        let name = path.file_stem().map_or_else(String::new, |s| s.to_string_lossy().into_owned());
        Self::parse(&name, &read_text(path)?, &Place::file(path)).map_err(with_line)
    }

    /// Parses the text of an animation file.
    pub fn parse(name: &str, text: &str, place: &Place) -> Result<Self> {
        let file: File = parse_toml(text, place)?;
        check_duration(file.duration_s, place)?;
        check_times(&file, place)?;
        let mut keys: BTreeMap<Vec<String>, Vec<(f32, Leaf)>> = BTreeMap::new();
        for (index, key) in file.key.into_iter().enumerate() {
            let KeyFile { t_s, environment, camera, view, lights, materials, shapes } = key;
            let place = place_of_key(index, t_s, place);
            let state = State { environment, camera, view, lights, materials, shapes };
            let table = toml::Table::try_from(&state).map_err(|e| Error::invalid(&place, e.to_string()))?;
            let mut leaves = Vec::new();
            flatten(toml::Value::Table(table), &mut Vec::new(), &mut |leaf, value| {
                leaves.push((leaf, value))
            });
            for (leaf, value) in leaves {
                let track = keys.entry(leaf).or_default();
                if track.last().is_some_and(|(before, _)| *before == t_s) {
                    return Err(Error::invalid(
                        &place,
                        "sets what the key before it sets at the same time; remove one, or move it in time",
                    ));
                }
                track.push((t_s, value));
            }
        }
        if keys.is_empty() {
            return Err(Error::invalid(
                place,
                "sets nothing at any time; add a [[key]] with t_s and keys of a state, or remove the file",
            ));
        }
        let tracks =
            keys.into_iter().map(|(leaf, keys)| Track::new(leaf, keys, place)).collect::<Result<_>>()?;
        let animation =
            Self { name: name.to_owned(), duration_s: file.duration_s, looping: file.looping, tracks };
        animation.validate(place)?;
        Ok(animation)
    }

    /// Checks lengths, times and values.
    pub fn validate(&self, place: &Place) -> Result<()> {
        check_duration(self.duration_s, place)?;
        if self.tracks.iter().map(|t| t.times_s.len()).sum::<usize>() > MAX_KEYS {
            return Err(Error::invalid(place, format!("more than {MAX_KEYS} keys")));
        }
        self.tracks.iter().try_for_each(|track| track.validate(place))?;
        if let Some(pair) = self.tracks.windows(2).find(|w| w[0].leaf >= w[1].leaf) {
            return Err(Error::invalid(
                place,
                format!("track `{}` is out of order or there twice", pair[1].leaf.join(".")),
            ));
        }
        // The leaves must make a legal state at any time; types do not change over time, so one sample tells.
        self.sample(0.0).map(|_| ()).map_err(|e| Error::invalid(place, e))
    }

    /// The state at `time_s`; before 0 and after the end it is held.
    ///
    /// # Errors
    /// Only if the tracks name leaves that a state does not have, which [`Animation::validate`] rules out.
    pub fn sample(&self, time_s: f32) -> std::result::Result<State, String> {
        let mut root = toml::Table::new();
        for track in &self.tracks {
            insert(&mut root, &track.leaf, track.sample(time_s))?;
        }
        root.try_into().map_err(|e: toml::de::Error| e.message().to_owned())
    }

    /// The times of all keys of all tracks, increasing. Between them every leaf is linear and every legal
    /// range is convex, so if the states at these times are legal, all are.
    pub fn key_times_s(&self) -> Vec<f32> {
        let mut times_s: Vec<f32> =
            self.tracks.iter().flat_map(|track| track.times_s.iter().copied()).collect();
        times_s.sort_by(f32::total_cmp);
        times_s.dedup();
        times_s
    }

    /// How many frames cover the duration once at `fps`: ceil(duration·fps).
    pub fn frame_count(&self, fps: f32) -> usize {
        // 1.2 s at 30 fps is 36 frames although 1.2f32·30 is a rounding error above.
        (f64::from(self.duration_s) * f64::from(fps) - 1e-4).ceil().max(1.0) as usize
    }
}

fn check_duration(duration_s: f32, place: &Place) -> Result<()> {
    if duration_s > 0.0 && duration_s <= 86_400.0 {
        return Ok(());
    }
    Err(Error::invalid(place, format!("duration_s {duration_s} must be above 0 and at most a day")))
}

fn place_of_key(index: usize, t_s: f32, place: &Place) -> Place {
    place.part(format!("[[key]] number {} at {t_s} s", index + 1))
}

/// Keys stand in the order of time, within the duration.
fn check_times(file: &File, place: &Place) -> Result<()> {
    let mut before = 0.0;
    for (index, key) in file.key.iter().enumerate() {
        let refuse = |reason: String| Err(Error::invalid(&place_of_key(index, key.t_s, place), reason));
        if !(key.t_s.is_finite() && key.t_s >= 0.0) {
            return refuse("t_s must be a number of seconds from 0 on".to_owned());
        }
        if key.t_s < before {
            return refuse(format!("comes after one at {before} s; sort the keys by t_s"));
        }
        if key.t_s > file.duration_s {
            return refuse(format!(
                "comes after the end, duration_s {}; raise duration_s or lower t_s",
                file.duration_s
            ));
        }
        before = key.t_s;
    }
    Ok(())
}

fn flatten(value: toml::Value, path: &mut Vec<String>, add: &mut impl FnMut(Vec<String>, Leaf)) {
    match value {
        toml::Value::Table(table) => {
            for (key, value) in table {
                path.push(key);
                flatten(value, path, add);
                path.pop();
            }
        }
        toml::Value::Float(v) => add(path.clone(), Leaf::Scalar(v as f32)),
        toml::Value::Integer(v) => add(path.clone(), Leaf::Scalar(v as f32)),
        toml::Value::String(v) => add(path.clone(), Leaf::Name(v)),
        toml::Value::Array(values) => {
            let numbers = values
                .iter()
                .filter_map(|v| v.as_float().or(v.as_integer().map(|i| i as f64)).map(|v| v as f32))
                .collect();
            add(path.clone(), Leaf::Vector(numbers));
        }
        // A state has no other types; it was parsed as one before.
        toml::Value::Boolean(_) | toml::Value::Datetime(_) => {}
    }
}

fn insert(table: &mut toml::Table, path: &[String], value: toml::Value) -> std::result::Result<(), String> {
    match path {
        [] => Err("a track names no leaf".to_owned()),
        [last] => {
            table.insert(last.clone(), value);
            Ok(())
        }
        [first, rest @ ..] => {
            match table.entry(first.clone()).or_insert_with(|| toml::Value::Table(toml::Table::new())) {
                toml::Value::Table(inner) => insert(inner, rest, value),
                _ => Err(format!("`{first}` is both a leaf and a table")),
            }
        }
    }
}

impl Track {
    fn new(leaf: Vec<String>, keys: Vec<(f32, Leaf)>, place: &Place) -> Result<Self> {
        let times_s = keys.iter().map(|k| k.0).collect();
        let (mut scalars, mut vectors, mut names) = (Vec::new(), Vec::new(), Vec::new());
        for (_, value) in keys {
            match value {
                Leaf::Scalar(v) => scalars.push(v),
                Leaf::Vector(v) => vectors.push(v),
                Leaf::Name(v) => names.push(v),
            }
        }
        let values = match (scalars.is_empty(), vectors.is_empty(), names.is_empty()) {
            (false, true, true) => TrackValues::Scalar(scalars),
            (true, false, true) => TrackValues::Vector(vectors),
            (true, true, false) => TrackValues::Name(names),
            _ => {
                return Err(Error::invalid(
                    place,
                    format!("`{}` changes its type between keys", leaf.join(".")),
                ));
            }
        };
        Ok(Self { leaf, times_s, values })
    }

    fn validate(&self, place: &Place) -> Result<()> {
        let refuse =
            |reason: &str| Err(Error::invalid(place, format!("track `{}`: {reason}", self.leaf.join("."))));
        // No state nests deeper, and building the state recurses.
        if !(2..=MAX_LEAF_DEPTH).contains(&self.leaf.len()) {
            return Err(Error::invalid(
                place,
                format!("a track's leaf has {} names, 2 to {MAX_LEAF_DEPTH} are possible", self.leaf.len()),
            ));
        }
        if self.times_s.is_empty() || self.times_s.iter().any(|t| !t.is_finite() || *t < 0.0) {
            return refuse("needs keys at finite times of at least 0");
        }
        if self.times_s.windows(2).any(|w| w[0] >= w[1]) {
            return refuse("key times must increase; sort the keys and give each leaf one value at a time");
        }
        let (count, strange, even) = match &self.values {
            TrackValues::Scalar(v) => (v.len(), v.iter().position(|x| !x.is_finite()), true),
            TrackValues::Vector(v) => {
                let length = v.first().map_or(0, Vec::len);
                let strange = v.iter().position(|x| !x.iter().all(|x| x.is_finite()));
                (v.len(), strange, (1..=16).contains(&length) && v.iter().all(|x| x.len() == length))
            }
            TrackValues::Name(v) => (v.len(), None, true),
        };
        if count != self.times_s.len() || !even {
            return refuse("needs one value of the same length per key");
        }
        match strange.and_then(|key| self.times_s.get(key)) {
            Some(t_s) => {
                let reason = format!("{} is not finite; write numbers", self.leaf.join("."));
                Err(Error::invalid(&place.part(format!("at {t_s} s")), reason))
            }
            None => Ok(()),
        }
    }

    /// The key at or before `time_s`, the next one, and how far between them, 0..1.
    fn locate(&self, time_s: f32) -> (usize, usize, f32) {
        let after = self.times_s.partition_point(|t| *t <= time_s);
        let last = self.times_s.len() - 1;
        if after == 0 {
            return (0, 0, 0.0);
        }
        if after > last {
            return (last, last, 0.0);
        }
        let (t0, t1) = (self.times_s[after - 1], self.times_s[after]);
        (after - 1, after, (time_s - t0) / (t1 - t0))
    }

    fn sample(&self, time_s: f32) -> toml::Value {
        let (a, b, mix) = self.locate(time_s);
        let lerp = |x: f32, y: f32| toml::Value::Float(f64::from(x + (y - x) * mix));
        match &self.values {
            TrackValues::Scalar(v) => lerp(v[a], v[b]),
            TrackValues::Vector(v) => {
                toml::Value::Array(v[a].iter().zip(&v[b]).map(|(x, y)| lerp(*x, *y)).collect())
            }
            TrackValues::Name(v) => toml::Value::String(v[a].clone()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "
        duration_s = 2.0
        loop = true
        [[key]]
        t_s = 0
        materials.a.kd = [0.0, 0.2, 0.4]
        materials.a.shininess = 10
        [[key]]
        t_s = 1.0
        materials.a.shininess = 30.0
        [[key]]
        t_s = 2.0
        materials.a.kd = [0.4, 0.2, 0.0]
    ";

    fn parse(text: &str) -> Result<Animation> {
        Animation::parse("test", text, &Place::file("a.toml"))
    }

    #[test]
    fn every_leaf_is_its_own_track() {
        let animation = parse(TEXT).unwrap();
        let state = animation.sample(0.5).unwrap();
        assert_eq!(state.materials["a"].shininess, Some(20.0));
        assert_eq!(state.materials["a"].kd, Some([0.1, 0.2, 0.3]));
        let end = animation.sample(1.75).unwrap();
        assert_eq!(end.materials["a"].shininess, Some(30.0), "held after its last key");
    }

    #[test]
    fn frames_cover_the_duration() {
        let lasting = |duration_s: &str| TEXT.replace("= 2.0", &format!("= {duration_s}"));
        assert_eq!(parse(TEXT).unwrap().frame_count(30.0), 60);
        assert_eq!(parse(&lasting("1.2")).unwrap().frame_count(30.0), 36);
        assert_eq!(parse(&lasting("1.21")).unwrap().frame_count(30.0), 37);
    }

    #[test]
    fn mistakes_are_refused() {
        for (text, part) in [
            (
                TEXT.replace("loop", "looop"),
                "a.toml: line 3, column 9: unknown key `looop`; did you mean `loop`?",
            ),
            (
                TEXT.replace("t_s = 2.0", "t_s = 1.0\n materials.a.shininess = 5"),
                "a.toml: [[key]] number 3 at 1 s: sets what the key before it sets at the same time; remove one, or move it in time",
            ),
            (
                TEXT.replace("t_s = 2.0", "t_s = 0.5"),
                "a.toml: [[key]] number 3 at 0.5 s: comes after one at 1 s; sort the keys by t_s",
            ),
            (
                TEXT.replace("t_s = 2.0", "t_s = 2.5"),
                "a.toml: [[key]] number 3 at 2.5 s: comes after the end, duration_s 2; raise duration_s or lower t_s",
            ),
            (
                TEXT.replace("t_s = 0", "t_s = -1"),
                "a.toml: [[key]] number 1 at -1 s: t_s must be a number of seconds from 0 on",
            ),
            (
                TEXT.replace("shininess = 10", "shinyness = 10"),
                "a.toml: line 7, column 21: key.materials.a: unknown key `shinyness`; did you mean `shininess`?",
            ),
            (
                TEXT.replace("duration_s = 2.0", "duration_s = -1.0"),
                "a.toml: duration_s -1 must be above 0 and at most a day",
            ),
            (
                TEXT.replace("[0.4, 0.2, 0.0]", "[0.4, 0.2]"),
                "a.toml: line 13, column 26: key.materials.a.kd: 2 numbers where 3 are expected; add 1",
            ),
            (
                "duration_s = 1\n[[key]]\nt_s = 0".to_owned(),
                "a.toml: sets nothing at any time; add a [[key]] with t_s and keys of a state, or remove the file",
            ),
            (
                "duration_s = 1\n[[key]]\ncamera.fov_deg = 3".to_owned(),
                "a.toml: line 2, column 1: key: `t_s` is missing; add it",
            ),
            (
                "duration_s = 1\n[key]\nt_s = 3".to_owned(),
                "a.toml: line 2, column 1: key: a table where a list of tables is expected; write [[key]], with two brackets",
            ),
        ] {
            assert_eq!(parse(&text).unwrap_err().to_string(), part);
        }
    }
}
