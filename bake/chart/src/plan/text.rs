//! The text form of a plan.

use super::charted::BestPoint;
use super::facts::{Candidate, Plan, Prediction, Varies};
use super::stored::StoredFigures;
use relume_formats::name::plain;
use serde_json::Value;
use std::collections::BTreeMap;

/// The plan for a reader.
pub(super) fn of(plan: &Plan) -> String {
    if plan.methods.is_empty() {
        let ignored = if plan.not_modelled.is_empty() {
            String::new()
        } else {
            format!("not modelled:{}\n", bullets(&plan.not_modelled))
        };
        return format!("{} {}\n{ignored}", plan.scene, plan.why);
    }
    let mut text = format!("{} varies {}\n", plan.scene, varies(&plan.varies));
    plan.methods.iter().for_each(|candidate| text += &method(candidate));
    text += &match plan.chosen {
        Some(chosen) => format!("\nchosen: {chosen}, for {}\n", plan.why),
        None => format!("\nchosen: none; {}\n", plan.why),
    };
    let list = if plan.not_modelled.is_empty() {
        " nothing that the scene has".to_owned()
    } else {
        bullets(&plan.not_modelled)
    };
    text += &format!("not modelled:{list}\n");
    plan.stored_unusable
        .iter()
        .for_each(|reason| text += &format!("stored figures are left out: {reason}\n"));
    text
}

fn varies(varies: &Varies) -> String {
    let flags = [("light", varies.light), ("view", varies.view), ("shape", varies.shape)];
    let mut parts: Vec<String> =
        flags.into_iter().filter(|(_, on)| *on).map(|(name, _)| name.to_owned()).collect();
    if !varies.materials.is_empty() {
        let names: Vec<String> = varies.materials.iter().map(|name| format!("`{}`", plain(name))).collect();
        parts.push(format!("materials {}", names.join(", ")));
    }
    parts.join(", ")
}

fn method(candidate: &Candidate) -> String {
    if let Some(misfit) = &candidate.misfit {
        return format!("\n{}: does not fit: {misfit}\n", candidate.name);
    }
    let serves = if candidate.serves_all { "serves all that varies" } else { "serves a part of what varies" };
    let mut facts = vec![("settings", settings(&candidate.settings))];
    facts.extend(candidate.predicted.iter().map(|p| ("predicted", predicted(p))));
    let tells = candidate.predicted.iter().flat_map(|p| &p.tells);
    facts.extend(tells.map(|sentence| ("decides", sentence.clone())));
    facts.extend(candidate.stored.iter().map(|s| ("stored", stored(s))));
    facts.extend(candidate.charted.iter().map(|c| ("charted", charted(c))));
    facts.extend(candidate.leaves_out.iter().map(|sentence| ("leaves out", sentence.clone())));
    let lines: String =
        facts.iter().map(|(name, value)| format!("  {name:<10}  {}\n", plain(value))).collect();
    format!("\n{}: fits, {serves}\n{lines}", candidate.name)
}

fn predicted(prediction: &Prediction) -> String {
    let Prediction { rays, seconds, bytes_on_disk, bytes_of_memory, chooses, .. } = prediction;
    let chooses = chooses.map(|(name, value)| format!("{name} {value}, ")).unwrap_or_default();
    format!(
        "{chooses}{:.1} million rays, {} to bake on this machine now, {} on disk, at most {} of memory while baking",
        *rays as f64 / 1e6,
        duration(*seconds),
        megabytes(*bytes_on_disk),
        megabytes(*bytes_of_memory)
    )
}

fn stored(figures: &StoredFigures) -> String {
    let StoredFigures { folder, settings: of_bake, errors, bytes_on_disk, tracing, frame } = figures;
    let error =
        |name: &str| errors.get(name).map_or("unknown".to_owned(), |error| format!("{:.3} %", 100.0 * error));
    let number = |name: &str| tracing.get(name).and_then(Value::as_f64);
    let traced = number("rays").zip(number("tracing_seconds"));
    let traced = traced
        .map(|(rays, seconds)| format!(", {:.1} million rays in {}", rays / 1e6, duration(seconds)))
        .unwrap_or_default();
    let median_ms = frame.as_ref().and_then(|frame| frame.get("median_ms")).and_then(Value::as_f64);
    let frame = median_ms.map(|ms| format!(", a frame in {ms:.2} ms")).unwrap_or_default();
    format!(
        "in {folder} ({}): error {} median, {} worst; {} on disk{traced}{frame}",
        settings(of_bake),
        error("relative_l2_median"),
        error("relative_l2_worst"),
        megabytes(*bytes_on_disk)
    )
}

fn charted(best: &BestPoint) -> String {
    let BestPoint {
        point,
        relative_l2_median,
        relative_l2_worst,
        median_ms,
        bytes_on_disk,
        bake_seconds,
        date,
        adapter,
    } = best;
    format!(
        "nearest to path traced images with {point}: {:.3} % median, {:.3} % worst; {} on disk, a frame in {median_ms:.2} ms, baked in {} ({date}, {adapter})",
        100.0 * relative_l2_median,
        100.0 * relative_l2_worst,
        megabytes(*bytes_on_disk),
        duration(*bake_seconds)
    )
}

fn settings(settings: &BTreeMap<String, Value>) -> String {
    settings.iter().map(|(name, value)| format!("{name} {}", words(value))).collect::<Vec<_>>().join(", ")
}

/// A setting as one says it: lists in parentheses, of what is counted by name the names with their numbers.
fn words(value: &Value) -> String {
    let within = |values: &[Value], between: &str| {
        values.iter().filter(|value| !value.is_null()).map(words).collect::<Vec<_>>().join(between)
    };
    match value {
        Value::String(text) => text.clone(),
        Value::Array(pair) if matches!(&pair[..], [Value::String(_), _]) => within(pair, " "),
        Value::Array(values) => format!("({})", within(values, ", ")),
        other => other.to_string(),
    }
}

fn megabytes(bytes: u64) -> String {
    format!("{:.1} MB", bytes as f64 / 1e6)
}

fn duration(seconds: f64) -> String {
    if seconds < 120.0 { format!("{seconds:.1} s") } else { format!("{:.0} minutes", seconds / 60.0) }
}

fn bullets(sentences: &[String]) -> String {
    sentences.iter().map(|sentence| format!("\n  {}", plain(sentence))).collect()
}
