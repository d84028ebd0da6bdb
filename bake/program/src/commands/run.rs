//! `bake run` and `bake merge`.

use super::common::{BUNDLES, asked, load, look_at, start_threads, warn};
use super::first_scene::{Beside, expect_no_other};
use super::spheres;
use crate::cli::{MergeArgs, RunArgs};
use relume_bake::bundle::{self, MethodSummary};
use relume_bake::error::{BakeError, Result};
use relume_bake::job::{Job, detail, say, watch_signals};
use relume_bake::memory::MemoryLimit;
use relume_bake::merge;
use relume_bake::method::Method;
use relume_bake::methods::asked::Asked;
use relume_bake::methods::choice::{self, METHODS};
use relume_bake::methods::registered::Registered;
use relume_bake::shard::Shard;
use relume_bake::stage::Share;
use relume_bake::unfinished::{Leftover, holds_work};
use relume_chart::frame_cost;
use relume_formats::Place;
use relume_formats::method::cards_of;
use relume_scenes::Scene;
use relume_scenes::starter::is_model;
use serde_json::Value;
use std::path::{Path, PathBuf};

/// Noise may be so many times what was asked for before it is warned of: some paths foretell it.
const NOISE_TOLERANCE: f64 = 1.1;
/// How an interrupted bake goes on.
const RESUME: &str = "finished work is kept, add --resume to go on";

/// `bake run`.
pub fn run(args: &RunArgs) -> Result<String> {
    watch_signals()?;
    start_threads(args.threads)?;
    let job = Job::new(args.progress).with_memory(args.memory.unwrap_or(MemoryLimit::Free));
    let reading = job.step("reading");
    let model = Path::new(&args.scene);
    if is_model(model) && args.pieces.is_part() {
        let reason = "is a model, of which each part would have a scene of its own; write one by `bake new`, and give that to all machines";
        return Err(BakeError::invalid(&Place::file(model), reason));
    }
    let beside =
        is_model(model).then(|| Beside::of(model, args.output.as_deref(), args.force)).transpose()?;
    let scene = beside.as_ref().map_or_else(|| load(&args.scene), |beside| Ok(beside.scene.clone()))?;
    drop(reading);
    let folder = match (&beside, &args.output) {
        (Some(beside), _) => beside.folder.clone(),
        (None, Some(folder)) => folder.clone(),
        (None, None) => by_name(&scene, args.force)?,
    };
    let chosen =
        if args.method.is_empty() { vec![choice::cheapest(&scene.vary)] } else { args.method.clone() };
    let asked = asked(&args.asked, &scene);
    let looking = job.step("looking");
    look_at(&scene, asked.size)?;
    drop(looking);
    let methods = methods(&chosen, &asked, &scene)?;
    let leftover = match (args.resume, args.force) {
        (true, _) => Leftover::Resume,
        (_, true) => Leftover::Discard,
        _ => Leftover::Refuse,
    };
    if let Some(beside) = &beside {
        bundle::expect_fit(&scene, &methods, asked.size, &job)?;
        beside.write()?;
    }
    if args.pieces.is_part() {
        return run_shard(&scene, &methods, &asked, args.pieces, &folder, leftover, &job);
    }
    bake(&scene, &methods, &asked, &folder, leftover, &job)
}

/// Where the bundle of `scene` goes if nothing else is said; in the place of another scene's only if that
/// `replaces`.
fn by_name(scene: &Scene, replaces: bool) -> Result<PathBuf> {
    let folder = Path::new(BUNDLES).join(&scene.name);
    if !replaces {
        expect_no_other(scene, &folder)?;
    }
    Ok(folder)
}

/// Bakes and tells what came of it.
fn bake(
    scene: &Scene,
    methods: &[Box<dyn Method>],
    asked: &Asked,
    folder: &Path,
    leftover: Leftover,
    job: &Job,
) -> Result<String> {
    let baked = bundle::run(scene, methods, asked.size, folder, leftover, asked.seed, job);
    // The lock lasts until the report is whole.
    let (summary, _lock) = baked.map_err(|e| e.kept(holds_work(folder, &names(methods)), RESUME))?;
    let mut text: String =
        summary.sphere_sets.iter().map(|set| spheres::describe_stage(&scene.name, set)).collect();
    summary
        .methods
        .iter()
        .for_each(|method| text += &describe(scene, method, summary.is_black, asked.max_error));
    text += &format!("{:.1} MB in {}\n", summary.bytes as f64 / 1e6, folder.display());
    if summary.has_news() {
        detail(&describe_steps(job));
        text += &frame_cost::measure(scene, &summary, asked.size, folder)?;
    }
    Ok(text)
}

