//! Animations: how long they are, and the keys of every leaf.

use super::out::{Out, file_name_part};
use super::words::{list, many};
use super::{Described, Facts, Inspected};
use relume_formats::Result;
use relume_formats::container::{Kind, Stored};
use relume_formats::kinds::manifest::is_plain_name;
use relume_formats::state::{Animation, TrackValues};
use serde::Serialize;
use std::path::Path;

/// See there.
pub(super) const INSPECTED: Inspected = Inspected { kind: Kind::Animation, describe, export };

#[derive(Serialize)]
struct Details {
    name: String,
    duration_s: f32,
    #[serde(rename = "loop")]
    looping: bool,
    tracks: Vec<TrackInfo>,
}

/// One animated leaf.
#[derive(Serialize)]
struct TrackInfo {
    leaf: String,
    keys: usize,
}

fn describe(path: &Path) -> Result<Described> {
    let Animation { name, duration_s, looping, tracks } = <Animation as Stored>::read_file(path)?;
    let tracks = tracks.iter().map(|t| TrackInfo { leaf: t.leaf.join("."), keys: t.times_s.len() }).collect();
    let details = Details { name, duration_s, looping, tracks };
    Ok(Described { facts: facts(&details), details: Box::new(details) })
}

fn facts(details: &Details) -> Facts {
    vec![
        ("name", details.name.clone()),
        ("duration", format!("{} s{}", details.duration_s, if details.looping { ", repeated" } else { "" })),
        (
            "tracks",
            list(details.tracks.iter().map(|t| format!("{} ({})", t.leaf, many(t.keys, "key", "keys")))),
        ),
    ]
}

fn export(path: &Path, out: &mut Out) -> Result<()> {
    animation_json(&<Animation as Stored>::read_file(path)?, out)
}

/// `animation_<name>.json`.
pub(crate) fn animation_json(animation: &Animation, out: &mut Out) -> Result<()> {
    // Those of a bundle are called plainly, and no two the same.
    let plain = format!("animation_{}.json", animation.name);
    let file = if is_plain_name(&plain) {
        plain
    } else {
        format!("animation_{}.json", file_name_part(&animation.name))
    };
    out.json(&file, &AnimationFile::new(animation))
}

/// An animation as JSON.
#[derive(Serialize)]
struct AnimationFile<'a> {
    name: &'a str,
    duration_s: f32,
    #[serde(rename = "loop")]
    looping: bool,
    tracks: Vec<TrackFile<'a>>,
}

#[derive(Serialize)]
struct TrackFile<'a> {
    leaf: &'a [String],
    times_s: &'a [f32],
    values: ValuesFile<'a>,
}

#[derive(Serialize)]
#[serde(untagged)]
enum ValuesFile<'a> {
    Scalar(&'a [f32]),
    Vector(&'a [Vec<f32>]),
    Name(&'a [String]),
}

impl<'a> AnimationFile<'a> {
    fn new(animation: &'a Animation) -> Self {
        let tracks = animation.tracks.iter().map(|track| {
            let values = match &track.values {
                TrackValues::Scalar(v) => ValuesFile::Scalar(v),
                TrackValues::Vector(v) => ValuesFile::Vector(v),
                TrackValues::Name(v) => ValuesFile::Name(v),
            };
            TrackFile { leaf: &track.leaf, times_s: &track.times_s, values }
        });
        Self {
            name: &animation.name,
            duration_s: animation.duration_s,
            looping: animation.looping,
            tracks: tracks.collect(),
        }
    }
}
