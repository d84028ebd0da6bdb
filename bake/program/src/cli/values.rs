//! The values that options take: names with what help says of them, and numbers within bounds.

use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use relume_bake::job::ProgressMode;
use relume_bake::memory::MemoryLimit;
use relume_bake::methods::asked::Quality;
use relume_bake::methods::choice::METHODS;
use relume_bake::methods::registered::Registered;
use relume_bake::trace::reference::Paths;

/// A value that an option takes: its name, what it stands for, and what help says of it.
pub(super) type Named<T> = (&'static str, T, &'static str);

pub(super) const QUALITIES: [Named<Quality>; 3] = [
    ("draft", Quality::Draft, "A first look"),
    ("preview", Quality::Preview, "Good to work with"),
    ("final", Quality::Final, "Good to keep"),
];
pub(super) const PATHS: [Named<Paths>; 2] = [
    ("best", Paths::Best, "The ones with the least noise for the materials at hand"),
    ("gather", Paths::Gather, "The very ones that a bake with the same size, seed and samples traces"),
];
pub(super) const FILTER: [Named<bool>; 2] = [
    ("on", true, "Noise is filtered out, where an estimate of its error says that this helps"),
    ("off", false, "Images are as they were traced"),
];
pub(super) const PROGRESS: [Named<ProgressMode>; 4] = [
    ("auto", ProgressMode::Auto, "A bar on a terminal, else plain lines"),
    ("plain", ProgressMode::Plain, "A line now and then"),
    ("json", ProgressMode::Json, "A JSON object a line: stage, done, total, seconds, seconds_left"),
    ("none", ProgressMode::None, "Nothing"),
];

pub(super) fn one_of<T: Copy + Send + Sync + 'static>(
    values: &'static [Named<T>],
) -> impl TypedValueParser<Value = T> {
    let names =
        PossibleValuesParser::new(values.iter().map(|(name, _, help)| PossibleValue::new(*name).help(*help)));
    names.try_map(|name| {
        values.iter().find(|(known, ..)| *known == name).map(|(_, value, _)| *value).ok_or("no such value")
    })
}

pub(super) fn method_parser() -> impl TypedValueParser<Value = &'static Registered> {
    let names = PossibleValuesParser::new(METHODS.map(|method| method.card.name));
    names.try_map(|name| Registered::find(&name).ok_or("no such method"))
}

pub(super) fn parse_memory(text: &str) -> Result<MemoryLimit, String> {
    let gib = text.parse().ok().filter(|gib: &f64| *gib > 0.0 && *gib <= 1e6);
    let bytes = gib.map(|gib| MemoryLimit::Bytes((gib * f64::from(1 << 30)) as u64));
    bytes.ok_or_else(|| "expected a number of GiB above 0".to_owned())
}

pub(super) fn parse_scale(text: &str) -> Result<f64, String> {
    let scale = text.parse().ok().filter(|scale| (1e-30..=1e30).contains(scale));
    scale.ok_or_else(|| "expected a number above 0, such as 0.01 for centimetres".to_owned())
}

pub(super) fn parse_max_error(text: &str) -> Result<f64, String> {
    let error = text.parse().ok().filter(|error: &f64| *error > 0.0 && error.is_finite());
    error.ok_or_else(|| "expected a number above 0 with a decimal point, such as 0.01".to_owned())
}

pub(super) fn parse_tight(text: &str) -> Result<f64, String> {
    let tight = text.parse().ok().filter(|tight| (0.0..=0.1).contains(tight));
    tight.ok_or_else(|| "expected a number from 0 to 0.1, a part of the bounding box's diagonal".to_owned())
}

pub(super) fn parse_size(text: &str) -> Result<[u32; 2], String> {
    let sides = text.split_once('x').and_then(|(w, h)| Some([w.parse().ok()?, h.parse().ok()?]));
    match sides {
        Some(size) if size.iter().all(|n| (1..=relume_formats::kinds::scene::MAX_SIDE).contains(n)) => {
            Ok(size)
        }
        _ => Err(format!(
            "expected WIDTHxHEIGHT such as 512x512, each at most {}",
            relume_formats::kinds::scene::MAX_SIDE
        )),
    }
}