/// Makes the pieces of a share.
fn run_shard(
    scene: &Scene,
    methods: &[Box<dyn Method>],
    asked: &Asked,
    share: Share,
    folder: &Path,
    leftover: Leftover,
    job: &Job,
) -> Result<String> {
    let shard = Shard::new(scene, &names(methods), asked, share);
    let baked = bundle::run_shard(scene, methods, &shard, folder, leftover, job);
    let traced = baked.map_err(|e| e.kept(holds_work(folder, &names(methods)), RESUME))?;
    let Share { number, of } = share;
    let folder = folder.display();
    Ok(format!(
        "{}: pieces {number}/{of}: {} made, {:.1} million rays in {:.1} s, in {folder}; when all {of} are done: bake merge DIR... -o BUNDLE\n",
        scene.name,
        traced.pieces,
        traced.rays as f64 / 1e6,
        traced.seconds
    ))
}

/// `bake merge`.
pub fn merge(args: &MergeArgs) -> Result<String> {
    watch_signals()?;
    start_threads(args.threads)?;
    let job = Job::new(args.progress).with_memory(args.memory.unwrap_or(MemoryLimit::Free));
    let shard = merge::expect_all(&args.folders)?;
    let scene = relume_scenes::load(&shard.scene)?;
    shard.expect_scene(&scene)?;
    warn(&scene.warnings);
    let unknown = |name: &String| {
        BakeError::invalid(&Place::file(name), "is no method of this program; merge with the one that baked")
    };
    let chosen = shard
        .methods
        .iter()
        .map(|name| Registered::find(name).ok_or_else(|| unknown(name)))
        .collect::<Result<Vec<_>>>()?;
    let methods = methods(&chosen, &shard.asked, &scene)?;
    bundle::expect_room(&scene, &args.output)?;
    merge::gather(&args.folders, &args.output)?;
    bake(&scene, &methods, &shard.asked, &args.output, Leftover::Resume, &job)
}

fn names(methods: &[Box<dyn Method>]) -> Vec<&'static str> {
    methods.iter().map(|method| method.name()).collect()
}

/// The methods that are `chosen`, with what is `asked` of them. Tells what they leave out.
fn methods(chosen: &[&'static Registered], asked: &Asked, scene: &Scene) -> Result<Vec<Box<dyn Method>>> {
    let refuse = |flag: &str, reason: &str| Err(BakeError::invalid(&Place::file(flag), reason));
    let names: Vec<&str> = chosen.iter().map(|method| method.card.name).collect();
    if names.iter().enumerate().any(|(i, name)| names[..i].contains(name)) {
        return refuse("--method", "the same one is given twice; once is enough");
    }
    cards_of(names.iter().copied(), &Place::file("--method"))?;
    let belongs = |flag: &str| chosen.iter().flat_map(|method| method.options).any(|(own, _)| *own == flag);
    let mut strangers =
        METHODS.into_iter().flat_map(|method| method.options).filter(|(flag, _)| !belongs(flag));
    if let Some((flag, _)) = strangers.find(|(_, is_given)| is_given(asked)) {
        return refuse(
            flag,
            "belongs to a method that is not baked here; remove it, or add the method with --method",
        );
    }
    let methods: Vec<Box<dyn Method>> = chosen.iter().map(|method| (method.new)(asked, scene)).collect();
    warn(&methods.iter().flat_map(|method| method.leaves_out(scene)).collect::<Vec<_>>());
    Ok(methods)
}

/// What the steps of a bake took, the longest first.
fn describe_steps(job: &Job) -> String {
    let mut steps: Vec<(&str, f64)> = job.steps().into_iter().collect();
    steps.sort_by(|a, b| b.1.total_cmp(&a.1));
    let steps: Vec<String> = steps.iter().map(|(name, seconds)| format!("{name} {seconds:.2} s")).collect();
    format!("baked in {:.2} s: {}", job.seconds(), steps.join(", "))
}

/// What came of one method, and a warning where that is less than was asked for.
fn describe(scene: &Scene, summary: &MethodSummary, is_black: bool, max_error: f64) -> String {
    let MethodSummary { entry, traced } = summary;
    let error = |name: &str| entry.errors.get(name).map(|error| 100.0 * error);
    let figures = error("relative_l2_median").zip(error("relative_l2_worst")).filter(|_| !is_black);
    let settings = entry
        .settings
        .iter()
        .filter(|(name, _)| *name != "revision")
        .map(|(name, value)| format!("{name} {value}"));
    let settings: Vec<String> = settings.collect();
    let what = if traced.is_none() { "up to date, reused" } else { "baked" };
    let mut text = format!("{}: {} {what}: {}\n", scene.name, entry.name, settings.join(", "));
    text += &match figures {
        Some((median, worst)) => {
            format!("error over held-out states: median {median:.3} %, worst {worst:.3} %\n")
        }
        None if is_black => "no error figure: the picture is black\n".to_owned(),
        None => {
            say(&format!(
                "warning: nothing that {} was compared on is lit and reflects; check camera, lights and materials",
                entry.name
            ));
            "no error figure: nothing that was compared is lit\n".to_owned()
        }
    };
    let more = [
        ("nodes", "all reflections, at the nodes' albedos"),
        ("albedos", "lobes that later reflections leave out"),
    ];
    for (ending, what) in more {
        let error = |which: &str| error(&format!("relative_l2_{which}_of_{ending}"));
        if let Some((median, worst)) = error("median").zip(error("worst")).filter(|_| !is_black) {
            text += &format!("{what}: median {median:.1} %, worst {worst:.1} %\n");
        }
    }
    let of_noise = error("relative_l2_of_noise").zip(error("relative_l2_of_noise_unfiltered"));
    if let Some((after, before)) = of_noise.filter(|_| !is_black) {
        let filtered = entry.settings.get("filter") == Some(&"on".into());
        let was = if filtered { format!(", {before:.2} % before the filter") } else { String::new() };
        let samples = entry.settings.get("mean_samples").and_then(Value::as_f64);
        let by = samples.map_or_else(String::new, |n| format!(", {n:.0} samples a pixel in the mean"));
        let asked = entry.settings.get("noise").and_then(Value::as_f64).map(|noise| 100.0 * noise);
        let wanted = asked.map_or_else(String::new, |asked| format!(" where {asked:.2} % was asked for"));
        text += &format!("noise over random states: about {after:.2} %{wanted}{was}{by}\n");
        if let Some(asked) = asked.filter(|asked| after > NOISE_TOLERANCE * asked) {
            let all = entry.settings.get("samples").and_then(Value::as_f64).unwrap_or_default();
            let remedy = if samples.is_some_and(|mean| mean < 0.9 * all) {
                "it was foretold to be less, ask for less by --noise"
            } else {
                "raise --spp, which is the most in the mean"
            };
            say(&format!(
                "warning: the noise of {} is above the {asked:.2} % asked for; {remedy}",
                entry.name
            ));
        }
    }
    if entry.settings.get("samples") == Some(&1.into()) && entry.settings.contains_key("filter") {
        text += "noise over random states: not known, for that takes two samples a pixel\n";
    }
    if traced.is_some_and(|traced| traced.pieces == 0) {
        text += "rays traced before are used again\n";
    } else if let Some(traced) = traced.filter(|traced| traced.rays > 0) {
        let rate = traced.rays as f64 / traced.seconds.max(1e-9) / 1e6;
        text += &format!(
            "{:.1} million rays in {:.1} s, {rate:.2} million a second\n",
            traced.rays as f64 / 1e6,
            traced.seconds
        );
    }
    if figures.is_some_and(|(_, worst)| worst > 100.0 * max_error) {
        let remedy =
            Registered::find(&entry.name).map(|method| (method.remedy)(&entry.settings)).unwrap_or_default();
        say(&format!(
            "warning: the worst error of {} is above the {} % asked for; {remedy}",
            entry.name,
            100.0 * max_error
        ));
    }
    text
}
